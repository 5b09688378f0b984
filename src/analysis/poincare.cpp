#include "amb_rotor/analysis/poincare.hpp"

#include <algorithm>
#include <cmath>

#include "amb_rotor/common/units.hpp"
#include "argument.hpp"

namespace amb_rotor {
namespace {

struct ValueSlope {
  double value;
  double slope;
};

/// Polynomial through the nodes (Newton form), its value and derivative at t.
ValueSlope interpolate(const std::vector<double>& t, std::vector<double> v, double at) {
  const std::size_t n = t.size();
  for (std::size_t order = 1; order < n; ++order) {
    for (std::size_t i = n - 1; i >= order; --i) v[i] = (v[i] - v[i - 1]) / (t[i] - t[i - order]);
  }
  double value = v[n - 1], slope = 0.0;
  for (std::size_t i = n - 1; i-- > 0;) {
    slope = slope * (at - t[i]) + value;
    value = value * (at - t[i]) + v[i];
  }
  return {value, slope};
}

/// Cubic with given values and slopes at both ends.
ValueSlope hermite(double t0, double t1, double p0, double p1, double m0, double m1, double at) {
  const double h = t1 - t0, s = (at - t0) / h;
  const double d = p1 - p0;
  const double a = h * m0 - d, b = d - h * m1;
  // p = (1-s) p0 + s p1 + s (1-s) ((1-s) a + s b)
  const double inner = (1.0 - s) * a + s * b;
  const double value = (1.0 - s) * p0 + s * p1 + s * (1.0 - s) * inner;
  const double slope = (d + (1.0 - 2.0 * s) * inner + s * (1.0 - s) * (b - a)) / h;
  return {value, slope};
}

double sectionValue(const MotionSample& sample, SectionKind kind) {
  return kind == SectionKind::stroboscopic ? sample.angle : sample.surface;
}

}  // namespace

PoincareAccumulator::PoincareAccumulator(SectionOptions options) : options_(options) {
  requireArgument(std::isfinite(options.phase), "phase", options.phase, "must be finite [rad]");
}

std::vector<PoincarePoint> PoincareAccumulator::pointsBetween(std::size_t left) const {
  const MotionSample& a = window_[left];
  const MotionSample& b = window_[left + 1];
  const double va = sectionValue(a, options_.kind), vb = sectionValue(b, options_.kind);
  // Levels crossed in (a, b]: a sample exactly on the section belongs to the interval that ends there.
  std::vector<std::pair<double, long>> levels;
  if (options_.kind == SectionKind::stroboscopic) {
    const double ka = (va - options_.phase) / two_pi, kb = (vb - options_.phase) / two_pi;
    for (double k = std::floor(ka) + 1.0; k <= kb; k += 1.0) {
      levels.emplace_back(options_.phase + two_pi * k, std::lround(k));
    }
  } else {
    const bool rising = va < 0.0 && vb >= 0.0, falling = va > 0.0 && vb <= 0.0;
    if (rising && options_.direction != CrossingDirection::falling) levels.emplace_back(0.0, 1);
    if (falling && options_.direction != CrossingDirection::rising) levels.emplace_back(0.0, -1);
  }
  if (levels.empty()) return {};

  std::vector<double> t, v, x, y, angle;
  for (const MotionSample& sample : window_) {
    t.push_back(sample.time - a.time);  // relative: keeps the digits of late times
    v.push_back(sectionValue(sample, options_.kind));
    x.push_back(sample.x);
    y.push_back(sample.y);
    angle.push_back(sample.angle);
  }
  const double h = b.time - a.time;
  const bool velocities =
      std::isfinite(a.vx) && std::isfinite(a.vy) && std::isfinite(b.vx) && std::isfinite(b.vy);
  std::vector<PoincarePoint> points;
  for (const auto& [level, index] : levels) {
    // Bracketed false position with halving (Illinois): superlinear, never leaves the interval.
    double t0 = 0.0, t1 = h, f0 = va - level, f1 = vb - level, at = h;
    if (f1 != 0.0) {
      for (int i = 0; i < 60 && t1 - t0 > 1e-15 * h; ++i) {
        at = (t0 * f1 - t1 * f0) / (f1 - f0);
        if (!(at > t0 && at < t1)) at = 0.5 * (t0 + t1);
        const double f = interpolate(t, v, at).value - level;
        if (std::fabs(f) <= 1e-15 * (std::fabs(va) + std::fabs(vb))) break;
        if ((f > 0.0) == (f1 > 0.0)) {
          t1 = at;
          f1 = f;
          f0 *= 0.5;
        } else {
          t0 = at;
          f0 = f;
          f1 *= 0.5;
        }
      }
    }
    const ValueSlope px = velocities ? hermite(0.0, h, a.x, b.x, a.vx, b.vx, at) : interpolate(t, x, at);
    const ValueSlope py = velocities ? hermite(0.0, h, a.y, b.y, a.vy, b.vy, at) : interpolate(t, y, at);
    PoincarePoint point;
    point.time = a.time + at;
    point.angle = options_.kind == SectionKind::stroboscopic ? level : interpolate(t, angle, at).value;
    point.x = px.value;
    point.y = py.value;
    point.vx = px.slope;
    point.vy = py.slope;
    point.index = index;
    points.push_back(point);
  }
  return points;
}

std::vector<PoincarePoint> PoincareAccumulator::add(const MotionSample& sample) {
  const bool usable = std::isfinite(sample.time) && std::isfinite(sample.x) && std::isfinite(sample.y) &&
                      std::isfinite(sectionValue(sample, options_.kind));
  if (!usable || (!window_.empty() && sample.time < window_.back().time)) {
    ++dropped_;
    return {};
  }
  if (!window_.empty() && sample.time == window_.back().time) {
    window_.back() = sample;
    return {};
  }
  if (window_.size() == 4) window_.erase(window_.begin());
  window_.push_back(sample);
  // With three samples the first interval is complete, with four the middle one.
  if (window_.size() == 3 && !first_interval_done_) {
    first_interval_done_ = true;
    return pointsBetween(0);
  }
  if (window_.size() == 4) return pointsBetween(1);
  return {};
}

std::vector<PoincarePoint> PoincareAccumulator::finish() {
  if (window_.size() < 2) return {};
  std::vector<PoincarePoint> points = pointsBetween(window_.size() - 2);
  window_.clear();
  first_interval_done_ = false;
  return points;
}

namespace {

std::vector<PoincarePoint> sectionOf(const std::vector<double>& time, const std::vector<double>& value,
                                     const std::vector<double>& x, const std::vector<double>& y,
                                     const std::vector<double>& vx, const std::vector<double>& vy,
                                     const SectionOptions& options) {
  requireSameLength(time, value, "section value");
  requireSameLength(time, x, "x");
  requireSameLength(time, y, "y");
  if (!vx.empty()) requireSameLength(time, vx, "vx");
  if (!vy.empty()) requireSameLength(time, vy, "vy");
  PoincareAccumulator accumulator(options);
  std::vector<PoincarePoint> all;
  const auto append = [&all](const std::vector<PoincarePoint>& points) {
    all.insert(all.end(), points.begin(), points.end());
  };
  for (std::size_t i = 0; i < time.size(); ++i) {
    MotionSample sample;
    sample.time = time[i];
    sample.x = x[i];
    sample.y = y[i];
    if (!vx.empty()) sample.vx = vx[i];
    if (!vy.empty()) sample.vy = vy[i];
    (options.kind == SectionKind::stroboscopic ? sample.angle : sample.surface) = value[i];
    append(accumulator.add(sample));
  }
  append(accumulator.finish());
  return all;
}

}  // namespace

std::vector<PoincarePoint> stroboscopicSection(const std::vector<double>& time,
                                               const std::vector<double>& angle, const std::vector<double>& x,
                                               const std::vector<double>& y, const std::vector<double>& vx,
                                               const std::vector<double>& vy, double phase) {
  SectionOptions options;
  options.phase = phase;
  return sectionOf(time, angle, x, y, vx, vy, options);
}

std::vector<PoincarePoint> surfaceSection(const std::vector<double>& time, const std::vector<double>& surface,
                                          const std::vector<double>& x, const std::vector<double>& y,
                                          CrossingDirection direction, const std::vector<double>& vx,
                                          const std::vector<double>& vy) {
  SectionOptions options;
  options.kind = SectionKind::surface;
  options.direction = direction;
  return sectionOf(time, surface, x, y, vx, vy, options);
}

double radialVelocity(double x, double y, double vx, double vy, double center_x, double center_y) {
  const double dx = x - center_x, dy = y - center_y;
  const double radius = std::hypot(dx, dy);
  return radius > 0.0 ? (dx * vx + dy * vy) / radius : vx;
}

}  // namespace amb_rotor
