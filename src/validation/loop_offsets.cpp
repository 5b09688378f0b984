#include "amb_rotor/validation/loop_offsets.hpp"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "amb_rotor/common/linear_algebra.hpp"
#include "amb_rotor/common/units.hpp"
#include "amb_rotor/validation/fit.hpp"
#include "amb_rotor/validation/recording.hpp"
#include "amb_rotor/validation/stretches.hpp"

namespace amb_rotor {
namespace {

/// Share of the stated deviation that offsets in the recording alone stay below by chance in next to no set of runs.
constexpr double next_to_none = 0.1;
/// Share of the offsets' deviation, as a current by kp, beyond which integrators that hold as much do not begin at 0 where the offsets go
/// round the loop.
constexpr double held_in_loop = 0.1;
/// Share of the turning speed at which integrators in a run-in forget their mean: their ripple is off by as much; turns it is read from.
constexpr double leak_share = 0.05;
constexpr int ripple_turns = 3;
/// Mean square of a Hann window's weights, of mean 1.
constexpr double hann_variance = 1.5;
/// Variance of a displacement's mean by what noise in the loop, a third of the sensors', moves the rotor, over that of the noise, times the
/// number of instants.
constexpr double wander_variance = 0.5;
/// Instants before an excitation from which their means are read: Hann's weights of one instant alone have no mean of 1.
constexpr long least_quiet = 10;
/// What delay and lag of currents may be beside the believed ones, and half the time that a current's rate is taken over.
constexpr double lateness_std_s = 2e-4, rate_reach_s = 1e-3;
/// Offset that the response is taken at, and drift over the run [m].
constexpr double probe_m = 1e-6;
/// Stated deviations up to which offsets go into the lanes themselves.
constexpr double most_in_lanes = 4.0;

/// The first instant of an excitation; the number of samples: there is none.
long firstExcited(const Recording& rec) {
  long first = rec.samples;
  for (const auto& axis : rec.excitation.axis)
    if (!axis.empty()) first = std::min<long>(first, std::find_if(axis.begin(), axis.end(), [](double i) { return i != 0.0; }) - axis.begin());
  return first;
}

/// Of mean 1 over so many instants.
double hannWeight(long instant, long instants) {
  return 1.0 - std::cos(two_pi * (static_cast<double>(instant) + 0.5) / static_cast<double>(instants));
}

/// From the start, before an excitation or an event; 0: they are few, or a turning rotor does not turn often enough in them.
long quietSamples(const Recording& rec) {
  long samples = firstExcited(rec);
  for (const auto& event : rec.run.events) samples = std::min(samples, std::lround(event.time_s * rec.run.sample_rate_hz));
  const double turns = std::fabs(rec.startingSpeed()) / two_pi * static_cast<double>(samples) / rec.run.sample_rate_hz;
  return samples >= least_quiet && (rec.standstill || turns >= ripple_turns) ? samples : 0;
}

/// Of a channel over its first so many instants, weighted by Hann's window.
double quietMean(const Recording& rec, int channel, long quiet) {
  double mean = 0.0;
  for (long i = 0; i < quiet; ++i)
    mean += rec.measured[static_cast<std::size_t>(i) * predicted_channels + channel] * hannWeight(i, quiet);
  return mean / static_cast<double>(quiet);
}

double medianOf(std::vector<double> values) {
  std::nth_element(values.begin(), values.begin() + static_cast<long>(values.size() / 2), values.end());
  return values[values.size() / 2];
}

bool hasPlainPid(const Model& belief) {
  return belief.amb_model == AmbModel::linear && belief.control.plain() && belief.rig.controller.kp_A_per_m > 0.0;
}

}  // namespace

LawReading readLaw(const Recording& rec, const Model& belief, double offset_std_m) {
  const auto& control = belief.rig.controller;
  const double kp = control.kp_A_per_m, kd = control.kd_A_s_per_m, ki = control.ki_A_per_m_s;
  const double step = 1.0 / rec.run.sample_rate_hz;
  const double bandwidth_hz = belief.rig.amb.amplifier_bandwidth_hz;
  const double late_s = control.delay_s + (bandwidth_hz > 0.0 ? 1.0 / (two_pi * bandwidth_hz) : 0.0) + 0.5 * step;
  const long quiet = quietSamples(rec), reach = std::max(1L, std::lround(rate_reach_s / step));
  LawReading out;
  for (int a = 0; a < axis_count; ++a) {
    if (!(rec.noise[a] > 0.0 && rec.noise[axis_count + a] > 0.0)) {
      out.offset_m[a] = out.integral_A[a] = out.settled_integral_A[a] = out.loop_integral_A[a] = std::numeric_limits<double>::quiet_NaN();
      continue;
    }
    // y = -ki I(0) + o (kp + ki t) - (lateness beside the believed) i' + d (kp u + ki t u/2), u = t/T
    Eigen::Matrix4d products = Eigen::Matrix4d::Zero();
    Eigen::Vector4d along = Eigen::Vector4d::Zero();
    double integral = 0.0;
    const auto current = [&](long i) { return rec.measured[static_cast<std::size_t>(i) * predicted_channels + axis_count + a]; };
    for (long i = 0; i < rec.samples; ++i) {
      const double u = (static_cast<double>(i) + 0.5) / static_cast<double>(rec.samples), t = static_cast<double>(i) * step;
      const double* channels = &rec.measured[static_cast<std::size_t>(i) * predicted_channels];
      const double excitation = rec.excitation.axis[a].empty() ? 0.0 : rec.excitation.axis[a][static_cast<std::size_t>(i)];
      integral += step * channels[a];
      const double rate = i > 0 ? (channels[a] - channels[a - predicted_channels]) / step : 0.0;
      const double current_rate = (current(std::min(rec.samples - 1, i + reach)) - current(std::max(0L, i - reach))) /
                                  (2.0 * static_cast<double>(reach) * step);
      const double y = current(i) + late_s * current_rate - excitation + kp * channels[a] + kd * rate + ki * integral;
      const Eigen::Vector4d terms(1.0, kp + ki * t, -current_rate, kp * u + 0.5 * ki * t * u);
      const Eigen::Vector4d weighted = hannWeight(i, rec.samples) * terms;
      products += weighted * terms.transpose();
      along += y * weighted;
    }
    if (!(ki > 0.0)) {
      out.offset_m[a] = along[0] / products(0, 0) / kp;
      continue;
    }
    const double variance = hann_variance * (std::pow(kp * rec.noise[a], 2) + std::pow(rec.noise[axis_count + a], 2));
    products(2, 2) += variance / (lateness_std_s * lateness_std_s);
    const Eigen::Vector3d without_drift = Ldlt(products.topLeftCorner<3, 3>()).solve(along.head<3>());
    out.offset_m[a] = without_drift[1];
    out.integral_A[a] = out.settled_integral_A[a] = -without_drift[0];
    const std::vector<int> without_offset = {0, 2};
    out.loop_integral_A[a] = -Ldlt(products(without_offset, without_offset)).solve(along(without_offset))[0];
    if (!(offset_std_m > 0.0)) continue;
    products(3, 3) += variance / (offset_std_m * offset_std_m);
    const double begun_at_zero = along.tail<3>().dot(Ldlt(products.bottomRightCorner<3, 3>()).solve(along.tail<3>()));
    // what a settled integrator leaves in the mean displacement is the offset, o + d u in the middle of the quiet instants
    const Eigen::Vector4d shown(0.0, 1.0, 0.0, 0.5 * static_cast<double>(quiet) / static_cast<double>(rec.samples));
    const double mean = quiet > 0 ? quietMean(rec, a, quiet) : 0.0;
    const double weight = variance * static_cast<double>(quiet) / ((hann_variance + wander_variance) * rec.noise[a] * rec.noise[a]);
    products += weight * shown * shown.transpose();
    along += weight * mean * shown;
    const Eigen::Vector4d settled = Ldlt(products).solve(along);
    out.settled_integral_A[a] = -settled[0];
    if (quiet > 0) out.settled_gain += (along.dot(settled) - weight * mean * mean - begun_at_zero) / variance;
  }
  return out;
}

LoopReading readLoop(const std::vector<Recording>& recordings, const Model& belief, double offset_std_m) {
  LoopReading out;
  if (!hasPlainPid(belief)) return out;
  const double kp = belief.rig.controller.kp_A_per_m, ki = belief.rig.controller.ki_A_per_m_s;
  struct Of {
    std::vector<double> offsets, integrals;
  } excited, other;
  double settled_gain = 0.0;
  for (const Recording& rec : recordings) {
    if (rec.holdsContact() || rec.samples < 2) continue;
    const LawReading reading = readLaw(rec, belief, offset_std_m);
    if (!reading.offset_m.allFinite()) continue;
    settled_gain += reading.settled_gain;
    if (!rec.run.events.empty()) continue;
    Of& of = firstExcited(rec) < rec.samples ? excited : other;
    for (const double offset : reading.offset_m) of.offsets.push_back(std::fabs(offset));
    // beside an offset noise is many times as large in them; without one an offset of the recording is taken for them
    of.integrals.push_back(reading.integral_A.cwiseAbs().cwiseMin(reading.loop_integral_A.cwiseAbs()).maxCoeff());
  }
  const auto& [offsets, integrals] = other.offsets.empty() ? excited : other;
  if (offsets.empty()) return out;
  out.offsets_in_loop = medianOf(offsets) < next_to_none * offset_std_m;
  out.integrators_settled = out.offsets_in_loop ? ki > 0.0 && medianOf(integrals) > held_in_loop * kp * offset_std_m : settled_gain > 0.0;
  return out;
}

std::vector<double> offsetsInLoop(const Recording& rec, const Model& belief) {
  const std::vector<Model> models = withTrialWeights({belief}, rec);
  Stretch stretch = stretchOf(rec, models[0]);
  stretch.settle_s = std::max(stretch.settle_s, settledRunIn(rec, models[0], stretch, 0.0));
  stretch.contact_step_s = 0.0;
  const std::size_t width = static_cast<std::size_t>(rec.samples) * predicted_channels;
  constexpr std::size_t columns = 2 * axis_count;
  std::vector<double> outs(width * (1 + columns));
  std::vector<LaneJob> jobs;
  for (std::size_t k = 0; k <= columns; ++k) {
    jobs.push_back(jobOf(rec, models[0], 0.0));
    if (k > axis_count)
      jobs.back().drift_m_per_s[k - 1 - axis_count] = probe_m / rec.duration();
    else if (k > 0)
      jobs.back().offset_m[k - 1] = probe_m;
    jobs.back().out = outs.data() + k * width;
  }
  predict(stretch, jobs);
  if (!std::all_of(jobs.begin(), jobs.end(), [](const LaneJob& job) { return job.finite; })) return {};
  std::vector<double> out(width * columns);
  for (std::size_t at = 0; at < width; ++at)
    for (std::size_t k = 0; k < columns; ++k) out[at * columns + k] = (outs[(k + 1) * width + at] - outs[at]) / probe_m;
  return out;
}

Eigen::VectorXd offsetsInLanes(const Recording& rec, const LocalState& local, double offset_std_m) {
  Eigen::VectorXd out = Eigen::VectorXd::Zero(2 * axis_count);
  if (!rec.offsets_in_loop || !(offset_std_m > 0.0)) return out;
  for (int a = 0; a < axis_count; ++a) {
    out[a] = local.offset_m[a];
    out[axis_count + a] = local.drift_m[a];
  }
  const double most = most_in_lanes * offset_std_m;
  return out.cwiseMax(-most).cwiseMin(most);
}

void takeOffsets(const Recording& rec, const Eigen::VectorXd& offsets, LaneJob& job) {
  for (int a = 0; a < axis_count; ++a) {
    job.offset_m[a] = offsets[a];
    job.drift_m_per_s[a] = offsets[axis_count + a] / rec.duration();
  }
}

Eigen::Vector4d integralRipple_m_s(const Recording& rec) {
  Eigen::Vector4d out = Eigen::Vector4d::Zero();
  const double speed = rec.standstill ? 0.0 : std::fabs(rec.startingSpeed()), rate = rec.run.sample_rate_hz;
  const long samples = speed > 0.0 ? std::lround(ripple_turns * two_pi / speed * rate) : 0;
  if (samples < 2 || samples > rec.samples) return out;
  for (int a = 0; a < axis_count; ++a) {
    // s = mean + c cos + d sin over whole turns; of the integral c sin/w - d cos/w at t = 0 is -d/w
    double sine = 0.0, mean = 0.0;
    for (long i = 0; i < samples; ++i) mean += rec.measured[i * predicted_channels + a] / static_cast<double>(samples);
    for (long i = 0; i < samples; ++i)
      sine += 2.0 / static_cast<double>(samples) * (rec.measured[i * predicted_channels + a] - mean) *
              std::sin(speed * static_cast<double>(i) / rate);
    out[a] = -sine / speed;
  }
  return out;
}

void applyLoopReading(std::vector<Recording>& recordings, const Model& belief) {
  const auto offset_std = belief.uncertainty.find("sensor.offset_m");
  if (offset_std == belief.uncertainty.end() || !(offset_std->second > 0.0)) return;
  const LoopReading loop = readLoop(recordings, belief, offset_std->second);
  tbb::parallel_for(std::size_t{0}, recordings.size(), [&](std::size_t r) {
    Recording& rec = recordings[r];
    if (loop.integrators_settled && !rec.holdsContact()) {
      const LawReading reading = readLaw(rec, belief, offset_std->second);
      const Eigen::Vector4d& held_A = loop.offsets_in_loop ? reading.loop_integral_A : reading.settled_integral_A;
      if (held_A.allFinite()) {
        const Eigen::Vector4d ripple = integralRipple_m_s(rec);
        for (int a = 0; a < axis_count; ++a)
          rec.integral_m_s[static_cast<std::size_t>(a)] = held_A[a] / belief.rig.controller.ki_A_per_m_s - ripple[a];
        if (!rec.standstill) rec.integrator_leak_per_s = leak_share * std::fabs(rec.startingSpeed());
      }
    }
    rec.offsets_in_loop = loop.offsets_in_loop;
    if (!loop.offsets_in_loop || rec.holdsContact()) return;
    rec.offset_columns = offsetsInLoop(rec, belief);
    rec.offsets_in_loop = !rec.offset_columns.empty();
  });
}

}  // namespace amb_rotor
