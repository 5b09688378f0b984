#include "pairs.hpp"

#include <algorithm>
#include <cmath>
#include <map>

#include "amb_rotor/validation/starts.hpp"
#include "amb_rotor/validation/term_search.hpp"

namespace amb_rotor {
namespace {

constexpr std::size_t most_linear = 5, most_pairs = 6;
constexpr int iterations = 8;
/// Evidence that a pair must promise beyond the better of the two.
constexpr double least_more = 12.0;

/// Share of what it must have that a pair must promise.
constexpr double least_promise = 0.1;
/// Share of a start at which all candidates are linearised together: near neutral, where none hides another.
constexpr double next_to_neutral = 0.01;

/// Drop of chi2 by some of the coordinates.
double dropOf(const Eigen::MatrixXd& h, const Eigen::VectorXd& g, const std::vector<int>& chosen) {
  const Eigen::VectorXd step = solveFor(h, g, chosen);
  double drop = 0.0;
  for (std::size_t i = 0; i < chosen.size(); ++i) drop += step[static_cast<long>(i)] * g[chosen[i]];
  return std::isfinite(drop) ? drop : 0.0;
}

}  // namespace

std::vector<PairGain> pairGains(const Trial& all, const std::vector<std::string>& effects, double least) {
  const FitSpace& space = *all.space;
  Eigen::MatrixXd h = all.fit.normal.h;
  Eigen::VectorXd g = all.fit.normal.g;
  std::vector<int> base;
  std::map<std::string, std::vector<int>> own;
  for (int k = 0; k < space.size(); ++k) {
    const Coordinate& c = space.coordinates()[k];
    if (c.prior_std > 0.0) {
      const double weight = 1.0 / (c.prior_std * c.prior_std);
      h(k, k) += weight;
      g[k] -= weight * (all.fit.x[k] - c.prior_mean);
    }
    const std::string effect = c.name.substr(0, c.name.find('.'));
    const bool candidate =
        k >= space.nuisances() && std::find(effects.begin(), effects.end(), effect) != effects.end();
    (candidate ? own[effect] : base).push_back(k);
  }
  const double chi2 = all.fit.normal.chi2, count = std::max(2.0, all.fit.count);
  const double before = dropOf(h, g, base);
  const auto evidence = [&](const std::vector<const std::vector<int>*>& parts) {
    std::vector<int> chosen = base;
    for (const auto* part : parts) chosen.insert(chosen.end(), part->begin(), part->end());
    const double drop = dropOf(h, g, chosen) - before;
    const double level = std::max(1.0, (chi2 - before - drop) / count);
    return 0.5 * (drop / level - static_cast<double>(chosen.size() - base.size()) * std::log(count));
  };
  std::map<std::string, double> single;
  for (const auto& [effect, coordinates] : own) single[effect] = evidence({&coordinates});
  std::vector<PairGain> gains;
  for (auto a = own.begin(); a != own.end(); ++a)
    for (auto b = std::next(a); b != own.end(); ++b) {
      const double together = evidence({&a->second, &b->second});
      const double more = together - std::max({single[a->first], single[b->first], 0.0});
      if (more > least) gains.push_back({a->first, b->first, together, more});
    }
  std::stable_sort(gains.begin(), gains.end(),
                   [](const PairGain& a, const PairGain& b) { return a.evidence > b.evidence; });
  return gains;
}

std::vector<PairTrial> tryPairs(const Candidates& candidates, const std::vector<Trial>& screened,
                                const Settings& adopted, const References& references, double least,
                                const std::function<void(const std::string&)>& tell) {
  std::vector<std::pair<std::string, std::string>> pairs;
  const auto join = [&](const std::string& a, const std::string& b) {
    const bool there = std::any_of(pairs.begin(), pairs.end(), [&](const auto& p) {
      return (p.first == a && p.second == b) || (p.first == b && p.second == a);
    });
    if (!there && pairs.size() < most_pairs) pairs.emplace_back(a, b);
  };
  std::map<std::string, EffectSetting> start;
  std::vector<std::string> linear, best;
  double best_promise = 0.0;
  Settings all = adopted;
  for (const Trial& t : screened) {
    if (!t.usable()) continue;
    if (best.size() < 2) {
      best.push_back(t.effect);
      best_promise += t.evidence;
    }
    start[t.effect] = t.effects().back();
    if (!isNested(t.effect) || needsContact(t.effect)) continue;
    std::string unused;
    const auto values = startingValues(t.effect, candidates.belief(), candidates.recordings(), unused);
    if (values.empty()) continue;
    start[t.effect] = {t.effect, values[0]};
    scaleStart(start[t.effect], next_to_neutral);
    all.push_back(start[t.effect]);
    linear.push_back(t.effect);
  }
  const Eigen::VectorXd nuisance = references.free.nuisance();
  if (linear.size() > 1) {
    tell("all candidates at once");
    const Trial joint =
        candidates.fit(all, &nuisance, references.free.local, {Through::free, 0, false, true});
    if (joint.fit.finite)
      for (const PairGain& gain : pairGains(joint, linear, std::max(least_more, least_promise * references.worth)))
        if (pairs.size() < most_linear && gain.evidence >= least) join(gain.first, gain.second);
  }
  // an effect without contact stands still in fits through contact: such a pair would be one effect only
  if (best.size() == 2 && needsContact(best[0]) == needsContact(best[1]) &&
      best_promise >= least && (needsContact(best[0]) || best_promise > least_promise * references.worth))
    join(best[0], best[1]);

  std::vector<PairTrial> out;
  for (const auto& [first, second] : pairs) {
    tell(first + " and " + second);
    PairTrial pair;
    pair.first = first;
    pair.second = second;
    pair.contact = needsContact(first);
    Settings effects = adopted;
    effects.push_back(start[first]);
    effects.push_back(start[second]);
    const Trial& reference = pair.contact ? references.contact : references.free;
    const Eigen::VectorXd own = reference.nuisance();
    pair.trial = candidates.fit(effects, &own, reference.local,
                                {pair.contact ? Through::contact : Through::free, iterations},
                                pair.contact ? &references.prior : nullptr);
    pair.trial.evidence = candidates.evidence(pair.trial, reference);
    out.push_back(std::move(pair));
  }
  std::stable_sort(out.begin(), out.end(), [](const PairTrial& a, const PairTrial& b) {
    return a.trial.evidence > b.trial.evidence;
  });
  return out;
}

}  // namespace amb_rotor
