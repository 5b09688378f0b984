#include "amb_rotor/validation/coordinates.hpp"

#include <algorithm>
#include <cmath>

#include "amb_rotor/common/check.hpp"
#include "amb_rotor/common/units.hpp"
#include "amb_rotor/effects/catalogue.hpp"
#include "amb_rotor/validation/starts.hpp"

namespace amb_rotor {
namespace {

/// Of a rise, over the typical value of what rises: below it there is none to see.
constexpr double least_rise = 1e-4;

/// A factor of either sign goes by its logarithm above this, and is plain below. What two factors share is then told by their
/// sum alone, along a straight valley: that of the shapes of a mode at its magnets and at its sensors ended a quarter off.
constexpr double linear_factor = 0.05;
/// Share of its value that a parameter through contact is known to at best: the steps of a prediction move a Hertzian stiffness
/// by 1e-4 from where exact times of contact have it.
constexpr double contact_step_share = 1e-4;
/// An amplitude of fewer deviations may be nothing, or point the other way.
constexpr double deviations_to_any_phase = 3.0;

/// Its uncertainty is absolute; all others are relative to the believed value.
bool isAngle(const std::string& name) { return name == "unbalance.phase_rad"; }

/// An amplitude of either sign below this share of the next one that shares its phase says nothing of the sign.
constexpr double tells_the_sign = 0.1;

/// Share of the currents' noise by which a limit is rounded: the most of it that was seen is a half.
constexpr double rounded_corner = 0.5;

/// Amplitudes of either sign that share a phase and all of them turned by half a turn are one machine: the one whose first amplitude
/// is positive is what is stated, and its phase within half a turn of 0. So are factors that act by their products (the shapes of a
/// mode) and all of them turned round: the ones that go with those of a free beam, whose ends are positive. What lies at the auxiliary
/// bearings has no say: runs without contact do not tell of it.
void stateOnce(const std::vector<ParameterSchema>& parameters, const Model& belief, std::vector<double>& values) {
  double sum = 0.0;
  const std::vector<double> beam = shapesOfBeam(belief);
  std::size_t place = 0;
  for (std::size_t i = 0; i < parameters.size() && place < beam.size(); ++i) {
    if (parameters[i].role != ParameterRole::factor) continue;
    if (!parameters[i].needs_contact) sum += beam[place] * values[i];
    ++place;
  }
  for (std::size_t i = 0; i < parameters.size() && sum < 0.0; ++i)
    if (parameters[i].role == ParameterRole::factor) values[i] = -values[i];
  std::size_t first = 0;  // of the amplitudes that share the next phase
  for (std::size_t i = 0; i < parameters.size(); ++i) {
    if (parameters[i].role == ParameterRole::amplitude) continue;
    if (parameters[i].role == ParameterRole::phase && i > first && parameters[i].harmonic == 1) {
      std::size_t sign = first;
      while (sign + 1 < i && std::fabs(values[sign]) < tells_the_sign * std::fabs(values[sign + 1])) ++sign;
      if (values[sign] < 0.0) {
        for (std::size_t k = first; k < i; ++k) values[k] = -values[k];
        values[i] += pi;
      }
      values[i] = std::remainder(values[i], two_pi);
    }
    first = i + 1;
  }
}

/// Inertia, magnets' stiffnesses and unbalances are what the forces of a rotor without contact are linear in: as they are, a valley
/// along which all of them grow by one factor is straight. What else is uncertain by a share multiplies.
bool isFactor(const std::string& name, double value) {
  static const char* const linear[] = {"rotor.", "unbalance.", "amb.current_stiffness_N_per_A", "amb.displacement_stiffness_N_per_m",
                                       "amb.stiffness_N_per_m", "amb.damping_N_s_per_m"};
  return value > 0.0 && std::none_of(std::begin(linear), std::end(linear),
                                     [&](const char* one) { return name.rfind(one, 0) == 0; });
}

struct Range {
  double lower, upper;
};

/// What a parameter may be on a rig.
Range rangeOnRig(const std::string& effect, const ParameterSchema& parameter, const Model& belief) {
  Range out = {parameter.lower, parameter.upper};
  narrowToRig(effect, parameter.name, belief, out.lower, out.upper);
  return out;
}

}  // namespace

bool isMachineUncertainty(const std::string& name) { return name.rfind("sensor.", 0) != 0; }

FitSpace::FitSpace(const Model& belief, const std::vector<EffectSetting>& fitted) : belief_(belief), fitted_(fitted) {
  std::vector<double> start;
  // nuisance, in the order of the rig's fields; an entry of the unbalance list each has its own
  Rig<double>::visit(belief_.rig, [&](const char* name, const double& value) {
    const auto found = belief_.uncertainty.find(name);
    if (found == belief_.uncertainty.end()) return;
    const double std = isAngle(name) ? found->second : std::fabs(found->second * value);
    if (std <= 0.0) return;
    Coordinate c;
    c.name = name;
    c.by_logarithm = isFactor(name, value);
    c.is_angle = isAngle(name);
    c.scale = c.prior_std = c.by_logarithm ? std / value : std;
    c.prior_mean = c.by_logarithm ? std::log(value) : value;
    if (c.by_logarithm) {
      c.lower = c.prior_mean - std::log(farthest_factor);
      c.upper = c.prior_mean + std::log(farthest_factor);
    } else if (!c.is_angle) {
      c.lower = value / farthest_factor;
      c.upper = value * farthest_factor;
      if (value < 0.0) std::swap(c.lower, c.upper);
    }
    coordinates_.push_back(c);
    start.push_back(c.prior_mean);
  });
  nuisances_ = static_cast<int>(coordinates_.size());

  for (std::size_t e = 0; e < fitted_.size(); ++e) {
    const EffectSchema* schema = effectCatalogue().find(fitted_[e].id);
    AMB_ROTOR_CHECK(schema != nullptr, "unknown effect " + fitted_[e].id);
    const auto& parameters = schema->parameters;
    const int place = static_cast<int>(e);
    for (int i = 0; i < static_cast<int>(parameters.size()); ++i) {
      const auto& p = parameters[i];
      const double value = fitted_[e].values[i];
      Coordinate c;
      c.name = schema->id + "." + p.name;
      c.scale = scaleOnRig(schema->id, p, belief_);
      const Range range = rangeOnRig(schema->id, p, belief_);
      c.lower = range.lower;
      c.upper = range.upper;
      if (p.role == ParameterRole::fixed) continue;
      const bool vector_next = p.role == ParameterRole::amplitude && i + 1 < static_cast<int>(parameters.size()) &&
                               parameters[i + 1].role == ParameterRole::phase && p.lower >= 0.0 &&
                               (i == 0 || parameters[i - 1].role != ParameterRole::amplitude);
      if (vector_next) {
        const double phase = fitted_[e].values[i + 1] * parameters[i + 1].harmonic;
        c.lower = -p.upper;
        c.upper = p.upper;
        addSlot(place, i, Kind::vector_cosine, c, parameters[i + 1].harmonic, i + 1);
        start.push_back(value * std::cos(phase));
        c.name = schema->id + "." + parameters[i + 1].name;
        addSlot(place, i, Kind::vector_sine, c, parameters[i + 1].harmonic, i + 1);
        start.push_back(value * std::sin(phase));
        ++i;  // the phase went with it
        continue;
      }
      if (p.role == ParameterRole::rise) {
        const double rise = value - fitted_[e].values[i + 1];
        c.lower = std::log(least_rise * c.scale);
        c.upper = std::log(p.upper - p.lower);
        c.scale = 0.1;
        addSlot(place, i, Kind::rise, c, 1, i + 1, rise < 0.0 ? -1.0 : 1.0);
        start.push_back(std::max(c.lower, std::log(std::max(std::fabs(rise), 1e-300))));
      } else if (p.role == ParameterRole::quotient) {
        const Range divisor = rangeOnRig(schema->id, parameters[i + 1], belief_);
        c.lower = std::log(c.lower / divisor.upper);
        c.upper = std::log(c.upper / divisor.lower);
        c.scale = 0.1;
        addSlot(place, i, Kind::quotient, c, 1, i + 1);
        start.push_back(std::log(std::max(value, p.lower) / fitted_[e].values[i + 1]));
      } else if (p.role == ParameterRole::reciprocal) {
        c.lower = 1.0 / p.upper;
        c.upper = 1.0 / p.lower;
        c.scale = 0.1 / p.typical;
        addSlot(place, i, Kind::reciprocal, c);
        start.push_back(1.0 / std::max(value, p.lower));
      } else if (p.role == ParameterRole::factor) {
        c.lower = std::asinh(c.lower / linear_factor);
        c.upper = std::asinh(c.upper / linear_factor);
        c.scale = 0.1;
        addSlot(place, i, Kind::factor, c);
        start.push_back(std::asinh(value / linear_factor));
      } else if (p.lower > 0.0 && p.neutral >= p.upper) {
        c.lower = 1.0 / std::sqrt(p.upper);
        c.upper = 1.0 / std::sqrt(p.lower);
        c.scale = 1.0 / std::sqrt(p.typical);
        addSlot(place, i, Kind::inverse_root, c);
        start.push_back(1.0 / std::sqrt(std::max(value, p.lower)));
      } else if (p.lower > 0.0) {
        c.lower = std::log(c.lower);
        c.upper = std::log(c.upper);
        c.scale = 0.1;
        addSlot(place, i, Kind::logarithm, c);
        start.push_back(std::log(std::max(value, p.lower)));
      } else {
        if (p.role == ParameterRole::phase) c.scale = 0.2;
        addSlot(place, i, Kind::plain, c);
        start.push_back(value);
      }
    }
  }
  start_ = Eigen::Map<Eigen::VectorXd>(start.data(), static_cast<long>(start.size()));
}

void FitSpace::addSlot(int effect, int parameter, Kind kind, const Coordinate& coordinate, int harmonic, int other,
                       double sign) {
  slots_.push_back({effect, parameter, size(), kind, harmonic, other, sign});
  coordinates_.push_back(coordinate);
}

int FitSpace::nuisanceNamed(const std::string& name) const {
  for (int k = 0; k < nuisances_; ++k)
    if (coordinates_[k].name == name) return k;
  return -1;
}

std::vector<int> FitSpace::farFromBelief(const Eigen::VectorXd& x, double deviations) const {
  std::vector<int> far;
  for (int k = 0; k < nuisances_; ++k)
    if (std::fabs(x[k] - coordinates_[k].prior_mean) > deviations * coordinates_[k].prior_std) far.push_back(k);
  return far;
}

Eigen::VectorXd FitSpace::clamped(Eigen::VectorXd x) const {
  for (int i = 0; i < size(); ++i) {
    const Coordinate& c = coordinates_[i];
    if (c.is_angle && std::fabs(x[i] - c.prior_mean) > pi) x[i] = c.prior_mean + std::remainder(x[i] - c.prior_mean, two_pi);
    x[i] = std::min(std::max(x[i], c.lower), c.upper);
  }
  return x;
}

std::vector<double> FitSpace::values(int place, const Eigen::VectorXd& x) const {
  std::vector<double> v = fitted_[place].values;
  for (const Slot& slot : slots_) {
    if (slot.effect != place) continue;
    const double at = x[slot.coordinate];
    switch (slot.kind) {
      case Kind::plain: v[slot.parameter] = at; break;
      case Kind::logarithm: v[slot.parameter] = std::exp(at); break;
      case Kind::inverse_root: v[slot.parameter] = 1.0 / (at * at); break;
      case Kind::reciprocal: v[slot.parameter] = 1.0 / at; break;
      case Kind::factor: v[slot.parameter] = linear_factor * std::sinh(at); break;
      case Kind::rise:
      case Kind::quotient: break;  // below, when what they are counted from is there
      case Kind::vector_cosine: {
        const double sine = x[slot.coordinate + 1];
        v[slot.parameter] = std::hypot(at, sine);
        v[slot.other_parameter] = (at != 0.0 || sine != 0.0) ? std::atan2(sine, at) / slot.harmonic : 0.0;
        break;
      }
      case Kind::vector_sine: break;
    }
  }
  for (const Slot& slot : slots_) {
    if (slot.effect != place || (slot.kind != Kind::rise && slot.kind != Kind::quotient)) continue;
    const auto& p = effectCatalogue().find(fitted_[place].id)->parameters[slot.parameter];
    const Range range = rangeOnRig(fitted_[place].id, p, belief_);
    const double other = v[slot.other_parameter], own = std::exp(x[slot.coordinate]);
    v[slot.parameter] = std::clamp(slot.kind == Kind::rise ? other + slot.sign * own : other * own, range.lower, range.upper);
  }
  stateOnce(effectCatalogue().find(fitted_[place].id)->parameters, belief_, v);
  return v;
}

Model FitSpace::model(const Eigen::VectorXd& at) const {
  const Eigen::VectorXd x = clamped(at);
  Model model = belief_;
  model.source.reset();  // what is fitted is no longer the file's
  int next = 0;
  Rig<double>::visit(model.rig, [&](const char* name, double& value) {
    if (next >= nuisances_ || coordinates_[next].name != name) return;
    value = coordinates_[next].by_logarithm ? std::exp(x[next]) : x[next];
    ++next;
  });
  for (std::size_t e = 0; e < fitted_.size(); ++e) {
    EffectSetting setting{fitted_[e].id, values(static_cast<int>(e), x)};
    const auto there = std::find_if(model.effects.begin(), model.effects.end(),
                                    [&](const EffectSetting& s) { return s.id == setting.id; });
    if (there != model.effects.end())
      *there = setting;
    else
      model.effects.push_back(setting);
  }
  return model;
}

int FitSpace::coordinateOf(int place, int parameter) const {
  const auto slot = std::find_if(slots_.begin(), slots_.end(),
                                 [&](const Slot& s) { return s.effect == place && s.parameter == parameter; });
  AMB_ROTOR_CHECK(slot != slots_.end(), "a rise, or a quotient, stands before what it is counted from");
  return slot->coordinate;
}

/// A standard deviation of what is fitted by a function of it: to the farther of the values one deviation to either side.
double FitSpace::spread(Kind kind, const Coordinate& c, double x, double std) {
  const auto at = [&](double y) {
    if (kind == Kind::reciprocal) return 1.0 / y;
    if (kind == Kind::factor) return linear_factor * std::sinh(y);
    return kind == Kind::inverse_root ? 1.0 / (y * y) : std::exp(y);
  };
  const double here = at(x);
  return std::max(std::fabs(at(std::min(x + std, c.upper)) - here), std::fabs(at(std::max(x - std, c.lower)) - here));
}

std::vector<FittedParameter> FitSpace::nuisanceValues(const Eigen::VectorXd& x,
                                                      const Eigen::MatrixXd& covariance) const {
  std::vector<FittedParameter> out;
  for (int i = 0; i < nuisances_; ++i) {
    const double std = std::sqrt(std::max(0.0, covariance(i, i)));
    const double value = coordinates_[i].by_logarithm ? std::exp(x[i]) : x[i];
    out.push_back({coordinates_[i].name, "", value, coordinates_[i].by_logarithm ? value * std : std});
  }
  return out;
}

std::vector<FittedParameter> FitSpace::effectValues(int place, const Eigen::VectorXd& at,
                                                    const Eigen::MatrixXd& covariance) const {
  const Eigen::VectorXd x = clamped(at);
  const EffectSchema& schema = *effectCatalogue().find(fitted_[place].id);
  const std::vector<double> v = values(place, x);
  std::vector<FittedParameter> out;
  for (std::size_t i = 0; i < schema.parameters.size(); ++i)
    out.push_back({schema.parameters[i].name, schema.parameters[i].unit, v[i], 0.0});
  for (const Slot& slot : slots_) {
    if (slot.effect != place) continue;
    const int c = slot.coordinate;
    // what no run determines is somewhere in its range
    const double range = coordinates_[c].upper - coordinates_[c].lower;
    const double variance = std::min(std::max(0.0, covariance(c, c)), range * range / 12.0);
    switch (slot.kind) {
      case Kind::plain: out[slot.parameter].std = std::sqrt(variance); break;
      case Kind::logarithm:
      case Kind::inverse_root:
      case Kind::reciprocal: out[slot.parameter].std = spread(slot.kind, coordinates_[c], x[c], std::sqrt(variance)); break;
      case Kind::factor: {  // the range of values is the narrower one where no run tells: the coordinate's ends are far out
        const double most = linear_factor * (std::sinh(coordinates_[c].upper) - std::sinh(coordinates_[c].lower));
        out[slot.parameter].std =
            std::min(spread(slot.kind, coordinates_[c], x[c], std::sqrt(variance)), most / std::sqrt(12.0));
        break;
      }
      case Kind::rise: {
        const double own = slot.sign * spread(slot.kind, coordinates_[c], x[c], std::sqrt(variance));
        const int from = coordinateOf(place, slot.other_parameter);
        const double below = std::max(0.0, covariance(from, from));
        const double together = variance > 0.0 ? covariance(c, from) / std::sqrt(variance) : 0.0;
        out[slot.parameter].std = std::sqrt(std::max(0.0, own * own + below + 2.0 * own * together));
        break;
      }
      case Kind::quotient: {  // as the sum of two logarithms
        const int from = coordinateOf(place, slot.other_parameter);
        const double sum = variance + std::max(0.0, covariance(from, from)) + 2.0 * covariance(c, from);
        const Range own = rangeOnRig(schema.id, schema.parameters[slot.parameter], belief_);
        out[slot.parameter].std =
            std::min(std::fabs(v[slot.parameter]) * std::sqrt(std::max(0.0, sum)), (own.upper - own.lower) / std::sqrt(12.0));
        break;
      }
      case Kind::vector_cosine: {
        const double a = std::max(v[slot.parameter], 1e-300);
        const double cs = x[c] / a, sn = x[c + 1] / a;
        const double radial = cs * cs * variance + sn * sn * covariance(c + 1, c + 1) + 2 * cs * sn * covariance(c, c + 1);
        const double across = sn * sn * variance + cs * cs * covariance(c + 1, c + 1) - 2 * cs * sn * covariance(c, c + 1);
        out[slot.parameter].std = std::sqrt(std::max(0.0, radial));
        // one that may be nothing within three deviations may have any phase within three of its own
        const double least = a < deviations_to_any_phase * out[slot.parameter].std ? pi / deviations_to_any_phase : 0.0;
        out[slot.other_parameter].std = std::min(pi, std::max(least, std::sqrt(std::max(0.0, across)) / a)) / slot.harmonic;
        break;
      }
      case Kind::vector_sine: break;
    }
    FittedParameter& own = out[slot.parameter];
    if (fitted_[place].id == "current_saturation") own.std = std::hypot(own.std, rounded_corner * current_noise_A_);
    if (needsContact(fitted_[place].id)) {
      own.std = std::hypot(own.std, contact_step_share * own.value);
    }
  }
  return out;
}

}  // namespace amb_rotor
