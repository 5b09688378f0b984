#include "amb_rotor/analysis/whirl.hpp"

#include <algorithm>
#include <cmath>

#include "argument.hpp"

namespace amb_rotor {

WhirlAccumulator::WhirlAccumulator(double center_x, double center_y, double least_radius)
    : center_x_(center_x), center_y_(center_y), least_radius_(least_radius) {
  requireArgument(least_radius >= 0.0, "least_radius", least_radius, "must be at least 0 [m]");
}

void WhirlAccumulator::add(double time, double x, double y) {
  const double dx = x - center_x_, dy = y - center_y_;
  const double radius = std::hypot(dx, dy);
  if (!std::isfinite(time) || !std::isfinite(radius) || radius < least_radius_ || radius == 0.0) return;
  const double angle = std::atan2(dy, dx);
  if (samples_ == 0) {
    first_time_ = time;
  } else {
    const double step = std::remainder(angle - last_angle_, 2.0 * M_PI);
    if (std::fabs(step) > 0.75 * M_PI) resolved_ = false;
    path_ += step;
    total_path_ += std::fabs(step);
    if (step > 0.0) forward_path_ += step;
  }
  last_angle_ = angle;
  ++samples_;
  radius_sum_ += radius;
  // Running co-moments of time and path for the straight line.
  const double t = time - first_time_, n = static_cast<double>(samples_);
  const double dt = t - mean_time_;
  mean_time_ += dt / n;
  mean_path_ += (path_ - mean_path_) / n;
  time_square_ += dt * (t - mean_time_);
  time_path_ += dt * (path_ - mean_path_);
}

WhirlState WhirlAccumulator::state() const {
  WhirlState state;
  state.samples = samples_;
  state.resolved = resolved_ && samples_ > 1;
  state.revolutions = path_ / (2.0 * M_PI);
  if (samples_ > 0) state.mean_radius = radius_sum_ / static_cast<double>(samples_);
  if (time_square_ > 0.0) state.frequency = time_path_ / time_square_;
  if (total_path_ > 0.0) state.forward_share = forward_path_ / total_path_;
  // Less than a whole turn, or as much back as forth: no whirl about this centre.
  const bool turns = std::fabs(state.revolutions) >= 1.0 && std::fabs(path_) > 0.05 * total_path_;
  if (turns) {
    state.direction = path_ > 0.0 ? WhirlDirection::forward : WhirlDirection::backward;
  } else if (total_path_ > 2.0 * M_PI) {
    state.direction = WhirlDirection::planar;
  }
  return state;
}

void WhirlAccumulator::reset() { *this = WhirlAccumulator(center_x_, center_y_, least_radius_); }

WhirlState whirlFromOrbit(const std::vector<double>& time, const std::vector<double>& x,
                          const std::vector<double>& y, double center_x, double center_y,
                          double least_radius) {
  requireSameLength(time, x, "x");
  requireSameLength(time, y, "y");
  WhirlAccumulator accumulator(center_x, center_y, least_radius);
  for (std::size_t i = 0; i < time.size(); ++i) accumulator.add(time[i], x[i], y[i]);
  return accumulator.state();
}

SpectralWhirl whirlFromSpectrum(const Spectrum& full_spectrum, double planar_ratio) {
  SpectralWhirl whirl;
  for (std::size_t i = 0; i < full_spectrum.frequency.size(); ++i) {
    const double energy = full_spectrum.amplitude[i] * full_spectrum.amplitude[i];
    if (full_spectrum.frequency[i] > 0.0) whirl.forward_energy += energy;
    if (full_spectrum.frequency[i] < 0.0) whirl.backward_energy += energy;
  }
  whirl.forward_energy /= full_spectrum.noise_bandwidth;
  whirl.backward_energy /= full_spectrum.noise_bandwidth;
  const double sum = whirl.forward_energy + whirl.backward_energy;
  const double difference = whirl.forward_energy - whirl.backward_energy;
  if (!(sum > 0.0)) return whirl;
  const std::vector<SpectralPeak> peaks = spectralPeaks(full_spectrum, 1);
  if (!peaks.empty()) {
    whirl.frequency = 2.0 * M_PI * peaks.front().frequency;
    whirl.amplitude = peaks.front().amplitude;
  }
  whirl.direction = std::fabs(difference) <= planar_ratio * sum
                        ? WhirlDirection::planar
                        : (difference > 0.0 ? WhirlDirection::forward : WhirlDirection::backward);
  return whirl;
}

std::string toString(SlipKind kind) {
  switch (kind) {
    case SlipKind::slipping:
      return "slipping";
    case SlipKind::rolling:
      return "rolling";
    case SlipKind::undefined:
      break;
  }
  return "undefined";
}

SlipState slipState(double spin, double whirl, double rotor_radius, double orbit_radius, double tolerance) {
  requireArgument(rotor_radius > 0.0, "rotor_radius", rotor_radius, "must be above 0 [m]");
  requireArgument(orbit_radius > 0.0, "orbit_radius", orbit_radius, "must be above 0 [m]");
  requireArgument(tolerance >= 0.0, "tolerance", tolerance, "must be at least 0");
  SlipState state;
  state.rolling_whirl = -rotor_radius * spin / orbit_radius;
  state.slip_speed = rotor_radius * spin + orbit_radius * whirl;
  if (spin == 0.0) return state;
  state.kind = std::fabs(state.slip_speed) <= tolerance * std::fabs(rotor_radius * spin) ? SlipKind::rolling
                                                                                         : SlipKind::slipping;
  return state;
}

}  // namespace amb_rotor
