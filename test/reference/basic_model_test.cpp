// The basic model against an end state that was computed elsewhere.
#include <gtest/gtest.h>

#include "amb_rotor/machine/basic_lanes.hpp"

namespace amb_rotor {
namespace {

/// 300 forcing periods in rub: centred bearing, unbalance phase 0, friction mu N against the positive spin,
/// not regularised, from (1, 0) at rest. The end state is SciPy's DOP853 at tolerance 1e-13, to 8 digits.
BasicParameters<double> rubbing() {
  BasicParameters<double> p;
  p.frequency_ratio = 1.05;
  p.damping = 0.0347;
  p.eccentricity = 0.0973;
  p.contact_stiffness = 13.68;
  p.friction = 0.015;
  return p;
}
constexpr double end_x = 0.94156385;
constexpr double end_y = -0.37870998;

BasicState<double> endState(const std::string& set, int steps) {
  BasicLaneOptions options;
  options.steps_per_turn = steps;
  options.turns_skipped = 300;
  options.turns_kept = 0;
  options.instruction_set = set;
  return runBasicLanes({rubbing()}, {{1.0, 0.0, 0.0, 0.0}}, options).end.front();
}

TEST(BasicModelReference, LanesReachTheEndStateOfDop853) {
  for (const std::string& set : basicInstructionSets()) {
    const auto end = endState(set, 200);
    // Plain RK4 with 200 steps a period is known to end 3.5e-6 away; a wrong term ends 1e-2 away.
    EXPECT_NEAR(end.x, end_x, 4e-6) << set;
    EXPECT_NEAR(end.y, end_y, 4e-6) << set;
  }
}

TEST(BasicModelReference, FinerLanesReachTheEndStateToItsDigits) {
  const auto end = endState("", 6400);
  // Steps that straddle an event leave an error of order 2 to 3 in the step (the motion bounces, so there
  // are about 1000 events): 1.6e-8 at 1600 steps, 1e-9 or less here. The reference has half a digit, 5e-9.
  EXPECT_NEAR(end.x, end_x, 6e-9);
  EXPECT_NEAR(end.y, end_y, 6e-9);
}

TEST(BasicModelReference, ReversedFrictionEndsElsewhere) {
  BasicParameters<double> p = rubbing();
  p.friction_sign = -1.0;
  BasicLaneOptions options;
  options.turns_skipped = 300;
  options.turns_kept = 0;
  const auto end = runBasicLanes({p}, {{1.0, 0.0, 0.0, 0.0}}, options).end.front();
  EXPECT_GT(std::hypot(end.x - end_x, end.y - end_y), 1e-2);
}

}  // namespace
}  // namespace amb_rotor
