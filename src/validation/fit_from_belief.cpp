// A fit from where the owner believes the rig to be.
#include <cmath>
#include <limits>

#include "amb_rotor/validation/fit.hpp"

namespace amb_rotor {
namespace {

/// Mean square over the noise from which on the end of a fit may be a hollow.
constexpr double hollow_square = 1.5;

/// A point and its chi2; infinite where the motion does not stay finite.
struct Place {
  Eigen::VectorXd x;
  double chi2;
};

/// Of the points beside the beliefs, each of one number moved by one and two of its deviations, the one of least chi2.
/// @param least  the beliefs'
Place leastBeside(const FitProblem& problem, Place least, const std::vector<bool>& held,
                  const std::function<double(const Eigen::VectorXd&)>& chi2At) {
  const FitSpace& space = problem.space();
  const Eigen::VectorXd start = least.x;
  for (int k = 0; k < space.size(); ++k)
    for (const double deviations : {-2.0, -1.0, 1.0, 2.0}) {
      const Coordinate& coordinate = space.coordinates()[k];
      if (!(coordinate.prior_std > 0.0) || (!held.empty() && held[k])) continue;
      Eigen::VectorXd x = start;
      x[k] = coordinate.prior_mean + deviations * coordinate.prior_std;
      x = space.clamped(x);
      const double chi2 = chi2At(x) + deviations * deviations;
      if (chi2 < least.chi2) least = {x, chi2};
    }
  return least;
}

}  // namespace

FitResult fitFromBelief(const FitProblem& problem, const std::vector<int>& which, std::vector<LocalState>& local, const FitOptions& options) {
  EvaluationOptions alone;
  alone.jacobian = false;
  alone.all_or_nothing = true;
  const std::vector<LocalState> fresh = local;
  const auto chi2At = [&](const Eigen::VectorXd& x) {
    std::vector<LocalState> trial = fresh;
    const NormalEquations found = problem.evaluate(x, which, trial, alone);
    return found.finite ? found.chi2 : std::numeric_limits<double>::infinity();
  };
  Place begin = {problem.space().clamped(problem.space().start()), 0.0};
  begin.chi2 = chi2At(begin.x);
  const bool runs = std::isfinite(begin.chi2);
  if (!runs) begin = leastBeside(problem, begin, options.held, chi2At);
  FitResult out = fit(problem, begin.x, which, local, options);
  if (!runs || !out.finite || out.squares < hollow_square * out.count) return out;
  const Place other = leastBeside(problem, begin, options.held, chi2At);
  if (!(other.chi2 < out.chi2)) return out;
  std::vector<LocalState> there = fresh;
  FitResult more = fit(problem, other.x, which, there, options);
  if (!more.finite || more.chi2 >= out.chi2) return out;
  local = std::move(there);
  return more;
}

}  // namespace amb_rotor
