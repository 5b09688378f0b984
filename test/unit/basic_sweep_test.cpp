// Sweep files, the grid, periods and regimes on cases with a known answer.
#include "amb_rotor/machine/basic_sweep.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <fstream>

namespace amb_rotor {
namespace {

std::string fileWith(const std::string& text) {
  const std::string path = testing::TempDir() + "sweep_test.yaml";
  std::ofstream(path) << text;
  return path;
}

const char* const valid = R"(format: amb-sweep/1
name: a
title: a
source: a test
machine: basic
contact: linear
friction_law: spin
parameters: {damping: 0.0347, support_stiffness: 1.0, eccentricity: 0.0973, contact_stiffness: 13.68,
             friction_sign: 1, misalignment: 0.5, misalignment_angle_deg: 90, unbalance_phase_deg: 0}
initial: {x: 0, y: 0, vx: 0, vy: 0}
swept:
  - {parameter: friction, values: [0.0, 0.1]}
  - {parameter: frequency_ratio, from: 0.7, to: 1.0, step: 0.1}
run: {turns: 200, kept_turns: 50, steps_per_turn: 200}
)";

std::string changed(const std::string& from, const std::string& to) {
  std::string text = valid;
  text.replace(text.find(from), from.size(), to);
  return text;
}

void expectFault(const std::string& text, const std::string& part) {
  try {
    readBasicSweep(fileWith(text));
    FAIL() << "accepted, though: " << part;
  } catch (const InputError& error) {
    EXPECT_NE(std::string(error.what()).find(part), std::string::npos) << error.what();
  }
}

TEST(BasicSweepFile, GivesTheGridWithTheLastAxisFastest) {
  const auto sweep = readBasicSweep(fileWith(valid));
  ASSERT_EQ(sweep.size(), 8u);  // 0.7, 0.8, 0.9, 1.0 by two frictions: the last step rounds to its end
  EXPECT_EQ(sweep.valuesAt(5)[0], 0.1);
  EXPECT_NEAR(sweep.valuesAt(5)[1], 0.8, 1e-15);
  const auto machine = sweep.machineAt(5);
  EXPECT_EQ(machine.friction, 0.1);
  EXPECT_NEAR(machine.misalignment_y, 0.5, 1e-15);
  EXPECT_NEAR(machine.misalignment_x, 0.0, 1e-15);
}

TEST(BasicSweepFile, FaultsAreNamed) {
  expectFault(changed("damping: 0.0347, ", ""), "parameters.damping: the key is missing");
  expectFault(changed("damping: 0.0347", "damping: -1.0"), "parameters.damping");
  expectFault(changed("parameter: friction,", "parameter: frictoin,"), "nearest: friction");
  expectFault(changed("friction_sign: 1,", "friction_sign: 1, friction: 0.1,"), "is swept");
  expectFault(changed("friction_sign: 1,", "friction_sign: 1, hertz_damping: 0.1,"), "not known here");
  expectFault(changed("kept_turns: 50", "kept_turns: 500"), "at most `turns`");
  expectFault(changed("step: 0.1", "step: -0.1"), "must lead from");
  expectFault(changed("steps_per_turn: 200", "steps_per_turn: 20"), "too coarse for the contact");
  expectFault(changed("amb-sweep/1", "amb-sweep/9"), "format");
}

TEST(BasicSweepFile, EveryLineOfAFaultIsThatOfItsKey) {
  try {
    readBasicSweep(fileWith(changed("turns: 200,", "turns: 1.5,")));
    FAIL();
  } catch (const InputError& error) {
    EXPECT_EQ(error.faults().front().line, 14) << error.what();
  }
}

TEST(BasicSweep, PartsOfTheGridAreTheWhole) {
  const auto sweep = readBasicSweep(fileWith(valid));
  const auto whole = runBasicSweep(sweep, 0, 8);
  const auto part = runBasicSweep(sweep, 3, 4);
  for (std::size_t i = 0; i < 4; ++i) {
    // A lane does not know its neighbours: the same bits.
    EXPECT_EQ(part.lanes.end[i].x, whole.lanes.end[i + 3].x);
    EXPECT_EQ(part.motions[i].regime, whole.motions[i + 3].regime);
  }
}

TEST(BasicSweep, AWiderBearingIsTheSameMachineWithAnotherClearance) {
  // (5.6) with Hertz contact and sliding friction in the file's lengths, clearance c = 1.5, by a Runge-Kutta
  // of its own: nothing here is over the clearance.
  const double c = 1.5, eta = 0.9, d = 0.1, e = 0.4, kappa = 20.0, a = 0.3, mu = 0.1, rho = 30.0, v0 = 0.2,
               xs = 0.6;
  const NamedValues values = {
      {"frequency_ratio", eta},     {"damping", d},   {"eccentricity", e},     {"hertz_stiffness", kappa},
      {"hertz_damping", a},         {"friction", mu}, {"surface_radius", rho}, {"misalignment", xs},
      {"regularisation_speed", v0}, {"clearance", c}};
  using Four = std::array<double, 4>;
  const auto rate = [&](double t, const Four& q) {
    const double u = q[0] - xs, v = q[1], r = std::hypot(u, v), depth = r - c;
    Four f{q[2], q[3], eta * eta * e * std::cos(eta * t) - d * q[2] - q[0],
           eta * eta * e * std::sin(eta * t) - d * q[3] - q[1]};
    if (depth > 0.0) {
      const double n =
          kappa * std::pow(depth, 1.5) * std::max(0.0, 1.0 + 1.5 * a * (u * q[2] + v * q[3]) / r);
      const double s = mu * std::tanh((eta * rho + (u * q[3] - v * q[2]) / r) / v0);
      f[2] -= n * (u - s * v) / r;
      f[3] -= n * (v + s * u) / r;
    }
    return f;
  };
  Four q{0.3, 0.0, 0.0, 0.5};
  const int steps = 60000, turns = 3;
  const double h = 2.0 * 3.14159265358979323846 * turns / (eta * steps);
  const auto plus = [](const Four& x, double f, const Four& y) {
    return Four{x[0] + f * y[0], x[1] + f * y[1], x[2] + f * y[2], x[3] + f * y[3]};
  };
  double furthest = 0.0;
  for (int i = 0; i < steps; ++i) {
    const double t = i * h;
    const Four k1 = rate(t, q), k2 = rate(t + h / 2, plus(q, h / 2, k1)),
               k3 = rate(t + h / 2, plus(q, h / 2, k2)), k4 = rate(t + h, plus(q, h, k3));
    q = plus(plus(plus(plus(q, h / 6, k1), h / 3, k2), h / 3, k3), h / 6, k4);
    furthest = std::max(furthest, std::hypot(q[0] - xs, q[1]));
  }
  ASSERT_GT(furthest, 1.02 * c) << "it must touch";
  BasicLaneOptions run;
  run.contact = BasicContact::hertz;
  run.friction = BasicFriction::sliding;
  run.steps_per_turn = 4000;
  run.turns_skipped = turns;
  run.turns_kept = 0;
  const auto end =
      runBasicLanes({basicParametersFrom(values)}, {overOwnClearance({0.3, 0.0, 0.0, 0.5}, values)}, run)
          .end.front();
  // 4000 steps a turn, order 4 but for the steps of the contact's ends: 1e-6.
  EXPECT_NEAR(c * end.x, q[0], 1e-5);
  EXPECT_NEAR(c * end.y, q[1], 1e-5);
  EXPECT_NEAR(c * end.vx, q[2], 1e-5);
}

TEST(BasicSweepFile, TheClearanceIsSweptOverTheFilesOwn) {
  std::string text = changed("friction, values: [0.0, 0.1]", "clearance, values: [1.0, 2.0]");
  text.replace(text.find("friction_sign: 1,"), 17, "friction_sign: 1, friction: 0.1,");
  text.replace(text.find("{x: 0,"), 6, "{x: 1,");
  const auto sweep = readBasicSweep(fileWith(text));
  EXPECT_EQ(sweep.machineAt(0).eccentricity, 0.0973);
  EXPECT_EQ(sweep.machineAt(4).eccentricity, 0.0973 / 2.0);
  EXPECT_EQ(sweep.machineAt(4).misalignment_y, 0.25);
  EXPECT_EQ(sweep.initialAt(4).x, 0.5);
  text.replace(text.find("[1.0, 2.0]"), 10, "[1.0, 0.0]");
  expectFault(text, "parameters.clearance");
}

std::vector<BasicState<double>> logistic(double r, int turns) {
  std::vector<BasicState<double>> points;
  double x = 0.4;
  for (int i = 0; i < 2000 + turns; ++i) {
    x = r * x * (1.0 - x);
    if (i >= 2000) points.push_back({x, 0.0, 0.0, 0.0});
  }
  return points;
}

TEST(BasicRegime, PeriodsOfTheLogisticMap) {
  // Published: period 1 to 3, 2 to 3.449, 4 to 3.544, 8 to 3.564, period 3 at 3.83, chaos at 3.9.
  const std::pair<double, int> cases[] = {{2.9, 1}, {3.2, 2}, {3.5, 4}, {3.55, 8}, {3.83, 3}, {3.9, 0}};
  for (const auto& [r, period] : cases) {
    const auto points = logistic(r, 100);
    EXPECT_EQ(basicPeriod(points.data(), 100), period) << r;
  }
}

TEST(BasicRegime, SlowDriftRoundAClosedCurveIsNoPeriod) {
  // A turn moves the point by 0.9e-3 of the clearance, below the tolerance, but 100 turns by 0.087.
  std::vector<BasicState<double>> drift, still;
  for (int i = 0; i < 100; ++i) {
    const double angle = 0.9e-2 * i;
    drift.push_back({0.1 * std::cos(angle), 0.1 * std::sin(angle), 0.0, 0.0});
    still.push_back({0.1 + (i % 3) * 0.05, 0.0, 0.0, 0.0});
  }
  EXPECT_EQ(basicPeriod(drift.data(), 100), 0);
  EXPECT_EQ(basicPeriod(still.data(), 100), 3);
}

BasicMotion motionOf(const BasicParameters<double>& p, const BasicState<double>& start, int turns,
                     BasicFriction friction = BasicFriction::spin) {
  BasicLaneOptions options;
  options.lyapunov = true;
  options.friction = friction;
  options.steps_per_turn = 400;
  options.turns_skipped = turns;
  options.turns_kept = 100;
  return basicMotions(runBasicLanes({p}, {start}, options)).front();
}

TEST(BasicRegime, KnownMotionsGetTheirNames) {
  BasicParameters<double> p;
  p.frequency_ratio = 0.7;
  EXPECT_EQ(motionOf(p, {}, 400).regime, Regime::no_contact);

  p.frequency_ratio = 1.05;
  EXPECT_EQ(motionOf(p, {1.0, 0.0, 0.0, 0.0}, 2000).regime, Regime::full_annular_rub);

  p.misalignment_x = 0.65;
  const auto doubled = motionOf(p, {}, 1000);
  EXPECT_EQ(doubled.regime, Regime::period);
  EXPECT_EQ(doubled.period, 2);

  p.frequency_ratio = 1.25;
  EXPECT_EQ(motionOf(p, {}, 1000).regime, Regime::chaotic);
}

TEST(BasicRegime, FrictionWithoutLimitDivergesAndSlidingFrictionRolls) {
  BasicParameters<double> p;
  p.frequency_ratio = 1.05;
  p.friction = 0.3;  // far above the border 0.021
  EXPECT_EQ(motionOf(p, {1.0, 0.0, 0.0, -2.0}, 400).regime, Regime::diverged);
  p.surface_radius = 3.0;  // so that rolling is slow enough for the linear contact
  p.regularisation_speed = 0.05;
  EXPECT_EQ(motionOf(p, {1.0, 0.0, 0.0, -2.0}, 400, BasicFriction::sliding).regime, Regime::dry_whirl);
}

}  // namespace
}  // namespace amb_rotor
