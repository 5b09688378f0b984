#include "amb_rotor/analysis/lyapunov.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "argument.hpp"

namespace amb_rotor {

void LyapunovAccumulator::add(Eigen::MatrixXd& tangent, double interval) {
  requireArgument(interval > 0.0 && std::isfinite(interval), "interval", interval, "must be above 0");
  const Eigen::Index n = tangent.cols();
  if (sums_.size() == 0) sums_ = Eigen::VectorXd::Zero(n);
  AMB_ROTOR_CHECK(sums_.size() == n, "the number of tangent vectors changed");
  if (!tangent.allFinite()) {
    valid_ = false;
    return;
  }
  // Modified Gram-Schmidt, twice for orthogonality to round-off; the growth is that of the first pass.
  Eigen::VectorXd norms(n);
  for (int pass = 0; pass < 2; ++pass) {
    for (Eigen::Index k = 0; k < n; ++k) {
      for (Eigen::Index j = 0; j < k; ++j)
        tangent.col(k) -= tangent.col(j).dot(tangent.col(k)) * tangent.col(j);
      const double norm = tangent.col(k).norm();
      if (!(norm > 0.0)) {
        valid_ = false;
        return;
      }
      tangent.col(k) /= norm;
      norms(k) = pass == 0 ? norm : norms(k) * norm;
    }
  }
  sums_ += norms.array().log().matrix();
  total_ += interval;
  growth_.push_back(std::log(norms(0)));
  lengths_.push_back(interval);
}

Eigen::VectorXd LyapunovAccumulator::exponents() const {
  return total_ > 0.0 ? Eigen::VectorXd(sums_ / total_) : Eigen::VectorXd::Zero(sums_.size());
}

double LyapunovAccumulator::largestStandardError() const {
  constexpr std::size_t blocks = 10;
  if (growth_.size() < 2 * blocks) return 0.0;
  const double mean = sums_(0) / total_;
  double squares = 0.0;
  const std::size_t length = growth_.size() / blocks;
  for (std::size_t b = 0; b < blocks; ++b) {
    double growth = 0.0, duration = 0.0;
    for (std::size_t i = b * length; i < (b + 1) * length; ++i) {
      growth += growth_[i];
      duration += lengths_[i];
    }
    squares += (growth / duration - mean) * (growth / duration - mean);
  }
  return std::sqrt(squares / (blocks * (blocks - 1.0)));
}

LyapunovResult lyapunovBenettin(const TangentFlow& flow, Eigen::VectorXd state, std::size_t count,
                                double interval, std::size_t intervals, std::size_t transient) {
  const auto n = static_cast<std::size_t>(state.size());
  requireArgument(count >= 1 && count <= n, "count", static_cast<double>(count),
                  "must be from 1 to the size of the state");
  requireArgument(intervals >= 1, "intervals", static_cast<double>(intervals), "must be at least 1");
  requireArgument(interval > 0.0 && std::isfinite(interval), "interval", interval, "must be above 0");
  LyapunovResult result;
  Eigen::MatrixXd tangent =
      Eigen::MatrixXd::Identity(static_cast<Eigen::Index>(n), static_cast<Eigen::Index>(count));
  LyapunovAccumulator settle, accumulator;
  for (std::size_t i = 0; i < transient + intervals; ++i) {
    if (!flow(state, tangent) || !state.allFinite()) {
      result.reason = "the flow ended after " + std::to_string(i) + " intervals";
      return result;
    }
    (i < transient ? settle : accumulator).add(tangent, interval);
    if (!tangent.allFinite() || (i >= transient && !accumulator.valid())) {
      result.reason = "a tangent vector vanished or grew beyond all bounds";
      return result;
    }
  }
  result.valid = true;
  result.exponents = accumulator.exponents();
  result.standard_error = accumulator.largestStandardError();
  return result;
}

SaltationMatrix saltationMatrix(const HybridEvent& event, double grazing_tolerance) {
  const Eigen::Index n = event.field_before.size();
  const bool reset = event.reset_jacobian.size() > 0;
  requireArgument(event.field_after.size() == n && event.normal.size() == n, "event",
                  static_cast<double>(event.normal.size()), "must have fields and normal of one size");
  requireArgument(!reset || (event.reset_jacobian.rows() == n && event.reset_jacobian.cols() == n),
                  "reset_jacobian", static_cast<double>(event.reset_jacobian.rows()),
                  "must be square of the state's size");
  requireArgument(event.reset_rate.size() == 0 || event.reset_rate.size() == n, "reset_rate",
                  static_cast<double>(event.reset_rate.size()), "must have the state's size");
  SaltationMatrix result;
  result.approach_rate = event.normal.dot(event.field_before) + event.guard_rate;
  const double scale = event.normal.norm() * event.field_before.norm();
  result.grazing = !(std::fabs(result.approach_rate) > grazing_tolerance * scale);
  if (result.grazing) return result;
  const Eigen::MatrixXd g = reset ? event.reset_jacobian : Eigen::MatrixXd::Identity(n, n);
  Eigen::VectorXd jump = event.field_after - g * event.field_before;
  if (event.reset_rate.size() > 0) jump -= event.reset_rate;
  result.matrix = g + jump * event.normal.transpose() / result.approach_rate;
  return result;
}

SeriesLyapunov lyapunovFromSeries(const Eigen::MatrixXd& points, const SeriesLyapunovOptions& options) {
  requireArgument(options.horizon >= 4, "horizon", static_cast<double>(options.horizon),
                  "must be at least 4");
  requireArgument(options.theiler_window >= 1, "theiler_window", static_cast<double>(options.theiler_window),
                  "must be at least 1");
  SeriesLyapunov result;
  const auto n = static_cast<std::size_t>(points.cols());
  if (n < 3 * options.horizon || !points.allFinite()) {
    result.reason = "fewer points than three horizons, or not finite";
    return result;
  }
  std::vector<double> sums(options.horizon + 1, 0.0);
  std::vector<std::size_t> counts(options.horizon + 1, 0);
  const auto column = [&points](std::size_t i) { return points.col(static_cast<Eigen::Index>(i)); };
  const std::size_t usable = n - options.horizon;
  for (std::size_t i = 0; i < usable; ++i) {
    double best = std::numeric_limits<double>::infinity();
    std::size_t neighbour = n;
    for (std::size_t j = 0; j < usable; ++j) {
      const std::size_t apart = i > j ? i - j : j - i;
      if (apart < options.theiler_window || apart == 0) continue;
      const double square = (column(i) - column(j)).squaredNorm();
      if (square > 0.0 && square < best) {
        best = square;
        neighbour = j;
      }
    }
    if (neighbour == n) continue;
    for (std::size_t k = 0; k <= options.horizon; ++k) {
      const double square = (column(i + k) - column(neighbour + k)).squaredNorm();
      if (!(square > 0.0)) continue;
      sums[k] += 0.5 * std::log(square);
      ++counts[k];
    }
  }
  if (counts[0] == 0) {
    result.reason = "all points are equal";
    return result;
  }
  for (std::size_t k = 0; k <= options.horizon; ++k) {
    result.divergence.push_back(counts[k] > 0 ? sums[k] / static_cast<double>(counts[k]) : 0.0);
  }
  // Straight part: from the start to saturation_share of the rise to the plateau (mean of the last third).
  // Without a rise by at least a factor e there is no saturation, and the whole horizon counts.
  const std::vector<double>& s = result.divergence;
  const std::size_t third = options.horizon / 3;
  double plateau = 0.0;
  for (std::size_t k = options.horizon + 1 - third; k <= options.horizon; ++k) plateau += s[k] / third;
  std::size_t last = options.horizon;
  if (plateau - s[0] > 1.0) {
    const double limit = s[0] + options.saturation_share * (plateau - s[0]);
    for (last = 0; last < options.horizon && s[last + 1] <= limit;) ++last;
  }
  result.fit_steps = last;
  if (last < 2) {
    result.reason = "no straight part of the divergence: noise or too few points";
    return result;
  }
  const double count = static_cast<double>(last + 1), middle = 0.5 * static_cast<double>(last);
  double mean = 0.0, slope = 0.0, square = 0.0, residual = 0.0;
  for (std::size_t k = 0; k <= last; ++k) mean += s[k] / count;
  for (std::size_t k = 0; k <= last; ++k) {
    slope += (static_cast<double>(k) - middle) * (s[k] - mean);
    square += (static_cast<double>(k) - middle) * (static_cast<double>(k) - middle);
  }
  result.exponent = slope / square;
  for (std::size_t k = 0; k <= last; ++k) {
    const double r = s[k] - mean - result.exponent * (static_cast<double>(k) - middle);
    residual += r * r;
  }
  result.standard_error = std::sqrt(residual / (std::max(1.0, count - 2.0) * square));
  result.valid = true;
  return result;
}

Eigen::MatrixXd delayEmbedding(const std::vector<double>& series, std::size_t dimension, std::size_t lag) {
  requireArgument(dimension >= 1, "dimension", static_cast<double>(dimension), "must be at least 1");
  requireArgument(lag >= 1, "lag", static_cast<double>(lag), "must be at least 1");
  const std::size_t reach = (dimension - 1) * lag;
  const std::size_t n = series.size() > reach ? series.size() - reach : 0;
  Eigen::MatrixXd points(dimension, n);
  for (std::size_t i = 0; i < n; ++i) {
    for (std::size_t k = 0; k < dimension; ++k) {
      points(static_cast<Eigen::Index>(k), static_cast<Eigen::Index>(i)) = series[i + k * lag];
    }
  }
  return points;
}

double windingNumber(const std::vector<double>& lift) {
  // Weighted Birkhoff mean of the increments, weight exp(-1/(s (1 - s))).
  const std::size_t n = lift.size() < 2 ? 0 : lift.size() - 1;
  double sum = 0.0, weights = 0.0;
  for (std::size_t i = 0; i < n; ++i) {
    const double s = (static_cast<double>(i) + 1.0) / (static_cast<double>(n) + 1.0);
    const double weight = std::exp(-1.0 / (s * (1.0 - s)));
    sum += weight * (lift[i + 1] - lift[i]);
    weights += weight;
  }
  return weights > 0.0 ? sum / weights : 0.0;
}

double windingNumber(const std::vector<double>& x, const std::vector<double>& y, double center_x,
                     double center_y) {
  requireSameLength(x, y, "y");
  // An increment near half a turn must not flip sign from step to step: the increments are unwrapped about
  // their circular mean.
  std::vector<double> angle;
  for (std::size_t i = 0; i < x.size(); ++i) angle.push_back(std::atan2(y[i] - center_y, x[i] - center_x));
  double cosine = 0.0, sine = 0.0;
  for (std::size_t i = 1; i < angle.size(); ++i) {
    cosine += std::cos(angle[i] - angle[i - 1]);
    sine += std::sin(angle[i] - angle[i - 1]);
  }
  const double mean = std::atan2(sine, cosine);
  std::vector<double> lift(angle.empty() ? 0 : 1, 0.0);
  for (std::size_t i = 1; i < angle.size(); ++i) {
    const double step = mean + std::remainder(angle[i] - angle[i - 1] - mean, 2.0 * M_PI);
    lift.push_back(lift.back() + step / (2.0 * M_PI));
  }
  const double winding = windingNumber(lift);
  return winding - std::ceil(winding - 0.5);  // to (-1/2, 1/2]
}

}  // namespace amb_rotor
