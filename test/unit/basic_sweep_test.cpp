// Sweep files, the grid, periods and regimes on cases with a known answer.
#include "amb_rotor/machine/basic_sweep.hpp"

#include <gtest/gtest.h>

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
