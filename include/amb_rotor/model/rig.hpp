#pragma once
// The rig block of a model file as numbers: what an owner believes of a machine, before any effect.
//
// Frame: z along the shaft, x horizontal, y vertical (up), spin positive about z (x turns towards y).
// Planes are named by z from the centre of gravity, positive towards end B. Both ends are symmetric in
// kind: index 0 is end A, 1 is end B. Everything SI.
//
// Rig<S> is written for a Scalar so that each SIMD lane carries its own machine.
#include <vector>

#include "amb_rotor/common/scalar.hpp"

namespace amb_rotor {

enum class RotorModel {
  rigid_mass,  ///< 2 freedoms: x, y of the centre of gravity; all planes move alike
  rigid_beam,  ///< 4 freedoms: x, y and the two tilts, with the gyroscopic moment where Ip > 0
  flexible     ///< modes of a shaft from its geometry (rotor.geometry)
};

enum class AmbModel {
  linear,     ///< F = Ki i + Ks x, with controller and amplifier
  equivalent  ///< F = -k x - d x' (the thesis's k1, d1 of ONE bearing), no controller
};

template <class S>
struct Unbalance {
  S plane_z_m = S(0.0);    ///< axial position
  S moment_kg_m = S(0.0);  ///< mass times eccentricity, >= 0
  S phase_rad = S(0.0);    ///< in the rotor, from the tacho mark, positive with the spin
};

template <class S>
struct Rig {
  struct {
    S mass_kg = S(0.0);
    S transverse_inertia_kg_m2 = S(0.0);
    S polar_inertia_kg_m2 = S(0.0);
  } rotor;
  struct {
    S amb[2] = {S(0.0), S(0.0)}, sensor[2] = {S(0.0), S(0.0)}, aux[2] = {S(0.0), S(0.0)};  ///< axial positions [m]
  } planes;
  struct {
    S current_stiffness_N_per_A = S(0.0);       ///< Ki (linear)
    S displacement_stiffness_N_per_m = S(0.0);  ///< Ks, positive destabilises (linear)
    S bias_current_A = S(0.0);
    S air_gap_m = S(0.0);
    S bias_flux_density_T = S(0.0);  ///< 0: not stated
    S amplifier_bandwidth_hz = S(0.0);
    S max_current_A = S(0.0);
    S stiffness_N_per_m = S(0.0);    ///< of one bearing and axis (equivalent)
    S damping_N_s_per_m = S(0.0);    ///< of one bearing and axis (equivalent)
  } amb;
  struct {
    S sample_rate_hz = S(0.0);
    S kp_A_per_m = S(0.0);
    S kd_A_s_per_m = S(0.0);
    S ki_A_per_m_s = S(0.0);
    S derivative_filter_hz = S(0.0);
    S delay_s = S(0.0);  ///< from the sample to the command at the amplifier
  } controller;
  struct {
    S clearance_m = S(0.0);
    S rotor_radius_m = S(0.0);
    S stiffness_N_per_m = S(0.0);
    S damping_N_s_per_m = S(0.0);
    S friction_coefficient = S(0.0);
  } auxiliary_bearing;
  S gravity_m_s2 = S(0.0);  ///< acts along -y
  std::vector<Unbalance<S>> unbalance;

  /// The named numeric fields, in the order of the file. Unbalance i is "unbalance.i.moment_kg_m".
  template <class R, class F>
  static void visit(R& r, F&& f) {
    f("rotor.mass_kg", r.rotor.mass_kg);
    f("rotor.transverse_inertia_kg_m2", r.rotor.transverse_inertia_kg_m2);
    f("rotor.polar_inertia_kg_m2", r.rotor.polar_inertia_kg_m2);
    f("planes.amb.a", r.planes.amb[0]);
    f("planes.amb.b", r.planes.amb[1]);
    f("planes.sensor.a", r.planes.sensor[0]);
    f("planes.sensor.b", r.planes.sensor[1]);
    f("planes.aux.a", r.planes.aux[0]);
    f("planes.aux.b", r.planes.aux[1]);
    f("amb.current_stiffness_N_per_A", r.amb.current_stiffness_N_per_A);
    f("amb.displacement_stiffness_N_per_m", r.amb.displacement_stiffness_N_per_m);
    f("amb.bias_current_A", r.amb.bias_current_A);
    f("amb.air_gap_m", r.amb.air_gap_m);
    f("amb.bias_flux_density_T", r.amb.bias_flux_density_T);
    f("amb.amplifier_bandwidth_hz", r.amb.amplifier_bandwidth_hz);
    f("amb.max_current_A", r.amb.max_current_A);
    f("amb.stiffness_N_per_m", r.amb.stiffness_N_per_m);
    f("amb.damping_N_s_per_m", r.amb.damping_N_s_per_m);
    f("controller.sample_rate_hz", r.controller.sample_rate_hz);
    f("controller.kp_A_per_m", r.controller.kp_A_per_m);
    f("controller.kd_A_s_per_m", r.controller.kd_A_s_per_m);
    f("controller.ki_A_per_m_s", r.controller.ki_A_per_m_s);
    f("controller.derivative_filter_hz", r.controller.derivative_filter_hz);
    f("controller.delay_s", r.controller.delay_s);
    f("auxiliary_bearing.clearance_m", r.auxiliary_bearing.clearance_m);
    f("auxiliary_bearing.rotor_radius_m", r.auxiliary_bearing.rotor_radius_m);
    f("auxiliary_bearing.contact.stiffness_N_per_m", r.auxiliary_bearing.stiffness_N_per_m);
    f("auxiliary_bearing.contact.damping_N_s_per_m", r.auxiliary_bearing.damping_N_s_per_m);
    f("auxiliary_bearing.friction_coefficient", r.auxiliary_bearing.friction_coefficient);
    f("gravity_m_s2", r.gravity_m_s2);
    for (auto& u : r.unbalance) {
      f("unbalance.plane_z_m", u.plane_z_m);
      f("unbalance.moment_kg_m", u.moment_kg_m);
      f("unbalance.phase_rad", u.phase_rad);
    }
  }
};

}  // namespace amb_rotor
