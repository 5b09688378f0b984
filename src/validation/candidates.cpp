#include "candidates.hpp"

#include <algorithm>
#include <cmath>

#include "amb_rotor/effects/catalogue.hpp"
#include "amb_rotor/validation/starts.hpp"

namespace amb_rotor {
namespace {

/// Iterations of a candidate's first look, and candidates that are then fitted to the end.
constexpr int first_look_iterations = 2, finalists = 6;
/// Of several starts through contact so many are followed.
constexpr std::size_t followed_starts = 2;
/// They are told by every so many-th window alone.
constexpr int start_stride = 12;
/// Iterations that a candidate may need to come near a reference which it does not contain.
constexpr int approach_iterations = 5, approach_rounds = 2;
/// Each finalist goes on in rounds of so many iterations, while so many more rounds like the last would reach the leader.
constexpr int round_iterations = 4, most_rounds = 3;
constexpr double hopeless_pace = 8.0;
/// Evidence after the first look below which a candidate is not followed.
constexpr double hopeless = -40.0;
/// Prior standard deviations by which a refitted nuisance must be off for candidates to start from the belief too.
constexpr double far_from_belief = 2.5;

}  // namespace

bool isNested(const std::string& effect) {
  if (effect == "foundation_resonance" || effect == "eddy_current_lag") return false;
  const auto& parameters = effectCatalogue().find(effect)->parameters;
  return std::all_of(parameters.begin(), parameters.end(),
                     [](const ParameterSchema& p) { return std::isfinite(p.neutral); });
}

Settings Trial::effects() const {
  Settings out = space->fitted();
  const Model at = space->model(fit.x);
  for (auto& e : out)
    for (const auto& s : at.effects)
      if (s.id == e.id) e.values = s.values;
  return out;
}

Candidates::Candidates(const Model& belief, const Dataset& dataset)
    : belief_(belief), recordings_(prepareRecordings(dataset)) {
  for (const auto& setting : belief_.uncertainty)
    if (setting.first == "sensor.offset_m") offset_std_ = setting.second;
  for (int i = 0; i < static_cast<int>(recordings_.size()); ++i) {
    const bool to_fit = recordings_[i].run.use == RunUse::fit;
    const bool contact = recordings_[i].holdsContact();
    (to_fit ? (contact ? fit_contact_ : fit_free_) : (contact ? check_contact_ : check_free_)).push_back(i);
  }
}

Trial Candidates::fit(const Settings& effects, const Eigen::VectorXd* nuisance, const std::vector<LocalState>& local,
                      const FitEffort& effort, const QuadraticPrior* prior) const {
  Trial trial;
  trial.space = std::make_shared<FitSpace>(belief_, effects);
  trial.local = local;
  for (auto& state : trial.local) {
    state.angle_searches = 0;
    state.window_response.clear();  // they belong to other coordinates
  }
  Eigen::VectorXd start = trial.space->start();
  if (nuisance != nullptr) start.head(nuisance->size()) = *nuisance;
  const FitProblem problem(recordings_, *trial.space, offset_std_);
  FitOptions options;
  options.most_iterations = effort.iterations;
  options.scores = effort.scores;
  if (effort.first_look) {
    options.attempts = 3;
    options.covariance = false;
    if (effort.through == Through::contact) options.window_stride = trial.stride = effort.stride;
  }
  std::vector<int> which = effort.through == Through::contact ? fit_contact_ : fit_free_;
  if (effort.through == Through::all) which.insert(which.end(), fit_contact_.begin(), fit_contact_.end());
  trial.fit = amb_rotor::fit(problem, start, which, trial.local, options, prior);
  if (!effects.empty()) trial.effect = effects.back().id;
  return trial;
}

CandidateErrors Candidates::judge(Trial& trial, bool with_contact, bool thorough) const {
  CandidateErrors errors;
  const FitProblem problem(recordings_, *trial.space, offset_std_);
  EvaluationOptions evaluation;
  evaluation.jacobian = false;
  evaluation.window_passes = 3;
  evaluation.thorough = thorough;
  std::vector<LocalState>& local = trial.local;
  double sum = 0.0;
  int count = 0;
  const auto mean = [&](const std::vector<int>& which) {
    std::vector<RunResult> own;
    // twice where windows are: the first pass finds the runs' offsets, the second counts with them
    const bool windows = !which.empty() && recordings_[which[0]].holdsContact();
    if (windows) problem.evaluate(trial.fit.x, which, local, evaluation, nullptr);
    problem.evaluate(trial.fit.x, which, local, evaluation, &own);
    double part = 0.0;
    for (const auto& r : own) part += r.mean_square;
    sum += part;
    count += static_cast<int>(own.size());
    return own.empty() ? -1.0 : std::sqrt(part / own.size());
  };
  errors.validation_error_free = mean(check_free_);
  if (with_contact) errors.validation_error_contact = mean(check_contact_);
  errors.validation_error = count > 0 ? std::sqrt(sum / count) : 0.0;
  errors.fit_error = trial.fit.count > 0.0 ? std::sqrt(trial.fit.squares / trial.fit.count) : 0.0;
  return errors;
}

double Candidates::evidence(const Trial& trial, const Trial& against) const {
  if (!trial.fit.finite || !against.fit.finite) return -1e300;
  // the noise level that the better model leaves scales chi2: a wrong noise figure is no evidence
  const double level = std::max(1.0, trial.fit.normal.chi2 / std::max(1.0, trial.fit.count));
  const int more = trial.space->size() - against.space->size();
  // states of its own (a mount's) that each window estimates anew are unknowns too
  const double starts = against.fit.normal.occam - trial.fit.normal.occam;
  return 0.5 * (trial.stride * ((against.fit.chi2 - trial.fit.chi2) / level + starts) -
                more * std::log(std::max(2.0, trial.stride * trial.fit.count)));
}

References Candidates::referencesOf(const Trial& free, const Trial& all) const {
  References out;
  out.free = free;
  const int n = free.space->nuisances();
  out.prior.h = free.fit.normal.h.topLeftCorner(n, n);
  out.prior.centre = free.nuisance();
  out.contact = out.sparse = all;
  if (!haveContact()) return out;
  const Eigen::VectorXd own = all.nuisance();
  out.contact = fit(all.effects(), &own, all.local, {Through::contact, 6}, &out.prior);
  const Eigen::VectorXd at = out.contact.nuisance();
  out.sparse = fit(out.contact.effects(), &at, out.contact.local, {Through::contact, 0, false, true}, &out.prior);
  return out;
}

Trial Candidates::bestOf(const std::vector<Settings>& starts, const std::vector<Eigen::VectorXd>& nuisances,
                         const References& references, bool contact) const {
  const Through through = contact ? Through::contact : Through::free;
  const QuadraticPrior* prior = contact ? &references.prior : nullptr;
  const auto& local = references.contact.local;
  std::vector<std::pair<const Settings*, const Eigen::VectorXd*>> looks;
  for (const auto& nuisance : nuisances)
    for (const auto& start : starts) looks.emplace_back(&start, &nuisance);
  if (contact && looks.size() > followed_starts) {
    // where each start stands by itself says which are worth a fit
    std::vector<std::pair<double, std::size_t>> order;
    for (std::size_t i = 0; i < looks.size(); ++i)
      order.emplace_back(fit(*looks[i].first, looks[i].second, local, {through, 0, false, true, start_stride}, prior).fit.chi2, i);
    std::sort(order.begin(), order.end());
    std::vector<std::pair<const Settings*, const Eigen::VectorXd*>> kept;
    for (std::size_t i = 0; i < followed_starts; ++i) kept.push_back(looks[order[i].second]);
    looks = kept;
  }
  Trial winner;
  winner.fit.chi2 = 1e301;
  const int iterations = !contact && starts.size() > 2 ? 1 : first_look_iterations;
  for (const auto& [start, nuisance] : looks) {
    Trial trial = fit(*start, nuisance, local, {through, iterations, false, true}, prior);
    if (trial.fit.chi2 < winner.fit.chi2) winner = std::move(trial);
  }
  return winner;
}

Trial Candidates::look(const std::string& effect, const Settings& adopted, const References& references) const {
  Trial none;
  none.effect = effect;
  none.excited = false;
  const bool contact = needsContact(effect);
  const auto values = startingValues(effect, belief_, recordings_, none.note);
  if (values.empty()) return none;
  if (contact && !haveContact()) {
    none.note = "no run to fit holds contact";
    return none;
  }
  std::vector<Settings> starts;
  for (const auto& start : values) {
    starts.push_back(adopted);
    starts.back().push_back({effect, start});
  }
  // from the refitted nuisance, and from the belief where a wrong model has pulled it far away
  const Trial& reference = contact ? references.contact : references.free;
  std::vector<Eigen::VectorXd> nuisances = {reference.nuisance()};
  for (int k = 0; k < reference.space->nuisances(); ++k) {
    const Coordinate& c = reference.space->coordinates()[k];
    if (std::fabs(nuisances[0][k] - c.prior_mean) > far_from_belief * c.prior_std) {
      nuisances.push_back(reference.space->start().head(reference.space->nuisances()));
      break;
    }
  }
  Trial winner = bestOf(starts, nuisances, references, contact);
  winner.effect = effect;
  value(winner, references);
  // a start that does not contain the reference may need some steps to come near it, and windows whose starts the way
  // there has led astray begin anew
  for (int round = 0; round < approach_rounds && winner.fit.finite && !isNested(effect) && winner.evidence < hopeless;
       ++round) {
    const Eigen::VectorXd own = winner.nuisance();
    std::vector<LocalState> local = winner.local;
    if (contact)
      for (auto& state : local) state.window_start.clear();
    Trial more = fit(winner.effects(), &own, local, {contact ? Through::contact : Through::free, approach_iterations, false, true},
                     contact ? &references.prior : nullptr);
    if (more.fit.chi2 >= winner.fit.chi2) break;
    winner = std::move(more);
    value(winner, references);
  }
  return winner;
}

void Candidates::value(Trial& trial, const References& references) const {
  trial.evidence = trial.excited ? evidence(trial, references.of(trial)) : -1e300;
}

void Candidates::finish(std::vector<Trial>& trials, const References& references,
                        const std::function<void(const std::string&)>& tell) const {
  const auto order = [](const Trial& a, const Trial& b) { return a.evidence > b.evidence; };
  std::stable_sort(trials.begin(), trials.end(), order);
  int finished = 0;
  double leader = -1e300;
  for (auto& t : trials) {
    // those that may still become the best: the first few, and whatever comes near them
    if (!t.usable() || finished >= finalists || t.evidence < hopeless) break;
    ++finished;
    tell(t.effect);
    const bool contact = needsContact(t.effect);
    for (int round = 0; round < most_rounds; ++round) {
      const Eigen::VectorXd own = t.nuisance();
      Trial more = fit(t.effects(), &own, t.local, {contact ? Through::contact : Through::free, round_iterations},
                       contact ? &references.prior : nullptr);
      const bool comparable = more.stride == t.stride;
      if (comparable && more.fit.chi2 > t.fit.chi2) break;
      const double was = t.evidence;
      t = std::move(more);
      value(t, references);
      if (t.evidence < hopeless) break;
      if (!comparable) continue;
      const double gained = t.evidence - was;
      // at this pace it would not come near the leader
      if (gained < 0.5 || (t.evidence < leader && hopeless_pace * gained < leader - t.evidence)) break;
    }
    leader = std::max(leader, t.evidence);
  }
  std::stable_sort(trials.begin(), trials.end(), order);
}

}  // namespace amb_rotor
