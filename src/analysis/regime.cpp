#include "amb_rotor/analysis/regime.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "amb_rotor/analysis/determinism.hpp"
#include "amb_rotor/analysis/lyapunov.hpp"
#include "argument.hpp"

namespace amb_rotor {
namespace {

constexpr Eigen::Index least_points = 6;  // two of period 3: below, nothing repeats convincingly
constexpr Eigen::Index least_chaos_points =
    120;  // with 100 the 0-1 test still calls a third of quasi-periodic series chaotic

/// rms distance of points `lag` turns apart.
double repeatError(const Eigen::MatrixXd& points, Eigen::Index lag) {
  const Eigen::Index n = points.cols() - lag;
  return std::sqrt((points.rightCols(n) - points.leftCols(n)).squaredNorm() / static_cast<double>(n));
}

Eigen::MatrixXd statesOf(const RegimeInput& input) {
  Eigen::MatrixXd states(2, static_cast<Eigen::Index>(input.points.size()));
  for (std::size_t i = 0; i < input.points.size(); ++i) {
    states.col(static_cast<Eigen::Index>(i)) << input.points[i].x, input.points[i].y;
  }
  return states / input.clearance;
}

/// Points less the mean of their class k mod n.
Eigen::MatrixXd aboutClassMeans(const Eigen::MatrixXd& points, int n) {
  Eigen::MatrixXd means = Eigen::MatrixXd::Zero(points.rows(), n);
  Eigen::VectorXd counts = Eigen::VectorXd::Zero(n);
  for (Eigen::Index k = 0; k < points.cols(); ++k) {
    means.col(k % n) += points.col(k);
    counts(k % n) += 1.0;
  }
  Eigen::MatrixXd rest = points;
  for (Eigen::Index k = 0; k < points.cols(); ++k) rest.col(k) -= means.col(k % n) / counts(k % n);
  return rest;
}

/// Smallest n whose class means explain the points nearly as well as any.
int noisyPeriod(const Eigen::MatrixXd& points, int max_period) {
  std::vector<double> variance;
  for (int n = 1; n <= max_period && 3 * n <= points.cols(); ++n) {
    // Per degree of freedom: n means take n of them.
    variance.push_back(aboutClassMeans(points, n).squaredNorm() / static_cast<double>(points.cols() - n));
  }
  const double least = *std::min_element(variance.begin(), variance.end());
  for (std::size_t i = 0; i < variance.size(); ++i) {
    if (variance[i] <= 1.5 * least) return static_cast<int>(i) + 1;
  }
  return 1;
}

void decideIrregular(const RegimeInput& input, const Eigen::MatrixXd& points, const RegimeOptions& options,
                     RegimeResult& result) {
  const Eigen::VectorXd mean = points.rowwise().mean();
  const auto quasiPeriodic = [&] {
    result.regime = Regime::quasi_periodic;
    std::vector<double> x, y;
    for (Eigen::Index k = 0; k < points.cols(); ++k) {
      x.push_back(points(0, k));
      y.push_back(points(1, k));
    }
    result.winding_number = windingNumber(x, y, mean(0), mean(1));
    result.reason = "the points do not repeat and stay on closed curves";
  };
  if (input.largest_lyapunov &&
      exponentIsChaotic(*input.largest_lyapunov, static_cast<double>(points.cols()), options.rules)) {
    result.regime = Regime::chaotic;
    result.certain = true;
    result.reason = "largest Lyapunov exponent " + std::to_string(*input.largest_lyapunov) + " per turn";
    return;
  }
  if (points.cols() < least_chaos_points) {
    if (input.largest_lyapunov) {
      quasiPeriodic();
      result.certain = true;
    } else {
      result.reason = "the points do not repeat, and are too few to tell more";
    }
    return;
  }
  const int classes = noisyPeriod(points, options.max_period);
  const Eigen::MatrixXd rest = aboutClassMeans(points, classes);
  result.forecast_ratio = forecastRatio(rest, 2);
  if (result.forecast_ratio > options.forecast_limit) {
    result.regime = Regime::period;
    result.period = classes;
    result.scatter = std::sqrt(rest.squaredNorm() / static_cast<double>(rest.cols()));
    result.reason =
        "unpredictable scatter about " + std::to_string(classes) + " point(s): noise above the tolerance";
    return;
  }
  if (input.largest_lyapunov) {
    quasiPeriodic();
    result.certain = true;
    return;
  }
  const Eigen::MatrixXd centred = points.colwise() - mean;
  const Eigen::Index axis = centred.row(0).squaredNorm() >= centred.row(1).squaredNorm() ? 0 : 1;
  std::vector<double> series(static_cast<std::size_t>(points.cols()));
  for (Eigen::Index k = 0; k < points.cols(); ++k) series[static_cast<std::size_t>(k)] = points(axis, k);
  result.chaos_number = zeroOneTest(series);
  result.certain = std::fabs(result.chaos_number - options.chaos_number) > 0.2;
  if (result.chaos_number > options.chaos_number) {
    result.regime = Regime::chaotic;
    result.reason = "0-1 test " + std::to_string(result.chaos_number) + ", forecast ratio " +
                    std::to_string(result.forecast_ratio);
  } else {
    quasiPeriodic();
  }
}

}  // namespace

PeriodDetection detectPeriod(const Eigen::MatrixXd& points, double tolerance, int max_period) {
  requireArgument(tolerance > 0.0 && std::isfinite(tolerance), "tolerance", tolerance, "must be above 0");
  requireArgument(max_period >= 1, "max_period", max_period, "must be at least 1");
  PeriodDetection result;
  result.repeat_error = std::numeric_limits<double>::infinity();
  const Eigen::Index count = points.cols();
  std::vector<double> error;
  for (Eigen::Index n = 1; n <= max_period && 3 * n <= count; ++n) error.push_back(repeatError(points, n));
  if (count < least_points || error.empty()) return result;
  result.repeat_error = *std::min_element(error.begin(), error.end());
  const double limit = std::min(tolerance, std::max(0.2 * tolerance, 2.0 * result.repeat_error));
  for (std::size_t i = 0; i < error.size(); ++i) {
    if (!(error[i] <= limit)) continue;
    const auto n = static_cast<Eigen::Index>(i) + 1;
    const Eigen::Index most = count / (2 * n);  // repetitions in half the record
    bool stays = true;
    for (Eigen::Index m : {most, (2 * most) / 3, most / 2}) {
      stays = stays && (m < 1 || repeatError(points, n * m) <= tolerance);
    }
    if (!stays) continue;
    result.period = static_cast<int>(n);
    result.repeat_error = error[i];
    return result;
  }
  return result;
}

RegimeResult decideRegime(const RegimeInput& input, double tolerance, const RegimeOptions& options) {
  requireArgument(input.clearance > 0.0, "clearance", input.clearance, "must be above 0 [m]");
  RegimeResult result;
  const Eigen::MatrixXd points = statesOf(input);
  const ContactStatistics& contact = input.contact;
  const WhirlState& whirl = input.whirl;
  MotionFacts facts;
  facts.finite = points.allFinite() && std::isfinite(input.max_radius);
  facts.max_radius = input.max_radius / input.clearance;
  facts.touched = contact.contact_fraction > 0.0 || contact.impacts > 0;
  facts.contact_fraction = contact.contact_fraction;
  if (whirl.resolved) {
    facts.backward =
        whirl.direction == WhirlDirection::backward && whirl.forward_share <= options.dry_whirl_forward;
    if (whirl.direction == WhirlDirection::forward && input.spin != 0.0)
      facts.whirl_ratio = whirl.frequency / input.spin;
  }
  if (facts.finite) {
    const PeriodDetection repeated = detectPeriod(points, tolerance, options.max_period);
    facts.period = result.period = repeated.period;
    result.repeat_error = repeated.repeat_error;
  }
  result.regime = regimeByRules(facts, options.rules);
  result.certain = result.regime != Regime::undecided;
  switch (result.regime) {
    case Regime::diverged:
      result.period = 0;
      result.reason = "the motion left " + std::to_string(options.rules.diverged_ratio) + " clearances";
      return result;
    case Regime::no_contact:
      result.reason = "no time in contact";
      return result;
    case Regime::dry_whirl:
      if (input.rotor_radius > 0.0) {
        result.slip = slipState(input.spin, whirl.frequency, input.rotor_radius, whirl.mean_radius,
                                options.rolling_tolerance)
                          .kind;
      }
      result.reason = "in contact and backward round the bearing's centre, " + toString(result.slip);
      return result;
    case Regime::full_annular_rub:
      result.reason = "in contact all the time, once round forward with each turn";
      return result;
    case Regime::period:
      result.reason = "repeats after " + std::to_string(result.period) + " turn(s)";
      return result;
    default:
      break;
  }
  if (points.cols() < least_points) {
    result.reason = "too few points";
    return result;
  }
  decideIrregular(input, points, options, result);
  return result;
}

}  // namespace amb_rotor
