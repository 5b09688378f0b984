#include "window_ease.hpp"

#include <algorithm>

namespace amb_rotor {
namespace {

/// It grows by so much a step, to so much at most.
constexpr double growth_of_ease = 4.0, most_ease = 100.0;
/// Below this a step is as long as it should be.
constexpr double least_ease = 1.5;
/// Mean square over the noise that the windows must leave: right models leave 0.5 to 0.93, and there what the gradient loses is that of
/// the hollows. At 1.18 a fit to ten runs still crept, by steps of a tenth of a scale for 15 iterations, and ended at the 15th.
constexpr double far_from_noise = 1.0;

}  // namespace

bool WindowEase::isWanted(double mean_square) const { return ease_ > 1.0 && mean_square > far_from_noise; }

void WindowEase::learn(const Eigen::MatrixXd& h, const Eigen::VectorXd& g, const Eigen::VectorXd& after, const Eigen::VectorXd& step) {
  const double foretold = step.dot(h * step), lost = step.dot(g - after);
  const double most = std::min(growth_of_ease * ease_, most_ease);
  ease_ = foretold > 0.0 && lost > 0.0 ? std::min(foretold / lost, most) : most;
  if (!(ease_ > least_ease)) ease_ = 1.0;
}

void WindowEase::shorten() {
  ease_ /= growth_of_ease;
  if (!(ease_ > least_ease)) ease_ = 1.0;
}

void WindowEase::relieve(const Eigen::MatrixXd& windows_h, const std::vector<bool>& held, Eigen::MatrixXd& h) const {
  const double share = 1.0 - 1.0 / ease_;
  for (Eigen::Index i = 0; i < h.rows(); ++i)
    for (Eigen::Index j = 0; j < h.cols(); ++j)
      if (held.empty() || (!held[i] && !held[j])) h(i, j) -= share * windows_h(i, j);
}

}  // namespace amb_rotor
