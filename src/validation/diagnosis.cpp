#include "amb_rotor/validation/diagnosis.hpp"

#include <tbb/global_control.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>

#include "amb_rotor/effects/catalogue.hpp"
#include "amb_rotor/validation/breakdown.hpp"
#include "amb_rotor/validation/fit.hpp"
#include "amb_rotor/validation/starts.hpp"
#include "amb_rotor/validation/unexplained.hpp"

namespace amb_rotor {
namespace {

/// Evidence (half the BIC's drop) below which an effect does not earn its place, whatever else.
constexpr double least_evidence = 12.0;
/// Share of the validation runs' chi2 that must fall.
constexpr double least_validation_drop = 0.004;
/// Share of the excess over the floor (1) that an effect must take there.
constexpr double least_excess_share = 0.15;
/// Validation error over which a residual counts as structured.
constexpr double structured_error = 1.12, structured_contact_error = 1.6;

/// Iterations of a candidate's first look, and candidates that are then fitted to the end.
constexpr int first_look_iterations = 2, finalists = 6;
/// Evidence after the first look below which a candidate is not followed.
constexpr double hopeless = -40.0;
/// Prior standard deviations by which a refitted nuisance must be off for candidates to start from the belief too.
constexpr double far_from_belief = 2.5;

struct Trial {
  std::string effect;
  FitResult fit;
  std::vector<LocalState> local;
  std::shared_ptr<FitSpace> space;
  bool excited = true;
  std::string note;
  double evidence = -1e300;
  CandidateErrors errors;
};

std::string twoPlaces(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.2f", value);
  return text;
}

/// The finding, readable in one look.
std::vector<std::string> sentencesOf(const Diagnosis& d) {
  std::vector<std::string> out;
  out.push_back("On the runs to validate, the believed model stands at " + twoPlaces(d.baseline.validation_error) +
                " times the noise, all its uncertain numbers refitted.");
  for (const auto& step : d.steps)
    out.push_back("With " + step.added + " it stands at " + twoPlaces(step.errors.validation_error) + ".");
  if (d.steps.empty()) out.push_back("No effect of the catalogue earns its place on these runs.");
  std::string unseen;
  for (const auto& c : d.ranking)
    if (!c.excited) unseen += (unseen.empty() ? "" : ", ") + c.effect;
  if (!unseen.empty()) out.push_back("These runs cannot show: " + unseen + ".");
  return out;
}

class Diagnoser {
 public:
  Diagnoser(const Model& model, const Dataset& dataset, const DiagnosisOptions& options)
      : belief_(model), options_(options), recordings_(prepareRecordings(dataset)) {
    for (const auto& setting : belief_.uncertainty)
      if (setting.first == "sensor.offset_m") offset_std_ = setting.second;
    for (int i = 0; i < static_cast<int>(recordings_.size()); ++i) {
      const bool fit = recordings_[i].run.use == RunUse::fit;
      const bool contact = recordings_[i].holdsContact();
      (fit ? (contact ? fit_contact_ : fit_free_) : (contact ? check_contact_ : check_free_)).push_back(i);
    }
  }

  Diagnosis run();

 private:
  using Settings = std::vector<EffectSetting>;
  void progress(double share, const std::string& what) const {
    if (options_.progress) options_.progress(share, what);
  }
  Trial fitEffects(const Settings& effects, const Eigen::VectorXd* nuisance, bool contact, int iterations,
                   const std::vector<LocalState>& local, bool scores, const QuadraticPrior* prior = nullptr,
                   bool first_look = false) const;
  CandidateErrors judge(const Trial& trial, bool with_contact, std::vector<RunResult>* results = nullptr) const;
  double evidence(const Trial& trial, const Trial& against) const;
  std::vector<Trial> screen(const Settings& adopted, const Trial& reference, const QuadraticPrior& free_prior,
                            double from, double to);
  void finish(std::vector<Trial>& trials, const Trial& reference_free, const Trial& reference_contact,
              const QuadraticPrior& free_prior) const;
  static Settings valuesOf(const Trial& trial);
  bool earns(const Trial& trial, const CandidateErrors& before) const;
  std::vector<int> joined(const std::vector<int>& a, const std::vector<int>& b) const {
    std::vector<int> out = a;
    out.insert(out.end(), b.begin(), b.end());
    return out;
  }

  Model belief_;
  DiagnosisOptions options_;
  std::vector<Recording> recordings_;
  double offset_std_ = 0.0;
  std::vector<int> fit_free_, fit_contact_, check_free_, check_contact_;
};

Trial Diagnoser::fitEffects(const Settings& effects, const Eigen::VectorXd* nuisance, bool contact, int iterations,
                            const std::vector<LocalState>& local, bool scores, const QuadraticPrior* prior,
                            bool first_look) const {
  Trial trial;
  trial.space = std::make_shared<FitSpace>(belief_, effects);
  trial.local = local;
  for (auto& state : trial.local) state.angle_searches = 0;
  Eigen::VectorXd start = trial.space->start();
  if (nuisance != nullptr) start.head(nuisance->size()) = *nuisance;
  const FitProblem problem(recordings_, *trial.space, offset_std_);
  FitOptions options;
  options.most_iterations = iterations;
  options.scores = scores;
  if (first_look) {
    options.attempts = 3;
    options.covariance = false;
  }
  const std::vector<int> which = prior != nullptr ? fit_contact_ : (contact ? joined(fit_free_, fit_contact_) : fit_free_);
  trial.fit = fit(problem, start, which, trial.local, options, prior);
  if (!effects.empty()) trial.effect = effects.back().id;
  return trial;
}

CandidateErrors Diagnoser::judge(const Trial& trial, bool with_contact, std::vector<RunResult>* results) const {
  CandidateErrors errors;
  const FitProblem problem(recordings_, *trial.space, offset_std_);
  EvaluationOptions evaluation;
  evaluation.jacobian = false;
  evaluation.window_passes = 3;
  std::vector<LocalState> local = trial.local;
  const auto mean = [&](const std::vector<int>& which, double& sum, int& count) {
    std::vector<RunResult> own;
    // twice where windows are: the first pass finds the runs' offsets, the second counts with them
    const bool windows = !which.empty() && recordings_[which[0]].holdsContact();
    if (windows) problem.evaluate(trial.fit.x, which, local, evaluation, nullptr);
    problem.evaluate(trial.fit.x, which, local, evaluation, &own);
    double part = 0.0;
    for (const auto& r : own) part += r.mean_square;
    sum += part;
    count += static_cast<int>(own.size());
    if (results != nullptr) results->insert(results->end(), own.begin(), own.end());
    return own.empty() ? -1.0 : std::sqrt(part / own.size());
  };
  double sum = 0.0;
  int count = 0;
  errors.validation_error_free = mean(check_free_, sum, count);
  if (with_contact) errors.validation_error_contact = mean(check_contact_, sum, count);
  errors.validation_error = count > 0 ? std::sqrt(sum / count) : 0.0;
  errors.fit_error = trial.fit.count > 0.0 ? std::sqrt(trial.fit.squares / trial.fit.count) : 0.0;
  return errors;
}

double Diagnoser::evidence(const Trial& trial, const Trial& against) const {
  if (!trial.fit.finite || !against.fit.finite) return -1e300;
  // the noise level that the better model leaves scales chi2: a wrong noise figure is no evidence
  const double level = std::max(1.0, trial.fit.squares / std::max(1.0, trial.fit.count));
  const int more = trial.space->size() - against.space->size();
  return 0.5 * ((against.fit.chi2 - trial.fit.chi2) / level - more * std::log(std::max(2.0, trial.fit.count)));
}

bool Diagnoser::earns(const Trial& trial, const CandidateErrors& before) const {
  if (trial.evidence < least_evidence) return false;
  // it must take a share of what is above the floor: a wrong effect that bends a little towards the right one does not
  const auto earned = [](double was, double is) {
    if (was < 0.0 || is < 0.0) return false;
    const double drop = was * was - is * is, excess = was * was - 1.0;
    return drop > least_validation_drop * was * was && drop > least_excess_share * excess;
  };
  return earned(before.validation_error_free, trial.errors.validation_error_free) ||
         earned(before.validation_error_contact, trial.errors.validation_error_contact);
}

std::vector<Trial> Diagnoser::screen(const Settings& adopted, const Trial& reference, const QuadraticPrior& free_prior,
                                     double from, double to) {
  std::vector<std::string> names = options_.candidates;
  if (names.empty())
    for (const auto& schema : effectCatalogue().all())
      if (!schema.hypothesis) names.push_back(schema.id);
  std::vector<Trial> best;
  // from the refitted nuisance, and from the belief where a wrong model has pulled it far away
  std::vector<Eigen::VectorXd> nuisances = {reference.fit.x.head(reference.space->nuisances())};
  for (int k = 0; k < reference.space->nuisances(); ++k) {
    const Coordinate& c = reference.space->coordinates()[k];
    if (std::fabs(nuisances[0][k] - c.prior_mean) > far_from_belief * c.prior_std) {
      nuisances.push_back(reference.space->start().head(reference.space->nuisances()));
      break;
    }
  }
  for (std::size_t n = 0; n < names.size(); ++n) {
    const std::string& name = names[n];
    progress(from + (to - from) * n / names.size(), name);
    const bool there = std::any_of(adopted.begin(), adopted.end(), [&](const EffectSetting& s) { return s.id == name; }) ||
                       std::any_of(belief_.effects.begin(), belief_.effects.end(),
                                   [&](const EffectSetting& s) { return s.id == name; });
    if (there) continue;
    Trial winner;
    winner.effect = name;
    std::string reason;
    const auto starts = startingValues(name, belief_, recordings_, reason);
    const bool contact = effectCatalogue().find(name)->needs_contact;
    if (starts.empty() || (contact && fit_contact_.empty())) {
      winner.excited = false;
      winner.note = reason.empty() ? "no run to fit holds contact" : reason;
      best.push_back(winner);
      continue;
    }
    // a short look from each start
    winner.fit.chi2 = 1e301;
    for (std::size_t look = 0; look < starts.size() * nuisances.size(); ++look) {
      const auto& start = starts[look % starts.size()];
      const Eigen::VectorXd& nuisance = nuisances[look / starts.size()];
      Settings effects = adopted;
      for (std::size_t i = 0; i < effects.size(); ++i)
        effects[i].values = reference.space->model(reference.fit.x).effects[belief_.effects.size() + i].values;
      effects.push_back({name, start});
      Trial trial = fitEffects(effects, &nuisance, contact, starts.size() > 2 ? 1 : first_look_iterations,
                               reference.local, false, contact ? &free_prior : nullptr, true);
      if (trial.fit.chi2 < winner.fit.chi2) winner = trial;
    }
    winner.effect = name;
    best.push_back(winner);
  }
  return best;
}

void Diagnoser::finish(std::vector<Trial>& trials, const Trial& reference_free, const Trial& reference_contact,
                       const QuadraticPrior& free_prior) const {
  const auto value = [&](Trial& t) {
    t.evidence = t.excited ? evidence(t, effectCatalogue().find(t.effect)->needs_contact ? reference_contact : reference_free)
                           : -1e300;
  };
  const auto order = [](const Trial& a, const Trial& b) { return a.evidence > b.evidence; };
  for (auto& t : trials) {
    value(t);
    // a start that does not contain the reference may need a few steps to come near it
    const auto& parameters = effectCatalogue().find(t.effect)->parameters;
    const bool nested = std::all_of(parameters.begin(), parameters.end(),
                                    [](const ParameterSchema& p) { return std::isfinite(p.neutral); }) &&
                        t.effect != "foundation_resonance" && t.effect != "eddy_current_lag";
    if (!t.excited || !t.fit.finite || nested || t.evidence >= hopeless) continue;
    const bool contact = effectCatalogue().find(t.effect)->needs_contact;
    const Eigen::VectorXd own = t.fit.x.head(t.space->nuisances());
    Trial more = fitEffects(valuesOf(t), &own, contact, 3, t.local, false, contact ? &free_prior : nullptr, true);
    if (more.fit.chi2 > t.fit.chi2) continue;
    more.effect = t.effect;
    t = more;
    value(t);
  }
  std::stable_sort(trials.begin(), trials.end(), order);
  int finished = 0;
  for (auto& t : trials) {
    // those that may still become the best: the first few, and whatever comes near them
    if (!t.excited || !t.fit.finite || finished >= finalists || t.evidence < hopeless) break;
    ++finished;
    const bool contact = effectCatalogue().find(t.effect)->needs_contact;
    Settings effects = valuesOf(t);
    const Eigen::VectorXd own = t.fit.x.head(t.space->nuisances());
    Trial more = fitEffects(effects, &own, contact, 10, t.local, false, contact ? &free_prior : nullptr);
    if (more.fit.chi2 <= t.fit.chi2) {
      more.effect = t.effect;
      t = more;
    }
    value(t);
  }
  std::stable_sort(trials.begin(), trials.end(), order);
}

Diagnoser::Settings Diagnoser::valuesOf(const Trial& trial) {
  Settings effects = trial.space->fitted();
  const Model at = trial.space->model(trial.fit.x);
  for (auto& e : effects)
    for (const auto& s : at.effects)
      if (s.id == e.id) e.values = s.values;
  return effects;
}

Diagnosis Diagnoser::run() {
  const auto begin = std::chrono::steady_clock::now();
  Diagnosis out;
  for (const auto& r : recordings_)
    for (const auto& remark : r.remarks) out.remarks.push_back(r.run.id + ": " + remark);
  progress(0.0, "baseline");
  std::vector<LocalState> fresh(recordings_.size());
  Trial free = fitEffects({}, nullptr, false, 10, fresh, false);
  const Eigen::VectorXd free_nuisance = free.fit.x;
  const auto priorOf = [](const Trial& t) {
    QuadraticPrior prior;
    const int n = t.space->nuisances();
    prior.h = t.fit.normal.h.topLeftCorner(n, n);
    prior.centre = t.fit.x.head(n);
    return prior;
  };
  QuadraticPrior prior = priorOf(free);
  Trial contact = free;
  if (!fit_contact_.empty()) {
    progress(0.05, "baseline through contact");
    contact = fitEffects({}, &free_nuisance, true, 6, free.local, false, &prior);
    contact.local = contact.local;
  }
  free.errors = judge(contact, true);
  free.errors.fit_error = std::sqrt((free.fit.squares + (fit_contact_.empty() ? 0.0 : contact.fit.squares)) /
                                    std::max(1.0, free.fit.count + (fit_contact_.empty() ? 0.0 : contact.fit.count)));
  out.baseline = free.errors;
  out.nuisance = contact.space->nuisanceValues(contact.fit.x, contact.fit.covariance);

  Settings adopted;
  Trial reference_free = free, reference_contact = contact;
  CandidateErrors before = free.errors;
  Trial last = contact;
  for (int step = 0; step < options_.most_steps; ++step) {
    const double from = 0.1 + 0.8 * step / options_.most_steps, to = 0.1 + 0.8 * (step + 1) / options_.most_steps;
    Trial reference = reference_free;
    reference.local = reference_contact.local;
    std::vector<Trial> trials = screen(adopted, reference, prior, from, to);
    finish(trials, reference_free, reference_contact, prior);
    for (auto& t : trials) {
      t.errors = before;  // what cannot be seen changes nothing
      if (!t.excited || !t.fit.finite) continue;
      const bool through_contact = effectCatalogue().find(t.effect)->needs_contact;
      t.errors = judge(t, through_contact);
      // the runs that this candidate was not fitted on count as the reference left them
      const FitResult& other = through_contact ? reference_free.fit : reference_contact.fit;
      if (!fit_contact_.empty())
        t.errors.fit_error = std::sqrt((t.fit.squares + other.squares) / (t.fit.count + other.count));
    }
    if (step == 0)
      for (const auto& t : trials) {
        Candidate c;
        c.effect = t.effect;
        c.excited = t.excited;
        c.note = t.note;
        c.evidence = t.excited && t.fit.finite ? std::max(t.evidence, -1e6) : 0.0;
        c.errors = t.errors;
        if (t.excited && t.fit.finite) {
          c.parameters = t.space->effectValues(static_cast<int>(t.space->fitted().size()) - 1, t.fit.x, t.fit.covariance);
          for (const auto& other : trials)
            if (other.effect != t.effect && other.excited && t.evidence > least_evidence &&
                std::fabs(other.evidence - t.evidence) < std::max(8.0, 0.03 * t.evidence))
              c.confounded_with.push_back(other.effect);
        }
        out.ranking.push_back(c);
      }
    const auto chosen = std::find_if(trials.begin(), trials.end(), [&](const Trial& t) {
      return t.excited && t.fit.finite && earns(t, before);
    });
    if (chosen == trials.end()) break;
    // joint refit of everything with robust standard deviations
    progress(to - 0.02, "refit with " + chosen->effect);
    const Settings effects = valuesOf(*chosen);
    const bool through_contact = !fit_contact_.empty();
    const Eigen::VectorXd own = chosen->fit.x.head(free_nuisance.size());
    Trial all_free = fitEffects(effects, &own, false, 6, chosen->local, true);
    Trial joint = all_free;
    if (through_contact) joint = fitEffects(effects, &own, true, 6, chosen->local, true);
    joint.errors = judge(joint, true);
    joint.errors.fit_error = std::sqrt(joint.fit.squares / std::max(1.0, joint.fit.count));
    adopted = effects;
    DiagnosisStep taken;
    taken.added = chosen->effect;
    taken.errors = joint.errors;
    for (std::size_t i = 0; i < effects.size(); ++i) {
      const auto values = joint.space->effectValues(static_cast<int>(i), joint.fit.x, joint.fit.covariance);
      if (effects[i].id == taken.added) taken.parameters = values;
      for (auto& earlier : out.steps)
        if (earlier.added == effects[i].id) earlier.parameters = values;
    }
    out.steps.push_back(taken);
    if (step == 0)
      for (auto& c : out.ranking)
        if (c.effect == taken.added) {
          c.parameters = taken.parameters;
          c.errors = taken.errors;
        }
    reference_free = all_free;
    reference_contact = joint;
    if (through_contact) {
      // evidence of contact effects is counted over the contact runs with the free runs as prior
      prior = priorOf(all_free);
      const Eigen::VectorXd x = joint.fit.x.head(free_nuisance.size());
      reference_contact = fitEffects(adopted, &x, true, 3, joint.local, false, &prior);
    }
    before = joint.errors;
    last = joint;
    const bool clean = before.validation_error_free < 1.02 * out.noise_floor + 0.03 &&
                       (before.validation_error_contact < 0.0 || before.validation_error_contact < 1.1);
    if (clean) break;
  }
  out.adopted = last.space->model(last.fit.x);
  out.sentences = sentencesOf(out);
  const CandidateErrors& end = before;
  const bool structured = end.validation_error_free > structured_error ||
                          end.validation_error_contact > structured_contact_error;
  if (structured) {
    out.verdict = "unknown";
    out.unexplained = searchUnexplained(recordings_, *last.space, last.fit.x, last.local, offset_std_);
  } else {
    out.verdict = out.steps.empty() ? "none" : "effect";
  }
  out.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  progress(1.0, "done");
  return out;
}

}  // namespace

Diagnosis diagnose(const Model& model, const Dataset& dataset, const DiagnosisOptions& options) {
  std::unique_ptr<tbb::global_control> limit;
  if (options.threads > 0)
    limit = std::make_unique<tbb::global_control>(tbb::global_control::max_allowed_parallelism, options.threads);
  return Diagnoser(model, dataset, options).run();
}

}  // namespace amb_rotor
