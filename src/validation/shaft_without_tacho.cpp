// Angle and speed of a shaft that turns without pulses, by the first harmonic of its displacements.
//
// The speed W is where sum_n h_n (x + i y)_n e^(-i W t_n) is largest over both ends, h Hann's window, near the believed one; the
// angle is the phase of that sum against the one that the belief predicts from angle 0. Both are unknowns of the run with
// a wide belief, as the angle is at standstill. Runs that may touch: their first turns at the believed speed.
// Left out: a belief whose phase is wrong is not found out by this, nor an effect that only turns the phase of all runs.
#include <algorithm>
#include <array>
#include <cmath>
#include <complex>

#include "amb_rotor/common/units.hpp"
#include "amb_rotor/validation/recording.hpp"
#include "amb_rotor/validation/stretches.hpp"

namespace amb_rotor {
namespace {

using EndSums = std::array<std::complex<double>, 2>;

constexpr double farthest_speed = 0.02;    // of the believed one
constexpr double least_harmonic = 10.0;    // over its own noise
constexpr long first_turns = 8;
constexpr double any_angle_rad = 1.8;      // standard deviation of a uniform turn
constexpr double run_away_rad = 1.0;       // over the run

/// Hann's window times the displacements, turned back with the shaft and over the noise, at both ends.
EndSums harmonicAt(const Recording& rec, const std::vector<double>& channels, long count, double speed) {
  EndSums sums{};
  for (long i = 0; i < count; ++i) {
    const double share = static_cast<double>(i) / static_cast<double>(count);
    const std::complex<double> turn =
        (1.0 - std::cos(two_pi * share)) * std::polar(1.0, -speed * static_cast<double>(i) / rec.run.sample_rate_hz);
    for (int c = 0; c < 4; ++c) {
      if (rec.noise[c] <= 0.0) continue;
      const double value = channels[i * predicted_channels + c] / rec.noise[c];
      sums[c / 2] += turn * (c % 2 == 0 ? std::complex<double>(value, 0.0) : std::complex<double>(0.0, value));
    }
  }
  return sums;
}

double powerOf(const EndSums& sums) { return std::norm(sums[0]) + std::norm(sums[1]); }

/// Where the harmonic is largest about the believed speed.
double shownSpeed(const Recording& rec, long count, double believed) {
  const double spacing = 0.5 * two_pi * rec.run.sample_rate_hz / static_cast<double>(count);
  const auto power = [&](double speed) { return powerOf(harmonicAt(rec, rec.measured, count, speed)); };
  double best = believed, most = power(believed);
  for (double off = spacing; off < farthest_speed * believed; off += spacing)
    for (const double speed : {believed - off, believed + off}) {
      const double value = power(speed);
      if (value > most) most = value, best = speed;
    }
  double low = best - spacing, high = best + spacing;  // one hill, by thirds
  while (high - low > 1e-3 * spacing) {
    const double third = (high - low) / 3.0;
    if (power(low + third) < power(high - third)) low += third;
    else high -= third;
  }
  return std::clamp(0.5 * (low + high), believed * (1.0 - farthest_speed), believed * (1.0 + farthest_speed));
}

}  // namespace

bool findShaft(Recording& rec, const Model& belief) {
  const double believed = rec.speed_rad_s;
  if (!(believed < pi * rec.run.sample_rate_hz)) return false;  // turns that no sample follows
  long count = rec.samples;
  for (const RunEvent& event : rec.run.events)
    count = std::min(count, static_cast<long>(event.time_s * rec.run.sample_rate_hz));
  const double turn = two_pi / believed * rec.run.sample_rate_hz;  // in samples
  if (rec.holdsContact()) count = std::min(count, std::lround(first_turns * turn));
  if (static_cast<double>(count) < 2.0 * turn) return false;
  const double speed = rec.holdsContact() ? believed : shownSpeed(rec, count, believed);
  const EndSums measured = harmonicAt(rec, rec.measured, count, speed);
  // of white noise of 1 in up to four channels, under the window
  if (powerOf(measured) < std::pow(least_harmonic, 2) * 4.0 * 1.5 * static_cast<double>(count)) return false;

  rec.speed_rad_s = speed;
  const std::vector<Model> models = withTrialWeights({belief}, rec);
  Stretch stretch = stretchOf(rec, models[0]);
  stretch.contact_step_s = 0.0;
  stretch.last = count;
  std::vector<double> predicted(static_cast<std::size_t>(count) * predicted_channels);
  std::vector<LaneJob> jobs = {jobOf(rec, models[0], 0.0)};
  jobs[0].out = predicted.data();
  predict(stretch, jobs);
  std::complex<double> against = 0.0;
  if (jobs[0].finite) {
    const EndSums believed_sums = harmonicAt(rec, predicted, count, speed);
    for (int end = 0; end < 2; ++end) against += measured[end] * std::conj(believed_sums[end]);
  }
  rec.angle0_rad = std::arg(against);
  rec.first_turns_s = 0.5 * static_cast<double>(count) / rec.run.sample_rate_hz;
  rec.angle_std_rad = any_angle_rad;
  rec.speed_std_rad_s = run_away_rad / rec.duration();
  return true;
}

}  // namespace amb_rotor
