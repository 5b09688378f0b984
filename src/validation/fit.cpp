#include "amb_rotor/validation/fit.hpp"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <limits>
#include <mutex>

#include "amb_rotor/common/error.hpp"
#include "amb_rotor/common/linear_algebra.hpp"
#include "amb_rotor/common/units.hpp"
#include "amb_rotor/effects/catalogue.hpp"
#include "amb_rotor/model/effect_file.hpp"
#include "law_place.hpp"
#include "trusted_step.hpp"
#include "window_ease.hpp"

namespace amb_rotor {

namespace {

/// Finite differences through impacts, where predictions have kinks, over a coordinate's scale.
constexpr double step_through_contact = 0.02;

/// Share of chi2 that a step has gained from which on the runs' own unknowns are still on their way, even where the
/// coordinates would stay: through contact their squares are far from a parabola.
constexpr double still_settling = 0.01;

/// Evaluations at most until a run stands, and the share by which its mean square then still changes. Twelve runs of another program
/// were left 1.0 to 3.6 times the noise squared off by their right models in the first, 0.5 to 1.0 in the second, and stood after two to
/// four.
constexpr int most_settling_passes = 6;
constexpr double settled_share = 0.02;
/// Starts of windows are searched in all their guesses again, which is most of the time where a wrong model throws many off, where a run
/// is left below so many times the noise's square, or the pass before has taken such a share off.
constexpr double searched_again = 4.0, falling_share = 0.3;

/// Drop of chi2 that a step through contact must promise for shorter ones to be tried where it fails: hollows are deeper than this.
constexpr double within_hollows = 3.0;

/// Through impacts the linear model of an effect is good for a few of its parameters' scales only. Of a nuisance: no bound.
Eigen::VectorXd trustedLengths(const FitSpace& space) {
  constexpr double trusted_scales = 6.0;
  Eigen::VectorXd out = Eigen::VectorXd::Constant(space.size(), std::numeric_limits<double>::infinity());
  for (int k = space.nuisances(); k < space.size(); ++k) out[k] = trusted_scales * space.coordinates()[k].scale;
  return out;
}

}  // namespace

void NormalEquations::add(const NormalEquations& other) {
  h += other.h;
  g += other.g;
  chi2 += other.chi2;
  squares += other.squares;
  count += other.count;
  occam += other.occam;
  starts += other.starts;
  scores += other.scores;
  finite = finite && other.finite;
}

LocalState begunAnew(const LocalState& state) {
  LocalState out;
  out.angle_searches = state.angle_searches;
  out.angle_rad = state.angle_rad;
  out.turning = state.turning;
  out.evaluations = state.evaluations;
  out.run_in_s = state.run_in_s;
  return out;
}

std::vector<LocalState> begunAnew(std::vector<LocalState> states) {
  for (LocalState& state : states) state = begunAnew(state);
  return states;
}

FitProblem::FitProblem(const std::vector<Recording>& recordings, const FitSpace& space, double offset_std_m)
    : recordings_(recordings), space_(space), offset_std_(offset_std_m) {
  for (const auto& coordinate : space.coordinates()) {
    steps_.push_back(step_through_contact * coordinate.scale);
    free_steps_.push_back(step_without_contact * coordinate.scale);
  }
}

bool FitProblem::dependsOnAngle(const Model& model) const {
  for (const auto& effect : model.effects) {
    const EffectSchema* schema = effectCatalogue().find(effect.id);
    if (effect.id == "couple_unbalance") continue;  // no force at standstill
    if (schema->law != nullptr && schema->law->reads(EffectLaw::angle)) return true;
    if (const std::optional<LawPlace> law = LawPlace::of(effect.id))
      for (int term = 0; term < law->terms(); ++term)
        if (law->readsAngle(term) && effect.values[term] != 0.0) return true;
    for (const auto& p : schema->parameters)
      if (p.role == ParameterRole::phase) return true;
  }
  return false;
}

namespace {

/// Watches over the sum of a step that is tried.
class Useful {
 public:
  explicit Useful(double most_chi2) : most_(most_chi2) {}
  bool ended() const { return ended_at_.load(std::memory_order_relaxed) >= 0; }
  int endedAt() const { return ended_at_.load(); }
  void add(const NormalEquations& part, int index) {
    if (!std::isfinite(most_)) return;
    const std::lock_guard<std::mutex> lock(mutex_);
    sum_ += std::max(0.0, part.chi2);
    if (!ended() && !(part.finite && sum_ < most_)) ended_at_ = index;
  }

 private:
  const double most_;
  double sum_ = 0.0;
  std::atomic<int> ended_at_{-1};
  std::mutex mutex_;
};

}  // namespace

NormalEquations FitProblem::evaluate(const Eigen::VectorXd& x, const std::vector<int>& which,
                                     std::vector<LocalState>& local, const EvaluationOptions& options,
                                     std::vector<RunResult>* results) const {
  const int p = space_.size();
  std::vector<Model> free = {space_.model(x)}, touching = free;
  std::vector<int> columns;
  const bool any_touching = std::any_of(which.begin(), which.end(), [&](int i) { return holdsContact(i); });
  const bool any_free = std::any_of(which.begin(), which.end(), [&](int i) { return !holdsContact(i); });
  const int frozen = options.frozen != nullptr ? options.frozen->size : 0;
  const auto moved = [&](int k, double step) {
    Eigen::VectorXd to = x;
    // away from a limit, so that the difference is a real one
    to[k] += x[k] + steps_[k] <= space_.coordinates()[k].upper ? step : -step;
    return space_.model(to);
  };
  if (options.jacobian)
    for (int k = 0; k < p; ++k) {
      if (!options.held.empty() && options.held[k]) continue;
      columns.push_back(k);
      if (k < frozen) continue;
      if (any_free) free.push_back(moved(k, free_steps_[k]));
      if (any_touching) touching.push_back(moved(k, steps_[k]));
    }
  std::vector<NormalEquations> parts(which.size(), NormalEquations(p));
  std::vector<RunResult> own(which.size());
  Useful useful(options.useful_chi2);
  tbb::parallel_for(std::size_t{0}, which.size(), [&](std::size_t place) {
    const std::size_t i = (place + options.first) % which.size();
    if (useful.ended()) return;
    const Recording& rec = recordings_[which[i]];
    LocalState& state = local[which[i]];
    AMB_ROTOR_CHECK(frozen == 0 || !rec.holdsContact(), "frozen columns are of recordings without contact");
    parts[i] = rec.holdsContact() ? evaluateWindows(x, touching, columns, rec, state, options, own[i])
                                  : evaluateFree(free, columns, rec, state, options, own[i]);
    useful.add(parts[i], static_cast<int>(i));
  });
  NormalEquations sum(p);
  if (useful.ended()) {
    sum.finite = false;
    sum.chi2 = sum.squares = 1e300;
    sum.ended_at = useful.endedAt();
    return sum;
  }
  for (std::size_t i = 0; i < parts.size(); ++i) sum.add(parts[i]);
  if (options.jacobian && any_touching) {
    sum.windows = {Eigen::MatrixXd::Zero(p, p), Eigen::VectorXd::Zero(p)};
    for (std::size_t i = 0; i < parts.size(); ++i) {
      if (!recordings_[which[i]].holdsContact()) continue;
      sum.windows.h += parts[i].h;
      sum.windows.g += parts[i].g;
      sum.windows.chi2 += parts[i].chi2;
      sum.windows.count += parts[i].count;
    }
  }
  // a coordinate at its upper limit was stepped downwards
  if (options.jacobian)
    for (int k = frozen; k < p; ++k)
      if (x[k] + steps_[k] > space_.coordinates()[k].upper) {
        sum.h.row(k) *= -1.0;
        sum.h.col(k) *= -1.0;
        sum.scores.row(k) *= -1.0;
        sum.scores.col(k) *= -1.0;
        sum.g[k] *= -1.0;
        if (sum.windows.empty()) continue;
        sum.windows.h.row(k) *= -1.0;
        sum.windows.h.col(k) *= -1.0;
        sum.windows.g[k] *= -1.0;
      }
  if (results != nullptr) *results = std::move(own);
  return sum;
}

void evaluateSettled(const FitProblem& problem, const Eigen::VectorXd& x, const std::vector<int>& which, std::vector<LocalState>& local,
                     const EvaluationOptions& options, std::vector<RunResult>& results) {
  results.assign(which.size(), {});
  tbb::parallel_for(std::size_t{0}, which.size(), [&](std::size_t i) {
    EvaluationOptions pass_options = options;
    const auto pass = [&] {
      std::vector<RunResult> own;
      problem.evaluate(x, {which[i]}, local, pass_options, &own);
      return std::move(own[0]);
    };
    RunResult& kept = results[i];
    // what impacts have thrown off without the offsets is found with them
    const bool without_offsets = problem.findsOffsetsByWindows(which[i]) && local[which[i]].window_start.empty();
    pass_options.thorough = options.thorough && !without_offsets;
    kept = pass();
    if (!problem.settlesByPasses(which[i])) return;
    double before = kept.mean_square;
    for (int number = 1; number < most_settling_passes; ++number) {
      if (kept.stands && pass_options.thorough == options.thorough) break;
      const bool first_with_offsets = number == 1 && without_offsets, falls = kept.mean_square < (1.0 - falling_share) * before;
      before = kept.mean_square;
      pass_options.thorough = options.thorough && (first_with_offsets || falls || before < searched_again);
      kept = pass();
      if (std::fabs(kept.mean_square - before) <= settled_share * before) break;
    }
  });
}

namespace {

/// Windows that all begin anew are estimated with sensors that have no offset, which throws those with an impact off: they are searched
/// again with what the others have found. Where the model is far off that finds nothing, and leads astray.
void settleFresh(const FitProblem& problem, const Eigen::VectorXd& x, const std::vector<int>& which, EvaluationOptions evaluation,
                 std::vector<LocalState>& local) {
  std::vector<int> fresh;
  for (const int run : which)
    if (problem.findsOffsetsByWindows(run) && local[run].window_start.empty()) fresh.push_back(run);
  if (fresh.empty()) return;
  evaluation.jacobian = false;
  std::vector<LocalState> settled = local;
  std::vector<RunResult> results;
  evaluateSettled(problem, x, fresh, settled, evaluation, results);
  for (std::size_t i = 0; i < fresh.size(); ++i)
    if (results[i].finite && results[i].mean_square < searched_again) local[fresh[i]] = std::move(settled[fresh[i]]);
}

}  // namespace

FitResult fit(const FitProblem& problem, const Eigen::VectorXd& start, const std::vector<int>& which,
              std::vector<LocalState>& local, const FitOptions& options, const QuadraticPrior* extra) {
  const FitSpace& space = problem.space();
  const int p = space.size();
  FitResult result;
  result.x = space.clamped(start);
  EvaluationOptions evaluation;
  evaluation.window_passes = options.first_window_passes;
  evaluation.window_stride = options.window_stride;
  evaluation.window_offset = options.window_offset;
  evaluation.window_s = options.window_s;
  evaluation.all_or_nothing = true;
  evaluation.held = options.held;
  evaluation.frozen = options.frozen;
  Eigen::VectorXd prior_weight = Eigen::VectorXd::Zero(p), prior_mean = Eigen::VectorXd::Zero(p);
  for (int k = 0; k < p; ++k) {
    const auto& c = space.coordinates()[k];
    if (c.prior_std > 0.0) {
      prior_weight[k] = 1.0 / (c.prior_std * c.prior_std);
      prior_mean[k] = c.prior_mean;
    }
  }
  const int q = extra != nullptr ? static_cast<int>(extra->centre.size()) : 0;
  const auto penalty = [&](const Eigen::VectorXd& x) {
    double sum = (prior_weight.array() * (x - prior_mean).array().square()).sum();
    if (q > 0) {
      const Eigen::VectorXd d = x.head(q) - extra->centre;
      sum += d.dot(extra->h * d) + extra->chi2;
    }
    return sum;
  };
  evaluation.thorough = options.thorough_first;
  settleFresh(problem, result.x, which, evaluation, local);
  NormalEquations now = problem.evaluate(result.x, which, local, evaluation);
  evaluation.thorough = false;
  result.finite = now.finite;
  if (!now.finite) {
    result.chi2 = 1e300;
    result.covariance = Eigen::MatrixXd::Zero(p, p);
    result.normal = now;
    return result;
  }
  evaluation.window_passes = options.window_passes;
  double chi2 = now.chi2 + penalty(result.x);
  double damping = 1e-6;
  // what a fit is reported by goes to the end of a flat valley: 20 may be several deviations of what lies along it
  const double last_drop = options.scores ? 1.0 : 20.0;
  double gained = 0.0;  // by the last step
  const bool windows = std::any_of(which.begin(), which.end(), [&](int i) { return problem.holdsContact(i); });
  const Eigen::VectorXd trusted = trustedLengths(space);
  WindowEase ease;
  int first = 0;
  for (int iteration = 0; iteration < options.most_iterations && !(options.give_up && options.give_up()); ++iteration) {
    Eigen::MatrixXd h = now.h;
    Eigen::VectorXd g = now.g;
    h.diagonal() += prior_weight;
    g -= prior_weight.cwiseProduct(result.x - prior_mean);
    if (q > 0) {
      h.topLeftCorner(q, q) += extra->h;
      g.head(q) -= extra->h * (result.x.head(q) - extra->centre);
    }
    for (int k = 0; k < p; ++k)
      if (!options.held.empty() && options.held[k]) {
        h.row(k).setZero();
        h.col(k).setZero();
        h(k, k) = 1.0;
        g[k] = 0.0;
      }
    bool improved = false, converged = false;
    for (int attempt = 0; attempt < options.attempts; ++attempt) {
      const bool eased = ease.isWanted(now.windows.chi2 / std::max(1.0, now.windows.count));
      Eigen::MatrixXd damped = h;
      if (eased) ease.relieve(now.windows.h, options.held, damped);
      for (int k = 0; k < p; ++k) {
        const double scale = space.coordinates()[k].scale;
        damped(k, k) += damping * h(k, k) + 1e-9 / (scale * scale);
      }
      const Eigen::VectorXd step = windows ? trustedStep(damped, g, trusted) : Ldlt(damped).solve(g);
      if (!step.allFinite()) {
        damping = std::max(damping * 100.0, 1e-3);
        continue;
      }
      const Eigen::VectorXd x = space.clamped(result.x + step);
      const double expected = step.dot(g);  // about twice the drop of half chi2
      if (expected < options.tolerance * 0.1 * std::max(1.0, chi2) && expected < 0.5 && gained < still_settling * chi2) {
        converged = true;
        break;
      }
      // the value alone first: many steps that fail do so here; through windows, and with few columns to predict, it is
      // hardly cheaper than all
      std::vector<LocalState> trial_local = local;
      EvaluationOptions trial_options = evaluation;
      const bool needed = options.covariance || iteration + 1 < options.most_iterations;
      const bool with_columns = windows || options.frozen != nullptr || (options.columns_at_once && needed);
      trial_options.jacobian = with_columns && attempt == 0;
      if (options.thorough_first && attempt > 0) {  // a step may fail for windows that the way there has thrown off
        trial_options.thorough = true;
        trial_options.window_passes = options.first_window_passes;
      }
      trial_options.useful_chi2 = chi2 - penalty(x);
      trial_options.first = first;
      NormalEquations trial = problem.evaluate(x, which, trial_local, trial_options);
      if (trial.ended_at >= 0) first = trial.ended_at;  // the next step, which is a shorter one, may fail there, too
      const double trial_chi2 = trial.chi2 + penalty(x);
      if (trial.finite && trial_chi2 < chi2) {
        converged = chi2 - trial_chi2 < options.tolerance * chi2 && chi2 - trial_chi2 < last_drop;
        gained = windows ? chi2 - trial_chi2 : 0.0;
        const Eigen::VectorXd taken = x - result.x;
        const WindowsShare before = now.windows;
        local = std::move(trial_local);
        result.x = x;
        chi2 = trial_chi2;
        const bool go_on = !converged && iteration + 1 < options.most_iterations;
        if (trial_options.jacobian) {
          now = std::move(trial);
        } else if (go_on || options.covariance) {
          trial_options.jacobian = true;
          trial_options.useful_chi2 = std::numeric_limits<double>::infinity();
          now = problem.evaluate(x, which, local, trial_options);
          chi2 = now.chi2 + penalty(x);
        } else {
          now.chi2 = trial.chi2;
          now.squares = trial.squares;
          now.count = trial.count;
          now.occam = trial.occam;
        }
        if (!now.windows.empty()) ease.learn(before.h, before.g, now.windows.g, taken);
        damping = std::max(damping * 0.1, 1e-9);
        improved = true;
        break;
      }
      if (!eased)
        damping = std::max(damping * 10.0, 1e-2);
      else if (attempt + 2 < options.attempts)
        ease.shorten();
      else
        ease = {};  // the last one is as long as the normal equations say
      if (windows ? expected < within_hollows : attempt >= 3 && expected < 1.0) break;
    }
    ++result.iterations;
    if (!improved || converged) break;
  }
  if (options.scores) {
    evaluation.scores = true;
    now = problem.evaluate(result.x, which, local, evaluation);
  }
  Eigen::MatrixXd h = now.h;
  h.diagonal() += prior_weight;
  if (q > 0) h.topLeftCorner(q, q) += extra->h;
  for (int k = 0; k < p; ++k) h(k, k) += 1e-9 / std::pow(space.coordinates()[k].scale, 2);
  const Eigen::MatrixXd inverse = Ldlt(h).solveColumns(Eigen::MatrixXd::Identity(p, p));
  if (options.scores) {
    // sandwich: the noise is coloured (part of it went round the loop), so blocks of time count, not samples
    // a misfit that no test of a million residuals sees, but that all of them share, shifts what they determine
    Eigen::MatrixXd middle = now.scores + shared_misfit * shared_misfit * now.count * now.h;
    middle.diagonal() += prior_weight;
    if (q > 0) middle.topLeftCorner(q, q) += extra->h;
    const Eigen::MatrixXd robust = inverse * middle * inverse;
    result.covariance = robust;
    for (int k = 0; k < p; ++k)  // few blocks may flatter a coordinate: never below the plain value
      if (!(robust(k, k) > 0.0)) {
        result.covariance(k, k) = inverse(k, k);  // no run knows of it
      } else if (robust(k, k) < inverse(k, k)) {
        const double grow = std::sqrt(inverse(k, k) / robust(k, k));
        result.covariance.row(k) *= grow;
        result.covariance.col(k) *= grow;
      }
  } else {
    result.covariance = inverse;
  }
  result.chi2 = now.chi2 + penalty(result.x);
  result.squares = now.squares;
  result.count = now.count;
  result.normal = std::move(now);
  return result;
}

}  // namespace amb_rotor
