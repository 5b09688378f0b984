// Rigs drawn at random: what the owner believes, and what is true within the stated uncertainty.
#include <cmath>
#include <cstdio>
#include <cstdlib>

#include "amb_rotor/common/units.hpp"
#include "make_dataset_parts.hpp"

namespace amb_rotor::making {
namespace {

/// To the digits that an owner would write down.
double rounded(double value, int digits = 4) {
  char text[40];
  std::snprintf(text, sizeof text, "%.*g", digits, value);
  return std::strtod(text, nullptr);
}

}  // namespace

double Dice::logUniform(double from, double to) { return from * std::pow(to / from, uniform(0.0, 1.0)); }

double Dice::normal() {
  const double radius = std::sqrt(-2.0 * std::log(1.0 - uniform(0.0, 1.0)));
  return radius * std::cos(two_pi * uniform(0.0, 1.0));
}

double netStiffness(const Model& model) {
  return model.rig.amb.current_stiffness_N_per_A * model.rig.controller.kp_A_per_m -
         model.rig.amb.displacement_stiffness_N_per_m;
}

double criticalHz(const Model& model) {
  return std::sqrt(2.0 * netStiffness(model) / model.rig.rotor.mass_kg) / two_pi;
}

double topSpeedHz(const Model& model) { return 1.75 * criticalHz(model); }

Model drawBelief(Dice& dice, bool horizontal, bool polar_inertia_unknown) {
  Model model;
  auto& rig = model.rig;
  const double mass = rounded(dice.logUniform(1.0, 15.0));
  rig.rotor.mass_kg = mass;
  const double arm = 0.06 + 0.02 * std::pow(mass, 0.35);
  for (int end = 0; end < 2; ++end) {
    const double side = end == 0 ? -1.0 : 1.0;
    const double amb = rounded(arm * dice.uniform(0.75, 1.25), 3);
    rig.planes.amb[end] = side * amb;
    rig.planes.sensor[end] = side * rounded(amb + dice.sign() * dice.uniform(0.010, 0.028), 3);
    rig.planes.aux[end] = side * rounded(amb + dice.uniform(0.015, 0.05), 3);
  }
  rig.rotor.transverse_inertia_kg_m2 =
      rounded(-mass * rig.planes.amb[0] * rig.planes.amb[1] * dice.uniform(0.8, 1.8));
  if (!polar_inertia_unknown && dice.chance(0.25))
    rig.rotor.polar_inertia_kg_m2 = rounded(rig.rotor.transverse_inertia_kg_m2 * dice.uniform(0.05, 0.3));
  auto& amb = rig.amb;
  amb.current_stiffness_N_per_A = rounded(dice.uniform(50.0, 120.0) + 5.0 * mass);
  amb.bias_current_A = rounded(dice.uniform(1.8, 3.0), 2);
  amb.air_gap_m = rounded(dice.uniform(0.36e-3, 0.75e-3), 2);
  amb.displacement_stiffness_N_per_m =
      rounded(amb.current_stiffness_N_per_A * amb.bias_current_A / amb.air_gap_m, 8);
  amb.bias_flux_density_T = rounded(dice.uniform(0.4, 0.6), 2);
  amb.amplifier_bandwidth_hz = rounded(dice.uniform(1700.0, 2900.0), 3);
  amb.max_current_A = 2.0 * amb.bias_current_A;
  auto& controller = rig.controller;
  controller.sample_rate_hz = sample_rate_hz;
  const double critical = radPerSecond(dice.uniform(60.0, 115.0));
  const double net = 0.5 * mass * critical * critical;
  controller.kp_A_per_m = rounded((net + amb.displacement_stiffness_N_per_m) / amb.current_stiffness_N_per_A, 5);
  controller.derivative_filter_hz = rounded(dice.uniform(1500.0, 2600.0), 3);
  controller.delay_s = rounded(dice.uniform(0.8e-4, 1.6e-4), 2);
  const double lag = controller.delay_s + 0.5 / sample_rate_hz + 1.0 / radPerSecond(amb.amplifier_bandwidth_hz);
  controller.kd_A_s_per_m = rounded(dice.uniform(0.14, 0.25) * mass * critical / amb.current_stiffness_N_per_A +
                                        lag * controller.kp_A_per_m,
                                    5);
  if (dice.chance(0.2)) controller.ki_A_per_m_s = rounded(controller.kp_A_per_m * dice.uniform(1.0, 4.0), 3);
  auto& bearing = rig.auxiliary_bearing;
  bearing.clearance_m = rounded(dice.uniform(0.14e-3, 0.25e-3), 2);
  bearing.rotor_radius_m = rounded(dice.uniform(0.010, 0.018), 3);
  bearing.stiffness_N_per_m = rounded(mass * dice.uniform(4e6, 9e6), 3);
  bearing.damping_N_s_per_m = rounded(dice.uniform(0.1, 0.2) * std::sqrt(bearing.stiffness_N_per_m * mass), 3);
  bearing.friction_coefficient = rounded(dice.uniform(0.07, 0.19), 3);
  rig.unbalance.push_back({rounded(dice.uniform(-0.03, 0.03), 2), rounded(mass * dice.logUniform(4e-6, 15e-6)),
                           rounded(dice.uniform(-3.0, 3.0), 3)});
  rig.gravity_m_s2 = horizontal || dice.chance(0.5) ? standard_gravity_m_s2 : 0.0;
  model.uncertainty = {{"rotor.mass_kg", 0.005},
                       {"amb.current_stiffness_N_per_A", 0.03},
                       {"auxiliary_bearing.contact.stiffness_N_per_m", 0.10},
                       {"unbalance.moment_kg_m", 0.10},
                       {"unbalance.phase_rad", 0.05},
                       {"sensor.offset_m", 1e-6}};
  if (dice.chance(0.6)) model.uncertainty["auxiliary_bearing.friction_coefficient"] = 0.10;
  return model;
}

Model drawTruth(Dice& dice, const Model& belief) {
  Model truth = belief;
  const auto off = [&](const char* name) {
    const auto found = belief.uncertainty.find(name);
    const double draw = dice.normal();
    return found == belief.uncertainty.end() ? 0.0 : found->second * draw;
  };
  auto& rig = truth.rig;
  rig.rotor.mass_kg *= 1.0 + off("rotor.mass_kg");
  rig.amb.current_stiffness_N_per_A *= 1.0 + off("amb.current_stiffness_N_per_A");
  rig.auxiliary_bearing.stiffness_N_per_m *= 1.0 + off("auxiliary_bearing.contact.stiffness_N_per_m");
  rig.auxiliary_bearing.friction_coefficient *= 1.0 + off("auxiliary_bearing.friction_coefficient");
  for (auto& unbalance : rig.unbalance) {
    unbalance.moment_kg_m *= 1.0 + off("unbalance.moment_kg_m");
    unbalance.phase_rad += off("unbalance.phase_rad");
  }
  return truth;
}

}  // namespace amb_rotor::making
