#include "candidates.hpp"

#include <algorithm>
#include <cmath>

#include "amb_rotor/common/linear_algebra.hpp"
#include "amb_rotor/effects/catalogue.hpp"
#include "amb_rotor/validation/starts.hpp"

namespace amb_rotor {
namespace {

/// Of its prior standard deviation so much may be left of a nuisance that counts as settled by the runs without contact.
constexpr double settled_share = 0.25;
/// Share of a coordinate's scale from a limit at which it counts as stopped there.
constexpr double limit_share = 0.01;
/// Prior standard deviations by which a refitted nuisance must be off for candidates to start from the belief too.
constexpr double far_from_belief = 2.5;

}  // namespace

bool isNested(const std::string& effect) {
  if (effect == "foundation_resonance") return false;
  const auto& parameters = effectCatalogue().find(effect)->parameters;
  return std::all_of(parameters.begin(), parameters.end(),
                     [](const ParameterSchema& p) { return std::isfinite(p.neutral); });
}

int strideOver(const Settings& effects, int stride) {
  const auto lasting = [](const EffectSetting& effect) { return effectCatalogue().find(effect.id)->lasting; };
  return std::any_of(effects.begin(), effects.end(), lasting) ? 1 : stride;
}

bool returnToBelief(const FitSpace& space, Eigen::VectorXd& nuisance) {
  const std::vector<int> far = space.farFromBelief(nuisance, far_from_belief);
  for (const int k : far) nuisance[k] = space.coordinates()[k].prior_mean;
  return !far.empty();
}

namespace {

/// Whether it is a number of one of the effects, and runs without contact say nothing of it.
bool onlyContactShows(const std::string& coordinate, const Settings& effects) {
  return std::any_of(effects.begin(), effects.end(), [&](const EffectSetting& effect) {
    const EffectSchema& schema = *effectCatalogue().find(effect.id);
    if (coordinate.rfind(effect.id + ".", 0) != 0) return false;
    const int k = schema.indexOf(coordinate.substr(effect.id.size() + 1));
    return schema.needs_contact || (k >= 0 && schema.parameters[k].needs_contact);
  });
}

/// What runs without contact know nothing of.
std::vector<bool> heldWithoutContact(const FitSpace& space) {
  std::vector<bool> held;
  for (const auto& coordinate : space.coordinates())
    held.push_back(coordinate.name.rfind("auxiliary_bearing.", 0) == 0 || onlyContactShows(coordinate.name, space.fitted()));
  return held;
}

/// What the runs without contact have settled: fits to the others alone leave it there. A prior that is of an effect's numbers, too,
/// holds them itself, as they hang together.
std::vector<bool> heldThroughContact(const FitSpace& space, const QuadraticPrior& prior) {
  std::vector<bool> held(space.size(), false);
  const int n = space.nuisances();
  if (prior.centre.size() > n) return held;
  Eigen::MatrixXd h = prior.h;
  for (int k = 0; k < n; ++k) h(k, k) += 1.0 / std::pow(space.coordinates()[k].prior_std, 2);
  const Eigen::MatrixXd covariance = Ldlt(h).solveColumns(Eigen::MatrixXd::Identity(n, n));
  for (int k = 0; k < n; ++k) held[k] = std::sqrt(covariance(k, k)) < settled_share * space.coordinates()[k].prior_std;
  for (int k = n; k < space.size(); ++k) held[k] = !onlyContactShows(space.coordinates()[k].name, space.fitted());
  return held;
}

}  // namespace

Settings Trial::effects() const {
  Settings out = space->fitted();
  const Model at = space->model(fit.x);
  for (auto& e : out)
    for (const auto& s : at.effects)
      if (s.id == e.id) e.values = s.values;
  return out;
}

Candidates::Candidates(const Model& belief, const Dataset& dataset, const TimeLimit& limit)
    : belief_(belief), limit_(limit), recordings_(prepareRecordings(dataset)) {
  for (const auto& setting : belief_.uncertainty)
    if (setting.first == "sensor.offset_m") offset_std_ = setting.second;
  for (int i = 0; i < static_cast<int>(recordings_.size()); ++i) {
    const bool to_fit = recordings_[i].run.use == RunUse::fit;
    const bool contact = recordings_[i].holdsContact();
    for (int a = 0; a < 4; ++a) current_noise_A_ = std::max(current_noise_A_, recordings_[i].noise[4 + a]);
    (to_fit ? (contact ? fit_contact_ : fit_free_) : (contact ? check_contact_ : check_free_)).push_back(i);
  }
}

std::vector<EffectSetting> Candidates::awayFromLimits(const FitSpace& space, const Eigen::VectorXd& x, const EffectSetting& effect) const {
  std::string unused;
  const auto starts = startingValues(effect.id, belief_, recordings_, unused);
  if (starts.empty()) return {};
  EffectSetting away = effect, anew = effect;
  anew.values = starts[starts.size() / 2];
  const auto& parameters = effectCatalogue().find(effect.id)->parameters;
  for (int k = space.nuisances(); k < space.size(); ++k) {
    const Coordinate& c = space.coordinates()[k];
    const double close = limit_share * c.scale;
    if (x[k] - c.lower > close && c.upper - x[k] > close) continue;
    for (std::size_t i = 0; i < parameters.size(); ++i)
      if (c.name == effect.id + "." + parameters[i].name) away.values[i] = anew.values[i];
  }
  // what rises above another number stops at its own limit, which its coordinate does not know
  for (std::size_t i = 0; i < parameters.size(); ++i)
    if (effect.values[i] > (1.0 - limit_share) * parameters[i].upper) away.values[i] = anew.values[i];
  if (away.values == effect.values) return {};
  if (away.values == anew.values) return {away};
  return {away, anew};
}

Trial Candidates::fit(const Settings& effects, const Eigen::VectorXd* nuisance, const std::vector<LocalState>& local,
                      const FitEffort& effort, const QuadraticPrior* prior) const {
  Trial trial;
  trial.space = std::make_shared<FitSpace>(belief_, effects);
  trial.space->setCurrentNoise(current_noise_A_);
  trial.local = local;
  for (auto& state : trial.local) {
    state.angle_searches = 0;
    state.evaluations = 0;
    state.window_response.clear();  // they belong to other coordinates
  }
  Eigen::VectorXd start = trial.space->start();
  if (nuisance != nullptr) start.head(nuisance->size()) = *nuisance;
  const FitProblem problem(recordings_, *trial.space, offset_std_);
  FitOptions options;
  options.most_iterations = effort.iterations;
  options.give_up = [this, look = effort.first_look] { return look ? limit_.isUp() : limit_.isLongUp(); };
  options.thorough_first = effort.thorough;
  options.scores = effort.scores;
  options.frozen = effort.frozen;
  options.window_s = effort.window_s;
  options.columns_at_once = !haveContact();  // windows that follow end elsewhere for any difference
  if (effort.first_look) {
    options.attempts = effort.attempts;
    options.covariance = false;
    if (effort.iterations == 0) options.first_window_passes = 1;
    options.thorough_first = effort.through == Through::contact;  // a window that begins wrong outweighs many
    if (effort.through == Through::contact)
      options.window_stride = trial.stride = effort.every_effect ? effort.stride : strideOver(effects, effort.stride);
    options.window_offset = look_offset_;
  }
  if (effort.through == Through::all && !effects.empty() && needsContact(effects.back().id)) options.thorough_first = true;
  if (effort.through == Through::free) options.held = heldWithoutContact(*trial.space);
  if (effort.through == Through::contact && prior != nullptr) {
    options.held = heldThroughContact(*trial.space, *prior);
    for (int k = 0; k < trial.space->nuisances(); ++k)
      if (options.held[k]) start[k] = prior->centre[k];
  }
  if (effort.held >= 0) {
    options.held.resize(trial.space->size(), false);
    options.held[effort.held] = true;
  }
  std::vector<int> which = effort.through == Through::contact ? fit_contact_ : fit_free_;
  if (effort.through == Through::all) which.insert(which.end(), fit_contact_.begin(), fit_contact_.end());
  const bool from_belief = nuisance == nullptr && effects.empty() && effort.through == Through::free;
  trial.fit = from_belief ? fitFromBelief(problem, which, trial.local, options)
                          : amb_rotor::fit(problem, start, which, trial.local, options, prior);
  if (!effects.empty()) trial.effect = effects.back().id;
  return trial;
}

CandidateErrors Candidates::judge(Trial& trial, bool with_contact, Judging judging, int stride) const {
  CandidateErrors errors;
  const FitProblem problem(recordings_, *trial.space, offset_std_);
  EvaluationOptions evaluation;
  evaluation.jacobian = false;
  evaluation.window_passes = 3;
  evaluation.window_stride = stride;
  std::vector<LocalState>& local = trial.local;
  evaluation.thorough = judging == Judging::anew;
  if (evaluation.thorough)
    for (const int run : check_contact_) local[run] = begunAnew(local[run]);  // another model may have led it astray
  evaluation.keep_prediction = evaluation.thorough && with_contact;
  HeldOut held_out = {trial.fit.x, std::vector<RunResult>(recordings_.size())};
  double sum = 0.0;
  int count = 0;
  const auto mean = [&](const std::vector<int>& which) {
    std::vector<RunResult> own;
    if (judging == Judging::glance)
      problem.evaluate(trial.fit.x, which, local, evaluation, &own);
    else
      evaluateSettled(problem, trial.fit.x, which, local, evaluation, own);
    double part = 0.0;
    for (const auto& r : own) part += r.mean_square;
    sum += part;
    count += static_cast<int>(own.size());
    for (std::size_t i = 0; i < own.size(); ++i) held_out.runs[which[i]] = std::move(own[i]);
    return which.empty() ? -1.0 : std::sqrt(part / which.size());
  };
  errors.validation_error_free = mean(check_free_);
  errors.offset_deviations = offsetDeviations(local);
  if (with_contact) errors.validation_error_contact = mean(check_contact_);
  if (evaluation.keep_prediction) trial.held_out = std::make_shared<const HeldOut>(std::move(held_out));
  errors.validation_error = count > 0 ? std::sqrt(sum / count) : 0.0;
  errors.fit_error = trial.fit.count > 0.0 ? std::sqrt(trial.fit.squares / trial.fit.count) : 0.0;
  return errors;
}

double Candidates::offsetDeviations(const std::vector<LocalState>& local) const {
  double sum = 0.0;
  int count = 0;
  for (const int run : check_free_) {
    if (!recordings_[run].offsets_in_loop || offset_std_ <= 0.0) continue;
    for (const double offset : local[run].offset_m) sum += offset * offset / (offset_std_ * offset_std_);
    count += axis_count;
  }
  return count > 0 ? std::sqrt(sum / count) : -1.0;
}

double Candidates::evidence(const Trial& trial, const Trial& against) const {
  if (!trial.fit.finite || !against.fit.finite) return -1e300;
  // the noise level that the better model leaves scales chi2: a wrong noise figure is no evidence
  const double level = std::max(1.0, trial.fit.normal.chi2 / std::max(1.0, trial.fit.count));
  const int more = trial.space->size() - against.space->size();
  // states of its own (a mount's) that each window estimates anew are unknowns too. Of the same ones it would tell how well windows know
  // them, which hangs on the hollows that they end in: it was worth 270 to a bearing aside beside a right mount that left no more
  const NormalEquations &own = trial.fit.normal, &others = against.fit.normal;
  const double starts = own.starts != others.starts ? others.occam - own.occam : 0.0;
  return 0.5 * (trial.stride * ((against.fit.chi2 - trial.fit.chi2) / level + starts) -
                more * std::log(std::max(2.0, trial.stride * trial.fit.count)));
}

References Candidates::referencesWithoutContact(const Trial& free, const Trial& all) const {
  References out;
  out.free = free;
  const int n = free.space->nuisances();
  out.prior.h = free.fit.normal.h.topLeftCorner(n, n);
  out.prior.centre = free.nuisance();
  out.screen = std::make_shared<const StartScreen>(recordings_, fit_free_, *free.space, free.fit.x, free.local, offset_std_);
  out.contact = out.sparse = all;
  return out;
}

void Candidates::referThroughContact(References& references) {
  if (!haveContact()) return;
  const Trial all = references.contact;
  references.through_contact = true;
  references.short_level = 0.0;
  const Eigen::VectorXd own = all.nuisance();
  references.contact = fit(all.effects(), &own, all.local, {Through::contact, 6}, &references.prior);
  const Eigen::VectorXd at = references.contact.nuisance();
  const FitEffort glance = {Through::contact, 0, false, true};
  const auto above = [](const Trial& trial) { return trial.fit.chi2 - trial.fit.count; };
  int worst = 0;
  for (int offset = 0; offset < strideOver(all.effects(), glance.stride); ++offset) {
    look_offset_ = offset;
    Trial sparse = fit(references.contact.effects(), &at, references.contact.local, glance, &references.prior);
    if (offset > 0 && !(above(sparse) > above(references.sparse))) continue;
    worst = offset;
    references.sparse = std::move(sparse);
  }
  look_offset_ = worst;
  if (references.sparse.stride == 1 || isAstray(references.contact)) return;
  // looks are fitted to these windows: near the noise, one that a glance has thrown off would speak for each of them
  const Eigen::VectorXd stood = references.sparse.nuisance();
  Trial fitted = fit(references.sparse.effects(), &stood, references.sparse.local, {Through::contact, first_look_iterations, false, true},
                     &references.prior);
  if (fitted.fit.finite && fitted.fit.chi2 < references.sparse.fit.chi2) references.sparse = std::move(fitted);
}

}  // namespace amb_rotor
