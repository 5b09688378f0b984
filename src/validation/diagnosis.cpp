#include "amb_rotor/validation/diagnosis.hpp"

#include <tbb/global_control.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <optional>

#include "amb_rotor/effects/catalogue.hpp"
#include "amb_rotor/validation/equivalent_unbalance.hpp"
#include "amb_rotor/validation/ranking.hpp"
#include "amb_rotor/validation/sensor_remarks.hpp"
#include "amb_rotor/validation/unexplained.hpp"
#include "candidates.hpp"
#include "diagnosis_words.hpp"
#include "foreseen.hpp"
#include "pairs.hpp"
#include "proposals.hpp"
#include "screening.hpp"

namespace amb_rotor {
namespace {

/// Of everything together at most; behind an effect that a fit without contact has followed to its end.
constexpr int joint_iterations = 15, joint_iterations_behind_free = 6;
/// Evidence from which on an effect through contact is refitted with everything before the runs to validate judge it.
constexpr double plain_promise = 200.0;
/// Evidence in the runs without contact of an effect that is in the rig whatever contact says.
constexpr double plain_place = 1000.0;
/// Candidates of a step that are refitted with everything, where those before do not keep their place.
constexpr int most_refits = 3;
/// Of what the adopted effects leave above the floor a law may leave so much to stand in their place: where they leave
/// structure, and where they leave little.
constexpr double law_share = 0.8, doubtful_law_share = 0.5;
/// Validation error without contact under which nothing is left that a law could name better than the effects adopted.
constexpr double settled_error = 1.02;
/// Validation error without contact above which a further effect is sought beside those adopted: half a million residuals tell
/// 1.02 from the noise.
constexpr double nothing_left = 1.015;
/// Evidence foreseen beside a model below that from which on an effect is looked at all the same.
constexpr double worth_a_look = 300.0;
/// Share of what is unexplained in the runs to validate that a law of one term must take to end the search at once.
constexpr double plain_gain = 0.95;
/// Validation error over which a residual counts as structured.
constexpr double structured_error = 1.12, structured_contact_error = 1.6;

/// Share of the evidence that all of what is unexplained would be, which a pair must promise where a plain law explains that; and
/// beside effects that are adopted: three are rare, and each look is dear where these are not linear.
constexpr double as_good = 0.9, beside_others = 0.5;
/// Effects adopted at most where a pair comes on top of the steps.
constexpr int most_adopted = 4;

class Diagnoser {
 public:
  Diagnoser(const Model& model, const Dataset& dataset, const DiagnosisOptions& options)
      : candidates_(model, dataset, TimeLimit(options.time_limit_s)), options_(options) {
    names_ = options.candidates;
    if (names_.empty())
      for (const auto& schema : effectCatalogue().all())
        if (!schema.only_by_name) names_.push_back(schema.id);
    std::stable_partition(names_.begin(), names_.end(), isNested);
    slowLast(names_);
  }

  Diagnosis run();

 private:
  void progress(double share, const std::string& what) const {
    if (options_.progress) options_.progress(share, what);
  }
  void setReferences(const Trial& free, const Trial& all);
  void baseline(Diagnosis& out);
  std::vector<Trial> screen(double from, double to, bool contact_may_wait);
  Candidate valued(const Trial& trial) const;
  void rank(const std::vector<Trial>& trials, Diagnosis& out) const;
  bool earns(const Trial& trial) const;
  bool promises(const Trial& trial) const;
  void adopt(const Settings& effects, const Trial& start, Diagnosis& out);
  const Trial* adoptBest(const std::vector<Trial>& trials, double share, Diagnosis& out);
  void refer();
  bool isMoreForeseen();
  bool keepsItsPlace(const Settings& others) const;
  bool withdraw(Diagnosis& out);
  void lookAgain(Diagnosis& out) const;
  bool clean() const;
  bool hurried() const { return candidates_.limit().isUp(); }
  bool strained() const;
  bool structured() const;
  bool isLeftOpen(Diagnosis& out) const;
  UnexplainedSearch lawsBeside(const Trial& trial) const;
  Unexplained lawBesideNone(LawEffort effort);  ///< beside the belief alone
  bool lawIsPlain(double share);
  bool lawLeavesLess();
  void standBy(Diagnosis& out);
  bool adoptPair(const std::vector<Trial>& trials, double share, double least, Diagnosis& out);

  Candidates candidates_;
  DiagnosisOptions options_;
  std::vector<std::string> names_;
  Settings adopted_;
  References references_;
  Trial first_;             ///< the belief, as the baseline left it
  CandidateErrors begun_;   ///< its
  References begin_;        ///< its
  std::optional<UnexplainedSearch> search_;  ///< beside it
  std::optional<Unexplained> law_;           ///< what that has found
  Trial joint_;             ///< the model as it stands, fitted to all runs
  CandidateErrors errors_;  ///< its
  bool contact_waited_ = false;  ///< in the last screening
};

void Diagnoser::setReferences(const Trial& free, const Trial& all) {
  references_ = candidates_.referencesOf(free, all);
  const FitResult& fit = references_.free.fit;
  const double level = std::max(1.0, fit.squares / std::max(1.0, fit.count));  // evidence is over the level that is left
  references_.worth = 0.5 * least_excess_share * std::max(0.0, fit.squares - fit.count) / level;
}

void Diagnoser::baseline(Diagnosis& out) {
  progress(0.0, "baseline");
  const std::vector<LocalState> fresh(candidates_.recordings().size());
  const Trial free = candidates_.fit({}, nullptr, fresh, {Through::free, 10});
  progress(0.05, "baseline through contact");
  setReferences(free, free);
  joint_ = references_.contact;
  progress(0.08, "baseline on the runs to validate");
  errors_ = candidates_.judge(joint_, true, true);
  references_.contact.local = joint_.local;
  double squares = free.fit.squares, count = free.fit.count;
  if (candidates_.haveContact()) {
    squares += joint_.fit.squares;
    count += joint_.fit.count;
  }
  errors_.fit_error = std::sqrt(squares / std::max(1.0, count));
  out.baseline = errors_;
  out.nuisance = joint_.space->nuisanceValues(joint_.fit.x, joint_.fit.covariance);
}

std::vector<Trial> Diagnoser::screen(double from, double to, bool contact_may_wait) {
  Screening out = amb_rotor::screen(candidates_, names_, {adopted_, references_, errors_, !adopted_.empty()}, contact_may_wait,
                                    [&](double share, const std::string& what) { progress(from + share * (to - from), what); });
  contact_waited_ = out.contact_waited;
  return std::move(out.trials);
}

Candidate Diagnoser::valued(const Trial& t) const {
  Candidate c;
  c.effect = t.effect;
  c.excited = t.excited;
  c.borne_out = earns(t);
  c.note = t.note;
  c.evidence = t.usable() ? std::max(t.evidence, -1e6) : 0.0;
  c.errors = t.errors;
  for (const EffectSetting& one : adopted_) c.beside += (c.beside.empty() ? "" : ", ") + one.id;
  if (!t.usable()) return c;
  c.parameters = t.space->effectValues(static_cast<int>(t.space->fitted().size()) - 1, t.fit.x, t.fit.covariance);
  if (t.evidence < least_evidence && c.note.empty()) c.note = powerOf(t, least_evidence);
  return c;
}

void Diagnoser::rank(const std::vector<Trial>& trials, Diagnosis& out) const {
  out.ranking.clear();
  for (const Trial& t : trials) out.ranking.push_back(valued(t));
  order(out.ranking);
}

bool Diagnoser::earns(const Trial& trial) const {
  return trial.usable() && trial.evidence >= least_evidence && bornOut(errors_, trial.errors, adopted_.empty());
}

/// Whether a look has brought the windows that it took down from far above the noise to next to it: fitted to some windows, an
/// effect may still be too far off for those of the runs to validate.
bool Diagnoser::promises(const Trial& trial) const {
  return trial.usable() && needsContact(trial.effect) && trial.evidence >= plain_promise && isAstray(references_.of(trial)) &&
         !isAstray(trial);
}

/// Everything refitted to all runs, with robust standard deviations; the model as it stands from then on.
void Diagnoser::adopt(const Settings& effects, const Trial& start, Diagnosis& out) {
  Eigen::VectorXd own = start.nuisance();
  Settings from = effects;
  std::vector<LocalState> local = start.local;
  if (needsContact(effects.back().id)) {
    Trial near = candidates_.approach(effects, start, references_.prior);
    own = near.nuisance();
    from = near.effects();
    local = std::move(near.local);
  }
  const bool all = candidates_.haveContact();
  const int iterations = all && !needsContact(effects.back().id) ? joint_iterations_behind_free : joint_iterations;
  joint_ = candidates_.fit(from, &own, local, {all ? Through::all : Through::free, iterations, true});
  Settings likelier = joint_.effects();
  Eigen::VectorXd there = joint_.nuisance();
  if (moveToLikeliestUnbalance(candidates_.belief(), *joint_.space, likelier, there)) {
    Trial more = candidates_.fit(likelier, &there, joint_.local,
                                 {all ? Through::all : Through::free, iterations, true});
    if (more.fit.finite && more.fit.chi2 < joint_.fit.chi2) joint_ = std::move(more);
  }
  // while the runs without contact lack something, windows through contact go astray for that
  if (candidates_.judge(joint_, false, true).validation_error_free < structured_error)
    joint_ = candidates_.settled(std::move(joint_), iterations);
  errors_ = candidates_.judge(joint_, true, true);
  if (std::any_of(effects.begin(), effects.end(), [](const EffectSetting& one) { return needsContact(one.id); })) {
    const Eigen::VectorXd stood = joint_.fit.x;
    joint_ = candidates_.followed(std::move(joint_), references_.prior, joint_iterations, errors_.validation_error_contact);
    if (joint_.fit.x != stood) errors_ = candidates_.judge(joint_, true, true);
  }
  adopted_ = joint_.effects();
  for (std::size_t i = 0; i < effects.size(); ++i)
    for (auto& step : out.steps)
      if (effects[i].id == step.added)
        step.parameters = joint_.space->effectValues(static_cast<int>(i), joint_.fit.x, joint_.fit.covariance);
  if (!out.steps.empty()) out.steps.back().errors = errors_;
}

/// What the next candidates are measured against.
void Diagnoser::refer() {
  const Eigen::VectorXd own = joint_.nuisance();
  const Trial free = candidates_.haveContact() ? candidates_.fit(adopted_, &own, joint_.local, {Through::free, 6}) : joint_;
  setReferences(free, joint_);
}

/// Whether an effect promises much beside a model that leaves next to nothing on the runs to validate: it may show in the runs to fit
/// mostly. Only such are then looked at; the references are those of the model as it stands.
bool Diagnoser::isMoreForeseen() {
  refer();
  std::vector<std::string> rest;
  for (const std::string& name : names_)
    if (std::none_of(adopted_.begin(), adopted_.end(), [&](const EffectSetting& one) { return one.id == name; })) rest.push_back(name);
  const std::map<std::string, double> promises = foreseen(candidates_, rest, adopted_, references_);
  names_.clear();
  for (const std::string& name : rest) {
    const auto promise = promises.find(name);
    if (promise != promises.end() && promise->second > worth_a_look) names_.push_back(name);
  }
  return !names_.empty();
}

/// Whether the runs without contact alone keep what the others lack, beyond doubt: through contact, a refit without it takes long.
bool Diagnoser::keepsItsPlace(const Settings& others) const {
  const Eigen::VectorXd own = joint_.nuisance();
  const Trial with = candidates_.fit(adopted_, &own, joint_.local, {Through::free, 0});
  Trial without = candidates_.fit(others, &own, joint_.local, {Through::free, 6});
  return candidates_.evidence(with, without) > plain_place &&
         (!clean() || bornOut(candidates_.judge(without, false, true), errors_, false));
}

/// Takes an earlier step back that the later ones have made needless.
bool Diagnoser::withdraw(Diagnosis& out) {
  if (adopted_.size() < 2 || hurried()) return false;
  for (std::size_t i = 0; i + 1 < adopted_.size(); ++i) {
    Settings rest = adopted_;
    rest.erase(rest.begin() + static_cast<long>(i));
    const bool all = candidates_.haveContact();
    if (all && !needsContact(adopted_[i].id) && keepsItsPlace(rest)) continue;
    const Eigen::VectorXd own = joint_.nuisance();
    Trial without = candidates_.fit(rest, &own, joint_.local, {all ? Through::all : Through::free, 6});
    if (candidates_.evidence(joint_, without) > least_evidence) {
      // at the floor an effect must be worth its place on the runs to validate, as when it was adopted: many parameters
      // find some evidence in the colour of the noise
      if (!clean() || bornOut(candidates_.judge(without, all, true), errors_, false)) continue;
    }
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
    anew.errors = candidates_.judge(trial, contact, false);
    anew.parameters = trial.space->effectValues(0, trial.fit.x, trial.fit.covariance);
    anew.note.clear();
    anew.borne_out = true;
    takeAnew(out.ranking, anew);
  }
}

bool Diagnoser::clean() const {
  return errors_.validation_error_free < 1.05 &&
         (errors_.validation_error_contact < 0.0 || errors_.validation_error_contact < 1.1);
}

/// Whether a nuisance is farther from the belief than chance takes it: it may stand for an effect (a contact that is too soft for
/// a mount in series), at the floor, too.
bool Diagnoser::strained() const {
  return !joint_.space->farFromBelief(joint_.fit.x, far_by_chance).empty();
}

bool Diagnoser::structured() const {
  return errors_.validation_error_free > structured_error || errors_.validation_error_contact > structured_contact_error;
}

/// Whether what is left through contact is no more than what the runs to fit leave open of the model's numbers; then says so. The
/// runs to validate may tell of a number more closely, a drop that whirls of a stiffness, and what is off by that is no structure.
bool Diagnoser::isLeftOpen(Diagnosis& out) const {
  if (adopted_.empty() || hurried() || errors_.validation_error_free > structured_error) return false;
  const LeftOpen open = candidates_.leftOpenThroughContact(joint_);
  if (!(open.error < structured_contact_error && open.byChance())) return false;
  out.remarks.push_back(leftOpenInWords(open, errors_.validation_error_contact));
  return true;
}

UnexplainedSearch Diagnoser::lawsBeside(const Trial& trial) const {
  return {candidates_.recordings(), *trial.space, trial.fit.x, trial.local, candidates_.offsetStd()};
}

Unexplained Diagnoser::lawBesideNone(LawEffort effort) {
  if (!search_) search_ = lawsBeside(first_);
  return search_->law(effort);
}

/// Whether a plain law beside the belief alone leaves next to nothing: then no second effect is sought beside the first, and
/// where no effect earned its place, none that shows in contact only and no pair.
bool Diagnoser::lawIsPlain(double share) {
  const bool little = adopted_.empty() || !leavesMoreThanDetails(begun_, errors_);
  if (errors_.validation_error_free < structured_error && little) return false;
  if (hurried() || (!adopted_.empty() && needsContact(adopted_.back().id))) return false;
  progress(share - 0.02, "a law of a few terms");
  Unexplained law = lawBesideNone(adopted_.empty() ? LawEffort::plain : LawEffort::foreseen);
  if (law.terms.empty() || law.held_out_gain < plain_gain) return false;
  law_ = std::move(law);
  return true;
}

/// Whether a law of a few terms beside the belief alone leaves less than the effects adopted so far. Where these leave
/// little, it must be far less, and plain: laws of several terms bend, too.
bool Diagnoser::lawLeavesLess() {
  const bool much = errors_.validation_error_free > structured_error;
  if (errors_.validation_error_free < settled_error) return false;
  // the law is sought in runs without contact: it stands for no effect that shows in contact
  for (const auto& effect : adopted_)
    if (needsContact(effect.id)) return false;
  const bool most_by_one = !much && adopted_.size() < 2 && !leavesMoreThanDetails(begun_, errors_);
  if (most_by_one && clean()) return false;
  if (!law_ && hurried()) return false;
  if (!law_) law_ = lawBesideNone(most_by_one || clean() ? LawEffort::plain : LawEffort::whole);
  return amb_rotor::lawLeavesLess(begun_, *law_, errors_, much ? law_share : doubtful_law_share);
}

/// The belief as it was, with the law beside it.
void Diagnoser::standBy(Diagnosis& out) {
  preferLaw(out, *law_);
  adopted_.clear();
  joint_ = first_;
  errors_ = out.baseline;
}

/// The first that earns its place and keeps it when everything is refitted: what was judged on some windows, or with the
/// rest where it was, may be worth less than it promised. Null: none does.
const Trial* Diagnoser::adoptBest(const std::vector<Trial>& trials, double share, Diagnosis& out) {
  const Trial stood = joint_;
  const CandidateErrors before = errors_;
  const Settings had = adopted_;
  Candidate beside;
  const auto steps = out.steps;
  int tried = 0;
  for (const Trial& t : trials) {
    if (tried == most_refits) break;
    if (!earns(t) && !promises(t)) continue;
    ++tried;
    progress(share - 0.02, "refit with " + t.effect);
    beside = valued(t);
    out.steps.push_back({t.effect, {}, {}});
    adopt(t.effects(), t, out);
    if (bornOut(before, errors_, false)) {
      if (!had.empty()) takeAnew(out.ranking, beside);
      return &t;
    }
    joint_ = stood;
    errors_ = before;
    adopted_ = had;
    out.steps = steps;
    if (steps.empty()) notBorneOut(out.ranking, t.effect);
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
    pair.trial.errors = candidates_.judge(pair.trial, pair.contact, false);
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

Diagnosis Diagnoser::run() {
  const auto begin = std::chrono::steady_clock::now();
  Diagnosis out;
  out.remarks = remarksOn(candidates_.recordings());
  baseline(out);
  first_ = joint_;
  begun_ = errors_;
  begin_ = references_;
  begin_.screen.reset();  // the starts' directions take much room
  bool referred = false;  // to the model as it stands
  for (int step = 0; step < options_.most_steps && !(step > 0 && hurried()); ++step) {
    if (step > 0 && !referred) refer();
    referred = false;
    const double from = 0.1 + 0.8 * step / options_.most_steps, to = 0.1 + 0.8 * (step + 1) / options_.most_steps;
    std::vector<Trial> trials = screen(from, to, true);
    if (step == 0) {
      rank(trials, out);
      names_ = likeliestFirst(names_, trials);
    }
    const Trial* chosen = adoptBest(trials, to, out);
    const bool plain_law = chosen == nullptr && step == 0 && lawIsPlain(to);
    const double least = (plain_law ? as_good : adopted_.empty() ? 0.0 : beside_others) * references_.most();
    if (plain_law && !adoptPair(trials, to, least, out)) break;
    if (chosen == nullptr && contact_waited_ && !plain_law) {  // in vain
      trials = screen(from, to, false);
      if (step == 0) rank(trials, out);
      chosen = adoptBest(trials, to, out);
    }
    if (chosen == nullptr) {
      if (!plain_law &&
          (static_cast<int>(out.steps.size()) + 2 > most_adopted || !structured() || !adoptPair(trials, to, least, out)))
        break;
      if (clean()) break;
      continue;
    }
    if (step == 0 && !hurried()) proposeExperiments(candidates_, trials, chosen->effect, out);
    if (step == 0)
      for (auto& c : out.ranking)
        if (c.effect == chosen->effect) {
          c.parameters = out.steps[0].parameters;
          c.errors = errors_;
        }
    while (withdraw(out)) {
    }
    if (clean() && errors_.validation_error_free < nothing_left && !strained()) {
      if (step + 1 == options_.most_steps || hurried() || !isMoreForeseen()) break;
      referred = true;
    } else if (step == 0 && !adopted_.empty() && lawIsPlain(to)) {
      break;
    }
    if (step > 0 && lawLeavesLess()) break;  // a third would only bend further
  }
  const bool stand_by = !out.steps.empty() && lawLeavesLess();
  if (stand_by) standBy(out);
  if (!out.withdrawn.empty() && !out.steps.empty() && !hurried()) lookAgain(out);
  out.adopted = joint_.space->model(joint_.fit.x);
  if (stand_by || (structured() && !isLeftOpen(out))) {
    const LawEffort effort = hurried() ? LawEffort::plain : LawEffort::whole;
    out.verdict = "unknown";
    if (out.unexplained.terms.empty())
      out.unexplained = errors_.validation_error_free <= structured_error ? inContactOnly()
                        : !adopted_.empty()                               ? lawsBeside(joint_).law(effort)
                        : law_                                            ? *law_
                                                                          : lawBesideNone(effort);
  } else {
    out.verdict = out.steps.empty() ? "none" : "effect";
  }
  out.sentences = sentencesOf(out);
  if (out.verdict != "unknown")
    for (std::string& sentence : strainsOf(joint_)) out.sentences.push_back(std::move(sentence));
  if (hurried()) {
    out.time_limit_reached = true;
    out.remarks.push_back("the search ended at its time limit: what had not been looked at by then is left out, and a longer one may "
                          "find more");
  }
  out.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  progress(1.0, "done");
  return out;
}

/// A diagnosis fits to some runs and is judged by others.
void requireBothUses(const Dataset& dataset) {
  std::vector<Fault> faults;
  const auto require = [&](RunUse use, const char* rule) {
    if (std::none_of(dataset.runs.begin(), dataset.runs.end(), [&](const Run& run) { return run.use == use; }))
      faults.push_back({datasetFile(dataset.folder), 0, "runs", "", rule});
  };
  require(RunUse::fit, "no run has use: fit: there is nothing to fit an effect to");
  require(RunUse::validate, "no run has use: validate: nothing is held out to judge an effect by");
  if (!faults.empty()) throw InputError(faults);
}

}  // namespace

Diagnosis diagnose(const Model& model, const Dataset& dataset, const DiagnosisOptions& options) {
  requireBothUses(dataset);
  std::unique_ptr<tbb::global_control> limit;
  if (options.threads > 0)
    limit = std::make_unique<tbb::global_control>(tbb::global_control::max_allowed_parallelism, options.threads);
  return Diagnoser(model, dataset, options).run();
}

}  // namespace amb_rotor
