// An effect that stood in for another is exchanged for it.
//
// The first effect of several is the one that does most alone; beside the belief that may be a stand-in, as what the second one
// leaves has pulled the nuisance away (a moving stator for an amplifier's lag, under a load that was not known of). What came after
// it is kept, it is left out, and what another effect promises beside the rest is held to what the model leaves with it. The last one
// may stand in, too: for one that promised less beside the rest and was not looked at.
#include <algorithm>

#include "amb_rotor/effects/catalogue.hpp"
#include "amb_rotor/validation/ranking.hpp"
#include "diagnoser.hpp"
#include "foreseen.hpp"

namespace amb_rotor {
namespace {

/// Of what the model as it stands leaves without contact, what a look at another effect in the place of an earlier one may leave: two
/// iterations do not bring it to its end, and what the refit leaves on the runs to validate decides.
constexpr double exchanged_leaves = 0.8;
constexpr int iterations_without = 6;
/// Iterations that follow the best look in the place of the last one.
constexpr int iterations_on = 10;
/// Numbers of an effect that is looked at in the place of the last whatever it promises: beside a nuisance that has been pulled next to
/// where the loop is no longer stable first order tells nothing of a lag that puts it right.
constexpr std::size_t few_numbers = 2;

bool isOfFewNumbers(const std::string& effect) {
  return hasASmallStart(effect) && effectCatalogue().find(effect)->parameters.size() <= few_numbers;
}

}  // namespace

/// The effect that promises to leave least beside all adopted ones but one of the earlier, in its place, and any of few numbers in the place
/// of the last: looked at, not usable where none leaves far less than the model as it stands.
Diagnoser::Instead Diagnoser::lookInstead() {
  Instead best = {notFollowed(), Trial(), 0};
  const std::vector<std::string> names = foreseeTheRest();  // the references are of the model as it stands from here on
  const double stands = references_.most();
  double left = exchanged_leaves * stands;
  for (std::size_t i = 0; i < adopted_.size() && !hurried(); ++i) {
    if (needsContact(adopted_[i].id)) continue;
    const bool last = i + 1 == adopted_.size();
    Settings rest = adopted_;
    rest.erase(rest.begin() + static_cast<long>(i));
    const Eigen::VectorXd own = joint_.nuisance();
    Trial without = candidates_.fit(rest, &own, joint_.local, {Through::free, iterations_without});
    if (!without.fit.finite) continue;
    rest = without.effects();
    References there = candidates_.referencesWithoutContact(without, without);
    const auto leavesOf = [](const Trial& one) { return one.usable() ? 0.5 * (one.fit.squares - one.fit.count) : 1e300; };
    const auto lookAt = [&](const std::string& name) {
      progress(0.9, name + " in the place of " + adopted_[i].id);
      return candidates_.look(name, rest, there, {});
    };
    Trial one = notFollowed();
    if (last) {
      for (const std::string& name : names) {
        if (!isOfFewNumbers(name) || hurried()) continue;
        Trial other = lookAt(name);
        if (leavesOf(other) < std::min(leavesOf(one), there.most())) one = std::move(other);
      }
      if (!one.usable() || hurried()) continue;
      const Eigen::VectorXd at = one.nuisance();
      std::string name = one.effect;
      one = candidates_.fit(one.effects(), &at, one.local, {Through::free, iterations_on});
      one.effect = std::move(name);
    } else {
      foresee(candidates_, names, rest, there);
      const auto most = std::max_element(there.promises.begin(), there.promises.end(),
                                         [](const auto& a, const auto& b) { return a.second.evidence < b.second.evidence; });
      if (most == there.promises.end() || there.most() - most->second.evidence > stands) continue;
      one = lookAt(most->first);
    }
    if (leavesOf(one) >= left) continue;
    left = leavesOf(one);
    one.evidence = candidates_.evidence(one, without);
    best = {std::move(one), std::move(without), i};
  }
  return best;
}

/// Exchanges an earlier effect where the model leaves structure without contact. False: none was.
bool Diagnoser::exchange(Diagnosis& out) {
  if (adopted_.size() < 2 || hurried() || errors_.validation_error_free < structured_error) return false;
  Instead other = lookInstead();
  if (!other.trial.usable()) return false;
  const Stood before = stood(out);
  out.withdrawn.push_back(adopted_[other.place].id);
  out.steps.erase(out.steps.begin() + static_cast<long>(other.place));
  if (other.place > 0) out.steps[other.place - 1].only_with_next = false;
  adopted_ = other.without.effects();
  out.steps.back().errors = candidates_.judge(other.without, true, Judging::glance);
  other.trial.errors = candidates_.judge(other.trial, false, Judging::settled);
  const Candidate beside = valued(other.trial);
  out.steps.push_back({other.trial.effect, {}, {}});
  adopt(other.trial.effects(), other.trial, out);
  if (bornOut(before.errors, errors_, false)) {
    takeAnew(out.ranking, beside);
    return true;
  }
  putBack(before, out);
  return false;
}

}  // namespace amb_rotor
