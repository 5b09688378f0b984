#include "amb_rotor/validation/diagnosis.hpp"

#include <tbb/global_control.h>

#include <algorithm>
#include <chrono>
#include <cmath>

#include "amb_rotor/effects/catalogue.hpp"
#include "amb_rotor/model/model_rules.hpp"
#include "amb_rotor/validation/ranking.hpp"
#include "amb_rotor/validation/sensor_remarks.hpp"
#include "diagnoser.hpp"
#include "diagnosis_words.hpp"
#include "proposals.hpp"
#include "screening.hpp"
#include "side_by_side.hpp"

namespace amb_rotor {
namespace {

/// Share of the evidence that all of what is unexplained would be, which a pair must promise where a plain law explains that; and
/// beside effects that are adopted: three are rare, and each look is dear where these are not linear.
constexpr double as_good = 0.9, beside_others = 0.5;
/// Effects adopted at most where a pair comes on top of the steps.
constexpr int most_adopted = 4;
/// Validation errors, without contact and through it, below which nothing more is sought.
constexpr double clean_error = 1.05, clean_contact_error = 1.1;

}  // namespace

Diagnoser::Diagnoser(const Model& model, const Dataset& dataset, const DiagnosisOptions& options)
    : candidates_(trustedAs(model, dataset), dataset, TimeLimit(options.time_limit_s)), options_(options) {
  names_ = options.candidates;
  if (names_.empty())
    for (const auto& schema : effectCatalogue().all())
      if (!schema.only_by_name) names_.push_back(schema.id);
  std::stable_partition(names_.begin(), names_.end(), isNested);
  slowLast(names_);
}

void Diagnoser::referWithoutContact(const Trial& free, const Trial& all) {
  references_ = candidates_.referencesWithoutContact(free, all);
  const FitResult& fit = references_.free.fit;
  const double level = std::max(1.0, fit.squares / std::max(1.0, fit.count));  // evidence is over the level that is left
  references_.worth = 0.5 * least_excess_share * std::max(0.0, fit.squares - fit.count) / level;
}

void Diagnoser::baseline(Diagnosis& out) {
  progress(0.0, "baseline");
  const std::vector<LocalState> fresh(candidates_.recordings().size());
  const Trial free = candidates_.fit({}, nullptr, fresh, {Through::free, most_iterations_from_belief});
  progress(0.05, "baseline through contact");
  referWithoutContact(free, free);
  candidates_.referThroughContact(references_);
  joint_ = references_.contact;
  progress(0.08, "baseline on the runs to validate");
  errors_ = candidates_.judge(joint_, true, Judging::anew);
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
  const bool beside = !adopted_.empty();
  const Standing standing = {adopted_, references_, errors_, beside, beside && leavesMoreThanDetails(begun_, errors_)};
  Screening out = amb_rotor::screen(candidates_, names_, standing, contact_may_wait, [&](double share, const std::string& what) {
    progress(from + share * (to - from), what);
  });
  contact_waited_ = out.contact_waited;
  explains_contact_ = out.explains_contact;
  none_near_ = out.none_near;
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

bool Diagnoser::cleanWithoutContact() const { return errors_.validation_error_free < clean_error; }

bool Diagnoser::clean() const { return cleanWithoutContact() && errors_.validation_error_contact < clean_contact_error; }

/// Whether a nuisance is farther from the belief than chance takes it: it may stand for an effect (a contact that is too soft for
/// a mount in series), at the floor, too.
bool Diagnoser::strained() const {
  return !joint_.space->farFromBelief(joint_.fit.x, far_by_chance).empty();
}

bool Diagnoser::structured() const {
  return errors_.validation_error_free > structured_error || errors_.validation_error_contact > structured_contact_error;
}

/// How near the runs to validate come within what the runs to fit leave open of the model's numbers, where that is below an error: they may
/// tell of a number more closely, a drop that whirls of a stiffness, and what is off by that is no structure. None: they do not.
std::optional<LeftOpen> Diagnoser::leftOpen(Through through, double error) const {
  if (adopted_.empty() || candidates_.limit().isLongUp()) return {};
  const LeftOpen open = candidates_.leftOpen(joint_, through);
  if (!(open.error < error && open.byChance())) return {};
  return open;
}

std::optional<LeftOpen> Diagnoser::structureLeftOpen() const {
  if (errors_.validation_error_free > structured_error) return {};
  return leftOpen(Through::contact, structured_contact_error);
}

/// Of less than structure without contact, where the runs to fit are at the noise: a current limit leaves a step next to where the loop is
/// lost, which tells of it more closely than all other runs, and no second effect is missing.
std::optional<LeftOpen> Diagnoser::littleLeftOpen() const {
  if (cleanWithoutContact() || structured() || errors_.validation_error_contact >= clean_contact_error || errors_.fit_error >= clean_error)
    return {};
  return leftOpen(Through::free, clean_error);
}

/// Of more through contact than the belief alone leaves there: the runs to fit told of the effects, and hardly of where they lie.
std::optional<LeftOpen> Diagnoser::moreLeftOpen() const {
  if (!(errors_.validation_error_contact > begun_.validation_error_contact)) return {};
  return leftOpen(Through::contact, begun_.validation_error_contact);
}

/// With the fits at hand: refits of their own would take as long as a third of the diagnosis, and end elsewhere. The runs to validate as
/// they were judged: windows that are left far off lead elsewhere each time.
void Diagnoser::compareAll(Diagnosis& out) const {
  progress(0.95, "predicting all runs");
  const std::vector<Recording>& recordings = candidates_.recordings();
  const auto compared = [&](const Trial& trial) {
    std::vector<LocalState> local = trial.local;
    const bool judged = trial.held_out != nullptr && trial.held_out->x == trial.fit.x;
    for (std::size_t i = 0; i < recordings.size() && !judged; ++i)
      if (recordings[i].run.use == RunUse::validate && recordings[i].holdsContact()) local[i] = begunAnew(local[i]);
    return sideBySide(recordings, *trial.space, candidates_.offsetStd(), trial.fit, std::move(local),
                      judged ? trial.held_out->runs : std::vector<RunResult>());
  };
  out.before = compared(first_);
  if (!out.steps.empty() && checkModel(out.adopted, effectCatalogue()).empty()) out.after = compared(joint_);
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
  for (int step = 0; step < options_.most_steps && !(step > 0 && hurried()); ++step) {
    if (step > 0) {
      refer();
      if (joined_ && !references_.through_contact) candidates_.referThroughContact(references_);
    }
    const double from = 0.1 + 0.8 * step / options_.most_steps, to = 0.1 + 0.8 * (step + 1) / options_.most_steps;
    std::vector<Trial> trials = screen(from, to, true);
    if (step == 0) {
      rank(trials, out);
      names_ = likeliestFirst(names_, trials);
    }
    const bool outshone = step == 0 && lawOutshines(trials, to);
    const Trial* chosen = none_near_ || outshone ? nullptr : adoptBest(trials, to, out);
    const bool plain_law = outshone || (chosen == nullptr && step == 0 && lawIsPlain(to));
    const double least = (plain_law ? as_good : adopted_.empty() ? 0.0 : beside_others) * references_.most();
    if (plain_law && (!adoptPair(trials, to, least, out) || lawLeavesAsLittle())) break;
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
    const bool exchanged = step == 0 && exchangeForTwo(trials, out);
    if (step == 0 && !hurried()) proposeExperiments(candidates_, trials, adopted_[0].id, out);
    if (step == 0 && !exchanged)
      for (auto& c : out.ranking)
        if (c.effect == chosen->effect) {
          c.parameters = out.steps[0].parameters;
          c.errors = errors_;
        }
    while (withdraw(out) || exchange(out)) {
    }
    if ((clean() || littleLeftOpen()) && !strained()) {
      joinLate(out);  // what is to be seen in a run through contact alone is not known before
      if (step + 1 == options_.most_steps || hurried() || !isMoreForeseen()) break;
    } else if (step == 0 && !adopted_.empty() && lawIsPlain(to)) {
      break;
    }
    if (step > 0 && lawIsPlain(to)) break;  // a third would only bend further
  }
  joinLate(out);
  const bool stand_by = !out.steps.empty() && (lawLeavesAsLittle() || lawLeavesLess());
  if (stand_by) standBy(out);
  if (!out.withdrawn.empty() && !out.steps.empty() && !hurried()) lookAgain(out);
  standingFirst(out);
  out.adopted = joint_.space->model(joint_.fit.x);
  const bool by_law = out.steps.empty() && ((law_ && !law_->terms.empty()) || lawIsLeft());  // what it leaves of contact was not looked at
  const std::optional<LeftOpen> open = stand_by || by_law ? std::nullopt : structured() ? structureLeftOpen() : littleLeftOpen();
  if (open) out.remarks.push_back(leftOpenInWords(*open, structured() ? Through::contact : Through::free, errors_));
  if (const std::optional<LeftOpen> more = open ? std::nullopt : moreLeftOpen()) out.remarks.push_back(leftOpenInWords(*more, Through::contact, errors_));
  if (stand_by || by_law || (structured() && !open)) {
    // beside effects, at the time limit, only what the measured path tells is fitted: with a bent shaft among them a fit takes minutes
    const LawEffort effort = !hurried() ? LawEffort::whole : adopted_.empty() ? LawEffort::plain : LawEffort::foreseen;
    out.verdict = "unknown";
    if (out.unexplained.terms.empty())
      out.unexplained = by_law                                            ? *law_
                        : errors_.validation_error_free <= structured_error ? inContactOnly()
                        : !adopted_.empty()                               ? lawBesideAdopted(effort)
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
  if (options_.comparisons) compareAll(out);
  out.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  progress(1.0, "done");
  return out;
}

std::vector<Fault> lackingUses(const Dataset& dataset) {
  std::vector<Fault> faults;
  const auto require = [&](RunUse use, const char* rule) {
    if (std::none_of(dataset.runs.begin(), dataset.runs.end(), [&](const Run& run) { return run.use == use; }))
      faults.push_back({datasetFile(dataset.folder), 0, "runs", "", rule});
  };
  require(RunUse::fit, "no run has use: fit: there is nothing to fit an effect to");
  require(RunUse::validate, "no run has use: validate: nothing is held out to judge an effect by");
  return faults;
}

Diagnosis diagnose(const Model& model, const Dataset& dataset, const DiagnosisOptions& options) {
  if (const std::vector<Fault> faults = lackingUses(dataset); !faults.empty()) throw InputError(faults);
  std::unique_ptr<tbb::global_control> limit;
  if (options.threads > 0)
    limit = std::make_unique<tbb::global_control>(tbb::global_control::max_allowed_parallelism, options.threads);
  return Diagnoser(model, dataset, options).run();
}

}  // namespace amb_rotor
