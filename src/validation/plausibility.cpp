#include "amb_rotor/validation/plausibility.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <complex>
#include <deque>

#include "amb_rotor/common/units.hpp"
#include "amb_rotor/magnetic_bearing/amplifier.hpp"
#include "amb_rotor/magnetic_bearing/pid.hpp"
#include "number_text.hpp"

namespace amb_rotor {
namespace {

constexpr double averaged_s = 1e-3, warm_up_s = 0.02;
constexpr double clear = 0.9, unlike = 0.3;     // correlations
constexpr double unit_factor = 3.0;
constexpr double same_end_bonus = 0.01;         // between currents that are alike
constexpr int segments = 8;
constexpr double least_drift_rad = 0.3, steady_amplitude = 0.3, steady_speed = 1e-3, straight = 0.2, close = 0.08;
constexpr double same_change = 0.3;             // of the harmonic's drift and that of the tacho's speed

/// A command's way to the force: held from its due time on, behind the amplifier's lag.
/// @param integrate  false: the integrator, whose state at the begin is not known, rests
std::vector<double> computedCurrent(const Recording& rec, const Model& belief, int axis, long count, bool integrate = false) {
  const auto& controller = belief.rig.controller;
  const Pid<double> pid(belief.rig);
  const Amplifier<double> amplifier(belief.rig);
  const double dt = 1.0 / rec.run.sample_rate_hz, decay = amplifier.decay(dt);
  PidMemory<double> memory;
  memory.previous_signal = rec.measured[axis];
  std::deque<std::pair<double, double>> queue;
  double held = 0.0, current = 0.0;
  long next = 0;
  std::vector<double> out;
  for (long i = 0; i < count; ++i) {
    const double time = i * dt;
    out.push_back(current);
    for (; next / controller.sample_rate_hz <= time + 0.5 * dt; ++next)
      queue.emplace_back(next / controller.sample_rate_hz + controller.delay_s,
                         pid.sample(rec.measured[i * predicted_channels + axis], memory, integrate));
    for (; !queue.empty() && queue.front().first <= time + 0.5 * dt; queue.pop_front()) held = queue.front().second;
    current = held + (current - held) * decay;
  }
  return out;
}

std::vector<double> laggedExcitation(const Recording& rec, const Model& belief, int axis, long count) {
  const Amplifier<double> amplifier(belief.rig);
  const double decay = amplifier.decay(1.0 / rec.run.sample_rate_hz);
  const auto& excitation = rec.excitation.axis[axis];
  double lagged = 0.0;
  std::vector<double> out;
  for (long i = 0; i < count; ++i) {
    out.push_back(lagged);
    const double now = i < static_cast<long>(excitation.size()) ? excitation[i] : 0.0;
    lagged = now + (lagged - now) * decay;
  }
  return out;
}

/// A measured current less something.
std::vector<double> currentLess(const std::vector<double>& taken, const Recording& rec, int axis) {
  std::vector<double> out;
  for (std::size_t i = 0; i < taken.size(); ++i) out.push_back(rec.measured[i * predicted_channels + 4 + axis] - taken[i]);
  return out;
}

bool isThere(const Recording& rec, int channel) { return rec.noise[channel] > 0.0; }

/// Samples while the bearings are on, and how many at their begin are left out.
struct Judged {
  long count = 0, width = 0, skip = 0;
};

Judged judgedPart(const Recording& rec) {
  Judged part;
  long count = rec.samples;
  for (const auto& event : rec.run.events)
    if (!event.amb_on) count = std::min(count, static_cast<long>(event.time_s * rec.run.sample_rate_hz));
  part.width = std::max(1L, std::lround(averaged_s * rec.run.sample_rate_hz));
  part.skip = std::lround(warm_up_s * rec.run.sample_rate_hz) + part.width;
  part.count = count < 4 * part.skip ? 0 : count;
  return part;
}

double product(const std::vector<double>& a, const std::vector<double>& b) {
  double sum = 0.0;
  for (std::size_t i = 0; i < a.size(); ++i) sum += a[i] * b[i];
  return sum;
}

bool isAnotherUnit(double gain) { return gain > unit_factor || gain < 1.0 / unit_factor; }

/// Slope of b over a where a is small: what a limit of b does not touch, and a wrong unit does.
double slopeWhereSmall(const std::vector<double>& a, const std::vector<double>& b) {
  std::vector<double> size(a.size());
  std::transform(a.begin(), a.end(), size.begin(), [](double v) { return std::fabs(v); });
  std::nth_element(size.begin(), size.begin() + size.size() / 2, size.end());
  const double most = size[size.size() / 2];
  double both = 0.0, square = 0.0;
  for (std::size_t i = 0; i < a.size(); ++i)
    if (std::fabs(a[i]) <= most) {
      both += a[i] * b[i];
      square += a[i] * a[i];
    }
  return both / std::max(square, 1e-300);
}

/// Running mean, without the warm-up and the mean.
std::vector<double> smooth(const std::vector<double>& values, long width, long skip) {
  std::vector<double> out;
  double sum = 0.0, total = 0.0;
  for (long i = 0; i < static_cast<long>(values.size()); ++i) {
    sum += values[i] - (i >= width ? values[i - width] : 0.0);
    if (i >= skip) out.push_back(sum / width);
  }
  for (double v : out) total += v;
  for (double& v : out) v -= total / out.size();
  return out;
}

bool isDriven(const Recording& rec) {
  return std::any_of(std::begin(rec.excitation.axis), std::end(rec.excitation.axis), [](const std::vector<double>& axis) {
    return std::any_of(axis.begin(), axis.end(), [](double i) { return i != 0.0; });
  });
}

/// Phases that stay up to a knot and then run away: c + slope max(0, s - knot), s in segments, as means over each.
struct RunningAway {
  double knot = -0.5, slope = 0.0, off = 1e300;  ///< off: the farthest from it
  double all() const { return slope * (segments - 0.5 - knot); }
  bool holds() const { return std::fabs(all()) >= least_drift_rad && off <= straight * std::fabs(all()); }
};

RunningAway runningAway(const double (&phase)[segments], double knot) {
  double h[segments], mean_h = 0.0, mean = 0.0, hh = 0.0, hy = 0.0;
  const auto area = [&](double s) { return 0.5 * std::pow(std::max(0.0, s - knot), 2); };
  for (int s = 0; s < segments; ++s) {
    h[s] = area(s + 0.5) - area(s - 0.5);
    mean_h += h[s] / segments;
    mean += phase[s] / segments;
  }
  for (int s = 0; s < segments; ++s) {
    hh += std::pow(h[s] - mean_h, 2);
    hy += (h[s] - mean_h) * (phase[s] - mean);
  }
  RunningAway out{knot, hy / hh, 0.0};
  for (int s = 0; s < segments; ++s) out.off = std::max(out.off, std::fabs(phase[s] - mean - out.slope * (h[s] - mean_h)));
  return out;
}

/// From the begin where that is close, else from the knot that fits best.
RunningAway bestRunningAway(const double (&phase)[segments]) {
  RunningAway best = runningAway(phase, -0.5);
  if (best.off < close * std::fabs(best.all())) return best;
  for (double knot = 0.0; knot <= segments - 2.5; knot += 0.25) {
    const RunningAway one = runningAway(phase, knot);
    if (one.off < best.off) best = one;
  }
  return best;
}

std::string columnOf(const Dataset& dataset, ChannelMeaning meaning, int axis) {
  const Channel* channel = dataset.findChannel(meaning, axis);
  return channel != nullptr ? channel->name : "";
}

}  // namespace

std::vector<std::string> channelRemarks(const Recording& rec, const Dataset& dataset) {
  std::vector<std::string> remarks;
  const Model& belief = dataset.belief;
  if (belief.amb_model != AmbModel::linear) return remarks;
  const Judged part = judgedPart(rec);
  if (part.count == 0) return remarks;

  std::array<std::vector<double>, axis_count> computed, measured;
  for (int a = 0; a < axis_count; ++a) {
    if (isThere(rec, a)) computed[a] = smooth(computedCurrent(rec, belief, a, part.count), part.width, part.skip);
    if (isThere(rec, 4 + a))
      measured[a] = smooth(currentLess(laggedExcitation(rec, belief, a, part.count), rec, a), part.width, part.skip);
  }
  double r[axis_count][axis_count] = {}, gain[axis_count][axis_count] = {};
  for (int d = 0; d < axis_count; ++d)
    for (int m = 0; m < axis_count; ++m) {
      if (computed[d].empty() || measured[m].empty()) continue;
      const double both = product(computed[d], measured[m]), square = product(computed[d], computed[d]);
      r[d][m] = both / std::max(std::sqrt(square * product(measured[m], measured[m])), 1e-300);
      gain[d][m] = both / std::max(square, 1e-300);
    }
  const auto integrated = [&](int a) {
    return smooth(computedCurrent(rec, belief, a, part.count, true), part.width, part.skip);
  };
  std::array<int, axis_count> other{};
  for (int d = 0; d < axis_count; ++d) {
    other[d] = d;
    if (computed[d].empty() || measured[d].empty()) continue;
    if (r[d][d] > unlike || r[d][d] < -clear) continue;
    double best = clear;
    for (int m = 0; m < axis_count; ++m) {
      const double value = r[d][m] + (m / 2 == d / 2 ? same_end_bonus : 0.0);
      if (m != d && r[d][m] > clear && value > best) {
        best = value;
        other[d] = m;
      }
    }
  }
  for (int d = 0; d < axis_count; ++d) {
    const std::string own = columnOf(dataset, ChannelMeaning::displacement, d);
    if (other[d] != d) {
      const int m = other[d];
      const bool both = isThere(rec, m);
      const std::string mate = (both ? "of " : "") + columnOf(dataset, both ? ChannelMeaning::displacement : ChannelMeaning::control_current, m);
      if (other[m] == d && m < d) continue;  // said already
      remarks.push_back(own + " goes with the control current " + mate + " (correlation " + text("%.2f", r[d][m]) +
                        ", with its own " + text("%.2f", r[d][d]) + "): " +
                        (other[m] == d ? "the two channels, or their currents, are swapped"
                                       : "it may belong to another place") +
                        "; change plane and axis in dataset.yaml");
    } else if (r[d][d] < -clear) {
      remarks.push_back(own + " has the wrong sign against its control current (correlation " + text("%.2f", r[d][d]) +
                        "): turn the sign of one of them");
    } else if (r[d][d] > clear && isAnotherUnit(gain[d][d]) && isAnotherUnit(slopeWhereSmall(computed[d], measured[d])) &&
               isAnotherUnit(slopeWhereSmall(integrated(d), measured[d]))) {
      remarks.push_back(own + " asks for a control current " + text("%.3g", 1.0 / gain[d][d]) + " times the measured one of " +
                        columnOf(dataset, ChannelMeaning::control_current, d) +
                        ": the unit of one of the two columns may be another");
    }
  }
  return remarks;
}

std::vector<std::string> excitationRemarks(const Recording& rec, const Dataset& dataset) {
  constexpr double wrong_sign = -0.8, not_its_own = 0.4, alike = 0.8;  // correlations
  std::vector<std::string> remarks;
  const Model& belief = dataset.belief;
  if (belief.amb_model != AmbModel::linear || rec.holdsContact()) return remarks;
  if (!isDriven(rec) && (rec.run.kind == RunKind::chirp || rec.run.kind == RunKind::step))
    return {"a chirp or step without an excitation current: what drove it is not recorded, and so not predicted"};
  const Judged part = judgedPart(rec);
  if (part.count == 0) return remarks;
  std::array<std::vector<double>, axis_count> beyond, drive;  // the controller; none where displacement or current are missing
  for (int a = 0; a < axis_count; ++a) {
    drive[a] = smooth(laggedExcitation(rec, belief, a, part.count), part.width, part.skip);
    if (!isThere(rec, a) || !isThere(rec, 4 + a)) continue;
    beyond[a] = smooth(currentLess(computedCurrent(rec, belief, a, part.count), rec, a), part.width, part.skip);
  }
  const auto correlation = [&](int a, int m) {
    if (beyond[m].empty()) return 0.0;
    return product(drive[a], beyond[m]) /
           std::max(std::sqrt(product(drive[a], drive[a]) * product(beyond[m], beyond[m])), 1e-300);
  };
  for (int a = 0; a < axis_count; ++a) {
    const double square = product(drive[a], drive[a]);
    if (square == 0.0 || beyond[a].empty()) continue;
    std::array<double, axis_count> r{};
    for (int m = 0; m < axis_count; ++m) r[m] = correlation(a, m);
    const int best = static_cast<int>(std::max_element(r.begin(), r.end()) - r.begin());
    const double gain = product(drive[a], beyond[a]) / square;
    const std::string own = columnOf(dataset, ChannelMeaning::excitation_current, a);
    const std::string current = columnOf(dataset, ChannelMeaning::control_current, a);
    if (r[a] < wrong_sign)
      remarks.push_back(own + " has the wrong sign against " + current + " (correlation " + text("%.2f", r[a]) +
                        "): turn the sign of one of them");
    else if (best != a && r[a] < not_its_own && r[best] > alike && correlation(best, best) < not_its_own)
      remarks.push_back(own + " is found in " + columnOf(dataset, ChannelMeaning::control_current, best) + " (correlation " +
                        text("%.2f", r[best]) + ", in " + current + " " + text("%.2f", r[a]) +
                        "): the channels of these two axes are swapped, of the excitation or of all else");
    else if (r[a] > alike && isAnotherUnit(gain))
      remarks.push_back(own + " is found in " + current + " " + text("%.3g", gain) +
                        " times as large: the unit of one of the two columns may be another");
  }
  return remarks;
}

std::vector<std::string> clockRemarks(const Recording& rec) {
  if (rec.standstill || rec.path != nullptr || rec.holdsContact() || rec.pulses.state != TachoState::turning || isDriven(rec))
    return {};
  const long from = static_cast<long>(std::ceil(rec.pulses.time.front() * rec.run.sample_rate_hz));
  const long to = std::min(rec.samples, static_cast<long>(rec.pulses.time.back() * rec.run.sample_rate_hz));
  const ShaftAngle shaft(rec.pulses);
  const double first = shaft.speed(rec.pulses.time.front()), last = shaft.speed(rec.pulses.time.back());
  const double length = (to - from) / rec.run.sample_rate_hz;
  const double turns = std::fabs(rec.speed_rad_s) * length / two_pi;
  if (turns < 4.0 * segments) return {};
  for (int end = 0; end < 2; ++end) {
    if (!isThere(rec, 2 * end) && !isThere(rec, 2 * end + 1)) continue;  // of one, 0 is measured beside it
    // the mean, which would leak into unwhole turns, taken out
    std::complex<double> mean = 0.0;
    const auto at = [&](long i) {
      return std::complex<double>(rec.measured[i * predicted_channels + 2 * end],
                                  rec.measured[i * predicted_channels + 2 * end + 1]);
    };
    for (long i = from; i < to; ++i) mean += at(i) / static_cast<double>(to - from);
    double phase[segments], least = 1e300, most = 0.0;
    for (int s = 0; s < segments; ++s) {
      const long a = from + (to - from) * s / segments, b = from + (to - from) * (s + 1) / segments;
      std::complex<double> sum = 0.0;
      for (long i = a; i < b; ++i)
        sum += (at(i) - mean) * std::polar(1.0, -shaft.angle(i / rec.run.sample_rate_hz)) / static_cast<double>(b - a);
      phase[s] = s == 0 ? std::arg(sum) : phase[s - 1] + std::remainder(std::arg(sum) - phase[s - 1], two_pi);
      least = std::min(least, std::abs(sum));
      most = std::max(most, std::abs(sum));
    }
    const double noise = std::max(rec.noise[2 * end], rec.noise[2 * end + 1]) * std::sqrt(2.0 * segments / static_cast<double>(to - from));
    if (least < 20.0 * noise || most - least > steady_amplitude * most) continue;
    const RunningAway away = bestRunningAway(phase);
    const double slope = away.slope * segments / length, changed = last - first;
    if (!away.holds()) continue;
    // a speed that changes for real takes the harmonic with it
    if (std::fabs(changed) > steady_speed * std::fabs(first) && std::fabs(slope + changed) > same_change * std::fabs(slope)) continue;
    const double from_s = from / rec.run.sample_rate_hz + (away.knot + 0.5) * length / segments;
    return {"the first harmonic runs away from the tacho by " + text("%.2f", away.all()) + " rad " +
            (away.knot < 0.0 ? "in " + text("%.2f", length) + " s" : "from " + text("%.2f", from_s) + " s on, and not before") +
            ": the tacho's clock drifts against the samples by " + text("%.0f", 1e6 * slope / rec.speed_rad_s) +
            " ppm; record both with one clock"};
  }
  return {};
}

}  // namespace amb_rotor
