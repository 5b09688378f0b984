#include "amb_rotor/validation/loop_offsets.hpp"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "amb_rotor/common/units.hpp"
#include "amb_rotor/validation/fit.hpp"
#include "amb_rotor/validation/recording.hpp"
#include "amb_rotor/validation/stretches.hpp"

namespace amb_rotor {
namespace {

/// Share of the stated deviation that offsets in the recording alone stay below by chance in next to no set of runs.
constexpr double next_to_none = 0.1;
/// Offsets' deviations, as currents by kp, beyond which integrators that hold as much do not begin at 0: where the offsets lie in the
/// recording, whose drift is in the reading, and where they do not.
constexpr double held_beside_offsets = 3.0, held_in_loop = 0.1;
/// Share of the turning speed at which integrators in a run-in forget their mean: their ripple is off by as much; turns it is read from.
constexpr double leak_share = 0.05;
constexpr int ripple_turns = 3;
/// Offset that the response is taken at, and drift over the run [m].
constexpr double probe_m = 1e-6;
/// Stated deviations up to which offsets go into the lanes themselves.
constexpr double most_in_lanes = 4.0;

bool isExcited(const Recording& rec) {
  return std::any_of(std::begin(rec.excitation.axis), std::end(rec.excitation.axis), [](const std::vector<double>& axis) {
    return std::any_of(axis.begin(), axis.end(), [](double value) { return value != 0.0; });
  });
}

double medianOf(std::vector<double> values) {
  std::nth_element(values.begin(), values.begin() + static_cast<long>(values.size() / 2), values.end());
  return values[values.size() / 2];
}

bool hasPlainPid(const Model& belief) {
  return belief.amb_model == AmbModel::linear && belief.control.plain() && belief.rig.controller.kp_A_per_m > 0.0;
}

}  // namespace

LawReading readLaw(const Recording& rec, const Model& belief) {
  const auto& control = belief.rig.controller;
  const double kp = control.kp_A_per_m, kd = control.kd_A_s_per_m, ki = control.ki_A_per_m_s;
  const double step = 1.0 / rec.run.sample_rate_hz;
  LawReading out = {Eigen::Vector4d::Zero(), Eigen::Vector4d::Zero()};
  for (int a = 0; a < axis_count; ++a) {
    if (!(rec.noise[a] > 0.0 && rec.noise[axis_count + a] > 0.0)) {
      out.offset_m[a] = out.integral_A[a] = std::numeric_limits<double>::quiet_NaN();
      continue;
    }
    double sum = 0.0, sum_t = 0.0, sum_tt = 0.0, sum_y = 0.0, sum_ty = 0.0, integral = 0.0;
    for (long i = 0; i < rec.samples; ++i) {
      const double weight = 1.0 - std::cos(two_pi * (static_cast<double>(i) + 0.5) / static_cast<double>(rec.samples));
      const double* channels = &rec.measured[static_cast<std::size_t>(i) * predicted_channels];
      const double excitation = rec.excitation.axis[a].empty() ? 0.0 : rec.excitation.axis[a][static_cast<std::size_t>(i)];
      integral += step * channels[a];
      const double rate = i > 0 ? (channels[a] - channels[a - predicted_channels]) / step : 0.0;
      const double t = static_cast<double>(i) * step,
                   y = channels[axis_count + a] - excitation + kp * channels[a] + kd * rate + ki * integral;
      sum += weight;
      sum_t += weight * t;
      sum_tt += weight * t * t;
      sum_y += weight * y;
      sum_ty += weight * t * y;
    }
    if (ki > 0.0) {
      const double slope = (sum * sum_ty - sum_t * sum_y) / (sum * sum_tt - sum_t * sum_t);
      out.offset_m[a] = slope / ki;
      out.integral_A[a] = kp * out.offset_m[a] - (sum_y - slope * sum_t) / sum;
    } else {
      out.offset_m[a] = sum_y / sum / kp;
    }
  }
  return out;
}

LoopReading readLoop(const std::vector<Recording>& recordings, const Model& belief, double offset_std_m) {
  LoopReading out;
  if (!hasPlainPid(belief)) return out;
  const double kp = belief.rig.controller.kp_A_per_m, ki = belief.rig.controller.ki_A_per_m_s;
  std::vector<double> offsets, integrals;
  for (const bool excited : {false, true}) {  // excited runs where there are no others
    for (const Recording& rec : recordings) {
      if (rec.holdsContact() || rec.samples < 2 || !rec.run.events.empty() || isExcited(rec) != excited) continue;
      const LawReading reading = readLaw(rec, belief);
      if (!reading.offset_m.allFinite()) continue;
      for (const double offset : reading.offset_m) offsets.push_back(std::fabs(offset));
      integrals.push_back(reading.integral_A.cwiseAbs().maxCoeff());
    }
    if (!offsets.empty()) break;
  }
  if (offsets.empty()) return out;
  const bool in_loop = medianOf(offsets) < next_to_none * offset_std_m;
  out.integrators_settled = ki > 0.0 && medianOf(integrals) > (in_loop ? held_in_loop : held_beside_offsets) * kp * offset_std_m;
  out.offsets_in_loop = in_loop && (ki == 0.0 || out.integrators_settled);
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
      const LawReading reading = readLaw(rec, belief);
      if (reading.integral_A.allFinite()) {
        const Eigen::Vector4d ripple = integralRipple_m_s(rec);
        for (int a = 0; a < axis_count; ++a)
          rec.integral_m_s[static_cast<std::size_t>(a)] = reading.integral_A[a] / belief.rig.controller.ki_A_per_m_s - ripple[a];
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
