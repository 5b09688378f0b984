#include "trusted_step.hpp"

#include <algorithm>
#include <cmath>

#include "amb_rotor/common/linear_algebra.hpp"

namespace amb_rotor {
namespace {

/// By so much the weight grows until a step stays within; between the last two it is then halved in logarithm, until the step that still
/// reaches beyond does so by no more than this.
constexpr double tighter = 4.0, close_enough = 1e-3;
constexpr int most_tightenings = 40, most_halvings = 40;

double shareWithin(const Eigen::VectorXd& step, const Eigen::VectorXd& lengths) {
  double share = 1.0;
  for (long k = 0; k < step.size(); ++k)
    if (std::fabs(step[k]) > lengths[k]) share = std::min(share, lengths[k] / std::fabs(step[k]));
  return share;
}

}  // namespace

Eigen::VectorXd trustedStep(const Eigen::MatrixXd& h, const Eigen::VectorXd& g, const Eigen::VectorXd& lengths) {
  const auto stepAt = [&](double weight) {
    Eigen::MatrixXd held = h;
    held.diagonal().array() += weight * lengths.array().square().inverse();
    return Eigen::VectorXd(Ldlt(held).solve(g));
  };
  Eigen::VectorXd step = Ldlt(h).solve(g);
  if (!step.allFinite() || shareWithin(step, lengths) == 1.0) return step;
  double loose = 0.0, tight = std::fabs(step.dot(g)) * shareWithin(step, lengths);
  for (int n = 0; n < most_tightenings; ++n) {
    const Eigen::VectorXd next = stepAt(tight);
    if (!next.allFinite() || shareWithin(next, lengths) == 1.0) break;
    step = next;
    loose = tight;
    tight *= tighter;
  }
  for (int n = 0; n < most_halvings && shareWithin(step, lengths) < 1.0 - close_enough; ++n) {
    const double middle = loose > 0.0 ? std::sqrt(loose * tight) : 0.5 * tight;
    const Eigen::VectorXd next = stepAt(middle);
    const bool beyond = next.allFinite() && shareWithin(next, lengths) < 1.0;
    (beyond ? loose : tight) = middle;
    if (beyond) step = next;
  }
  return step * shareWithin(step, lengths);
}

}  // namespace amb_rotor
