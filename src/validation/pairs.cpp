#include "pairs.hpp"

#include <algorithm>
#include <cmath>
#include <map>

#include "foreseen.hpp"

namespace amb_rotor {
namespace {

constexpr std::size_t most_linear = 5, most_pairs = 6;
constexpr int iterations = 8;
/// Evidence that a pair must promise beyond the better of the two.
constexpr double least_more = 12.0;

/// Share of what it must have that a pair must promise.
constexpr double least_promise = 0.1;

}  // namespace

std::vector<PairGain> pairGains(const Trial& all, const std::vector<std::string>& effects, double least) {
  const FirstOrder first_order(all, effects);
  std::map<std::string, double> single;
  for (const auto& effect : first_order.coordinates()) single[effect.first] = first_order.evidence({effect.first});
  std::vector<PairGain> gains;
  for (auto a = single.begin(); a != single.end(); ++a)
    for (auto b = std::next(a); b != single.end(); ++b) {
      const double together = first_order.evidence({a->first, b->first});
      const double more = together - std::max({a->second, b->second, 0.0});
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
  for (const Trial& t : screened) {
    if (!t.usable()) continue;
    if (best.size() < 2) {
      best.push_back(t.effect);
      best_promise += t.evidence;
    }
    start[t.effect] = t.effects().back();
    linear.push_back(t.effect);
  }
  tell("all candidates at once");
  const Trial joint = allAtOnce(candidates, adopted, references, linear);
  for (const EffectSetting& one : joint.space->fitted())
    if (std::find(linear.begin(), linear.end(), one.id) != linear.end()) start[one.id] = one;
  if (joint.fit.finite)
    for (const PairGain& gain : pairGains(joint, linear, std::max(least_more, least_promise * references.worth)))
      if (pairs.size() < most_linear && gain.evidence >= least) join(gain.first, gain.second);
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
