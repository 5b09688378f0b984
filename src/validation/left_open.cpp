// What the runs to fit leave open, asked of the runs to validate.
#include <cmath>

#include "amb_rotor/common/linear_algebra.hpp"
#include "candidates.hpp"

namespace amb_rotor {
namespace {

constexpr int iterations = 8;

}  // namespace

/// The posterior of the runs to fit stands as prior: half (x - x_fit)' C^-1 (x - x_fit), in which the belief is already.
LeftOpen Candidates::leftOpen(const Trial& trial, Through through) const {
  const std::vector<int>& held_out = through == Through::contact ? check_contact_ : check_free_;
  const long size = trial.fit.x.size();
  const Eigen::MatrixXd known = Ldlt(trial.fit.covariance).solveColumns(Eigen::MatrixXd::Identity(size, size));
  LeftOpen out;
  out.numbers = static_cast<int>(size);
  if (held_out.empty() || !known.allFinite()) return out;
  QuadraticPrior prior = {known, trial.fit.x, 0.0};
  for (int k = 0; k < trial.space->nuisances(); ++k) {
    const double belief_std = trial.space->coordinates()[k].prior_std;
    if (belief_std > 0.0) prior.h(k, k) -= 1.0 / (belief_std * belief_std);  // the fit adds it again, about the belief
  }
  const FitProblem problem(recordings_, *trial.space, offset_std_);
  FitOptions options;
  options.most_iterations = iterations;
  options.covariance = false;
  options.thorough_first = true;
  options.give_up = [this] { return limit_.isLongUp(); };
  std::vector<LocalState> local = trial.local;
  const FitResult moved = amb_rotor::fit(problem, trial.fit.x, held_out, local, options, &prior);
  if (!moved.finite) return out;
  const Eigen::VectorXd way = moved.x - trial.fit.x;
  const double squared = way.dot(known * way);
  if (!(squared >= 0.0)) return out;  // a stated covariance that is none says nothing
  out.deviations = std::sqrt(squared);
  EvaluationOptions evaluation;
  evaluation.jacobian = false;
  evaluation.window_passes = 3;
  evaluation.thorough = true;
  std::vector<RunResult> results;
  problem.evaluate(moved.x, held_out, local, evaluation, &results);
  double sum = 0.0;
  for (const RunResult& run : results) sum += run.mean_square;
  out.error = std::sqrt(sum / static_cast<double>(results.size()));
  return out;
}

}  // namespace amb_rotor
