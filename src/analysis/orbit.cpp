#include "amb_rotor/analysis/orbit.hpp"

#include <algorithm>
#include <cmath>

#include "argument.hpp"

namespace amb_rotor {

std::string toString(WhirlDirection direction) {
  switch (direction) {
    case WhirlDirection::forward:
      return "forward";
    case WhirlDirection::backward:
      return "backward";
    case WhirlDirection::planar:
      return "planar";
    case WhirlDirection::none:
      break;
  }
  return "none";
}

OrbitEllipse orbitEllipse(std::complex<double> forward, std::complex<double> backward, double planar_ratio) {
  const double f = std::abs(forward), b = std::abs(backward);
  OrbitEllipse ellipse;
  ellipse.semi_major = f + b;
  ellipse.semi_minor = f - b;
  if (ellipse.semi_major == 0.0) return ellipse;
  // A circle has no major axis: its inclination is 0 and the phase is where it crosses that axis.
  const bool circle = std::min(f, b) <= 1e-14 * ellipse.semi_major;
  const double arg_f = std::arg(forward), arg_b = std::arg(backward);
  double inclination = circle ? 0.0 : 0.5 * (arg_f + arg_b);
  double phase = circle ? (f > b ? -arg_f : arg_b) : 0.5 * (arg_b - arg_f);
  if (inclination > M_PI_2) {
    inclination -= M_PI;
    phase += M_PI;
  } else if (inclination <= -M_PI_2) {
    inclination += M_PI;
    phase += M_PI;
  }
  ellipse.inclination = inclination;
  ellipse.major_phase = phase > M_PI ? phase - 2.0 * M_PI : phase;
  ellipse.direction = std::fabs(ellipse.semi_minor) <= planar_ratio * ellipse.semi_major
                          ? WhirlDirection::planar
                          : (f > b ? WhirlDirection::forward : WhirlDirection::backward);
  return ellipse;
}

OrbitAccumulator::OrbitAccumulator(double clearance, double center_x, double center_y)
    : clearance_(clearance), center_x_(center_x), center_y_(center_y) {
  requireArgument(clearance > 0.0 && std::isfinite(clearance), "clearance", clearance, "must be above 0 [m]");
}

void OrbitAccumulator::add(double x, double y, double weight) {
  if (!std::isfinite(x) || !std::isfinite(y)) {
    ++non_finite_;
    return;
  }
  const double radius = std::hypot(x - center_x_, y - center_y_);
  if (samples_ == 0) {
    min_radius_ = max_radius_ = radius;
    low_x_ = high_x_ = x;
    low_y_ = high_y_ = y;
  }
  ++samples_;
  min_radius_ = std::min(min_radius_, radius);
  max_radius_ = std::max(max_radius_, radius);
  low_x_ = std::min(low_x_, x);
  high_x_ = std::max(high_x_, x);
  low_y_ = std::min(low_y_, y);
  high_y_ = std::max(high_y_, y);
  if (!(weight > 0.0)) return;
  // Weighted running mean and sum of squares (West 1979): no cancellation far from the origin.
  weight_ += weight;
  const double share = weight / weight_;
  const double dx = x - mean_x_, dy = y - mean_y_;
  mean_x_ += share * dx;
  mean_y_ += share * dy;
  square_sum_ += weight * (dx * (x - mean_x_) + dy * (y - mean_y_));
  mean_radius_ += share * (radius - mean_radius_);
}

OrbitStatistics OrbitAccumulator::statistics() const {
  OrbitStatistics s;
  s.samples = samples_;
  s.non_finite = non_finite_;
  s.mean_x = mean_x_;
  s.mean_y = mean_y_;
  s.rms_about_mean = weight_ > 0.0 ? std::sqrt(std::max(0.0, square_sum_ / weight_)) : 0.0;
  s.mean_radius = mean_radius_;
  s.max_radius = max_radius_;
  s.min_radius = min_radius_;
  s.peak_to_peak_x = high_x_ - low_x_;
  s.peak_to_peak_y = high_y_ - low_y_;
  s.max_radius_over_clearance = max_radius_ / clearance_;
  s.mean_radius_over_clearance = mean_radius_ / clearance_;
  return s;
}

void OrbitAccumulator::reset() { *this = OrbitAccumulator(clearance_, center_x_, center_y_); }

OrbitStatistics orbitStatistics(const std::vector<double>& x, const std::vector<double>& y, double clearance,
                                double center_x, double center_y) {
  requireSameLength(x, y, "y");
  OrbitAccumulator accumulator(clearance, center_x, center_y);
  for (std::size_t i = 0; i < x.size(); ++i) accumulator.add(x[i], y[i]);
  return accumulator.statistics();
}

Orbit orbitInClearance(const std::vector<double>& x, const std::vector<double>& y, double clearance,
                       double center_x, double center_y) {
  requireSameLength(x, y, "y");
  requireArgument(clearance > 0.0 && std::isfinite(clearance), "clearance", clearance, "must be above 0 [m]");
  Orbit orbit;
  orbit.x.reserve(x.size());
  orbit.y.reserve(y.size());
  for (std::size_t i = 0; i < x.size(); ++i) {
    orbit.x.push_back((x[i] - center_x) / clearance);
    orbit.y.push_back((y[i] - center_y) / clearance);
  }
  return orbit;
}

}  // namespace amb_rotor
