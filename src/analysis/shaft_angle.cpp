// The shaft angle between tacho pulses (declared in tacho.hpp).
#include <algorithm>
#include <cmath>

#include "amb_rotor/analysis/tacho.hpp"
#include "amb_rotor/common/linear_algebra.hpp"

namespace amb_rotor {
namespace {

/// Second derivatives at the knots of the not-a-knot cubic spline, four knots or more.
/// Interior knots: h_(i-1) M_(i-1) + 2 (h_(i-1) + h_i) M_i + h_i M_(i+1) = 6 (d_i - d_(i-1)), d the slopes of
/// the chords. Ends: the third derivative does not jump at the second and the last but one knot; this
/// eliminates M_0 and M_(n-1) and leaves a tridiagonal system.
std::vector<double> knotCurvature(const std::vector<double>& t, const std::vector<double>& v) {
  const std::size_t n = t.size(), m = n - 2;
  std::vector<double> h(n - 1), d(n - 1);
  for (std::size_t i = 0; i + 1 < n; ++i) {
    h[i] = t[i + 1] - t[i];
    d[i] = (v[i + 1] - v[i]) / h[i];
  }
  std::vector<double> lower(m), diagonal(m), upper(m), right(m);
  for (std::size_t i = 0; i < m; ++i) {
    lower[i] = h[i];
    diagonal[i] = 2.0 * (h[i] + h[i + 1]);
    upper[i] = h[i + 1];
    right[i] = 6.0 * (d[i + 1] - d[i]);
  }
  const double first = h[0] / h[1], last = h[n - 2] / h[n - 3];
  diagonal[0] += h[0] * (1.0 + first);
  upper[0] -= h[0] * first;
  diagonal[m - 1] += h[n - 2] * (1.0 + last);
  lower[m - 1] -= h[n - 2] * last;
  for (std::size_t i = 1; i < m; ++i) {
    const double factor = lower[i] / diagonal[i - 1];
    diagonal[i] -= factor * upper[i - 1];
    right[i] -= factor * right[i - 1];
  }
  std::vector<double> curvature(n);
  for (std::size_t i = m; i-- > 0;) {
    const double next = i + 1 < m ? upper[i] * curvature[i + 2] : 0.0;
    curvature[i + 1] = (right[i] - next) / diagonal[i];
  }
  curvature[0] = (1.0 + first) * curvature[1] - first * curvature[2];
  curvature[n - 1] = (1.0 + last) * curvature[n - 2] - last * curvature[n - 3];
  return curvature;
}

/// A cubic spline of equal pieces over 0 .. 1: 1, s, s^2, s^3 and (s - k/pieces)^3 beyond each knot; 0 pieces: a parabola.
Eigen::RowVectorXd smoothBasis(double s, int pieces) {
  Eigen::RowVectorXd row(pieces == 0 ? 3 : 3 + pieces);
  row.head(3) << 1.0, s, s * s;
  for (int k = 0; k < pieces; ++k) row[3 + k] = std::pow(std::max(0.0, s - static_cast<double>(k) / pieces), 3);
  return row;
}

constexpr int most_pieces = 32;
/// Rms of edges about the path over that of times rounded to samples, the largest over half a sample, and edges for each unknown: what
/// a path must keep to.
constexpr double rounded_rms = 1.15, farthest = 1.5;
constexpr long edges_each = 3;

}  // namespace

ShaftAngle::ShaftAngle(const SpeedFit& fit) {
  if (!fit.valid) return;
  time_ = {fit.reference_time, fit.reference_time};
  angle_ = {0.0};
  slope_ = {fit.speed};
  half_curvature_ = {0.5 * fit.acceleration};
  third_ = {0.0};
}

/// False: nothing smooth keeps to the edges.
bool ShaftAngle::smooth(const TachoPulses& pulses, const std::vector<double>& angle) {
  const std::vector<double>& t = pulses.time;
  const long n = static_cast<long>(t.size());
  const double length = t.back() - t.front();
  for (int pieces = 0; pieces <= most_pieces; pieces = std::max(1, 2 * pieces)) {
    const long unknowns = smoothBasis(0.0, pieces).size();
    if (n < edges_each * unknowns) return false;
    Eigen::MatrixXd design(n, unknowns);
    Eigen::VectorXd right(n);
    for (long i = 0; i < n; ++i) {  // over the speed: equations of times
      const long before = std::max(0L, i - 1), after = std::min(n - 1, i + 1);
      const double speed = (angle[after] - angle[before]) / (t[after] - t[before]);
      design.row(i) = smoothBasis((t[i] - t.front()) / length, pieces) / speed;
      right[i] = angle[i] / speed;
    }
    const Eigen::VectorXd c = leastSquares(design, right);
    const Eigen::VectorXd off = right - design * c;
    const double rms = std::sqrt(off.squaredNorm() / static_cast<double>(n - unknowns));
    if (rms > rounded_rms * pulses.half_width_s / std::sqrt(3.0) || off.cwiseAbs().maxCoeff() > farthest * pulses.half_width_s) continue;
    const double piece = length / std::max(1, pieces);
    double value = c[0], slope = c[1] / length, half_curvature = c[2] / (length * length), third = 0.0;
    for (int k = 0; k < std::max(1, pieces); ++k) {
      if (pieces > 0) third += c[3 + k] / std::pow(length, 3);
      time_.push_back(t.front() + k * piece);
      angle_.push_back(value);
      slope_.push_back(slope);
      half_curvature_.push_back(half_curvature);
      third_.push_back(third);
      value += piece * (slope + piece * (half_curvature + piece * third));
      slope += piece * (2.0 * half_curvature + 3.0 * piece * third);
      half_curvature += 3.0 * piece * third;
    }
    angle_.push_back(value);  // beyond the last pulse: constant acceleration
    slope_.push_back(slope);
    half_curvature_.push_back(half_curvature);
    third_.push_back(0.0);
    time_.push_back(t.back());
    time_.push_back(t.back());
    return true;
  }
  return false;
}

ShaftAngle::ShaftAngle(const TachoPulses& pulses) {
  const std::size_t n = pulses.time.size();
  if (pulses.state != TachoState::turning || n < 2) return;
  std::vector<double> value(n);
  for (std::size_t i = 0; i < n; ++i) {
    value[i] = 2.0 * M_PI * static_cast<double>(pulses.turn[i] - pulses.turn.front());
  }
  if (pulses.half_width_s > 0.0 && smooth(pulses, value)) return;
  const std::vector<double>& t = pulses.time;
  std::vector<double> curvature(n, 0.0);
  if (n == 3) {
    const double first = (value[1] - value[0]) / (t[1] - t[0]),
                 second = (value[2] - value[1]) / (t[2] - t[1]);
    std::fill(curvature.begin(), curvature.end(), 2.0 * (second - first) / (t[2] - t[0]));
  } else if (n > 3) {
    curvature = knotCurvature(t, value);
  }
  time_ = t;
  for (std::size_t i = 0; i + 1 < n; ++i) {
    const double h = t[i + 1] - t[i];
    angle_.push_back(value[i]);
    slope_.push_back((value[i + 1] - value[i]) / h - h * (2.0 * curvature[i] + curvature[i + 1]) / 6.0);
    half_curvature_.push_back(0.5 * curvature[i]);
    third_.push_back((curvature[i + 1] - curvature[i]) / (6.0 * h));
  }
  // One piece more, with constant acceleration, continues after the last pulse.
  const std::size_t last = n - 2;
  const double h = t[n - 1] - t[n - 2];
  angle_.push_back(value[n - 1]);
  slope_.push_back(slope_[last] + h * (2.0 * half_curvature_[last] + 3.0 * third_[last] * h));
  half_curvature_.push_back(0.5 * curvature[n - 1]);
  third_.push_back(0.0);
  time_.push_back(t[n - 1]);
}

ShaftAngle::Place ShaftAngle::place(double time) const {
  const auto end = time_.begin() + static_cast<std::ptrdiff_t>(angle_.size());
  const auto after = std::upper_bound(time_.begin(), end, time);
  const std::size_t piece = after == time_.begin() ? 0 : static_cast<std::size_t>(after - time_.begin()) - 1;
  return {piece, time - time_[piece]};
}

double ShaftAngle::angle(double time) const {
  if (!angleKnown()) return 0.0;
  const auto [i, s] = place(time);
  const double cubic = s >= 0.0 ? third_[i] : 0.0;  // before the first pulse: constant acceleration
  return angle_[i] + s * (slope_[i] + s * (half_curvature_[i] + s * cubic));
}

double ShaftAngle::speed(double time) const {
  if (!angleKnown()) return 0.0;
  const auto [i, s] = place(time);
  const double cubic = s >= 0.0 ? third_[i] : 0.0;
  return slope_[i] + s * (2.0 * half_curvature_[i] + 3.0 * s * cubic);
}

double ShaftAngle::acceleration(double time) const {
  if (!angleKnown()) return 0.0;
  const auto [i, s] = place(time);
  const double cubic = s >= 0.0 ? third_[i] : 0.0;
  return 2.0 * half_curvature_[i] + 6.0 * s * cubic;
}

std::vector<double> ShaftAngle::angles(const std::vector<double>& time) const {
  std::vector<double> result;
  result.reserve(time.size());
  for (double t : time) result.push_back(angle(t));
  return result;
}

std::vector<double> ShaftAngle::speeds(const std::vector<double>& time) const {
  std::vector<double> result;
  result.reserve(time.size());
  for (double t : time) result.push_back(speed(t));
  return result;
}

}  // namespace amb_rotor
