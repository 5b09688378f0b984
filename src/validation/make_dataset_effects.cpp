// Hidden effects of the generator: dice thrown once, then a size from barely there to plain.
#include <algorithm>
#include <cmath>

#include "amb_rotor/common/error.hpp"
#include "amb_rotor/common/units.hpp"
#include "amb_rotor/effects/catalogue.hpp"
#include "make_dataset_parts.hpp"

namespace amb_rotor::making {
namespace {

const std::vector<std::string> law_names = {"quadratic_damping", "cubic_stiffness", "sensor_dead_zone",
                                            "hum", "third_harmonic_force", "speed_stiffness",
                                            "current_dead_zone"};

/// Uniform between two limits by a die of the draw.
double between(const EffectDraw& draw, int die, double from, double to) {
  return from + (to - from) * draw.uniform[die];
}

/// Where a stiffness that grows with the speed has the size that is asked for.
constexpr double typical_speed_hz = 60.0;

double phase(const EffectDraw& draw, int die) { return between(draw, die, -3.1, 3.1); }

/// Bending of a free beam that ends a little outside its auxiliary bearings: 1 at the ends, -0.6 in the middle.
double bendingShape(const Model& truth, double z) {
  const double half = 1.15 * 0.5 * (truth.rig.planes.aux[1] - truth.rig.planes.aux[0]);
  const double middle = 0.5 * (truth.rig.planes.aux[1] + truth.rig.planes.aux[0]);
  const double share = (z - middle) / half;
  return 1.6 * share * share - 0.6;
}

std::vector<double> contactValues(const EffectDraw& draw, double size, const Model& truth) {
  const auto& bearing = truth.rig.auxiliary_bearing;
  const auto& id = draw.id;
  if (id == "auxiliary_bearing_misalignment") {
    std::vector<double> values;
    for (int i = 0; i < 4; ++i)
      values.push_back(std::clamp(0.05 * size * draw.normal[i], -0.5, 0.5) * bearing.clearance_m);
    return values;
  }
  if (id == "hertzian_contact") {
    const double depth = between(draw, 0, 3e-6, 12e-6) * std::clamp(size, 0.2, 5.0);
    return {bearing.stiffness_N_per_m / std::sqrt(depth), between(draw, 1, 0.1, 0.6)};
  }
  if (id == "compliant_mount")
    return {bearing.stiffness_N_per_m * between(draw, 0, 0.3, 0.8) / std::max(size, 0.1),
            bearing.damping_N_s_per_m * between(draw, 1, 0.3, 0.8), between(draw, 2, 0.03, 0.1)};
  if (id == "velocity_dependent_friction") {
    const double mu = bearing.friction_coefficient;
    return {std::min(mu * (1.0 + 0.5 * size), 0.6), mu * std::max(0.2, 1.0 - 0.25 * size), between(draw, 0, 0.5, 3.0)};
  }
  // inner_ring_spin: a light ring is soon dragged along
  return {std::clamp(1e-4 / (size * size), 5e-7, 1e-2), between(draw, 0, 0.002, 0.01)};
}

std::vector<double> rotatingValues(const EffectDraw& draw, double size, const Model& truth) {
  const auto& rig = truth.rig;
  const auto& id = draw.id;
  if (id == "couple_unbalance")
    return {0.3 * size * rig.unbalance[0].moment_kg_m, phase(draw, 0),
            rig.planes.amb[draw.uniform[1] < 0.5 ? 0 : 1] * between(draw, 2, 0.5, 1.0)};
  if (id == "shaft_bow")
    return {3e-6 * size * draw.normal[0], 3e-6 * size * draw.normal[1], phase(draw, 0)};
  if (id == "shaft_crack") return {0.05 * size, phase(draw, 0)};  // up to its limit
  std::vector<double> runout;  // sensor_runout
  for (int i = 0; i < 4; ++i) {
    runout.push_back(std::min(5e-5, 1e-6 * size * between(draw, i, 0.3, 1.0)));
    runout.push_back(phase(draw, 4 + i));
  }
  return runout;
}

std::vector<double> actuatorValues(const EffectDraw& draw, double size, const Model& truth, double peak_current_A) {
  const auto& amb = truth.rig.amb;
  const auto& id = draw.id;
  if (id == "magnetic_nonlinearity") return {amb.bias_current_A, amb.air_gap_m};
  if (id == "magnetic_saturation") return {amb.bias_flux_density_T * (1.0 + 1.2 / size)};
  if (id == "current_saturation") return {amb.bias_current_A + peak_current_A / (1.0 + 0.2 * size)};
  if (id == "amplifier_lag") return {amb.amplifier_bandwidth_hz / (1.0 + 0.1 * size)};
  if (id == "control_delay") return {truth.rig.controller.delay_s + 2e-5 * size};
  return {std::clamp(1e5 / (size * size), 200.0, 5e6)};  // eddy_current_lag
}

std::vector<double> flexibilityValues(const EffectDraw& draw, double size, const Model& truth) {
  std::vector<double> values = {between(draw, 0, 180.0, 420.0), between(draw, 1, 0.005, 0.02)};
  const auto& planes = truth.rig.planes;
  for (const auto* pair : {planes.amb, planes.sensor, planes.aux})
    for (int end = 0; end < 2; ++end) values.push_back(size * bendingShape(truth, pair[end]));
  values.push_back(size * bendingShape(truth, truth.rig.unbalance[0].plane_z_m));
  return values;
}

}  // namespace

Law lawOf(const std::string& name) {
  for (std::size_t i = 0; i < law_names.size(); ++i)
    if (law_names[i] == name) return static_cast<Law>(i + 1);
  return Law::none;
}

std::vector<std::string> lawDependsOn(Law law) {
  if (law == Law::quadratic_damping) return {"velocity"};
  if (law == Law::hum) return {"time"};
  if (law == Law::third_harmonic_force) return {"shaft angle"};
  if (law == Law::speed_stiffness) return {"position", "spin speed"};
  if (law == Law::current_dead_zone) return {"control current"};
  return law == Law::none ? std::vector<std::string>{} : std::vector<std::string>{"position"};
}

EffectDraw drawEffect(Dice& dice, const std::string& id) {
  EffectDraw draw;
  draw.id = id;
  for (double& value : draw.uniform) value = dice.uniform(0.0, 1.0);
  for (double& value : draw.normal) {
    value = dice.normal();  // none of them next to nothing
    value = std::copysign(std::clamp(std::fabs(value), 0.3, 2.0), value);
  }
  return draw;
}

EffectSetting effectOfSize(const EffectDraw& draw, double size, const Model& truth, double peak_current_A) {
  const auto& rig = truth.rig;
  const auto& id = draw.id;
  const double net = netStiffness(truth);
  const double arm = rig.planes.amb[1];
  const auto made = [&]() -> std::vector<double> {
    if (needsContact(id)) return contactValues(draw, size, truth);
    if (id == "couple_unbalance" || id == "shaft_bow" || id == "shaft_crack" || id == "sensor_runout")
      return rotatingValues(draw, size, truth);
    if (id == "magnetic_nonlinearity" || id == "magnetic_saturation" || id == "current_saturation" ||
        id == "amplifier_lag" || id == "control_delay" || id == "eddy_current_lag")
      return actuatorValues(draw, size, truth, peak_current_A);
    if (id == "shaft_flexibility") return flexibilityValues(draw, size, truth);
    if (id == "sensor_gain_error") {
      std::vector<double> factors;
      for (int i = 0; i < 4; ++i) factors.push_back(std::clamp(1.0 + 0.02 * size * draw.normal[i], 0.5, 1.7));
      return factors;
    }
    if (id == "sensor_axis_rotation")
      return {std::clamp(0.02 * size * draw.normal[0], -0.6, 0.6), std::clamp(0.02 * size * draw.normal[1], -0.6, 0.6)};
    if (id == "static_load") return {2.0 * size * draw.normal[0], 2.0 * size * draw.normal[1]};
    if (id == "gyroscopic_coupling") return {std::min(1.8, 0.1 * size) * rig.rotor.transverse_inertia_kg_m2};
    if (id == "stiffness_anisotropy") return {std::clamp(0.03 * size * draw.normal[0], -1.0, 1.0)};
    if (id == "cross_coupled_stiffness")
      return {0.02 * size * net, 100.0, draw.uniform[0] < 0.6 ? 1.0 : between(draw, 1, 0.5, 2.0),
              draw.uniform[2] < 0.5 ? 0.0 : arm * between(draw, 3, -0.6, 0.6)};
    if (id == "internal_damping")
      return {0.02 * size * rig.amb.current_stiffness_N_per_A * rig.controller.kd_A_s_per_m,
              draw.uniform[2] < 0.5 ? 0.0 : arm * between(draw, 3, -0.6, 0.6)};
    if (id == "motor_magnetic_pull") return {0.04 * size * net, arm * between(draw, 0, -0.9, 0.9)};
    if (id == "foundation_resonance")
      return {rig.rotor.mass_kg * std::max(1.0, between(draw, 0, 8.0, 25.0) / std::max(size, 0.05)), between(draw, 1, 25.0, 140.0),
              between(draw, 2, 0.015, 0.08)};
    const EffectSchema& schema = *effectCatalogue().find(id);
    if (schema.law != nullptr) {  // of a file: from where it does nothing towards what the file takes as typical
      std::vector<double> values;
      for (const auto& p : schema.parameters)
        values.push_back(std::isfinite(p.neutral) ? p.neutral + size * (p.typical - p.neutral) : p.typical);
      return values;
    }
    AMB_ROTOR_CHECK(id == "spin_drag", "every effect of the catalogue can be drawn");
    return {0.02 * size, 0.0};
  };
  EffectSetting setting{id, made()};
  const EffectSchema* schema = effectCatalogue().find(id);
  for (std::size_t i = 0; i < setting.values.size(); ++i)
    setting.values[i] = std::clamp(setting.values[i], schema->parameters[i].lower, schema->parameters[i].upper);
  return setting;
}

HiddenLaw lawOfSize(Law law, const EffectDraw& draw, double size, const Model& truth, double peak_current_A) {
  const double net = netStiffness(truth);
  const double far = 0.2 * truth.rig.auxiliary_bearing.clearance_m;
  const double fast = far * two_pi * criticalHz(truth);
  HiddenLaw made{law, 0.0, 0.0};
  if (law == Law::quadratic_damping) made.amount = 0.03 * size * net * far / (fast * fast);
  if (law == Law::cubic_stiffness) made.amount = 0.05 * size * net / (far * far);
  if (law == Law::sensor_dead_zone) {
    made.amount = std::min(0.3, 0.05 * size);
    made.second = between(draw, 0, 5e-6, 12e-6);
  }
  if (law == Law::hum) {
    made.amount = 5e-7 * size * net;
    made.second = draw.uniform[0] < 0.5 ? 50.0 : between(draw, 1, 23.0, 140.0);
  }
  if (law == Law::third_harmonic_force) {
    made.amount = 5e-7 * size * net;
    made.second = phase(draw, 0);
  }
  if (law == Law::speed_stiffness) made.amount = 0.03 * size * net / radPerSecond(typical_speed_hz);
  if (law == Law::current_dead_zone) {
    made.amount = std::min(0.5, 0.05 * size) * truth.rig.amb.current_stiffness_N_per_A;
    made.second = peak_current_A * between(draw, 0, 0.1, 0.3);
  }
  return made;
}

}  // namespace amb_rotor::making

namespace amb_rotor {
std::vector<std::string> hiddenLaws() { return making::law_names; }
}  // namespace amb_rotor
