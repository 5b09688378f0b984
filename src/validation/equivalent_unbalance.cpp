#include "amb_rotor/validation/equivalent_unbalance.hpp"

#include <algorithm>
#include <cmath>

#include "amb_rotor/common/units.hpp"

namespace amb_rotor {
namespace {

/// Over 1/(z - z_n), in which the pairs lie evenly; then halved about the best.
constexpr int places = 4001, refinements = 40;
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

bool moveToLikeliestUnbalance(const Model& belief, const FitSpace& space, std::vector<EffectSetting>& effects,
                              Eigen::VectorXd& nuisance) {
  const auto effect =
      std::find_if(effects.begin(), effects.end(), [](const EffectSetting& e) { return e.id == "couple_unbalance"; });
  if (effect == effects.end() || belief.rig.unbalance.size() != 1) return false;
  int moment = -1, phase = -1;
  for (int k = 0; k < space.nuisances(); ++k) {
    if (space.coordinates()[k].name == "unbalance.moment_kg_m") moment = k;
    if (space.coordinates()[k].name == "unbalance.phase_rad") phase = k;
  }
  if (moment < 0 || phase < 0) return false;
  const Coordinate &u = space.coordinates()[moment], &p = space.coordinates()[phase];
  const BelievedUnbalance believed = {belief.rig.unbalance[0].plane_z_m, u.prior_mean, u.prior_std, p.prior_mean, p.prior_std};
  double reach = 0.0;
  for (const auto* planes : {belief.rig.planes.amb, belief.rig.planes.sensor, belief.rig.planes.aux})
    for (int end = 0; end < 2; ++end) reach = std::max(reach, rotor_beyond_planes * std::fabs(planes[end]));
  const UnbalancePair found = {std::polar(nuisance[moment], nuisance[phase]), std::polar(effect->values[0], effect->values[1]),
                               effect->values[2]};
  const UnbalancePair best = likeliestUnbalance(found, believed, reach);
  if (best.second_z_m == found.second_z_m) return false;
  nuisance[moment] = std::abs(best.own);
  nuisance[phase] = p.prior_mean + std::remainder(std::arg(best.own) - p.prior_mean, two_pi);
  effect->values = {std::abs(best.second), std::arg(best.second), best.second_z_m};
  return true;
}

}  // namespace amb_rotor
