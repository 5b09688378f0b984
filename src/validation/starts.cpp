#include "amb_rotor/validation/starts.hpp"

#include <algorithm>
#include <cmath>

#include "amb_rotor/common/units.hpp"
#include "amb_rotor/effects/catalogue.hpp"
#include "amb_rotor/model/model_rules.hpp"
#include "amb_rotor/validation/coordinates.hpp"

namespace amb_rotor {
namespace {

/// First free-free bending mode of a uniform beam over [-h, h] about z = middle, 1 at the ends; without a length all is an end.
double beamShape(double z, double middle, double half) {
  if (!(half > 0.0)) return 1.0;
  constexpr double wavelength = 4.730040745;
  constexpr double ratio = 0.982502215;
  const double s = std::min(std::max((z - middle + half) / (2.0 * half), 0.0), 1.0) * wavelength;
  return 0.5 * (std::cosh(s) + std::cos(s) - ratio * (std::sinh(s) + std::sin(s)));
}

bool anyTurning(const std::vector<Recording>& recordings) {
  return std::any_of(recordings.begin(), recordings.end(), [](const Recording& r) { return !r.standstill; });
}

bool anyContact(const std::vector<Recording>& recordings) {
  return std::any_of(recordings.begin(), recordings.end(), [](const Recording& r) { return r.holdsContact(); });
}

double largestCurrent(const std::vector<Recording>& recordings) {
  double largest = 0.0;
  for (const auto& r : recordings)
    for (long i = 0; i < r.samples; ++i)
      for (int a = 4; a < 8; ++a) largest = std::max(largest, std::fabs(r.measured[i * predicted_channels + a]));
  return largest;
}

/// How deep an end goes into its auxiliary bearing, not exceeded in this share of the samples that touch [m]; 0: none does.
double penetration(const Model& belief, const std::vector<Recording>& recordings, double share) {
  std::vector<double> depths;
  for (const auto& r : recordings) {
    if (!r.holdsContact()) continue;
    for (long i = 0; i < r.samples; ++i) {
      for (const double z : belief.rig.planes.aux) {
        const double depth = radiusAt(r.measured.data() + i * predicted_channels, belief, z) - belief.rig.auxiliary_bearing.clearance_m;
        if (depth > 0.0) depths.push_back(depth);
      }
    }
  }
  if (depths.empty()) return 0.0;
  const auto at = depths.begin() + static_cast<long>(share * static_cast<double>(depths.size() - 1));
  std::nth_element(depths.begin(), at, depths.end());
  return *at;
}

/// Stiffness of an auxiliary bearing with what carries it, as the rotor rests on two after a drop: half its weight over how deep it lies
/// [N/m]; 0: it does not, or nothing weighs on them.
double stiffnessAtRest(const Model& belief, const std::vector<Recording>& recordings) {
  const double depth = penetration(belief, recordings, 0.5), weight = belief.rig.rotor.mass_kg * std::fabs(belief.rig.gravity_m_s2);
  return depth > 0.0 ? 0.5 * weight / depth : 0.0;
}

/// Fastest turning of the runs that hold contact, of all where those stand still [rad/s].
double fastestWithContact(const std::vector<Recording>& recordings) {
  double with_contact = 0.0, any = 1.0;
  for (const auto& r : recordings) {
    const double speed = r.startingSpeed();
    any = std::max(any, std::fabs(speed));
    if (r.holdsContact()) with_contact = std::max(with_contact, std::fabs(speed));
  }
  return with_contact > 0.0 ? with_contact : any;
}

/// What must hold between the rig's numbers (model/model_rules.hpp), where a parameter stands in place of one of them.
void narrowToRelations(const std::string& effect, const Model& belief, double& lower, double& upper,
                       const std::string& parameter) {
  constexpr double beyond = 1.0 + 1e-6;  // a limit itself may not do
  const auto& rig = belief.rig;
  if (effect == "gyroscopic_coupling") upper = std::min(upper, 2.0 * rig.rotor.transverse_inertia_kg_m2);
  if (belief.amb_model != AmbModel::linear) return;
  if (effect == "auxiliary_bearing_misalignment") {  // x and y together: within the square in the circle
    const double room = std::sqrt(0.5) * (rig.amb.air_gap_m - rig.auxiliary_bearing.clearance_m) / beyond;
    lower = std::max(lower, -room);
    upper = std::min(upper, room);
  }
  if (effect == "magnetic_nonlinearity" && parameter == "air_gap_m")
    lower = std::max(lower, beyond * rig.auxiliary_bearing.clearance_m);
  if (effect == "magnetic_nonlinearity" && parameter == "bias_current_A") upper = std::min(upper, rig.amb.max_current_A);
  if (effect == "current_saturation") lower = std::max(lower, rig.amb.bias_current_A);
  if (effect == "control_delay") upper = std::min(upper, max_delay_samples / rig.controller.sample_rate_hz);
}

}  // namespace

void narrowToRig(const std::string& effect, const std::string& parameter, const Model& belief, double& lower,
                 double& upper) {
  if (effect == "shaft_flexibility") {
    // steel with its fits stays below; a shape of 1 is the rms over the rotor's mass, 2 the end of a uniform beam
    if (parameter == "damping_ratio") upper = std::min(upper, 0.2);
    if (parameter.rfind("shape_", 0) == 0) {
      lower = std::max(lower, -6.0);
      upper = std::min(upper, 6.0);
    }
  }
  if (effect == "magnetic_saturation" && belief.rig.amb.bias_flux_density_T > 0.0)
    lower = std::max(lower, belief.rig.amb.bias_flux_density_T);  // the iron carries its bias flux
  narrowToRelations(effect, belief, lower, upper, parameter);
  if (effect != "compliant_mount") return;
  const double mass = belief.rig.rotor.mass_kg, stiffness = belief.rig.auxiliary_bearing.stiffness_N_per_m;
  if (parameter == "stiffness_N_per_m") lower = std::max(lower, 0.001 * stiffness);
  if (parameter == "damping_N_s_per_m") upper = std::min(upper, 3.0 * std::sqrt(0.1 * stiffness * mass));
  if (parameter == "mass_kg") {
    lower = std::max(lower, 1e-3 * mass);
    upper = std::min(upper, 0.5 * mass);
  }
}

double scaleOnRig(const std::string& effect, const ParameterSchema& parameter, const Model& belief) {
  constexpr double at_rad_s = 400.0, slower_rad_s2 = 2.0;  // 1 rad after 1 s
  const double inertia = belief.rig.rotor.polar_inertia_kg_m2;
  if (effect == "spin_drag" && parameter.name == "torque_N_m" && inertia > 0.0) return slower_rad_s2 * inertia;
  if (effect == "spin_drag" && parameter.name == "decay_per_s") return slower_rad_s2 / at_rad_s;
  return std::fabs(parameter.typical) > 0.0 ? std::fabs(parameter.typical) : 1.0;
}

std::vector<double> shapesOfBeam(const Model& belief) {
  const auto& rig = belief.rig;
  const double half = 0.575 * (rig.planes.aux[1] - rig.planes.aux[0]);
  const double middle = 0.5 * (rig.planes.aux[1] + rig.planes.aux[0]);
  std::vector<double> out;
  const auto add = [&](double z) { out.push_back(1.4 * beamShape(z, middle, half)); };
  for (const double* planes : {rig.planes.amb, rig.planes.sensor, rig.planes.aux})
    for (int end = 0; end < 2; ++end) add(planes[end]);
  add(rig.unbalance.empty() ? middle : rig.unbalance[0].plane_z_m);
  return out;
}

bool isSizedByWhatStoodIn(const std::string& effect) { return effect == "foundation_resonance"; }

void sizeByWhatStoodIn(EffectSetting& effect, double believed, double stood) {
  effect.values[0] = believed * stood / (believed - stood);
}

bool startsAreAScan(const std::string& effect) { return effect == "foundation_resonance"; }

double usableShare(const std::string& effect, double share) {
  return effect == "shaft_flexibility" && share > 0.0 ? std::clamp(share, 0.01, 4.0) : share;
}

void scaleStart(EffectSetting& effect, double share) {
  const auto& parameters = effectCatalogue().find(effect.id)->parameters;
  for (std::size_t i = 0; i < parameters.size(); ++i) {
    const ParameterSchema& p = parameters[i];
    double factor = 1.0;
    if (effect.id == "shaft_flexibility") {
      if (p.name.rfind("shape_", 0) == 0) factor = std::sqrt(usableShare(effect.id, std::max(share, 0.01)));
    } else if (p.role == ParameterRole::amplitude) {
      factor = share;
    } else if (p.neutral >= p.upper && share > 0.0) {
      factor = 1.0 / (effect.id == "magnetic_saturation" ? std::pow(share, 0.25) : share);
    }
    if (factor != 1.0) effect.values[i] = std::clamp(factor * effect.values[i], p.lower, p.upper);
  }
}

/// Decay [1/s] and torque [N m] that slow the runs of constant speed down as their pulses show: W' = -c W - T/Ip, least squares
/// over the runs, neither below 0. Nothing: the pulses do not show it.
std::vector<double> dragOfPulses(const Model& belief, const std::vector<Recording>& recordings) {
  constexpr double significant = 5.0;         // standard deviations of a run's deceleration
  constexpr double least_edge_std_s = 1e-7;  // of pulses on a ramp of two samples
  const double inertia = belief.rig.rotor.polar_inertia_kg_m2;
  double ss = 0.0, s1 = 0.0, n = 0.0, sd = 0.0, d1 = 0.0;
  bool seen = false;
  for (const auto& rec : recordings) {
    if (rec.path != nullptr || rec.standstill || rec.holdsContact() || rec.pulses.state != TachoState::turning) continue;
    const SpeedFit fit = fitSpeed(rec.pulses, 0, true, least_edge_std_s);
    if (!fit.valid || !(fit.acceleration_std > 0.0)) continue;
    const double speed = fit.speed + 0.5 * fit.acceleration * rec.duration(), weight = 1.0 / (fit.acceleration_std * fit.acceleration_std), slowed = -fit.acceleration;
    seen = seen || slowed > significant * fit.acceleration_std;
    ss += weight * speed * speed;
    s1 += weight * speed;
    n += weight;
    sd += weight * speed * slowed;
    d1 += weight * slowed;
  }
  if (!seen) return {};
  const double det = ss * n - s1 * s1;
  double decay = sd / ss, constant = 0.0;
  if (inertia > 0.0 && det > 1e-9 * ss * n) {
    decay = (sd * n - d1 * s1) / det;
    constant = (ss * d1 - s1 * sd) / det;
    if (constant < 0.0) decay = sd / ss, constant = 0.0;
    if (decay < 0.0) decay = 0.0, constant = d1 / n;
  }
  return {std::max(decay, 0.0), std::max(constant, 0.0) * std::max(inertia, 0.0)};
}

/// Share of the believed contact stiffness below which the contact counts as softened by what carries it, and of the believed
/// friction below which that counts as fallen.
constexpr double much_softer = 0.5, much_less_friction = 0.6;
/// Share of it below which a model without a mount has come down as far as it can.
constexpr double soft_as_can_be = 1.2 / farthest_factor;

std::vector<std::vector<double>> startingValues(const std::string& effect, const Model& belief,
                                                const std::vector<Recording>& recordings, std::string& reason,
                                                const SeenContact& seen) {
  const EffectSchema& schema = *effectCatalogue().find(effect);
  const auto& rig = belief.rig;
  reason.clear();
  if (schema.needs_contact && !anyContact(recordings)) {
    reason = "no run holds contact";
    return {};
  }
  if (schema.law != nullptr) return startsOfOwnEffect(schema);
  const bool rotating = anyTurning(recordings);
  static const char* const turning[] = {"couple_unbalance", "gyroscopic_coupling", "cross_coupled_stiffness",
                                        "spin_drag", "shaft_crack", "shaft_bow", "sensor_runout"};
  if (!rotating && std::find(std::begin(turning), std::end(turning), effect) != std::end(turning)) {
    reason = "no run turns";
    return {};
  }
  const bool linear = belief.amb_model == AmbModel::linear;
  static const char* const electric[] = {"magnetic_nonlinearity", "magnetic_saturation", "current_saturation",
                                         "amplifier_lag", "control_delay", "eddy_current_lag"};
  if (!linear && std::find(std::begin(electric), std::end(electric), effect) != std::end(electric)) {
    reason = "the bearing has no coil and controller";
    return {};
  }
  const double kc = rig.auxiliary_bearing.stiffness_N_per_m, dc = rig.auxiliary_bearing.damping_N_s_per_m;
  const double span = rig.planes.amb[1] - rig.planes.amb[0];
  std::vector<double> neutral;
  for (const auto& p : schema.parameters) neutral.push_back(std::isfinite(p.neutral) ? p.neutral : p.typical);
  const auto with = [&](std::initializer_list<double> values) { return std::vector<double>(values); };

  if (effect == "couple_unbalance")
    return {with({0.0, 0.0, 0.5 * span}), with({0.0, 0.0, -0.5 * span})};
  if (effect == "shaft_bow") {
    std::vector<std::vector<double>> out;  // either end alone; half a turn on is the other sign
    for (int k = 0; k < 4; ++k) {
      out.push_back({1e-6, 0.0, 0.25 * pi * k});
      out.push_back({0.0, 1e-6, 0.25 * pi * k});
    }
    return out;
  }
  if (effect == "shaft_crack") {
    std::vector<std::vector<double>> out;  // what it does twice a turn is of one phase at all quarters
    for (int k = 0; k < 8; ++k) out.push_back({0.02, 0.25 * pi * k});
    return out;
  }
  if (effect == "shaft_flexibility" && belief.rotor_model != RotorModel::rigid_beam) {
    reason = "only a rigid beam has no bending of its own and tilts";
    return {};
  }
  if (effect == "gyroscopic_coupling" && belief.rotor_model != RotorModel::rigid_beam) {
    reason = "only a rigid beam tilts without a gyroscopic matrix of its own";
    return {};
  }
  if (effect == "gyroscopic_coupling") {
    // a long rotor to a disc: the split of the conical mode takes the responses through their peaks
    std::vector<std::vector<double>> out;
    for (double share : {0.02, 0.1, 0.3, 0.8}) out.push_back({share * rig.rotor.transverse_inertia_kg_m2});
    return out;
  }
  if (effect == "spin_drag") {  // turns that are lost are out of reach from none
    const auto drag = dragOfPulses(belief, recordings);
    return {drag.empty() ? neutral : drag};
  }
  if (effect == "cross_coupled_stiffness") return {with({0.0, 100.0, 1.0, 0.0})};
  if (effect == "foundation_resonance") {
    std::vector<std::vector<double>> out;
    // the peak at a damping of 0.03 is 6 % wide, and a fit climbs no hill from outside
    for (double f = 12.0; f < 250.0; f *= 1.1) out.push_back({10.0 * rig.rotor.mass_kg, f, 0.03});
    return out;
  }
  if (effect == "magnetic_nonlinearity")
    return {with({rig.amb.bias_current_A, rig.amb.air_gap_m > 0.0 ? rig.amb.air_gap_m : 0.6e-3})};
  if (effect == "magnetic_saturation") {
    if (rig.amb.bias_flux_density_T <= 0.0) {
      reason = "the rig's bias_flux_density_T is not stated";
      return {};
    }
    std::vector<std::vector<double>> out;
    for (double share : {3.5, 2.2, 1.5, 1.1}) out.push_back({share * rig.amb.bias_flux_density_T});
    return out;
  }
  if (effect == "current_saturation") {
    // a limit far below what was measured is none; a little above it shows, too, where wrong numbers ask for more than the rig
    // did, and with these a limit below may lose the rotor
    const double seen = largestCurrent(recordings), bias = rig.amb.bias_current_A;
    std::vector<std::vector<double>> out;
    for (double share : {1.1, 1.04, 0.99, 0.95, 0.9, 0.8})
      if (bias + share * seen < rig.amb.max_current_A) out.push_back({bias + share * seen});
    if (out.empty()) reason = "no command comes near a limit below the believed one";
    return out;
  }
  if (effect == "amplifier_lag") return {with({rig.amb.amplifier_bandwidth_hz})};
  if (effect == "control_delay") return {with({rig.controller.delay_s})};
  if (effect == "eddy_current_lag") return {with({1e5})};
  if (effect == "hertzian_contact") {
    // the same energy as the linear law at the penetrations seen, or at lesser ones
    const double seen = std::min(std::max(penetration(belief, recordings, 0.9), 1e-6), 5e-5);
    std::vector<std::vector<double>> out;
    for (double d : {seen, 0.4 * seen, 0.15 * seen}) out.push_back({1.25 * kc / std::sqrt(d), std::max(dc / (kc * d), 1e-3)});
    return out;
  }
  if (effect == "compliant_mount") {
    std::vector<std::vector<double>> out;
    const auto add = [&](double stiffness, double damping, double share) {
      const double mass = share * rig.rotor.mass_kg;
      out.push_back({stiffness, damping * std::sqrt(stiffness * mass), mass});
    };
    if (seen.stiffness_N_per_m > 0.0 && seen.stiffness_N_per_m < much_softer * kc) {
      // a mount softer than the model's contact can be shows in how deep the rotor lies, and swings with that
      const double resting = seen.stiffness_N_per_m < soft_as_can_be * kc ? stiffnessAtRest(belief, recordings) : 0.0;
      const bool softer = resting > 0.0 && resting < seen.stiffness_N_per_m;
      const double stiffness = 1.0 / (1.0 / (softer ? resting : seen.stiffness_N_per_m) - 1.0 / kc);
      for (double mass : {0.005, 0.015, 0.04})
        for (double damping : {0.3, 1.0}) add(stiffness, softer ? damping / std::sqrt(mass) : damping, mass);
    } else {
      for (double share : {0.15, 0.6})
        for (double mass : {0.005, 0.015, 0.04}) add(share * kc, 0.3, mass);
    }
    return out;
  }
  if (effect == "velocity_dependent_friction") {
    const double mu = rig.auxiliary_bearing.friction_coefficient;
    // the first is next to the believed law, the last fall far
    std::vector<std::vector<double>> out = {with({1.05 * mu, 0.95 * mu, 1.5}), with({1.6 * mu, 0.7 * mu, 1.0}),
                                            with({1.6 * mu, 0.7 * mu, 4.0}), with({4.0 * mu, 0.3 * mu, 0.7}),
                                            with({4.0 * mu, 0.3 * mu, 2.5})};
    if (seen.friction_coefficient > 0.0 && seen.friction_coefficient < much_less_friction * mu)
      out.push_back(with({4.0 * mu, seen.friction_coefficient, 0.7}));
    return out;
  }
  if (effect == "inner_ring_spin") {
    // rings that the weight's friction brings to the rotor's speed in a few, some ten and some hundred ms, with little and
    // with much drag
    const double torque = rig.auxiliary_bearing.friction_coefficient * rig.rotor.mass_kg * standard_gravity_m_s2 *
                          rig.auxiliary_bearing.rotor_radius_m;
    const double speed = fastestWithContact(recordings);
    std::vector<std::vector<double>> out;
    for (double time_s : {3e-3, 3e-2, 0.3})
      for (double drag : {0.05, 0.4}) out.push_back({torque * time_s / speed, drag * torque});
    return out;
  }
  if (effect == "shaft_flexibility") {
    const std::vector<double> shapes = shapesOfBeam(belief);
    std::vector<std::vector<double>> out;
    for (double f : {180.0, 260.0, 370.0, 530.0, 760.0, 1100.0}) {
      std::vector<double> v = {f, 0.01};
      v.insert(v.end(), shapes.begin(), shapes.end());
      out.push_back(v);
    }
    return out;
  }
  return {neutral};
}

}  // namespace amb_rotor
