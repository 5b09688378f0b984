#include "amb_rotor/validation/equivalent_unbalance.hpp"

#include <algorithm>
#include <cmath>
#include <optional>

#include "amb_rotor/common/units.hpp"
#include "amb_rotor/validation/common_gain.hpp"

namespace amb_rotor {
namespace {

/// Over 1/(z - z_n), in which the pairs lie evenly; then halved about the best.
constexpr int places = 4001, refinements = 40;
/// Share of 1/(z - z_n) by which the belief's bend along the line is taken.
constexpr double line_step = 0.01;
/// A rotor ends within so many times its outermost plane.
constexpr double rotor_beyond_planes = 1.5;

double squareOff(const std::complex<double>& own, const BelievedUnbalance& b) {
  const double turn = std::remainder(std::arg(own) - b.phase_rad, two_pi);
  return std::pow((std::abs(own) - b.moment_kg_m) / b.moment_std_kg_m, 2) + std::pow(turn / b.phase_std_rad, 2);
}

}  // namespace

UnbalancePair likeliestUnbalance(const UnbalancePair& found, const BelievedUnbalance& believed, double reach_m) {
  const std::complex<double> sum = found.own + found.second;
  const std::complex<double> beside = found.second * (found.second_z_m - believed.plane_z_m);  // C - S z_n
  if (!(std::abs(beside) > 0.0) || !(believed.moment_std_kg_m > 0.0) || !(believed.phase_std_rad > 0.0)) return found;
  const auto pairAt = [&](double inverse) {
    return UnbalancePair{sum - beside * inverse, beside * inverse, believed.plane_z_m + 1.0 / inverse};
  };
  // planes nearer to z_n than a hundredth of the reach would need a second unbalance as large as the couple's arm is short
  const double most = 100.0 / reach_m;
  const auto cost = [&](double inverse) {
    if (std::fabs(inverse) < 1e-9 * most || std::fabs(believed.plane_z_m + 1.0 / inverse) > reach_m) return 1e300;
    return squareOff(sum - beside * inverse, believed);
  };
  double best = 1.0 / (found.second_z_m - believed.plane_z_m), least = cost(best);
  double step = 2.0 * most / (places - 1);
  for (int i = 0; i < places; ++i) {
    const double at = -most + i * step;
    if (cost(at) < least) {
      least = cost(at);
      best = at;
    }
  }
  for (int i = 0; i < refinements; ++i, step *= 0.5)
    for (const double at : {best - step, best + step})
      if (cost(at) < least) {
        least = cost(at);
        best = at;
      }
  return pairAt(best);
}

namespace {

/// Where a fit has the two unbalances, and what is believed of the rig's own.
struct Places {
  BelievedUnbalance believed;
  double reach_m = 0.0;
  int moment = -1, phase = -1;  ///< of the rig's own, among the nuisances
  std::size_t effect = 0;

  UnbalancePair pair(const std::vector<EffectSetting>& effects, const Eigen::VectorXd& nuisance) const {
    const std::vector<double>& values = effects[effect].values;
    return {std::polar(nuisance[moment], nuisance[phase]), std::polar(values[0], values[1]), values[2]};
  }
  void take(const UnbalancePair& pair, std::vector<EffectSetting>& effects, Eigen::VectorXd& nuisance) const {
    nuisance[moment] = std::abs(pair.own);
    nuisance[phase] = believed.phase_rad + std::remainder(std::arg(pair.own) - believed.phase_rad, two_pi);
    effects[effect].values = {std::abs(pair.second), std::arg(pair.second), pair.second_z_m};
  }
};

std::optional<Places> placesOf(const Model& belief, const FitSpace& space, const std::vector<EffectSetting>& effects) {
  const auto effect =
      std::find_if(effects.begin(), effects.end(), [](const EffectSetting& e) { return e.id == "couple_unbalance"; });
  if (effect == effects.end() || belief.rig.unbalance.size() != 1) return {};
  Places out;
  out.effect = static_cast<std::size_t>(effect - effects.begin());
  out.moment = space.nuisanceNamed("unbalance.moment_kg_m");
  out.phase = space.nuisanceNamed("unbalance.phase_rad");
  if (out.moment < 0 || out.phase < 0) return {};
  const Coordinate &u = space.coordinates()[out.moment], &p = space.coordinates()[out.phase];
  out.believed = {belief.rig.unbalance[0].plane_z_m, u.prior_mean, u.prior_std, p.prior_mean, p.prior_std};
  for (const auto* planes : {belief.rig.planes.amb, belief.rig.planes.sensor, belief.rig.planes.aux})
    for (int end = 0; end < 2; ++end) out.reach_m = std::max(out.reach_m, rotor_beyond_planes * std::fabs(planes[end]));
  return out;
}

}  // namespace

bool moveToLikeliestUnbalance(const Model& belief, const FitSpace& space, std::vector<EffectSetting>& effects,
                              Eigen::VectorXd& nuisance) {
  const std::optional<Places> places = placesOf(belief, space, effects);
  if (!places) return false;
  const UnbalancePair found = places->pair(effects, nuisance);
  const UnbalancePair best = likeliestUnbalance(found, places->believed, places->reach_m);
  if (best.second_z_m == found.second_z_m) return false;
  places->take(best, effects, nuisance);
  return true;
}

Eigen::VectorXd deviationAlongEquivalents(const Model& belief, const FitSpace& space, const Eigen::VectorXd& x) {
  std::vector<EffectSetting> effects = space.fitted();
  for (EffectSetting& effect : effects)
    for (const EffectSetting& there : space.model(x).effects)
      if (there.id == effect.id) effect.values = there.values;
  const std::optional<Places> places = placesOf(belief, space, effects);
  Eigen::VectorXd nuisance = x.head(space.nuisances()), none = Eigen::VectorXd::Zero(x.size());
  if (!places) return none;
  const UnbalancePair found = places->pair(effects, nuisance);
  const double z = places->believed.plane_z_m, inverse = 1.0 / (found.second_z_m - z), step = line_step * inverse;
  const std::complex<double> sum = found.own + found.second, beside = found.second / inverse;
  if (!std::isfinite(inverse) || !(std::abs(beside) > 0.0)) return none;
  Eigen::VectorXd at[2];
  double square[3] = {0.0, squareOff(found.own, places->believed), 0.0};
  for (const int side : {0, 1}) {
    const double there = inverse + (side == 0 ? -step : step);
    const UnbalancePair pair = {sum - beside * there, beside * there, z + 1.0 / there};
    square[2 * side] = squareOff(pair.own, places->believed);
    places->take(pair, effects, nuisance);
    at[side] = FitSpace(belief, effects).start();
    at[side].head(space.nuisances()) = nuisance;
  }
  const double bend = square[0] - 2.0 * square[1] + square[2];  // chi2'' step^2
  return bend > 0.0 ? Eigen::VectorXd(0.5 * (at[1] - at[0]) * std::sqrt(2.0 / bend)) : none;
}

void widenAlongEquivalents(const Model& belief, const FitSpace& space, const Eigen::VectorXd& x, Eigen::MatrixXd& covariance) {
  const auto& fitted = space.fitted();
  if (std::any_of(fitted.begin(), fitted.end(), [](const EffectSetting& e) { return e.id == "shaft_flexibility"; })) return;
  widenAlong(deviationAlongEquivalents(belief, space, x), covariance);
}

}  // namespace amb_rotor
