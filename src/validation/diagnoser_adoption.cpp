// What a diagnosis takes into the model, and out of it again.
#include <algorithm>
#include <cmath>

#include "amb_rotor/effects/catalogue.hpp"
#include "amb_rotor/validation/common_gain.hpp"
#include "amb_rotor/validation/equivalent_unbalance.hpp"
#include "amb_rotor/validation/ranking.hpp"
#include "diagnoser.hpp"
#include "foreseen.hpp"
#include "pairs.hpp"

namespace amb_rotor {
namespace {

/// Of everything together at most; behind an effect that a fit without contact has followed to its end.
constexpr int joint_iterations = 15, joint_iterations_behind_free = 6;
/// Of what is left where an effect is left out.
constexpr int iterations_without = 6;
/// Evidence from which on an effect through contact is refitted with everything before the runs to validate judge it.
constexpr double plain_promise = 200.0;
/// The same of the best of a screening, whatever it is beside: what the runs to fit leave open of it may be what those to validate tell.
constexpr double plainest_promise = 1000.0;
/// Evidence in the runs without contact of an effect that is in the rig whatever contact says.
constexpr double plain_place = 1000.0;
/// Candidates of a step that are refitted with everything, where those before do not keep their place.
constexpr int most_refits = 3;
/// Evidence beside a model below that, as a share of the residuals, that an effect must promise to be looked at all the same, and
/// have to be adopted: one that is to be seen is far above the former, and noise that is coloured by a mode next to instability makes
/// half of it (first order promises twice of what a fit then finds).
constexpr double worth_a_look = 0.002, worth_a_place = 0.0012;
/// Share of what is above the noise without contact that an effect must promise to be sought before a law.
constexpr double before_a_law = 0.5;
/// Deviations of the beliefs along a valley that runs do not tell from which on a way back is worth a fit.
constexpr double worth_a_way = 0.3;
/// Mean square of a run through contact, over what the runs without leave, from which on all effects that show there are looked at: a
/// mount or a ring takes the longest. The others are looked at below that, too: windows with free starts take the noise of the loop away,
/// and nobody knows how far below it a run is left by the right model.
constexpr double more_through_contact = 1.015;

bool isThroughContact(const EffectSetting& effect) { return needsContact(effect.id); }

/// Deviations from its belief of the number of the rig that stands in for an effect where a model lacks it. 0: there is none.
double deviationsOfMimic(const Trial& trial, const std::string& effect) {
  const int k = trial.space->nuisanceNamed(effectCatalogue().find(effect)->mimic);
  if (k < 0) return 0.0;
  const Coordinate& c = trial.space->coordinates()[k];
  return c.prior_std > 0.0 ? std::fabs(trial.fit.x[k] - c.prior_mean) / c.prior_std : 0.0;
}

/// Whether such a number comes home by the effect, and what the runs to validate are left with allows to believe that.
bool bringsHome(const Trial& was, const CandidateErrors& was_errors, const Trial& is, const CandidateErrors& errors, const std::string& effect) {
  return sparesBelief({deviationsOfMimic(was, effect), was_errors}, {deviationsOfMimic(is, effect), errors});
}

/// Whether looks at it take minutes.
bool takesLong(const std::string& name) {
  const EffectSchema& schema = *effectCatalogue().find(name);
  return schema.slow_to_predict || schema.lasting;
}

}  // namespace

bool Diagnoser::earns(const Trial& trial) const {
  const bool at_floor = !adopted_.empty() && (needsContact(trial.effect) ? clean() : cleanWithoutContact());
  const double least = at_floor ? worth_a_place * trial.fit.count : least_evidence;
  return trial.usable() && trial.evidence >= std::max(least_evidence, least) &&
         (bornOut(errors_, trial.errors, adopted_.empty()) || bringsHome(joint_, errors_, trial, trial.errors, trial.effect));
}

/// Whether a look has brought the windows that it took down from far above the noise to next to it: fitted to some windows, an
/// effect may still be too far off for those of the runs to validate. Or whether it takes most of what is off through contact, though it
/// hardly shows without: a current limit that no other run reaches.
bool Diagnoser::promises(const Trial& trial) const {
  if (trial.usable() && trial.effect == explains_contact_) return trial.evidence >= least_evidence;  // contact's among it
  return trial.usable() && needsContact(trial.effect) && trial.evidence >= plain_promise && isAstray(references_.of(trial)) &&
         !isAstray(trial);
}

/// Whether the runs to fit alone leave no doubt of an effect through contact.
bool Diagnoser::isTold(const Trial& trial) const {
  return trial.usable() && needsContact(trial.effect) && trial.evidence >= plainest_promise && !isAstray(trial);
}

/// Whether the runs to validate bear out the model as it stands with its numbers moved within what the runs to fit leave open of them: a
/// friction falls with a speed that those hardly reach.
bool Diagnoser::bornOutWithin(const CandidateErrors& before) const {
  const std::optional<LeftOpen> open = leftOpen(Through::contact, before.validation_error_contact);
  if (!open) return false;
  CandidateErrors there = errors_;
  there.validation_error_contact = open->error;
  return bornOut(before, there, false);
}

/// The model fitted from there, with robust standard deviations; of equivalent unbalances the likeliest.
Trial Diagnoser::jointly(Settings from, Eigen::VectorXd own, const std::vector<LocalState>& local, Through through, int iterations) const {
  Trial out = candidates_.fit(from, &own, local, {through, iterations, true});
  from = out.effects();
  own = out.nuisance();
  if (moveToLikeliestUnbalance(candidates_.belief(), *out.space, from, own)) {
    Trial more = candidates_.fit(from, &own, out.local, {through, iterations, true});
    if (more.fit.finite && more.fit.chi2 < out.fit.chi2) out = std::move(more);
  }
  return ofLikeliestGain(std::move(out), through, iterations);
}

/// Of gains, Ki and loads that the runs do not tell apart, the likeliest, and what the beliefs leave open of them. Beside a current limit
/// derivatives are taken by differences, which lend the valley a bend of its own and hold a fit where it has come from.
Trial Diagnoser::ofLikeliestGain(Trial trial, Through through, int iterations) const {
  if (!trial.fit.finite) return trial;
  const auto moved = [&](const Eigen::VectorXd& way, int of_iterations) {
    Trial at = trial;
    at.fit.x = trial.space->clamped(trial.fit.x + way);
    const Eigen::VectorXd own = at.nuisance();
    return candidates_.fit(at.effects(), &own, at.local, {through, of_iterations, of_iterations > 0});
  };
  Eigen::VectorXd along = alongCommonGain(*trial.space, trial.fit.x);
  PullOfBeliefs pull = pullAlong(*trial.space, trial.fit.x, along);
  if (!(pull.deviation > 0.0)) return trial;
  if (std::fabs(pull.way) > worth_a_way * pull.deviation && moved(pull.way * along, 0).fit.chi2 < trial.fit.chi2) {
    Trial more = moved(pull.way * along, iterations);
    if (more.fit.finite && more.fit.chi2 < trial.fit.chi2) {
      trial = std::move(more);
      along = alongCommonGain(*trial.space, trial.fit.x);
      pull = pullAlong(*trial.space, trial.fit.x, along);
    }
  }
  double rise = -2.0 * trial.fit.chi2;
  for (const double side : {-1.0, 1.0}) rise += moved(side * pull.deviation * along, 0).fit.chi2;
  if (std::isfinite(rise)) widenAlong(pull.deviation / std::sqrt(std::max(1.0, 0.5 * rise)) * along, trial.fit.covariance);
  return trial;
}

/// The model as it stands, refitted to all runs.
void Diagnoser::join(int iterations) {
  joined_ = true;
  referred_ = false;
  joint_ = jointly(joint_.effects(), joint_.nuisance(), joint_.local, Through::all, iterations);
  // while the runs without contact lack something, windows through contact go astray for that
  if (candidates_.judge(joint_, false, Judging::anew).validation_error_free < structured_error)
    joint_ = candidates_.settled(std::move(joint_), iterations);
  errors_ = candidates_.judge(joint_, true, Judging::anew);
}

/// Whether what is off through contact stays when an effect is adopted that shows without.
bool Diagnoser::staysAstrayThroughContact(const Trial& adopted) const {
  return references_.through_contact && isAstray(references_.contact) && !candidates_.explainsContact(adopted, references_, true);
}

/// Everything refitted to all runs; the model as it stands from then on. Runs with contact wait while an effect that shows without
/// leaves structure there, or what is missing shows in contact: their windows would go astray for that, and fits to them take the
/// longest.
void Diagnoser::adopt(const Settings& effects, const Trial& start, Diagnosis& out) {
  Trial near = start;
  Settings from = effects;
  int iterations = joint_iterations;
  joined_ = true;
  referred_ = false;
  bool stays = false;
  if (needsContact(effects.back().id)) {
    near = candidates_.approach(effects, start, references_.prior);
    from = near.effects();
  } else {
    near = candidates_.onHighestHill(jointly(effects, start.nuisance(), start.local, Through::free, joint_iterations), joint_iterations);
    from = near.effects();
    iterations = joint_iterations_behind_free;
    const bool structure = candidates_.judge(near, false, Judging::anew).validation_error_free > structured_error;
    const bool by_contact = candidates_.haveContact() && std::none_of(from.begin(), from.end(), isThroughContact);
    Trial told = structure ? near : candidates_.withContactsNumbers(near);
    const bool explains = told.fit.x != near.fit.x && !isAstray(told);
    stays = by_contact && !structure && !explains && staysAstrayThroughContact(near);
    if (explains) near = std::move(told);
    joined_ = !by_contact || (!structure && !stays);
  }
  joint_ = std::move(near);
  if (!throughAll()) errors_ = candidates_.judge(joint_, true, joined_ ? Judging::anew : Judging::glance);
  if (throughAll() || (!joined_ && !stays && !structured())) join(iterations);
  if (std::any_of(effects.begin(), effects.end(), isThroughContact)) {
    const Eigen::VectorXd stood = joint_.fit.x;
    joint_ = candidates_.followed(std::move(joint_), references_.prior, joint_iterations, errors_.validation_error_contact);
    if (joint_.fit.x != stood) errors_ = candidates_.judge(joint_, true, Judging::anew);
  }
  write(out);
}

/// What stands, into the steps.
void Diagnoser::write(Diagnosis& out) {
  widenAlongEquivalents(candidates_.belief(), *joint_.space, joint_.fit.x, joint_.fit.covariance);
  adopted_ = joint_.effects();
  for (std::size_t i = 0; i < adopted_.size(); ++i)
    for (auto& step : out.steps)
      if (adopted_[i].id == step.added)
        step.parameters = joint_.space->effectValues(static_cast<int>(i), joint_.fit.x, joint_.fit.covariance);
  if (!out.steps.empty()) out.steps.back().errors = errors_;
}

/// Runs with contact that have waited are fitted, too, where nothing came after: their error may be the contact's numbers.
void Diagnoser::joinLate(Diagnosis& out) {
  if (joined_ || adopted_.empty() || candidates_.limit().isLongUp() || errors_.validation_error_free > structured_error) return;
  joint_ = candidates_.withContactsNumbers(joint_);
  join(joint_iterations_behind_free);
  write(out);
}

/// What the next candidates are measured against without contact, for the model as it stands.
void Diagnoser::refer() {
  if (referred_) return;
  referred_ = true;
  const Eigen::VectorXd own = joint_.nuisance();
  const Trial free = throughAll() ? candidates_.fit(adopted_, &own, joint_.local, {Through::free, 6}) : joint_;
  std::map<std::string, Promise> kept = stillPromised(references_, free);
  referWithoutContact(free, joint_);
  references_.promises = std::move(kept);
}

std::vector<std::string> Diagnoser::notAdopted() const {
  std::vector<std::string> out;
  for (const std::string& name : names_)
    if (std::none_of(adopted_.begin(), adopted_.end(), [&](const EffectSetting& one) { return one.id == name; })) out.push_back(name);
  return out;
}

/// The candidates that are not in the model, with what they promise beside it.
std::vector<std::string> Diagnoser::foreseeTheRest() {
  refer();
  std::vector<std::string> rest = notAdopted();
  foresee(candidates_, rest, adopted_, references_);
  return rest;
}

/// Whether one effect promises so much of what a stand-in leaves that it is sought before a law.
bool Diagnoser::oneIsForeseen() {
  foreseeTheRest();
  return std::any_of(references_.promises.begin(), references_.promises.end(),
                     [&](const auto& one) { return one.second.evidence > before_a_law * references_.most(); });
}

/// Whether an effect promises much beside a model that leaves next to nothing on the runs to validate: it may show in the runs to fit
/// mostly, or in contact and there in a run whose error goes under in the mean. Only such are then looked at; the references are those
/// of the model as it stands.
bool Diagnoser::isMoreForeseen() {
  const std::vector<std::string> rest = foreseeTheRest();
  const std::map<std::string, Promise>& promises = references_.promises;
  const FitResult& free = references_.free.fit;
  const double floor = std::max(1.0, free.squares / std::max(1.0, free.count));
  const bool off = throughAll() && candidates_.worstThroughContact(joint_) > more_through_contact * floor;
  names_.clear();
  for (const std::string& name : rest) {
    const auto promise = promises.find(name);
    const bool looked_at = needsContact(name) ? throughAll() && (off || !takesLong(name))
                                              : promise != promises.end() && promise->second.evidence > worth_a_look * free.count;
    if (looked_at) names_.push_back(name);
  }
  if (names_.empty()) return false;
  candidates_.referThroughContact(references_);
  return true;
}

/// The rest of the adopted effects, fitted from where the model stands; where that does not run without the one left out, from where the
/// belief alone was fitted.
Trial Diagnoser::fitWithout(const Settings& rest, Through through) const {
  const Eigen::VectorXd own = joint_.nuisance();
  Trial out = candidates_.fit(rest, &own, joint_.local, {through, iterations_without});
  if (out.fit.finite) return out;
  const Eigen::VectorXd believed = first_.nuisance();
  return candidates_.fit(rest, &believed, first_.local, {through, iterations_without});
}

/// Whether the runs without contact alone keep what the others lack, beyond doubt: through contact, a refit without it takes long.
bool Diagnoser::keepsItsPlace(const Settings& others) const {
  const Eigen::VectorXd own = joint_.nuisance();
  const Trial with = candidates_.fit(adopted_, &own, joint_.local, {Through::free, 0});
  Trial without = fitWithout(others, Through::free);
  if (!without.fit.finite) return true;
  return candidates_.evidence(with, without) > plain_place &&
         (!clean() || bornOut(candidates_.judge(without, false, Judging::anew), errors_, false));
}

/// Takes an earlier step back that the later ones have made needless: also where the time for more steps is over.
bool Diagnoser::withdraw(Diagnosis& out) {
  if (adopted_.size() < 2) return false;
  for (std::size_t i = 0; i + 1 < adopted_.size(); ++i) {
    if (candidates_.limit().isLongUp()) return false;
    Settings rest = adopted_;
    rest.erase(rest.begin() + static_cast<long>(i));
    const bool all = throughAll();
    if (all && !needsContact(adopted_[i].id) && keepsItsPlace(rest)) continue;
    Trial without = fitWithout(rest, all ? Through::all : Through::free);
    if (!without.fit.finite) continue;  // no model of the rest runs: nothing says that it does as well
    if (candidates_.evidence(joint_, without) > least_evidence) {
      // at the floor an effect must be worth its place on the runs to validate, as when it was adopted: many parameters
      // find some evidence in the colour of the noise
      if (!clean() || bornOut(candidates_.judge(without, all, Judging::anew), errors_, false)) continue;
    }
    if (candidates_.limit().isLongUp()) return false;
    out.withdrawn.push_back(adopted_[i].id);
    out.steps.erase(out.steps.begin() + static_cast<long>(i));
    if (i > 0) out.steps[i - 1].only_with_next = false;
    adopt(rest, without, out);
    return true;
  }
  return false;
}

/// Values anew what stands in the end: the way over an effect since taken back may have led out of a hollow in which the
/// first look at it had stayed.
void Diagnoser::lookAgain(Diagnosis& out) const {
  for (const auto& effect : adopted_) {
    const bool contact = needsContact(effect.id);
    const Eigen::VectorXd own = joint_.nuisance();
    Trial trial = candidates_.fit({effect}, &own, joint_.local, {contact ? Through::contact : Through::free, joint_iterations},
                                  contact ? &begin_.prior : nullptr);
    trial.evidence = candidates_.evidence(trial, begin_.of(trial));
    const auto was =
        std::find_if(out.ranking.begin(), out.ranking.end(), [&](const Candidate& c) { return c.effect == effect.id; });
    if (was == out.ranking.end()) continue;
    const bool instead = !was->beside.empty() && adopted_.size() == 1;
    if (!instead && trial.evidence <= (was->beside.empty() ? *was : out.ranking[0]).evidence) continue;
    Candidate anew = *was;
    anew.beside.clear();
    anew.evidence = trial.evidence;
    anew.errors = candidates_.judge(trial, contact, Judging::settled);
    anew.parameters = trial.space->effectValues(0, trial.fit.x, trial.fit.covariance);
    anew.note.clear();
    anew.borne_out = true;
    takeAnew(out.ranking, anew);
  }
}

void Diagnoser::putBack(const Stood& before, Diagnosis& out) {
  joint_ = before.joint;
  joined_ = before.joined;
  referred_ = false;
  errors_ = before.errors;
  adopted_ = before.adopted;
  out.steps = before.steps;
  out.withdrawn = before.withdrawn;
}

/// The first that earns its place and keeps it when everything is refitted: what was judged on some windows, or with the
/// rest where it was, may be worth less than it promised. Null: none does.
const Trial* Diagnoser::adoptBest(const std::vector<Trial>& trials, double share, Diagnosis& out) {
  const Stood before = stood(out);
  Candidate beside;
  int tried = 0;
  for (const Trial& t : trials) {
    if (tried == most_refits) break;
    const bool told = &t == &trials.front() && isTold(t);
    if (!earns(t) && !promises(t) && !told) continue;
    ++tried;
    progress(share - 0.02, "refit with " + t.effect);
    beside = valued(t);
    out.steps.push_back({t.effect, {}, {}});
    adopt(t.effects(), t, out);
    if (bornOut(before.errors, errors_, false) || bringsHome(before.joint, before.errors, joint_, errors_, t.effect) ||
        (told && bornOutWithin(before.errors))) {
      if (!before.adopted.empty()) takeAnew(out.ranking, beside);
      return &t;
    }
    putBack(before, out);
    if (out.steps.empty()) notBorneOut(out.ranking, t.effect);
  }
  return nullptr;
}

/// Two effects that only help together and promise some evidence.
bool Diagnoser::adoptPair(const std::vector<Trial>& trials, double share, double least, Diagnosis& out) {
  if (hurried()) return false;
  std::vector<PairTrial> pairs = tryPairs(candidates_, trials, adopted_, references_, least, [&](const std::string& names) {
    progress(share - 0.02, "together: " + names);
  });
  for (auto& pair : pairs) {
    pair.trial.errors = candidates_.judge(pair.trial, pair.contact, Judging::settled);
    if (pair.trial.evidence < 2.0 * least_evidence || !earns(pair.trial)) continue;
    out.steps.push_back({pair.first, {}, {}});
    out.steps.back().errors = errors_;
    out.steps.back().only_with_next = true;
    out.steps.push_back({pair.second, {}, {}});
    adopt(pair.trial.effects(), pair.trial, out);
    while (withdraw(out)) {
    }
    return true;
  }
  return false;
}

}  // namespace amb_rotor
