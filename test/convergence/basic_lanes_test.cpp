// The lanes against the event-accurate motion of the basic model.
#include <gtest/gtest.h>

#include <cmath>

#include "amb_rotor/machine/basic_orbit.hpp"
#include "amb_rotor/machine/basic_regime.hpp"

namespace amb_rotor {
namespace {

BasicParameters<double> displaced(double eta) {
  BasicParameters<double> p;
  p.frequency_ratio = eta;
  p.misalignment_x = 0.65;
  return p;
}

double distance(const BasicState<double>& a, const BasicState<double>& b) {
  return std::hypot(std::hypot(a.x - b.x, a.y - b.y), std::hypot(a.vx - b.vx, a.vy - b.vy));
}

BasicState<double> lanesEnd(const BasicParameters<double>& p, const BasicLaneOptions& options,
                            const BasicState<double>& start) {
  return runBasicLanes({p}, {start}, options).end.front();
}

TEST(BasicLanesConvergence, OrderFourWithoutContact) {
  BasicParameters<double> p;
  p.frequency_ratio = 1.4;
  p.eccentricity = 0.02;
  BasicOrbitOptions reference;
  reference.tolerance = 1e-13;
  const BasicState<double> start{0.3, 0.1, 0.0, 0.2};
  const auto exact = advanceBasic(p, start, 10, reference).end;
  BasicLaneOptions options;
  options.turns_skipped = 10;
  options.turns_kept = 0;
  double before = 0.0;
  for (int steps : {80, 160, 320}) {
    options.steps_per_turn = steps;
    const double error = distance(lanesEnd(p, options, start), exact);
    // Halving the step divides the error by 16; 15 leaves room for the next order (5 % at 80 steps).
    if (before > 0.0) {
      EXPECT_GT(before / error, 15.0) << steps;
    }
    before = error;
  }
}

TEST(BasicLanesConvergence, SectionWithinAThousandthAtTheCoarsestStepAllowed) {
  BasicOrbitOptions reference;
  for (double eta : {0.9, 1.0, 1.05, 1.1}) {  // periodic motions: errors do not grow
    const auto p = displaced(eta);
    BasicLaneOptions options;
    options.steps_per_turn = requiredBasicSteps(p, options.contact);
    options.turns_skipped = 50;
    options.turns_kept = 0;
    // From the settled motion: a chaotic transient may end in the other phase of a motion of period 2.
    const auto settled = advanceBasic(p, {}, 400, reference);
    const auto exact = advanceBasic(p, settled.end, 50, reference);
    const auto end = lanesEnd(p, options, settled.end);
    ASSERT_TRUE(exact.finite);
    EXPECT_LT(std::hypot(end.x - exact.end.x, end.y - exact.end.y), 1e-3) << eta;
  }
}

TEST(BasicLanesConvergence, AllInstructionSetsAgree) {
  const auto p = displaced(1.05);
  BasicLaneOptions options;
  options.turns_skipped = 100;
  options.turns_kept = 0;
  options.instruction_set = "baseline";
  const auto baseline = lanesEnd(p, options, {});
  for (const auto& set : basicInstructionSets()) {
    options.instruction_set = set;
    // The same arithmetic but for fused multiply-adds: round-off over 20000 steps of a stable motion.
    EXPECT_LT(distance(lanesEnd(p, options, {}), baseline), 1e-10) << set;
  }
}

TEST(BasicLanesConvergence, UnbalancePhaseTurnsTheWholePicture) {
  auto p = displaced(1.05);
  BasicLaneOptions options;
  options.turns_skipped = 50;
  options.turns_kept = 0;
  const auto plain = lanesEnd(p, options, {0.2, 0.0, 0.0, 0.1});
  const double angle = 0.7;
  p.unbalance_phase = angle;
  const auto centre = rotated({0.65, 0.0, 0.0, 0.0}, angle);
  p.misalignment_x = centre.x;
  p.misalignment_y = centre.y;
  const auto turned = lanesEnd(p, options, rotated({0.2, 0.0, 0.0, 0.1}, angle));
  EXPECT_LT(distance(turned, rotated(plain, angle)), 1e-9);  // round-off over 10000 steps
}

TEST(BasicLanes, TooCoarseAStepIsRefusedWithTheOneThatWouldDo) {
  const auto p = displaced(0.6);
  BasicLaneOptions options;
  options.steps_per_turn = 60;
  try {
    runBasicLanes({p}, {{}}, options);
    FAIL() << "60 steps a turn were accepted";
  } catch (const InputError& error) {
    const std::string needed = std::to_string(requiredBasicSteps(p, options.contact));
    EXPECT_NE(std::string(error.what()).find(needed), std::string::npos) << error.what();
  }
}

TEST(BasicLanes, LyapunovExponentIsTheFloquetExponentOfAPeriodicMotion) {
  // Without contact the largest multiplier of a turn is exp(-d/2 * 2 pi/eta).
  BasicParameters<double> p;
  p.frequency_ratio = 0.7;
  p.eccentricity = 0.01;
  BasicLaneOptions options;
  options.lyapunov = true;
  options.turns_skipped = 100;
  options.turns_kept = 400;
  const auto result = runBasicLanes({p}, {{}}, options);
  const double expected = -0.5 * 0.0347 * 2.0 * M_PI / 0.7;
  // The tangent turns as it shrinks: its length is that of an ellipse, a bounded factor, over 400 turns.
  EXPECT_NEAR(result.lyapunov.front(), expected, 1.0 / 400);
  EXPECT_EQ(basicMotions(result).front().regime, Regime::no_contact);
}

TEST(BasicOrbit, DerivativesAreThoseOfDifferences) {
  auto p = displaced(1.05);
  BasicOrbitOptions options;
  options.tolerance = 1e-12;
  BasicParameters<double> direction;
  BasicParameters<double>::visit(direction, [](const char*, double& field) { field = 0.0; });
  direction.frequency_ratio = 1.0;
  options.direction = direction;
  const BasicState<double> start{0.1, -0.2, 0.3, 0.1};
  const auto orbit = basicOrbit(p, start, 2, options);
  ASSERT_GT(orbit.touch_downs, 0) << "the test is about events";
  const double h = 1e-6;
  for (int j = 0; j < 5; ++j) {
    Eigen::Vector4d q = phaseUnits(start, 1.05), ends[2];
    for (int side = 0; side < 2; ++side) {
      const double shift = side ? h : -h;
      auto machine = p;
      Eigen::Vector4d moved = q;
      if (j < 4) moved[j] += shift;
      if (j == 4) machine.frequency_ratio += shift;
      ends[side] =
          phaseUnits(advanceBasic(machine, timeUnits(moved, machine.frequency_ratio), 2, options).end,
                     machine.frequency_ratio);
    }
    const Eigen::Vector4d difference = (ends[1] - ends[0]) / (2.0 * h);
    const Eigen::Vector4d column = j < 4 ? Eigen::Vector4d(orbit.monodromy.col(j)) : orbit.by_parameter;
    // Central differences: tolerance / h = 1e-6, times the growth along the orbit.
    EXPECT_LT((difference - column).norm(), 2e-5 * (1.0 + column.norm())) << j;
  }
}

TEST(BasicOrbit, NothingJumpsAtAContactEvent) {
  const auto p = displaced(1.05);
  const BasicState<double> touching{1.65, 0.0, 0.4, 0.2};  // on the clearance
  for (auto contact : {BasicContact::linear, BasicContact::hertz}) {
    BasicOrbitOptions options;
    options.contact = contact;
    auto machine = p;
    machine.hertz_stiffness = 16.8;
    machine.hertz_damping = 1.3;
    // The force is 0 at the clearance: what is left is the round-off of r - 1 times the stiffness.
    EXPECT_LT(saltationJump(machine, touching, 0.3, options).norm(), 1e-13);
  }
}

}  // namespace
}  // namespace amb_rotor
