#pragma once
// Builders of models and scenarios for tests. Every number is a plausible one; none is taken from a file.
#include <cmath>
#include <complex>
#include <string>
#include <vector>

#include "amb_rotor/common/units.hpp"
#include "amb_rotor/effects/catalogue.hpp"
#include "amb_rotor/machine/run.hpp"
#include "amb_rotor/model/model.hpp"

namespace amb_rotor::testing_support {

/// Planes, auxiliary bearing and rotor that the builders share.
inline Model bareModel() {
  Model model;
  Rig<double>& rig = model.rig;
  rig.rotor.mass_kg = 3.36;
  rig.rotor.transverse_inertia_kg_m2 = 0.017;
  rig.planes.amb[0] = -0.096;
  rig.planes.amb[1] = 0.096;
  rig.planes.sensor[0] = -0.118;
  rig.planes.sensor[1] = 0.118;
  rig.planes.aux[0] = -0.140;
  rig.planes.aux[1] = 0.140;
  rig.auxiliary_bearing.clearance_m = 0.2e-3;
  rig.auxiliary_bearing.rotor_radius_m = 0.012;
  rig.auxiliary_bearing.stiffness_N_per_m = 3.38e7;
  rig.auxiliary_bearing.damping_N_s_per_m = 300.0;
  rig.auxiliary_bearing.friction_coefficient = 0.10;
  return model;
}

/// A rigid mass on springs and dampers: stiffness and damping are the rotor's sums, half at each bearing.
inline Model springMass(double stiffness = 2.47e6, double damping = 100.0) {
  Model model = bareModel();
  model.rotor_model = RotorModel::rigid_mass;
  model.amb_model = AmbModel::equivalent;
  model.rig.amb.stiffness_N_per_m = 0.5 * stiffness;
  model.rig.amb.damping_N_s_per_m = 0.5 * damping;
  return model;
}

/// A rigid beam on springs and dampers of each bearing.
inline Model springBeam(double stiffness = 2e5, double damping = 150.0) {
  Model model = bareModel();
  model.rotor_model = RotorModel::rigid_beam;
  model.amb_model = AmbModel::equivalent;
  model.rig.amb.stiffness_N_per_m = stiffness;
  model.rig.amb.damping_N_s_per_m = damping;
  return model;
}

/// A rigid beam levitated by a sampled PID; sensors beside the magnets. Net stiffness 2e5 N/m a bearing.
inline Model levitated() {
  Model model = bareModel();
  model.rotor_model = RotorModel::rigid_beam;
  model.amb_model = AmbModel::linear;
  auto& amb = model.rig.amb;
  amb.current_stiffness_N_per_A = 19.0;
  amb.displacement_stiffness_N_per_m = 63333.0;
  amb.bias_current_A = 2.5;
  amb.air_gap_m = 0.75e-3;
  amb.bias_flux_density_T = 0.45;
  amb.amplifier_bandwidth_hz = 2000.0;
  amb.max_current_A = 5.0;
  auto& controller = model.rig.controller;
  controller.sample_rate_hz = 10000.0;
  controller.kp_A_per_m = 13850.0;
  controller.kd_A_s_per_m = 16.0;
  controller.ki_A_per_m_s = 0.0;
  controller.derivative_filter_hz = 2000.0;
  controller.delay_s = 1e-4;
  return model;
}

inline double netStiffness(const Model& model) {
  const auto& rig = model.rig;
  if (model.amb_model == AmbModel::equivalent) return rig.amb.stiffness_N_per_m;
  return rig.amb.current_stiffness_N_per_A * rig.controller.kp_A_per_m -
         rig.amb.displacement_stiffness_N_per_m;
}

/// The model with one effect more, its parameters in the order of its schema.
inline Model with(Model model, const std::string& id, const std::vector<double>& values) {
  model.effects.push_back({id, values});
  return model;
}

/// Parameters of an effect at their typical strength.
inline std::vector<double> typicalValues(const std::string& id) {
  std::vector<double> values;
  for (const auto& parameter : effectCatalogue().find(id)->parameters) values.push_back(parameter.typical);
  return values;
}

inline Model withUnbalance(Model model, double moment_kg_m, double phase_rad = 0.0, double plane_z_m = 0.0) {
  model.rig.unbalance.emplace_back();
  model.rig.unbalance.back().plane_z_m = plane_z_m;
  model.rig.unbalance.back().moment_kg_m = moment_kg_m;
  model.rig.unbalance.back().phase_rad = phase_rad;
  return model;
}

inline Scenario constantSpeed(double hz, double duration_s, double record_rate_hz = 10000.0) {
  Scenario scenario;
  scenario.duration_s = duration_s;
  scenario.record_rate_hz = record_rate_hz;
  scenario.speed.type = SpeedType::constant;
  scenario.speed.start_hz = hz;
  return scenario;
}

/// Starts from given coordinates (x_G, y_G, beta, -alpha and their rates) instead of the settled state.
inline Scenario from(Scenario scenario, const std::vector<double>& displacement,
                     const std::vector<double>& velocity) {
  scenario.start_settled = false;
  scenario.initial_displacement_m = displacement;
  scenario.initial_velocity_m_s = velocity;
  return scenario;
}

inline Scenario bearingsOff(Scenario scenario, double time_s, int end = -1, int axis = -1) {
  FaultEvent fault;
  fault.type = FaultType::amb_off;
  fault.start_s = time_s;
  fault.end = end;
  fault.axis = axis;
  scenario.faults.push_back(fault);
  return scenario;
}

/// A constant current into the magnet of end a, axis x, for a while.
inline Excitation currentPulse(double amplitude_A, double start_s, double duration_s) {
  Excitation current;
  current.kind = Excitation::Kind::current;
  current.amplitude = amplitude_A;
  current.start_s = start_s;
  current.duration_s = duration_s;
  return current;
}

/// A run in which every effect has something to act on: rotation with unbalance and gravity, tilting, a
/// current that reaches its limit, and an impact with sliding.
inline Scenario eventful() {
  Scenario scenario = from(constantSpeed(20.0, 0.03), {1e-5, 0.0, 1e-4, -2e-4}, {0.01, 0.0, 0.5, 0.0});
  scenario.excitations.push_back(currentPulse(1.5, 0.002, 0.003));
  Excitation impact;
  impact.waveform = Waveform::impulse;
  impact.amplitude = 600.0;
  impact.plane_z_m = 0.05;
  impact.direction_rad = 0.8;
  impact.start_s = 0.012;
  impact.duration_s = 0.003;
  scenario.excitations.push_back(impact);
  return scenario;
}

inline Model eventfulModel() {
  Model model = withUnbalance(levitated(), 4e-5, 0.3, 0.02);
  model.rig.gravity_m_s2 = 9.81;
  model.rig.auxiliary_bearing.friction_coefficient = 0.3;  // enough to bring a ring up to the rotor's speed
  return model;
}

/// Amplitude C of a real signal's part C cos(order angle + arg): exact mean over whole turns of records.
/// Least squares of mean, cosine and sine, so that the window need not be whole.
inline std::complex<double> order(const std::vector<double>& angle, const std::vector<double>& signal,
                                  double order, std::size_t first) {
  double m[3][4] = {{0.0}};
  for (std::size_t i = first; i < angle.size(); ++i) {
    const double b[3] = {1.0, std::cos(order * angle[i]), std::sin(order * angle[i])};
    for (int r = 0; r < 3; ++r) {
      for (int c = 0; c < 3; ++c) m[r][c] += b[r] * b[c];
      m[r][3] += b[r] * signal[i];
    }
  }
  for (int p = 0; p < 3; ++p)
    for (int r = 0; r < 3; ++r) {
      if (r == p) continue;
      const double factor = m[r][p] / m[p][p];
      for (int c = p; c < 4; ++c) m[r][c] -= factor * m[p][c];
    }
  return {m[1][3] / m[1][1], -m[2][3] / m[2][2]};
}

/// Forward and backward amplitudes of one order in a plane: z = F exp(i order t) + B exp(-i order t).
struct WhirlOrder {
  std::complex<double> forward, backward;
};
inline WhirlOrder whirlOrder(const std::vector<double>& angle, const std::vector<double>& x,
                             const std::vector<double>& y, double n, std::size_t first) {
  const std::complex<double> cx = order(angle, x, n, first), cy = order(angle, y, n, first), i(0.0, 1.0);
  return {0.5 * (cx + i * cy), std::conj(0.5 * (cx - i * cy))};
}

inline double largest(const std::vector<double>& values, std::size_t first = 0) {
  double most = 0.0;
  for (std::size_t i = first; i < values.size(); ++i) most = std::max(most, std::fabs(values[i]));
  return most;
}

}  // namespace amb_rotor::testing_support
