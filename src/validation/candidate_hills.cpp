// Other places where an effect that a fit has found may do better, out of its reach.
//
// A bending mode at other frequencies. Where one step alone makes a mode ring, chi2 over its frequency has hills beside each other, a
// turn of the ring's phase apart, and a fit ends on the one where it began. Each other frequency is judged by one prediction: its
// change D to the predicted channels, freed of what all other unknowns can do to first order, with r what the fit has left, lowers
// chi2 by 2 D'r - D'D (amb_rotor/validation/start_screen.hpp). The static softness that the mode adds goes with the square of its
// shapes over that of its frequency, and stands: the shapes go along. The best of them are fitted.
//
// A crack half a turn on. What its stiffness does twice a turn is the same there, what it does once and thrice a turn has the other
// sign; a nuisance that has been pulled away holds the wrong one.
//
// A force at a place along the shaft, of the other sign at either magnetic bearing. From where it does nothing a fit learns of its size
// alone, and goes where that leads: it passes neither through nothing to the other sign, nor along the shaft while it does little.
//
// A bending mode, and the unbalance that drives it, both half a turn off. A fit without the mode turns the unbalance where the mode's part
// is the larger, and with the mode it ends where the unbalance drives that the other way.
//
// A friction that falls with the slip v, mu_d + (mu_s - mu_d) exp(-v/v_s), over another v_s. Runs tell of it at the slips that they
// have, mostly the rotor's radius times its speed; two laws that agree there are as good as each other, and a fit ends at the one where
// it began.
#include <algorithm>
#include <cmath>

#include "amb_rotor/common/linear_algebra.hpp"
#include "amb_rotor/common/units.hpp"
#include "amb_rotor/effects/catalogue.hpp"
#include "candidate_hills.hpp"
#include "foreseen.hpp"
#include "seen_shapes.hpp"

namespace amb_rotor {
namespace {

/// As far as other frequencies of a ring are looked for, their distance, and two of them that are on one hill: a ring of a hundred turns
/// shows its frequency to a hundredth. And farther off, where a fit without the mode has pulled the rig to where a softness without a
/// ring does best.
constexpr double hill_reach = 1.4, hill_step = 1.012, one_hill = 1.015, far_reach = 2.5, far_step = 1.04;
/// Damping ratio of a ring that a hill may have, beside that found, and drop of chi2 that one must promise.
constexpr double ringing = 0.008, worth_climbing = 20.0;
constexpr std::size_t most_hills = 2, models_at_once = 8;
/// Mean square over the noise below which nothing is to be had by half a turn, or far off.
constexpr double next_to_nothing = 1.06;
constexpr double quarter_turn = 0.5 * pi;
/// Times the speed over which a friction falls, the lesser where no law agrees so far off, and ratio from which on two slips are apart.
constexpr double other_falls[] = {3.5, 1.8, 1.4}, apart = 1.2;
/// Ratio of speeds up to which two falls are one.
constexpr double one_fall = 1.3;

/// The mode at so many times its frequency.
EffectSetting movedTo(EffectSetting mode, double ratio, double damping_ratio) {
  const EffectSchema& schema = *effectCatalogue().find(mode.id);
  for (std::size_t i = 0; i < mode.values.size(); ++i) {
    const ParameterSchema& p = schema.parameters[i];
    if (p.name == "damping_ratio")
      mode.values[i] = damping_ratio;
    else
      mode.values[i] = std::clamp(mode.values[i] * ratio, p.lower, p.upper);
  }
  return mode;
}

/// Which number of an effect at a place along the shaft is a size of either sign; -1: none.
int signedSizeOf(const std::string& effect) {
  const EffectSchema& schema = *effectCatalogue().find(effect);
  if (schema.only_by_name || schema.indexOf("z_m") < 0) return -1;
  for (std::size_t i = 0; i < schema.parameters.size(); ++i) {
    const ParameterSchema& p = schema.parameters[i];
    if (p.name != "z_m" && p.neutral == 0.0 && p.lower < 0.0 && p.upper > 0.0) return static_cast<int>(i);
  }
  return -1;
}

/// Slips at which a rotor that does not whirl touches, of the runs to fit.
std::vector<double> slipsOf(const std::vector<Recording>& recordings, double radius_m) {
  std::vector<double> out;
  for (const Recording& rec : recordings)
    if (rec.holdsContact() && rec.run.use == RunUse::fit) out.push_back(radius_m * std::fabs(rec.startingSpeed()));
  return out;
}

}  // namespace

std::vector<EffectSetting> actingAlike(const EffectSetting& effect, const Model& belief, const std::vector<Recording>& recordings) {
  if (effect.id != "velocity_dependent_friction") return {};
  const EffectSchema& schema = *effectCatalogue().find(effect.id);
  const int rest = schema.indexOf("static_coefficient"), moving = schema.indexOf("dynamic_coefficient"), fall = schema.indexOf("speed_m_per_s");
  const std::vector<double> slips = slipsOf(recordings, belief.rig.auxiliary_bearing.rotor_radius_m);
  const auto [slowest, fastest] = std::minmax_element(slips.begin(), slips.end());
  if (slips.empty() || *fastest < apart * *slowest) return {};
  std::vector<EffectSetting> out;
  const auto addAt = [&](double times) {
    EffectSetting other = effect;
    other.values[fall] *= times;
    Eigen::Matrix2d squares = Eigen::Matrix2d::Zero();  // least squares for mu_d and mu_s - mu_d
    Eigen::Vector2d along = Eigen::Vector2d::Zero();
    for (const double slip : slips) {
      const Eigen::Vector2d terms(1.0, std::exp(-slip / other.values[fall]));
      squares += terms * terms.transpose();
      along += (effect.values[moving] + (effect.values[rest] - effect.values[moving]) * std::exp(-slip / effect.values[fall])) * terms;
    }
    const Eigen::Vector2d law = Ldlt(squares).solve(along);
    other.values[moving] = law[0];
    other.values[rest] = law.sum();
    const auto inside = [&](int i) { return other.values[i] > schema.parameters[i].lower && other.values[i] < schema.parameters[i].upper; };
    const bool possible = law.allFinite() && inside(rest) && inside(moving) && inside(fall);
    if (possible) out.push_back(std::move(other));
    return possible;
  };
  for (const bool faster : {true, false})
    for (const double times : other_falls)
      if (addAt(faster ? times : 1.0 / times)) break;
  return out;
}

bool actsInOnePlace(const EffectSetting& one, const EffectSetting& other) {
  const int fall = effectCatalogue().find(one.id)->indexOf("speed_m_per_s");
  return std::fabs(std::log(one.values[fall] / other.values[fall])) < std::log(one_fall);
}

bool isUnbalanceTurned(const FitSpace& space, const Eigen::VectorXd& nuisance) {
  for (int k = 0; k < space.nuisances(); ++k) {
    const Coordinate& one = space.coordinates()[k];
    if (one.name == "unbalance.phase_rad" && std::fabs(std::remainder(nuisance[k] - one.prior_mean, two_pi)) > quarter_turn) return true;
  }
  return false;
}

EffectSetting drivenTheOtherWay(EffectSetting mode) {
  const EffectSchema& schema = *effectCatalogue().find(mode.id);
  const int i = schema.indexOf("shape_unbalance");
  mode.values[i] = std::clamp(-mode.values[i], schema.parameters[i].lower, schema.parameters[i].upper);
  return mode;
}

Trial Candidates::onHighestHill(Trial trial, int iterations) const {
  trial = onTheOtherSide(halfATurnOn(std::move(trial), iterations), iterations);
  return amongFrequencies(unbalanceTurnedBack(std::move(trial), iterations), iterations);
}

Trial Candidates::betterFrom(const Settings& effects, const Eigen::VectorXd& nuisance, Trial trial, int iterations) const {
  Trial more = fit(effects, &nuisance, trial.local, {Through::free, iterations, true});
  return more.fit.finite && more.fit.chi2 < trial.fit.chi2 ? more : trial;
}

Trial Candidates::halfATurnOn(Trial trial, int iterations) const {
  if (!trial.fit.finite || trial.fit.squares < next_to_nothing * trial.fit.count) return trial;
  Settings turned = trial.effects();
  const auto crack = std::find_if(turned.begin(), turned.end(), [](const EffectSetting& e) { return e.id == "shaft_crack"; });
  if (crack == turned.end()) return trial;
  double& phase = crack->values[effectCatalogue().find(crack->id)->indexOf("phase_rad")];
  phase += phase > 0.0 ? -pi : pi;
  for (const Eigen::VectorXd& nuisance : {Eigen::VectorXd(trial.space->start().head(trial.space->nuisances())), trial.nuisance()}) {
    if (limit_.isUp()) break;
    trial = betterFrom(turned, nuisance, std::move(trial), iterations);
  }
  return trial;
}

Trial Candidates::onTheOtherSide(Trial trial, int iterations) const {
  if (!trial.fit.finite || trial.fit.squares < next_to_nothing * trial.fit.count) return trial;
  Settings other = trial.effects();
  const int size = other.empty() ? -1 : signedSizeOf(other.back().id);
  if (size < 0) return trial;
  EffectSetting& effect = other.back();  // those before have had their turn
  effect.values[size] *= -1.0;
  const Eigen::VectorXd believed = trial.space->start().head(trial.space->nuisances());
  for (const double z : belief_.rig.planes.amb) {
    if (limit_.isUp()) break;
    effect.values[effectCatalogue().find(effect.id)->indexOf("z_m")] = z;
    trial = betterFrom(other, believed, std::move(trial), iterations);
  }
  return trial;
}

Trial Candidates::unbalanceTurnedBack(Trial trial, int iterations) const {
  if (!trial.fit.finite || trial.fit.squares < next_to_nothing * trial.fit.count || limit_.isUp()) return trial;
  Settings back = trial.effects();
  const auto mode = std::find_if(back.begin(), back.end(), [](const EffectSetting& e) { return hasShapes(e.id); });
  if (mode == back.end() || !isUnbalanceTurned(*trial.space, trial.nuisance())) return trial;
  *mode = drivenTheOtherWay(*mode);
  Eigen::VectorXd believed = trial.nuisance();
  for (int k = 0; k < believed.size(); ++k) {
    const Coordinate& one = trial.space->coordinates()[k];
    if (one.name.rfind("unbalance.", 0) == 0) believed[k] = one.prior_mean;
  }
  return betterFrom(back, believed, std::move(trial), iterations);
}

Trial Candidates::amongFrequencies(Trial trial, int iterations) const {
  const Settings found = trial.effects();
  const auto mode = std::find_if(found.begin(), found.end(), [](const EffectSetting& e) { return hasShapes(e.id); });
  if (mode == found.end() || !trial.fit.finite || limit_.isUp()) return trial;
  const StartScreen about(recordings_, fit_free_, *trial.space, trial.fit.x, trial.local, offset_std_);
  const double damping_ratio = mode->values[effectCatalogue().find(mode->id)->indexOf("damping_ratio")];
  struct Hill {
    double ratio, drop;
    Settings start;
  };
  std::vector<Hill> hills;
  const double reach = trial.fit.squares > next_to_nothing * trial.fit.count ? far_reach : hill_reach;
  for (double ratio = hill_step; ratio < reach; ratio *= ratio < hill_reach ? hill_step : far_step)
    for (const double side : {ratio, 1.0 / ratio})
      for (const double damping : {damping_ratio, ringing}) {
        Settings start = found;
        start[mode - found.begin()] = movedTo(*mode, side, damping);
        hills.push_back({side, 0.0, std::move(start)});
      }
  for (std::size_t from = 0; from < hills.size() && !limit_.isUp(); from += models_at_once) {
    std::vector<Settings> starts;
    for (std::size_t i = from; i < std::min(hills.size(), from + models_at_once); ++i) starts.push_back(hills[i].start);
    const StartScreen::Freed freed = about.freed(modelsOf(belief_, starts, trial.nuisance()), true);
    for (std::size_t i = 0; i < starts.size(); ++i)
      if (!freed.lost[i]) hills[from + i].drop = 2.0 * freed.along[static_cast<long>(i)] - freed.squares(i, i);
  }
  std::stable_sort(hills.begin(), hills.end(), [](const Hill& a, const Hill& b) { return a.drop > b.drop; });
  std::vector<double> climbed;
  for (const Hill& hill : hills) {
    if (hill.drop < worth_climbing || climbed.size() == most_hills || limit_.isUp()) break;
    const auto isOn = [&](double ratio) { return std::fabs(std::log(hill.ratio / ratio)) < std::log(one_hill); };
    if (isOn(1.0) || std::any_of(climbed.begin(), climbed.end(), isOn)) continue;
    climbed.push_back(hill.ratio);
    const Eigen::VectorXd own = trial.nuisance();
    trial = betterFrom(hill.start, own, std::move(trial), iterations);
  }
  return trial;
}

}  // namespace amb_rotor
