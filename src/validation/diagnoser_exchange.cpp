// An effect that stood in for another is exchanged for it.
//
// The first effect of several is the one that does most alone; beside the belief that may be a stand-in, as what the second one
// leaves has pulled the nuisance away (a moving stator for an amplifier's lag, under a load that was not known of). What came after
// it is kept, it is left out, and what another effect promises beside the rest is held to what the model leaves with it. The last one
// may stand in, too: for one that promised less beside the rest and was not looked at. One alone may stand in for two.
#include <algorithm>
#include <cmath>

#include "amb_rotor/common/error.hpp"
#include "amb_rotor/effects/catalogue.hpp"
#include "amb_rotor/validation/ranking.hpp"
#include "amb_rotor/validation/starts.hpp"
#include "diagnoser.hpp"
#include "foreseen.hpp"

namespace amb_rotor {
namespace {

/// Of what the model as it stands leaves without contact, what a look at another effect in the place of an earlier one may leave: two
/// iterations do not bring it to its end, and what the refit leaves on the runs to validate decides.
constexpr double exchanged_leaves = 0.8;
/// Iterations of an effect in the place of the last one, from next to nothing: no step then leads away from the rest. Of the best after that.
/// Of a rival, to its end: what it takes of the last of the noise counts.
constexpr int iterations_from_nothing = 4, iterations_on = 10, iterations_of_rival = 30;
/// Numbers of an effect that is looked at in the place of the last whatever it promises: beside a nuisance that has been pulled next to
/// where the loop is no longer stable first order tells nothing of a lag that puts it right.
constexpr std::size_t few_numbers = 2;
/// Share of an earlier effect's evidence beside the belief that a law of the iron or a limit must have had there to be looked at in its
/// place whatever it promises: next to nothing these do nothing, or the same as each other.
constexpr double rival_share = 0.5;
/// Share of what the rest leaves from which on a promise is enough to be looked at in the place of an earlier effect: beside a nuisance that
/// the earlier one has pulled far away first order does not tell of all.
constexpr double promised_instead = 0.5;

/// Validation error without contact up to which nothing is left that a rival of more numbers could take, where no number of the rig has
/// been pulled far from its belief.
constexpr double nothing_left = 1.01;

/// Validation error through contact from which on an effect whose numbers stand at the end of their ranges may stand in for two there, the
/// share of what it takes that two must take alone, together, to be fitted in its place, how many of the next best are paired, and iterations.
constexpr double clean_stand_in = 1.05, as_much_together = 0.8;
constexpr std::size_t next_best = 3;
constexpr int iterations_of_pair = 10;

std::size_t numbersOf(const std::string& effect) { return effectCatalogue().find(effect)->parameters.size(); }

bool isOfFewNumbers(const std::string& effect) {
  return hasASmallStart(effect) && numbersOf(effect) <= few_numbers;
}

/// Effects that beside the belief did nearly as much as this one, and of which first order beside others tells nothing; none that has
/// given way already, and only of fewer numbers where that is asked.
std::vector<std::string> rivalsOf(const std::string& effect, const std::vector<std::string>& names, const Diagnosis& so_far, bool fewer) {
  const std::vector<Candidate>& ranking = so_far.ranking;
  const std::vector<std::string>& gone = so_far.withdrawn;
  std::vector<std::string> out;
  const auto alone = [&](const std::string& name) {
    const auto found = std::find_if(ranking.begin(), ranking.end(), [&](const Candidate& c) { return c.effect == name && c.beside.empty(); });
    return found == ranking.end() ? 0.0 : found->evidence;
  };
  for (const std::string& name : names)
    if (!needsContact(name) && !hasASmallStart(name) && !(fewer && numbersOf(name) >= numbersOf(effect)) &&
        std::find(gone.begin(), gone.end(), name) == gone.end() &&
        alone(name) > rival_share * std::max(least_evidence, alone(effect)))
      out.push_back(name);
  return out;
}

}  // namespace

/// Whether nothing is left without contact, and no number of the rig stands in for anything.
bool Diagnoser::leavesNothing() const { return errors_.validation_error_free < nothing_left && !strained(); }

/// Whether an earlier effect has rivals that are not in the model.
bool Diagnoser::hasRivals(const Diagnosis& so_far) const {
  const std::vector<std::string> rest = notAdopted();
  return std::any_of(adopted_.begin(), adopted_.end() - 1,
                     [&](const EffectSetting& one) { return !rivalsOf(one.id, rest, so_far, leavesNothing()).empty(); });
}

/// The effect that promises to leave least beside all adopted ones but one of the earlier, in its place, or a rival of that, and any of few
/// numbers in the place of the last: looked at, not usable where none leaves far less than the model as it stands.
Diagnoser::Instead Diagnoser::lookInstead(const Diagnosis& so_far, bool rivals_alone) {
  Instead best = {notFollowed(), Trial(), 0};
  const std::vector<std::string> names = foreseeTheRest();  // the references are of the model as it stands from here on
  // where rivals leave much alike, how far the numbers of the rig are from their beliefs tells, and who needs fewer numbers of its own
  const auto above = [&](const Trial& one) {
    if (!rivals_alone) return 0.5 * (one.fit.squares - one.fit.count);
    return 0.5 * (one.fit.chi2 - one.fit.count + one.space->size() * std::log(std::max(2.0, one.fit.count)));
  };
  const double stands = rivals_alone ? above(references_.free) : references_.most();
  double left = rivals_alone ? stands : exchanged_leaves * stands;
  for (std::size_t i = 0; i < adopted_.size() && !hurried(); ++i) {
    if (needsContact(adopted_[i].id)) continue;
    const bool last = i + 1 == adopted_.size();
    if (last && (best.trial.usable() || rivals_alone)) break;  // one of the earlier stood in
    std::vector<std::string> asked = rivalsOf(adopted_[i].id, names, so_far, leavesNothing());
    if (rivals_alone && asked.empty()) continue;
    Settings rest = adopted_;
    rest.erase(rest.begin() + static_cast<long>(i));
    Trial without = fitWithout(rest, Through::free);
    if (!without.fit.finite) continue;
    rest = without.effects();
    References there = candidates_.referencesWithoutContact(without, without);
    const auto leavesOf = [&](const Trial& one) { return one.usable() ? above(one) : 1e300; };
    const auto tell = [&](const std::string& name) { progress(0.9, name + " in the place of " + adopted_[i].id); };
    const auto goneOn = [&](const Settings& from, const Trial& at, int iterations) {
      const Eigen::VectorXd nuisance = at.nuisance();
      Trial out = candidates_.fit(from, &nuisance, at.local, {Through::free, iterations});
      out.effect = from.back().id;
      return out;
    };
    Trial one = notFollowed();
    if (last) {
      for (const std::string& name : names) {
        if (!isOfFewNumbers(name) || hurried()) continue;
        std::string unused;
        const auto starts = startingValues(name, candidates_.belief(), candidates_.recordings(), unused);
        if (starts.empty()) continue;
        tell(name);
        Settings start = rest;
        start.push_back(nextToNothing({name, starts[0]}));
        Trial other = goneOn(start, without, iterations_from_nothing);
        if (leavesOf(other) < leavesOf(one)) one = std::move(other);
      }
      if (!one.usable() || hurried()) continue;
      one = goneOn(one.effects(), one, iterations_on);
    } else {
      if (!rivals_alone) foresee(candidates_, names, rest, there);
      const auto most = std::max_element(there.promises.begin(), there.promises.end(),
                                         [](const auto& a, const auto& b) { return a.second.evidence < b.second.evidence; });
      if (most != there.promises.end() &&
          (there.most() - most->second.evidence <= stands || most->second.evidence > promised_instead * there.most()) &&
          std::find(asked.begin(), asked.end(), most->first) == asked.end())
        asked.push_back(most->first);
      for (const std::string& name : asked) {
        if (hurried()) break;
        tell(name);
        Trial other = candidates_.look(name, rest, there, {});
        if (rivals_alone && other.usable() && !hurried()) other = goneOn(other.effects(), other, iterations_of_rival);
        if (leavesOf(other) < leavesOf(one)) one = std::move(other);
      }
    }
    if (leavesOf(one) >= left) continue;
    left = leavesOf(one);
    one.evidence = candidates_.evidence(one, without);
    best = {std::move(one), std::move(without), i};
  }
  return best;
}

/// Exchanges an earlier effect where the model leaves structure without contact; where it leaves none, for a rival that explains the runs
/// better or needs numbers of the rig less far from their beliefs. False: none was.
bool Diagnoser::exchange(Diagnosis& out) {
  if (adopted_.size() < 2 || hurried()) return false;
  const bool leaves_structure = errors_.validation_error_free >= structured_error;
  if (!leaves_structure && !hasRivals(out)) return false;
  Instead other = lookInstead(out, !leaves_structure);
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
  const bool likelier = !leaves_structure && candidates_.evidence(joint_, before.joint) > least_evidence && isAsNear(before.errors, errors_);
  if (bornOut(before.errors, errors_, false) || likelier) {
    takeAnew(out.ranking, beside);
    return true;
  }
  putBack(before, out);
  return false;
}

/// Pairs that may be what the first effect stands in for: of the next best, and through contact also it away from its limits with the best.
std::vector<Settings> Diagnoser::pairsInstead(const std::vector<EffectSetting>& away, const std::vector<Trial>& trials, const Trial& alone) const {
  const std::string& effect = adopted_[0].id;
  // evidence is over the level that each leaves, and does not add up
  const auto taken = [&](const Trial& t) { return t.stride * (references_.of(t).fit.chi2 - t.fit.chi2); };
  const bool contact = needsContact(effect);
  std::vector<const Trial*> others;
  for (const Trial& t : trials)
    if (t.usable() && t.effect != effect && needsContact(t.effect) == contact && t.evidence > least_evidence) others.push_back(&t);
  std::stable_sort(others.begin(), others.end(), [](const Trial* a, const Trial* b) { return a->evidence > b->evidence; });
  if (others.size() > next_best) others.resize(next_best);
  std::vector<Settings> pairs;
  for (std::size_t i = 0; i < others.size(); ++i)
    for (std::size_t j = i + 1; j < others.size(); ++j)
      if (taken(*others[i]) + taken(*others[j]) > as_much_together * taken(alone))
        pairs.push_back({others[i]->effects().back(), others[j]->effects().back()});
  if (contact && !others.empty())
    for (const EffectSetting& one : away) pairs.push_back({one, others[0]->effects().back()});
  return pairs;
}

/// Without contact, the second of a pair from its own starts beside the first: alone it has been led far away by what the first does.
Trial Diagnoser::oneBesideOther(const Settings& pair, const std::vector<Trial>& trials, const FitEffort& effort) const {
  const auto first = std::find_if(trials.begin(), trials.end(), [&](const Trial& t) { return t.effect == pair[0].id; });
  const References there = candidates_.referencesWithoutContact(*first, *first);
  const Trial second = candidates_.look(pair[1].id, first->effects(), there, {});
  if (!second.usable()) return notFollowed();
  const Eigen::VectorXd own = second.nuisance();
  return candidates_.fit(second.effects(), &own, second.local, effort);
}

/// Two effects in the place of the only one, where a number of that stands at the end of its range and something is left: a mode of nine
/// numbers leaves little of what the magnets' iron and a motor's pull do together. False: none are better.
bool Diagnoser::exchangeForTwo(const std::vector<Trial>& trials, Diagnosis& out) {
  if (adopted_.size() != 1 || hurried()) return false;
  const std::string effect = adopted_[0].id;
  const bool contact = needsContact(effect);
  if (contact ? errors_.validation_error_contact < clean_stand_in : errors_.validation_error_free < nothing_left) return false;
  const std::vector<EffectSetting> away = candidates_.awayFromLimits(*joint_.space, joint_.fit.x, adopted_[0]);
  if (away.empty()) return false;
  const auto alone = std::find_if(trials.begin(), trials.end(), [&](const Trial& t) { return t.effect == effect; });
  AMB_ROTOR_CHECK(alone != trials.end(), "what is adopted has been looked at");
  const Trial& reference = contact ? references_.contact : references_.free;
  const Eigen::VectorXd own = reference.nuisance();
  const QuadraticPrior* prior = contact ? &references_.prior : nullptr;
  // at the same windows, all of them: a look is at those that are the farthest off
  FitEffort effort = {contact ? Through::contact : Through::free, 0};
  const Eigen::VectorXd there = joint_.nuisance();
  const Trial stands = candidates_.fit(adopted_, &there, joint_.local, effort, prior);
  Trial best = notFollowed();
  best.evidence = candidates_.evidence(stands, reference) + 2.0 * least_evidence;
  effort.iterations = iterations_of_pair;
  effort.thorough = contact;
  const std::vector<LocalState> local = contact ? begunAnew(reference.local) : reference.local;  // what is not there had led windows astray
  for (const Settings& pair : pairsInstead(away, trials, *alone)) {
    if (hurried()) break;
    progress(0.9, pair[0].id + " and " + pair[1].id + " in the place of " + effect);
    Trial two = contact ? candidates_.fit(pair, &own, local, effort, prior) : oneBesideOther(pair, trials, effort);
    two.evidence = candidates_.evidence(two, reference);
    if (two.usable() && two.evidence > best.evidence) best = std::move(two);
  }
  if (!best.usable()) return false;
  const Stood before = stood(out);
  const Settings pair = best.effects();
  const auto first = std::find_if(trials.begin(), trials.end(), [&](const Trial& t) { return t.effect == pair[0].id; });
  const bool same = pair[0].id == effect, earned = same || first->errors.validation_error < begun_.validation_error;
  out.steps.clear();
  out.steps.push_back({pair[0].id, {}, {}});
  out.steps.back().errors = same ? before.errors : earned ? first->errors : begun_;
  out.steps.back().only_with_next = !earned;
  out.steps.push_back({pair[1].id, {}, {}});
  adopt(pair, best, out);
  // fits to other runs do not compare
  const bool fits = candidates_.evidence(joint_, before.joint) > least_evidence || joined_ != before.joined;
  if (fits && bornOut(before.errors, errors_, false)) {
    if (!same) out.withdrawn.push_back(effect);
    return true;
  }
  putBack(before, out);
  return false;
}

}  // namespace amb_rotor
