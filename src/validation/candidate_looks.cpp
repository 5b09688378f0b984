// The screening of the candidates: a short look at each, and the most promising ones to their end.
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>

#include "amb_rotor/effects/catalogue.hpp"
#include "amb_rotor/validation/ranking.hpp"
#include "amb_rotor/validation/starts.hpp"
#include "candidates.hpp"
#include "foreseen.hpp"
#include "seen_shapes.hpp"

namespace amb_rotor {
namespace {

/// Iterations of a first look at what promises little, and candidates that are then fitted to the end.
constexpr int glance_iterations = 1, finalists = 6;
/// Attempts at each of their steps where contact needs one look only.
constexpr int settled_attempts = 2;
/// Share of the evidence of a leader that leaves nothing which an effect must promise to be taken seriously beside it.
constexpr double rival_promise = 0.5;
/// The same of half the drop of chi2 by a leader that leaves more: to first order a right effect promises most of what it takes.
constexpr double serious_promise = 0.15;
/// A first look that leaves an effect at less than this share of what it must have is not followed where it can only gain.
constexpr double far_from_worth = 0.1;
/// Iterations that a candidate may need to come near a reference which it does not contain.
constexpr int approach_iterations = 5, approach_rounds = 2;
/// Each finalist goes on in rounds of so many iterations, while so many more rounds like the last would reach the leader.
constexpr int round_iterations = 4, most_rounds = 3, most_sparse_rounds = 8;
constexpr double hopeless_pace = 8.0;
/// Where the leader's mean square over the noise is below so much, rivals can only come near it: fewer rounds, and other
/// hills only for those that stand at this share of its evidence.
constexpr double settled_square = 1.06, settled_pace = 1.5, near = 0.9;
/// The highest that noise in the loop makes the floor, and the share of the reference's excess that a fit which is there leaves.
constexpr double highest_floor = 1.15, little_left = 0.03;
/// Share of the evidence of one that leaves nothing by which a rival through contact is beaten.
constexpr double not_near = 0.01;
/// Through contact, where windows forgive much, a start that leaves so many times the reference's squares is let go.
constexpr double out_of_reach = 1.2;
/// Evidence beyond which a candidate alone is sure without a fit through all windows.
constexpr double plain_evidence = 200.0;
/// Evidence of a leader that leaves nothing from which on candidates out of its reach are not fitted to their end.
constexpr double beyond_doubt = 1000.0;
/// Mean square over the noise without contact above which contact waits for a leader beyond doubt.
constexpr double plainly_off = 1.03;
/// Share of what is above the noise that the first look at one that is near takes: at a right effect's it is most.
constexpr double near_enough = 0.25;
/// Iterations at each length of the windows, where a first look has ended astray.
constexpr int lengthening_iterations = 5, finishing_iterations = 12;
/// Rounds to its end of one that takes most there, while each lowers chi2 by such a share: what is found to leave nothing spares the
/// others their looks, which take far longer.
constexpr int finishing_rounds = 6;
constexpr double still_falling = 0.003;
/// Share of the evidence below which a round's gain ends the rounds.
constexpr double small_gain = 0.01;
/// A first look through contact that takes this share of what is above the floor is followed at once, where the reference
/// leaves so many times the noise's square.
constexpr double most = 0.7, plain_misfit = 2.0;
/// The latter for an effect that is beyond doubt without contact.
constexpr double little_misfit = 1.2;
/// What right models mostly leave through contact, at most and in drops, where the currents are still; and the share of what the
/// reference leaves above the latter that one takes which leaves so little.
constexpr double right_square = 0.93, still_square = 0.8, half = 0.5;
/// The share of that which one step over few windows must take where looks over more are to tell whether an effect explains it: right ones
/// took 0.99 and more of it, gains far off 0.19, four wrong ones at most 0.11 (a foundation's mode beside a ring 0.80: more windows tell
/// of such); and the share of an effect that has to leave nothing.
constexpr double begun = 0.15, begun_to_leave_nothing = 0.5;
/// Iterations in a round for the other starts of a candidate that has several hills.
constexpr int climbing_iterations = 8;
/// Evidence after the first look below which a candidate is not followed.
constexpr double hopeless = -40.0;
/// A start that lacks less than this share of what an effect must have stands at the reference: it need not come nearer.
constexpr double already_near = 0.05;

/// Over the shortest windows: what the reference leaves above the noise for them to tell anything, the share of it that one leaves which
/// leads nowhere, the one that a right one may leave so early, and times the leader's that a wrong one leaves.
constexpr double seen_at_short_windows = 0.2, led_away = 0.7, nearly_right = 0.05, far_behind = 5.0;

/// Mean square over the noise through contact below which no model comes: each window's start is fitted.
constexpr double lowest_floor = 0.5;

/// Mean square over the noise that the right model leaves, as far as the runs without contact tell: what the rotor answers to noise
/// in its loop is above the sensors' own.
double floorOf(const References& references) {
  const FitResult& free = references.free.fit;
  return std::min(std::max(1.0, free.squares / std::max(1.0, free.count)), highest_floor);
}

/// What fits leave against a reference; both are over the floor.
struct Misfit {
  double left, reference, count;

  Misfit(const FitResult& fit, const FitResult& against, double floor)
      : left(fit.squares / floor), reference(against.squares / floor * (fit.count / std::max(1.0, against.count))), count(fit.count) {}
  Misfit(const Trial& trial, const References& references)
      : Misfit(trial.fit, references.of(trial).fit, needsContact(trial.effect) ? floorOf(references) : 1.0) {}

  /// Whether the fit has taken most of what the reference leaves above the floor, where that is plain: windows with free starts
  /// have a floor below 1 that nobody knows.
  bool takesMost(double misfit = plain_misfit) const {
    return reference > misfit * count && left - count < (1.0 - most) * (reference - count);
  }
  /// Whether it has taken all but a thousandth of that: some windows may still be astray.
  bool takesNearlyAll() const { return takesMost() && left - count < 1e-3 * (reference - count); }
  /// Whether it leaves no more than right models mostly do, and the reference plainly more.
  bool isWhereRightOnesAre() const {
    return left < right_square * count && left - still_square * count < half * (reference - still_square * count);
  }
  /// Whether it has plainly taken less than this share of what the reference leaves above the floor.
  bool takesLess(double share) const {
    return reference > little_misfit * count && reference - left < share * (reference - count);
  }
  /// Whether it leaves next to nothing.
  bool leavesNothing() const {
    return takesNearlyAll() || isWhereRightOnesAre() || (left < settled_square * count && takesMost());
  }
};

/// Whether a fit without contact leaves nothing to be had by a rival: it is at the noise, or next to the floor of a noisy loop and has
/// taken next to all.
bool isSettledFree(const Trial& trial, const References& references) {
  const FitResult& fit = trial.fit;
  if (fit.squares < settled_square * fit.count) return true;
  const double above = references.free.fit.squares - fit.count;
  return fit.squares < highest_floor * fit.count && fit.squares - fit.count < little_left * above;
}

/// Whether the reference leaves no more through contact than right models mostly do.
bool leavesWhatRightOnesDo(const References& references) {
  const FitResult& fit = references.contact.fit;
  return fit.squares < right_square * floorOf(references) * fit.count;
}

/// Whether a candidate through contact comes too late: nobody passes one that leaves nothing, but another such.
bool isBeaten(const Trial& trial, const References& references, const Leaders& leaders, const std::vector<Trial>& trials) {
  if (!leaders.through_contact || !needsContact(trial.effect) || Misfit(trial, references).leavesNothing()) return false;
  double best = 0.0;
  for (const Trial& t : trials)
    if (t.usable() && needsContact(t.effect)) best = std::max(best, t.evidence);
  return best - trial.evidence > std::max(beyond_doubt, not_near * best);
}

}  // namespace

double mostThroughContact(const References& references) {
  const FitResult& fit = references.contact.fit;
  return 0.5 * std::max(0.0, fit.chi2 - lowest_floor * fit.count);  // over a level of 1 at least
}

bool plainlyOffThroughContact(const References& references) {
  return references.contact.fit.squares > little_misfit * floorOf(references) * references.contact.fit.count;
}

bool Leaders::beyondContact(const References& references) const {
  return mostThroughContact(references) < (free_settled ? 1.0 : in_reach) * free;
}

bool Leaders::noneNear(const References& references) const {
  const FitResult& fit = references.free.fit;
  return fit.squares > structured_error * structured_error * fit.count && free < near_enough / least_excess_share * references.worth;
}

bool Leaders::mayLead(const std::string& effect, const References& references) const {
  const auto promise = references.promises.find(effect);
  if (promise == references.promises.end()) return !free_settled;
  if (!hasASmallStart(effect)) return true;  // one of two laws of the same iron may promise nothing beside the other
  double asked = free_settled ? rival_promise * free : 0.0;
  if (isToldByPromise(effect)) asked = std::max({asked, far_from_worth * references.worth, serious_promise * free_drop});
  return promise->second.evidence >= asked;
}

bool Leaders::waits(const References& references) const {
  const FitResult& fit = references.free.fit;
  return contact_waits && (noneNear(references) || explains_contact || (free > beyond_doubt && fit.squares > plainly_off * fit.count));
}

void Leaders::add(const Trial& trial, const References& references) {
  if (!trial.usable()) return;
  if (!needsContact(trial.effect)) {
    if (trial.evidence <= free) return;
    free = trial.evidence;
    free_drop = 0.5 * (references.free.fit.chi2 - trial.fit.chi2);
    free_settled = free > beyond_doubt && isSettledFree(trial, references);
    return;
  }
  if (trial.evidence > plain_evidence) short_level = std::min(short_level, trial.short_level > 0.0 ? trial.short_level : trial.level());
  // one that has to bend a belief for it may be a stand-in: a mount in series with a contact that is too hard, for Hertz's law
  const bool bends = !trial.space->farFromBelief(trial.fit.x, far_by_chance).empty();
  if (trial.evidence > plain_evidence && !bends && Misfit(trial, references).leavesNothing()) through_contact = true;
}

bool Leaders::mayBeRight(double at_short_windows, const References& references) const {
  const double floor = floorOf(references), reference = references.short_level / floor - 1.0;
  if (reference < seen_at_short_windows) return true;
  const double left = at_short_windows / floor - 1.0;
  return left < std::min(led_away * reference, std::max(nearly_right * reference, far_behind * (short_level / floor - 1.0)));
}

bool Leaders::isNearlyRight(double at_short_windows, const References& references) const {
  const double floor = floorOf(references), reference = references.short_level / floor - 1.0;
  return reference > seen_at_short_windows && at_short_windows / floor - 1.0 < nearly_right * reference;
}

Trial Candidates::bestOf(std::vector<Settings>& starts, const std::vector<Eigen::VectorXd>& nuisances, const References& references,
                         bool contact, const Leaders& leaders, const std::vector<double>& levels, bool& serious) const {
  auto followed = contact ? promisingThroughContact(starts, nuisances, references, leaders, levels)
                          : promisingFree(starts, nuisances, references, leaders, serious);
  if (followed.empty()) return notFollowed();
  const bool settled = contact && leaders.settles(references);
  const bool beside_right_ones = contact && starts[0].size() > 1 && leavesWhatRightOnesDo(references);
  const bool one_look = settled || beside_right_ones;
  if (one_look) {
    followed.resize(1);
    serious = false;
  }
  std::vector<Trial> trials(followed.size());
  const FrozenColumns directions = references.screen->directions();
  tbb::parallel_for(std::size_t{0}, followed.size(), [&](std::size_t i) {
    FitEffort effort = {contact ? Through::contact : Through::free, contact || serious ? first_look_iterations : glance_iterations, false, true};
    effort.every_effect = settled && references.sparse.stride > 1;
    if (one_look) effort.attempts = settled_attempts;
    if (!contact && isNested(followed[i].first->back().id)) effort.frozen = &directions;  // the reference is near
    trials[i] = fit(*followed[i].first, followed[i].second, references.contact.local, effort,
                    contact ? &references.prior : nullptr);
  });
  std::sort(trials.begin(), trials.end(), [](const Trial& a, const Trial& b) { return a.fit.chi2 < b.fit.chi2; });
  Trial winner = std::move(trials[0]);
  if (!isNested(winner.effect))
    for (std::size_t i = 1; i < trials.size() && i < followed_starts; ++i) winner.others.push_back(std::move(trials[i]));
  return winner;
}

Trial Candidates::look(const std::string& effect, const Settings& adopted, const References& references, const Leaders& leaders,
                       const Trial* seen) const {
  Trial none;
  none.effect = effect;
  none.excited = false;
  const bool contact = needsContact(effect);
  const Trial& reference = contact ? references.contact : references.free;
  auto [starts, nuisances] = startsOf(effect, adopted, reference, none.note);
  if (starts.empty()) return none;
  if (contact && !haveContact()) {
    none.note = "no run to fit holds contact";
    return none;
  }
  if (contact && leaders.waits(references)) {
    none.excited = true;
    none.fit.finite = false;
    none.note = "not valued alone: what the runs without contact lack comes first";
    return none;
  }
  if (!contact && leaders.only_serious && !leaders.mayLead(effect, references)) {
    none.excited = true;
    none.fit.finite = false;
    none.note = "not looked at: far less is foreseen of it than is to be had";
    return none;
  }
  const bool known = seen != nullptr && seen->usable() && !seen->stands &&
                     seen->stride == strideOver(seen->effects(), seen->stride) && Misfit(*seen, references).leavesNothing();
  if (seen != nullptr && seen->usable() && seen->stands) {
    starts = {seen->effects()};
    nuisances = {seen->nuisance()};
  }
  const auto promise = contact ? references.promises.end() : references.promises.find(effect);
  if (promise != references.promises.end() && promise->second.sized == starts.size())
    starts = promise->second.starts;  // with the shapes that are seen
  else if (!contact)
    addSeenShapes(belief_, nuisances[0], references, starts);
  bool serious = true;
  const std::vector<double> levels = seen != nullptr ? seen->start_levels : std::vector<double>{};
  Trial winner = known ? *seen : bestOf(starts, nuisances, references, contact, leaders, levels, serious);
  winner.effect = effect;
  if (!winner.fit.finite) {  // also: not followed
    if (contact && winner.note.empty()) winner.note = comes_not_near;
    return winner;
  }
  value(winner, references);
  // a start that does not contain the reference may need some steps to come near it, and windows whose starts the way
  // there has led astray begin anew
  const bool no_evidence_left = !contact && references.worth < least_evidence;
  const auto worthwhile = [&] {
    return serious && !no_evidence_left && winner.fit.finite && !isNested(effect) &&
           winner.evidence < std::min(hopeless, -already_near * references.worth) &&
           !(contact && winner.fit.chi2 > out_of_reach * references.of(winner).fit.chi2);
  };
  // over windows that grow it goes from far, too
  const bool grows = contact && !leaders.settles(references) && isAstray(winner) && isAstray(references.of(winner));
  for (int round = 0; round < approach_rounds && !grows && worthwhile() && !limit_.isUp(); ++round) {
    const Eigen::VectorXd own = winner.nuisance();
    const FitEffort effort = {contact ? Through::contact : Through::free, approach_iterations, false, true};
    Trial more = fit(winner.effects(), &own, contact ? begunAnew(winner.local) : winner.local, effort,
                     contact ? &references.prior : nullptr);
    if (more.fit.chi2 >= winner.fit.chi2) break;
    winner = std::move(more);
    value(winner, references);
    if (!contact && winner.fit.iterations < approach_iterations) break;  // it has come to rest
  }
  if (!contact || leaders.settles(references) || !winner.fit.finite || limit_.isUp()) return winner;
  const auto take = [&](Trial more) {
    if (!more.fit.finite || more.fit.chi2 >= winner.fit.chi2) return;
    more.others = std::move(winner.others);
    more.grown = std::max(more.grown, winner.grown);
    more.short_level = std::max(more.short_level, winner.short_level);
    winner = std::move(more);
    value(winner, references);
  };
  FitEffort effort = {Through::contact, lengthening_iterations, false, true};
  // where the reference is near the floor there is little to be had by what is far above it
  bool may_be_right = true;
  if (grows)
    take(lengthened(winner, effort, &references.prior, &references.of(winner), [&](double level) {
      may_be_right = leaders.mayBeRight(level, references);
      return !may_be_right ? 0 : leaders.isNearlyRight(level, references) ? finishing_iterations : lengthening_iterations;
    }));
  if (!may_be_right) return winner;
  if (Misfit(winner, references).takesMost()) {  // to the end at once: where it leaves nothing, the others need less
    const bool at_rest = winner.grown > 0.0 && winner.fit.iterations < lengthening_iterations;
    if (isAstray(winner) && !at_rest) {
      effort.iterations = finishing_iterations;
      take(lengthened(winner, effort, &references.prior));
    }
    effort.iterations = round_iterations;
    effort.window_s = contact_window_s;
    for (int round = 0; round < finishing_rounds && !Misfit(winner, references).leavesNothing() && !limit_.isUp(); ++round) {
      const double before = winner.fit.chi2;
      const Eigen::VectorXd own = winner.nuisance();
      take(fit(winner.effects(), &own, winner.local, effort, &references.prior));
      if (isAstray(winner) || winner.fit.chi2 > (1.0 - still_falling) * before) break;
    }
  }
  return winner;
}

std::optional<ExplainedContact> Candidates::explainsContact(const Trial& trial, const References& references,
                                                            bool shows_without) const {
  const Eigen::VectorXd own = trial.nuisance();
  // contact may tell what the runs without leave open of its numbers: gains of all sensors and Ki by one factor
  const QuadraticPrior prior = {trial.fit.normal.h, trial.fit.x};
  const double floor = floorOf(references);
  const std::vector<LocalState>& local = references.contact.local;
  if (strideOver(trial.effects(), start_stride) > 1) {  // wrong ones lead windows astray, and take long: few windows first
    FitEffort glance = {Through::contact, glance_iterations, false, true, start_stride};
    glance.attempts = 1;
    const Trial begins = fit(trial.effects(), &own, local, glance, &prior);
    glance.iterations = 0;
    const Eigen::VectorXd referred = references.contact.nuisance();
    const Trial without = fit(references.contact.effects(), &referred, local, glance, &references.prior);
    const double least = shows_without ? begun : begun_to_leave_nothing;
    if (!begins.fit.finite || Misfit(begins.fit, without.fit, floor).takesLess(least)) return {};
  }
  const Trial there = fit(trial.effects(), &own, local, {Through::contact, first_look_iterations, false, true}, &prior);
  const Trial& reference = there.stride > 1 ? references.sparse : references.contact;
  const Misfit misfit(there.fit, reference.fit, floor);
  if (!there.fit.finite || !misfit.takesMost(little_misfit)) return {};
  return ExplainedContact{evidence(there, reference), misfit.takesNearlyAll() || misfit.isWhereRightOnesAre()};
}

void Candidates::value(Trial& trial, const References& references) const {
  trial.evidence = trial.excited ? evidence(trial, references.of(trial)) : -1e300;
}

void Candidates::finish(std::vector<Trial>& trials, const References& references, const Leaders& leaders,
                        const std::function<void(const std::string&)>& tell) const {
  if (trials.empty()) return;  // all that was asked for is adopted
  const auto order = [](const Trial& a, const Trial& b) { return a.evidence > b.evidence; };
  std::stable_sort(trials.begin(), trials.end(), order);
  double leader = -1e300;
  bool settled = false;   // whether the leader leaves nothing to be had
  bool at_noise = false;  // whether it is at the noise, and not only at what may be the floor of a noisy loop
  const auto maySettle = [&](const Trial& t) {
    if (t.evidence <= leader) return;
    leader = t.evidence;
    at_noise = t.fit.squares < settled_square * t.fit.count;
    settled = needsContact(t.effect) ? leaders.through_contact || at_noise : isSettledFree(t, references);
  };
  // one that promises as much as a leader has that may be a stand-in, and had two iterations: a lag stood in for eddy currents so
  const auto mayPass = [&](const Trial& t) {
    const auto promise = references.promises.find(t.effect);
    return !at_noise && !needsContact(t.effect) && promise != references.promises.end() && promise->second.evidence > near * leader;
  };
  const auto goOn = [&](Trial& t, FitEffort effort) {
    const int rounds = effort.first_look ? most_sparse_rounds : most_rounds;
    for (int round = 0; round < rounds && !limit_.isUp(); ++round) {
      const Eigen::VectorXd own = t.nuisance();
      Trial more = fit(t.effects(), &own, t.local, effort, needsContact(t.effect) ? &references.prior : nullptr);
      const bool comparable = more.stride == t.stride;
      if (comparable && more.fit.chi2 > t.fit.chi2) break;
      const double was = t.evidence;
      more.grown = t.grown;
      t = std::move(more);
      value(t, references);
      if (t.evidence < hopeless || !comparable) break;
      const double gained = t.evidence - was;
      // at this pace it would not come near the leader
      if (gained < std::max(0.5, small_gain * t.evidence) ||
          (t.evidence < leader && (settled && !mayPass(t) ? settled_pace : hopeless_pace) * gained < leader - t.evidence)) break;
    }
    maySettle(t);
  };
  int finished = 0;
  for (auto& t : trials) {
    // those that may still become the best: the first few, and whatever comes near them
    if (!t.usable() || finished >= finalists || t.evidence < hopeless) break;
    if (isNested(t.effect) && !needsContact(t.effect) && t.evidence < far_from_worth * references.worth) continue;
    if (settled && leader > beyond_doubt && t.evidence < in_reach * leader && !mayPass(t)) continue;
    if (needsContact(t.effect) && (leaders.beyondContact(references) || isBeaten(t, references, leaders, trials))) continue;
    ++finished;
    tell(t.effect);
    const std::vector<Trial> others = std::move(t.others);
    const bool contact = needsContact(t.effect);
    FitEffort effort = {contact ? Through::contact : Through::free, round_iterations, false, contact};
    // what a look has told by all windows, a ring's speed, some of them would lose
    effort.every_effect = contact && leaders.through_contact && t.stride > 1;
    goOn(t, effort);
    // hills, as of a resonance's frequency, are told apart near their tops only
    for (Trial other : others) {
      if (t.evidence < (settled ? near : in_reach) * leader || (contact && Misfit(t, references).leavesNothing())) break;
      value(other, references);
      goOn(other, {contact ? Through::contact : Through::free, contact ? round_iterations : climbing_iterations, false, contact});
      if (other.evidence > t.evidence) t = std::move(other);
    }
    if (!contact && t.usable() && t.evidence >= in_reach * leader) {
      t = onTheOtherSide(std::move(t), climbing_iterations);
      value(t, references);
      maySettle(t);
    }
  }
  std::stable_sort(trials.begin(), trials.end(), order);
  // some of the windows tell candidates far apart; rivals are fitted through all of them
  std::vector<Trial*> rivals;
  int contenders = 0;  // also those that all windows tell of already, as a ring's
  const double best = std::max(trials[0].evidence, 0.0);
  const auto contends = [&](const Trial& t) { return t.evidence > in_reach * best && !isBeaten(t, references, leaders, trials); };
  for (auto& t : trials)
    if (t.usable() && contends(t)) {
      ++contenders;
      if (t.stride > 1) rivals.push_back(&t);
    }
  if (contenders > 1 || trials[0].evidence < plain_evidence)
    for (Trial* t : rivals) {
      tell(t->effect + " through all windows");
      goOn(*t, {Through::contact, round_iterations});
    }
  std::stable_sort(trials.begin(), trials.end(), order);
}

}  // namespace amb_rotor
