#include "amb_rotor/analysis/tacho.hpp"

#include <algorithm>
#include <cmath>

#include "amb_rotor/common/linear_algebra.hpp"
#include "amb_rotor/common/units.hpp"
#include "argument.hpp"

namespace amb_rotor {
namespace {

// A period under this share of both its neighbours' that no pulse too many explains is irregular.
constexpr double short_period_share = 0.5;
// Neighbouring intervals above this many of the median around them lack pulses themselves.
constexpr double long_period_share = 1.5;
// A whole multiple of the neighbours' period within this share of one period counts as missing pulses.
constexpr double missing_tolerance = 0.2;
// An edge between samples within this share of the channel's range from its levels tells nothing of where it was between them.
constexpr double at_level = 0.1;
// Time steps above this many of the median step are a gap in the record.
constexpr double gap_steps = 1.5;

/// Median of the intervals within four edges of edge i.
double medianInterval(const std::vector<double>& edges, std::size_t i) {
  std::vector<double> intervals;
  const std::size_t from = i > 4 ? i - 4 : 0, to = std::min(edges.size() - 1, i + 4);
  for (std::size_t k = from; k < to; ++k) intervals.push_back(edges[k + 1] - edges[k]);
  const auto middle = intervals.begin() + static_cast<std::ptrdiff_t>(intervals.size() / 2);
  std::nth_element(intervals.begin(), middle, intervals.end());
  return *middle;
}

}  // namespace

EdgeDetector::EdgeDetector(TachoOptions options) : options_(options) {
  requireArgument(std::isfinite(options.threshold), "threshold", options.threshold, "must be finite");
  requireArgument(options.hysteresis >= 0.0 && std::isfinite(options.hysteresis), "hysteresis",
                  options.hysteresis, "must be at least 0");
}

std::optional<double> EdgeDetector::add(double time, double value) {
  if (!std::isfinite(time) || !std::isfinite(value)) {
    ++non_finite_;
    started_ = armed_ = false;
    return std::nullopt;
  }
  std::optional<double> edge;
  // At the start of a record there is no edge before that noise could repeat.
  const double arming = started_ ? options_.threshold - options_.hysteresis : options_.threshold;
  if (value < arming) armed_ = true;
  if (started_ && armed_ && value_ < options_.threshold && value >= options_.threshold) {
    edge = time_ + (options_.threshold - value_) / (value - value_) * (time - time_);
    armed_ = false;
  }
  started_ = true;
  time_ = time;
  value_ = value;
  return edge;
}

std::string TachoFault::text() const {
  const std::string number = std::to_string(count);
  std::string what;
  switch (kind) {
    case TachoFaultKind::missing_pulse:
      what = number + " missing pulse(s) after";
      break;
    case TachoFaultKind::double_pulse:
      what = "one pulse too many at";
      break;
    case TachoFaultKind::dropout:
      what = number + " sample(s) lost from";
      break;
    case TachoFaultKind::irregular:
      what = "an interval that is no whole number of turns after";
      break;
  }
  return "tacho: " + what + " t = " + std::to_string(time) + " s";
}

TachoPulses numberPulses(std::vector<double> edges) {
  TachoPulses pulses;
  // A pulse too many splits one turn in two: the two parts together fit the neighbours, alone they do not.
  for (std::size_t i = 1; edges.size() >= 4 && i + 1 < edges.size();) {
    const double before = i >= 2 ? edges[i - 1] - edges[i - 2] : 0.0;
    const double after = i + 2 < edges.size() ? edges[i + 2] - edges[i + 1] : 0.0;
    const double expected = before > 0.0 && after > 0.0 ? std::sqrt(before * after) : std::max(before, after);
    const double first = edges[i] - edges[i - 1], second = edges[i + 1] - edges[i];
    const bool fits = std::fabs(first + second - expected) < missing_tolerance * expected;
    if (fits && expected < long_period_share * medianInterval(edges, i)) {
      pulses.faults.push_back({TachoFaultKind::double_pulse, edges[i], 1});
      edges.erase(edges.begin() + static_cast<std::ptrdiff_t>(i));
    } else {
      ++i;
    }
  }
  long turn = 0;
  for (std::size_t i = 0; i < edges.size(); ++i) {
    if (i > 0) {
      const double period = edges[i] - edges[i - 1];
      const double before = i >= 2 ? (edges[i - 1] - edges[i - 2]) / (turn - pulses.turn[i - 2]) : 0.0;
      const double after = i + 1 < edges.size() ? edges[i + 1] - edges[i] : 0.0;
      double expected = before > 0.0 ? before : after;
      if (before > 0.0 && after > 0.0) {
        // The next interval may lack pulses too: then the smaller one is the period.
        const bool alike = std::max(before, after) < 1.5 * std::min(before, after);
        expected = alike ? std::sqrt(before * after) : std::min(before, after);
      }
      const double ratio = expected > 0.0 ? period / expected : 1.0;
      const long steps = std::max(1L, std::lround(ratio));
      // At the ends there is one neighbour only, and a fast run-up from rest looks the same: ask for more.
      const bool both = before > 0.0 && after > 0.0;
      const double tolerance = both ? missing_tolerance : 0.5 * missing_tolerance;
      if (steps > 1 &&
          std::fabs(ratio - static_cast<double>(steps)) < tolerance * static_cast<double>(steps)) {
        pulses.faults.push_back(
            {TachoFaultKind::missing_pulse, edges[i - 1], static_cast<int>(std::min(steps - 1, 1000000L))});
        turn += steps;
      } else {
        if (both && (ratio > 1.5 || ratio < short_period_share)) {
          pulses.faults.push_back({TachoFaultKind::irregular, edges[i - 1], 1});
        }
        turn += 1;
      }
    }
    pulses.turn.push_back(turn);
  }
  pulses.time = std::move(edges);
  pulses.state = pulses.time.size() >= 2
                     ? TachoState::turning
                     : (pulses.time.empty() ? TachoState::standstill : TachoState::too_few);
  return pulses;
}

namespace {

/// Of a pulse's height: what values written with six digits are off by, times as many steps, is less; finer steps tell an edge closer than
/// anything asks.
constexpr double finest_step = 3e-4;

/// Of an edge's time, uniform within a step of the values next to edges, `above` the samples that complete these. The step is what all
/// these values have in common: few of them leave gaps of several steps.
double roundingOf(const std::vector<double>& signal, const std::vector<std::size_t>& above, double sample_s, double range) {
  std::vector<double> values, rises;
  for (const std::size_t i : above) {
    if (i == 0 || !std::isfinite(signal[i - 1])) continue;
    values.insert(values.end(), {signal[i - 1], signal[i]});
    rises.push_back(signal[i] - signal[i - 1]);
  }
  double step = 0.0;
  for (const double value : values)
    for (double rest = std::fabs(value - values[0]); rest > finest_step * range;) {  // Euclid's algorithm
      const double next = std::fabs(std::remainder(step, rest));
      step = rest;
      rest = next;
    }
  if (step == 0.0) return 0.0;
  std::nth_element(rises.begin(), rises.begin() + static_cast<std::ptrdiff_t>(rises.size() / 2), rises.end());
  return step / std::sqrt(12.0) / rises[rises.size() / 2] * sample_s;
}

}  // namespace

TachoPulses findPulses(const std::vector<double>& time, const std::vector<double>& signal,
                       const TachoOptions& options) {
  requireSameLength(time, signal, "signal");
  EdgeDetector detector(options);
  std::vector<double> edges, steps;
  std::vector<std::size_t> above;  // the sample that completes each
  std::vector<TachoFault> dropouts;
  double low = 0.0, high = 0.0;
  bool any = false, lost = false;
  for (std::size_t i = 0; i < time.size(); ++i) {
    if (const std::optional<double> edge = detector.add(time[i], signal[i])) {
      edges.push_back(*edge);
      above.push_back(i);
    }
    if (!std::isfinite(time[i]) || !std::isfinite(signal[i])) {
      if (lost) {
        ++dropouts.back().count;
      } else {
        dropouts.push_back({TachoFaultKind::dropout, i > 0 ? time[i - 1] : time[i], 1});
      }
      lost = true;
      continue;
    }
    lost = false;
    low = any ? std::min(low, signal[i]) : signal[i];
    high = any ? std::max(high, signal[i]) : signal[i];
    any = true;
    if (i > 0 && std::isfinite(time[i - 1])) steps.push_back(time[i] - time[i - 1]);
  }
  double usual = 0.0;
  if (steps.size() > 2) {
    std::vector<double> sorted = steps;
    std::nth_element(sorted.begin(), sorted.begin() + static_cast<std::ptrdiff_t>(sorted.size() / 2),
                     sorted.end());
    usual = sorted[sorted.size() / 2];
    for (std::size_t i = 1; i < time.size(); ++i) {
      const double step = time[i] - time[i - 1];
      if (usual > 0.0 && step > gap_steps * usual) {
        dropouts.push_back(
            {TachoFaultKind::dropout, time[i - 1], static_cast<int>(std::lround(step / usual)) - 1});
      }
    }
  }
  TachoPulses pulses = numberPulses(std::move(edges));
  const double close = at_level * (high - low);
  const auto steep = std::count_if(above.begin(), above.end(), [&](std::size_t i) { return signal[i] > high - close && signal[i - 1] < low + close; });
  if (2 * static_cast<std::size_t>(steep) > above.size()) pulses.half_width_s = 0.5 * usual;
  if (pulses.half_width_s == 0.0) pulses.rounding_s = roundingOf(signal, above, usual, high - low);
  pulses.faults.insert(pulses.faults.end(), dropouts.begin(), dropouts.end());
  const bool moved = any && low < options.threshold && high >= options.threshold;
  if (pulses.state == TachoState::standstill && moved) pulses.state = TachoState::too_few;
  return pulses;
}

double edgeScatter(const TachoPulses& pulses) {
  double squares = 0.0;
  int count = 0;
  for (std::size_t i = 3; i < pulses.time.size(); ++i) {
    if (pulses.turn[i] - pulses.turn[i - 3] != 3) continue;
    const double third = pulses.time[i] - 3.0 * pulses.time[i - 1] + 3.0 * pulses.time[i - 2] - pulses.time[i - 3];
    squares += third * third;
    ++count;
  }
  return count > 0 ? std::sqrt(squares / (20.0 * count)) : 0.0;
}

SpeedFit fitSpeed(const TachoPulses& pulses, int turns, bool with_acceleration, double edge_std) {
  requireArgument(turns >= 0, "turns", turns, "must be at least 0");
  requireArgument(edge_std >= 0.0 && std::isfinite(edge_std), "edge_std", edge_std, "must be at least 0 [s]");
  SpeedFit fit;
  std::size_t count = pulses.time.size();
  if (turns > 0) {
    while (count > 0 && pulses.turn[count - 1] - pulses.turn.front() > turns) --count;
  }
  const int unknowns = with_acceleration ? 3 : 2;
  if (count < static_cast<std::size_t>(unknowns)) return fit;
  // Angle by centred and scaled time: the normal equations stay well conditioned.
  const double from = pulses.time.front(), length = pulses.time[count - 1] - from;
  Eigen::MatrixXd design(count, unknowns);
  Eigen::VectorXd angle(count);
  for (std::size_t i = 0; i < count; ++i) {
    const double s = (pulses.time[i] - from) / length;
    design(i, 0) = 1.0;
    design(i, 1) = s;
    if (with_acceleration) design(i, 2) = s * s;
    angle(i) = two_pi * static_cast<double>(pulses.turn[i] - pulses.turn.front());
  }
  const Eigen::VectorXd solution = leastSquares(design, angle);
  const Eigen::VectorXd residual = angle - design * solution;
  const double half_acceleration = with_acceleration ? solution(2) / (length * length) : 0.0;
  const double slope = solution(1) / length;
  // Time near the first edge at which the angle is 0: one Newton step of a nearly straight line, repeated.
  double ahead = 0.0;
  for (int i = 0; i < 5; ++i) {
    ahead -= (solution(0) + slope * ahead + half_acceleration * ahead * ahead) /
             (slope + 2.0 * half_acceleration * ahead);
  }
  fit.valid = std::isfinite(ahead) && slope > 0.0;
  fit.reference_time = from + ahead;
  fit.speed = slope + 2.0 * half_acceleration * ahead;
  fit.acceleration = 2.0 * half_acceleration;
  fit.turns = static_cast<int>(pulses.turn[count - 1] - pulses.turn.front());
  const double freedom = static_cast<double>(count) - unknowns;
  if (freedom > 0.0) {
    const double least = fit.speed * edge_std;
    const double variance = std::max(residual.squaredNorm() / freedom, least * least);
    const Eigen::MatrixXd covariance = variance * inverse(design.transpose() * design);
    fit.speed_std = std::sqrt(covariance(1, 1)) / length;
    if (with_acceleration) fit.acceleration_std = 2.0 * std::sqrt(covariance(2, 2)) / (length * length);
    fit.edge_rms = std::sqrt(residual.squaredNorm() / static_cast<double>(count)) / fit.speed;
  }
  return fit;
}

}  // namespace amb_rotor
