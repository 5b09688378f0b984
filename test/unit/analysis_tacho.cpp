// Tacho pulses to edges, speed and angle. The pulses are made as in the measurement data sets: a ramp of two
// samples, values rounded to 0.001, 15 % of the turn high.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <random>
#include <utility>

#include "amb_rotor/analysis/tacho.hpp"
#include "amb_rotor/common/error.hpp"

namespace amb_rotor {
namespace {

constexpr double step = 1e-4;
// Rounding to 0.001 of a ramp of two samples: 0.0005 * 2e-4 s at most.
constexpr double edge_error = 1.01e-7;

struct Channel {
  std::vector<double> time, value;
};

/// @param angle growing function of time [rad].
Channel channel(double duration, const std::function<double(double)>& angle, double start = 0.0) {
  Channel c;
  for (int i = 0; start + i * step <= start + duration; ++i) {
    const double t = start + i * step;
    const double speed = (angle(t + step) - angle(t - step)) / (2.0 * step);
    const double place = std::remainder(angle(t), 2.0 * M_PI);  // seconds to the nearest edges:
    const double rise = place / speed, fall = std::remainder(angle(t) - 0.3 * M_PI, 2.0 * M_PI) / speed;
    const auto ramp = [](double s) { return std::clamp(0.5 + s / (2.0 * step), 0.0, 1.0); };
    const double turn = angle(t) - 2.0 * M_PI * std::floor(angle(t) / (2.0 * M_PI));
    double value = turn < 0.3 * M_PI ? 1.0 : 0.0;
    if (std::fabs(rise) < step) value = ramp(rise);
    if (std::fabs(fall) < step) value = 1.0 - ramp(fall);
    c.time.push_back(t);
    c.value.push_back(std::round(1000.0 * value) / 1000.0);
  }
  return c;
}

TEST(AnalysisTacho, EdgesBetweenSamples) {
  const double w = 2.0 * M_PI * 155.0532;
  const Channel c = channel(1.0, [w](double t) { return w * t + 1.0; });
  const TachoPulses pulses = findPulses(c.time, c.value);
  EXPECT_EQ(pulses.state, TachoState::turning);
  EXPECT_TRUE(pulses.faults.empty());
  ASSERT_EQ(pulses.time.size(), 155u);
  for (std::size_t k = 0; k < pulses.time.size(); ++k) {
    EXPECT_NEAR(pulses.time[k], (2.0 * M_PI * (k + 1.0) - 1.0) / w, edge_error);
    EXPECT_EQ(pulses.turn[k], static_cast<long>(k));
  }
}

TEST(AnalysisTacho, ConstantSpeedOfTheFirstTurns) {
  const double w = 2.0 * M_PI * 61.096;
  const Channel c = channel(1.0, [w](double t) { return w * t + 0.4; });
  const SpeedFit fit = fitSpeed(findPulses(c.time, c.value), 10);
  ASSERT_TRUE(fit.valid);
  EXPECT_EQ(fit.turns, 10);
  // Edge error 5.8e-8 s rms; slope of 11 points: 5.8e-8 sqrt(12/11^3) w/T ... relative 3.4e-7; four of them.
  EXPECT_NEAR(fit.speed / w, 1.0, 1.4e-6);
  EXPECT_LT(fit.speed_std / w, 1e-6);
  EXPECT_LT(fit.edge_rms, edge_error);
  // Angle by the fit at the first edge and a second later (61 turns: 383 rad times the speed's error).
  const ShaftAngle shaft(fit);
  const double first = (2.0 * M_PI - 0.4) / w;
  EXPECT_NEAR(shaft.angle(first), 0.0, w * edge_error);
  EXPECT_NEAR(shaft.angle(first + 1.0), w, 6e-4);
  EXPECT_NEAR(shaft.speed(0.7), fit.speed, 1e-12);
}

TEST(AnalysisTacho, RoundingThatRepeatsHidesTheError) {
  // 10000/155.0532 samples a turn: ten edges in a row are rounded alike, and scatter by nothing.
  TachoPulses pulses;
  pulses.state = TachoState::turning;
  for (int k = 0; k < 11; ++k) {
    pulses.time.push_back(k * 6.4494e-3);
    pulses.turn.push_back(k);
  }
  EXPECT_LT(fitSpeed(pulses).speed_std, 1e-9);
  const SpeedFit fit = fitSpeed(pulses, 0, false, 5.8e-8);
  // Slope of 11 points: 5.8e-8 s / sqrt(110) a turn, relative to the period.
  EXPECT_NEAR(fit.speed_std / fit.speed, 5.8e-8 / std::sqrt(110.0) / 6.4494e-3, 1e-12);
  EXPECT_THROW(fitSpeed(pulses, 0, false, -1.0), InputError);
}

TEST(AnalysisTacho, RoundingIsToldByFewValues) {
  // six edges: the nearest two of their values are seven steps apart
  const Channel few = channel(0.05, [](double t) { return 2.0 * M_PI * 110.3 * t - 0.4; });
  const TachoPulses pulses = findPulses(few.time, few.value);
  ASSERT_EQ(pulses.time.size(), 6u);
  EXPECT_NEAR(pulses.rounding_s, 0.001 / std::sqrt(12.0) / 0.5 * step, 1e-9);
  std::vector<double> coarse = few.value, exact = few.value;
  for (double& value : coarse) value = std::round(128.0 * value) / 128.0;
  EXPECT_NEAR(findPulses(few.time, coarse).rounding_s, 1.0 / 128.0 / std::sqrt(12.0) / 0.5 * step, 2e-8);
  for (double& value : coarse) value = std::round(1e6 * value) / 1e6;  // as written with six digits
  EXPECT_NEAR(findPulses(few.time, coarse).rounding_s, 1.0 / 128.0 / std::sqrt(12.0) / 0.5 * step, 2e-8);
  for (std::size_t i = 0; i < exact.size(); ++i) exact[i] += 1e-4 * std::sin(12.9898 * static_cast<double>(i));  // noise: no steps
  EXPECT_LT(findPulses(few.time, exact).rounding_s, 5.8e-8);
}

TEST(AnalysisTacho, ScatterIsToldBesideAnyCourse) {
  std::mt19937 dice(3);
  std::normal_distribution<double> normal(0.0, 4e-7);
  TachoPulses pulses;
  pulses.state = TachoState::turning;
  for (int k = 0; k < 400; ++k) {
    const double turns = k + 0.3;
    pulses.time.push_back(turns / 170.0 + 5e-7 * turns * turns);  // 170 Hz that decays by a twentieth
    pulses.turn.push_back(k);
  }
  EXPECT_LT(edgeScatter(pulses), 1e-12);
  for (double& time : pulses.time) time += normal(dice);
  EXPECT_NEAR(edgeScatter(pulses), 4e-7, 0.15 * 4e-7);  // of 397 third differences that hang together by threes
  pulses.turn.back() += 1;  // a lost one
  pulses.time.back() += 1.0 / 170.0;
  EXPECT_NEAR(edgeScatter(pulses), 4e-7, 0.15 * 4e-7);
  pulses.time.resize(3);
  pulses.turn.resize(3);
  EXPECT_EQ(edgeScatter(pulses), 0.0);
}

TEST(AnalysisTacho, DecayingSpeedWithAcceleration) {
  const Channel c = channel(1.0, [](double t) { return 600.0 * t - 10.0 * t * t; });
  const SpeedFit fit = fitSpeed(findPulses(c.time, c.value), 0, true);
  ASSERT_TRUE(fit.valid);
  // 92 edges over 1 s: standard error of the curvature w 5.8e-8 sqrt(720/92) = 1e-4 rad/s^2; five of them,
  // and as much for the speed.
  EXPECT_NEAR(fit.acceleration, -20.0, 5e-4);
  EXPECT_NEAR(fit.speed, 600.0 - 20.0 * fit.reference_time, 5e-4);
  EXPECT_NEAR(fit.acceleration_std, 1e-4, 7e-5);
}

TEST(AnalysisTacho, SplineOfARunUp) {
  // 38 to 168 Hz in 1.2 s, as steep as the data sets', and curved.
  const auto angle = [](double t) { return 2.0 * M_PI * (38.0 * t + 45.0 * t * t + 6.0 * t * t * t); };
  const Channel c = channel(1.2, angle);
  const TachoPulses pulses = findPulses(c.time, c.value);
  EXPECT_TRUE(pulses.faults.empty());
  const ShaftAngle shaft(pulses);
  ASSERT_TRUE(shaft.angleKnown());
  const double zero = 2.0 * M_PI * std::round(angle(pulses.time[0]) / (2.0 * M_PI));
  double worst_angle = 0.0, worst_speed = 0.0;
  for (double t : c.time) {
    const double speed = 2.0 * M_PI * (38.0 + 90.0 * t + 18.0 * t * t);
    if (t < pulses.time.front() || t > pulses.time.back()) continue;
    worst_angle = std::max(worst_angle, std::fabs(shaft.angle(t) + zero - angle(t)));
    worst_speed = std::max(worst_speed, std::fabs(shaft.speed(t) - speed));
  }
  // A cubic is met by a cubic spline: only the edges' error (1e-7 s at 1055 rad/s, a little more between the
  // knots) is left; the speed's is that over a period, times about 3.
  EXPECT_LT(worst_angle, 2.0 * 1055.0 * edge_error);
  EXPECT_LT(worst_speed, 3.0 * 1055.0 * edge_error * 168.0 * 2.0);
  // Half a turn beyond the ends.
  const double end = pulses.time.back() + 0.003;
  EXPECT_NEAR(shaft.angle(end) + zero, angle(end), 2e-3);
  EXPECT_NEAR(shaft.angle(pulses.time.front() - 0.01) + zero, angle(pulses.time.front() - 0.01), 2e-3);
  // Continuous value and slope at a knot.
  const double knot = pulses.time[10];
  EXPECT_NEAR(shaft.angle(knot - 1e-12), shaft.angle(knot + 1e-12), 1e-8);
  EXPECT_NEAR(shaft.speed(knot - 1e-12), shaft.speed(knot + 1e-12), 1e-6);
  EXPECT_NEAR(shaft.acceleration(knot - 1e-12), shaft.acceleration(knot + 1e-12), 1e-3);
}

/// 1 in the first 15 % of a turn, else 0.
Channel twoLevels(double duration, const std::function<double(double)>& angle) {
  Channel c;
  for (int i = 0; i * step <= duration; ++i) {
    const double turn = angle(i * step) / (2.0 * M_PI);
    c.time.push_back(i * step);
    c.value.push_back(turn - std::floor(turn) < 0.15 ? 1.0 : 0.0);
  }
  return c;
}

/// The largest and the rms difference of the shaft found from the one that made the pulses, between the first and the last [rad].
std::pair<double, double> offAngle(const TachoPulses& pulses, const std::function<double(double)>& angle) {
  const ShaftAngle shaft(pulses);
  const double zero = 2.0 * M_PI * std::ceil(angle(0.0) / (2.0 * M_PI));  // the angle at the first edge
  double largest = 0.0, squares = 0.0;
  constexpr int places = 1000;
  for (int i = 0; i < places; ++i) {
    const double t = pulses.time.front() + (pulses.time.back() - pulses.time.front()) * i / (places - 1.0);
    const double off = shaft.angle(t) + zero - angle(t);
    largest = std::max(largest, std::fabs(off));
    squares += off * off / places;
  }
  return {largest, std::sqrt(squares)};
}

TEST(AnalysisTacho, EdgesOfTwoLevelsAreSmoothed) {
  // 40 to 160 Hz in 1.5 s, 150 turns. A single edge is known to half a sample: 0.05 rad at 160 Hz, 0.018 rad rms over all. The
  // three numbers of a parabola leave sqrt(3/150) of that in the mean, 0.0026 rad, and three times as much at its ends.
  const auto ramp = [](double t) { return 2.0 * M_PI * (40.0 * t + 40.0 * t * t) + 0.7; };
  const Channel c = twoLevels(1.5, ramp);
  TachoPulses pulses = findPulses(c.time, c.value);
  EXPECT_NEAR(pulses.half_width_s, 0.5 * step, 1e-12);
  const auto [largest, rms] = offAngle(pulses, ramp);
  EXPECT_LT(largest, 0.012);
  EXPECT_LT(rms, 0.005);
  pulses.half_width_s = 0.0;  // as if each edge were exact
  EXPECT_GT(offAngle(pulses, ramp).second, 0.015);
}

TEST(AnalysisTacho, SmoothedEdgesFollowASpeedThatBends) {
  // held at 50 Hz for 0.5 s, then raised to 150 Hz along half a cosine, then held: no parabola
  const auto speed_share = [](double t) { return t < 0.5 ? 0.0 : t > 1.5 ? 1.0 : 0.5 - 0.5 * std::cos(M_PI * (t - 0.5)); };
  double turns = 0.1, before = 0.0;
  std::vector<double> at = {turns};
  for (int i = 1; i <= 200000; ++i) {  // 10 us
    const double now = speed_share(i * 1e-5);
    turns += 1e-5 * (50.0 + 50.0 * (now + before));
    before = now;
    at.push_back(turns);
  }
  const auto angle = [&](double t) {
    const double place = std::clamp(t / 1e-5, 0.0, 199999.0);
    const std::size_t i = static_cast<std::size_t>(place);
    return 2.0 * M_PI * (at[i] + (place - static_cast<double>(i)) * (at[i + 1] - at[i]));
  };
  const Channel c = twoLevels(1.999, angle);
  TachoPulses pulses = findPulses(c.time, c.value);
  // some twenty unknowns for 200 edges: a third of the spline's error, and what the pieces cannot follow, below that of an edge
  const double smoothed = offAngle(pulses, angle).second;
  pulses.half_width_s = 0.0;
  const double spline = offAngle(pulses, angle).second;
  EXPECT_GT(spline, 0.015);
  EXPECT_LT(smoothed, 0.6 * spline);
}

TEST(AnalysisTacho, LevelsBetweenTellAnEdgeClosely) {
  const double w = 2.0 * M_PI * 155.0532;
  const Channel c = channel(1.0, [w](double t) { return w * t + 1.0; });
  EXPECT_EQ(findPulses(c.time, c.value).half_width_s, 0.0);
}

TEST(AnalysisTacho, SplineOfExactKnotsReproducesACubic) {
  TachoPulses pulses;
  pulses.state = TachoState::turning;
  // Times at which 2 pi k = 2 pi (t + 0.1 t^3): knots of any spacing, found by Newton to round-off.
  for (int k = 0; k < 8; ++k) {
    double t = k;
    for (int i = 0; i < 50; ++i) t -= (t + 0.1 * t * t * t - k) / (1.0 + 0.3 * t * t);
    pulses.time.push_back(t);
    pulses.turn.push_back(k);
  }
  const ShaftAngle shaft(pulses);
  for (double t = 0.0; t < pulses.time.back(); t += 0.01) {
    EXPECT_NEAR(shaft.angle(t), 2.0 * M_PI * (t + 0.1 * t * t * t), 1e-12);
  }
}

TEST(AnalysisTacho, Standstill) {
  for (double value : {0.0, 1.0}) {
    const std::vector<double> time = {0, step, 2 * step, 3 * step}, signal(4, value);
    const TachoPulses pulses = findPulses(time, signal);
    EXPECT_EQ(pulses.state, TachoState::standstill);
    EXPECT_FALSE(fitSpeed(pulses).valid);
    const ShaftAngle shaft(pulses);
    EXPECT_FALSE(shaft.angleKnown());
    EXPECT_EQ(shaft.angle(1.0), 0.0);
    EXPECT_EQ(shaft.speed(1.0), 0.0);
    EXPECT_FALSE(ShaftAngle(fitSpeed(pulses)).angleKnown());
  }
  // One edge: it turns, but how fast is unknown.
  EXPECT_EQ(findPulses({0, 1, 2}, {0.0, 0.0, 1.0}).state, TachoState::too_few);
  EXPECT_EQ(findPulses({}, {}).state, TachoState::standstill);
}

TEST(AnalysisTacho, MissingDoubleAndLostPulsesAreReported) {
  std::vector<double> edges;
  for (int k = 0; k < 40; ++k) edges.push_back(0.01 * k * (1.0 - 0.003 * k));  // speeding up by 30 %
  const std::vector<double> clean = edges;
  edges.erase(edges.begin() + 20, edges.begin() + 22);               // pulses 20 and 21 are missing
  edges.insert(edges.begin() + 6, 0.7 * clean[5] + 0.3 * clean[6]);  // one too many after pulse 5
  edges.erase(edges.begin() + 1 + 1);                                // pulse 2, near the start
  const TachoPulses pulses = numberPulses(edges);
  ASSERT_EQ(pulses.time.size(), 37u);
  for (std::size_t i = 0; i < pulses.time.size(); ++i) {
    EXPECT_EQ(pulses.time[i], clean[static_cast<std::size_t>(pulses.turn[i])]);
  }
  int missing = 0, twice = 0, other = 0;
  for (const TachoFault& fault : pulses.faults) {
    if (fault.kind == TachoFaultKind::missing_pulse) {
      missing += fault.count;
    } else if (fault.kind == TachoFaultKind::double_pulse) {
      twice += fault.count;
    } else {
      ++other;
    }
    EXPECT_FALSE(fault.text().empty());
  }
  EXPECT_EQ(missing, 3);
  EXPECT_EQ(twice, 1);
  EXPECT_EQ(other, 0);
}

TEST(AnalysisTacho, CleanRunUpFromSlowSpeedHasNoFaults) {
  std::vector<double> edges;  // theta = 0.5 a t^2 from turn 3 on: periods fall by 13 % a turn at first
  for (int k = 3; k < 60; ++k) edges.push_back(std::sqrt(2.0 * k / 100.0));
  EXPECT_TRUE(numberPulses(edges).faults.empty());
}

TEST(AnalysisTacho, DropoutsAreReportedAndBridged) {
  const double w = 2.0 * M_PI * 50.0;
  Channel c = channel(1.0, [w](double t) { return w * t + 1.0; });
  const double first = (2.0 * M_PI - 1.0) / w;
  // NaN over the edge of turn 10; a hole in the record over turn 20's.
  const auto at = [&](double t) { return static_cast<std::ptrdiff_t>(std::lround(t / step)); };
  for (auto i = at(first + 0.2) - 5; i < at(first + 0.2) + 5; ++i) {
    c.value[static_cast<std::size_t>(i)] = std::numeric_limits<double>::quiet_NaN();
  }
  const auto hole = at(first + 0.4);
  c.time.erase(c.time.begin() + hole - 40, c.time.begin() + hole + 40);
  c.value.erase(c.value.begin() + hole - 40, c.value.begin() + hole + 40);
  const TachoPulses pulses = findPulses(c.time, c.value);
  ASSERT_EQ(pulses.time.size(), 48u);
  EXPECT_EQ(pulses.turn.back(), 49);
  int lost = 0;
  for (const TachoFault& fault : pulses.faults)
    lost += fault.kind == TachoFaultKind::dropout ? fault.count : 0;
  EXPECT_EQ(lost, 10 + 80);
  const ShaftAngle shaft(pulses);
  EXPECT_NEAR(shaft.angle(first + 0.2), 2.0 * M_PI * 10.0, 2.0 * w * edge_error);
}

TEST(AnalysisTacho, HysteresisAgainstNoise) {
  // The value trembles about the threshold on its way up: one edge.
  const std::vector<double> time = {0, 1, 2, 3, 4, 5, 6}, value = {0.0, 0.45, 0.55, 0.45, 0.55, 1.0, 1.0};
  EdgeDetector detector;
  int edges = 0;
  for (std::size_t i = 0; i < time.size(); ++i) edges += detector.add(time[i], value[i]).has_value();
  EXPECT_EQ(edges, 1);
  EXPECT_NEAR(
      *[] {
        EdgeDetector d;
        d.add(0.0, 0.0);
        return d.add(1.0, 0.8);
      }(),
      0.625, 1e-15);
  TachoOptions bad;
  bad.hysteresis = -1.0;
  EXPECT_THROW(EdgeDetector{bad}, InputError);
}

}  // namespace
}  // namespace amb_rotor
