// Branches of periodic motion against closed forms.
#include "amb_rotor/machine/basic_continuation.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "amb_rotor/machine/basic_annular_rub.hpp"

namespace amb_rotor {
namespace {

const Bifurcation* first(const Branch& branch, BifurcationKind kind) {
  for (const auto& found : branch.bifurcations) {
    if (found.kind == kind) return &found;
  }
  return nullptr;
}

TEST(Continuation, FollowsTheAnnularRubRoundItsFold) {
  ContinuationProblem problem;
  problem.parameter = "frequency_ratio";
  ContinuationOptions options;
  options.from = 1.0;
  options.to = 4.0;
  const auto start = problem.machineAt(1.5);
  const Branch branch =
      followBranch(problem, options, 1.5, annularRubState(start, annularRubRadii(start).back()), 1);
  const auto* fold = first(branch, BifurcationKind::fold);
  ASSERT_NE(fold, nullptr) << branch.ended;
  const auto folds = annularRubFolds(start, 1.0, 4.0);
  ASSERT_FALSE(folds.empty());
  // The parameter is stationary at a fold: bisection of the arc to 1e-9 leaves round-off of the tangent.
  EXPECT_NEAR(fold->at.parameter, folds.back(), 1e-6);
  for (const auto& point : branch.points) {
    // Until the rub loses contact the branch is the closed form's.
    if (point.contact_fraction < 0.9999) continue;
    const auto machine = problem.machineAt(point.parameter);
    const double radius = std::hypot(point.state.x, point.state.y);
    double nearest = 1.0;
    for (double r : annularRubRadii(machine)) nearest = std::min(nearest, std::abs(r - radius));
    EXPECT_LT(nearest, 1e-7) << point.parameter;
    EXPECT_EQ(point.stable, annularRubStable(machine, radius)) << point.parameter;
  }
}

TEST(Continuation, FindsTheBorderOfStabilityInTheFriction) {
  ContinuationProblem problem;
  problem.parameter = "friction";
  problem.parameters = {{"frequency_ratio", 1.05}};
  ContinuationOptions options;
  options.from = 0.0;
  options.to = 0.04;
  const auto start = problem.machineAt(0.01);
  const Branch branch =
      followBranch(problem, options, 0.01, annularRubState(start, annularRubRadii(start).back()), 1);
  const auto* border = first(branch, BifurcationKind::neimark_sacker);
  ASSERT_NE(border, nullptr) << branch.ended;
  // The multiplier's modulus is known to the orbit's tolerance 1e-10, its rate over the friction is near 1.
  EXPECT_NEAR(border->at.parameter, annularRubFrictionBorder(start), 1e-6);
}

TEST(Continuation, GrazingIsWhereTheFreeMotionReachesTheClearance) {
  ContinuationProblem problem;
  problem.parameter = "eccentricity";
  problem.parameters = {{"frequency_ratio", 0.8}, {"misalignment", 0.3}};
  ContinuationOptions options;
  options.from = 0.0;
  options.to = 1.0;
  const double gain = 0.64 / std::abs(std::complex<double>(1.0 - 0.64, 0.0347 * 0.8));
  const auto machine = problem.machineAt(0.1);
  BasicLaneOptions run;
  run.turns_skipped = 400;
  run.turns_kept = 0;
  const Branch branch =
      followBranch(problem, options, 0.1, runBasicLanes({machine}, {{}}, run).end.front(), 1);
  const auto* grazing = first(branch, BifurcationKind::grazing);
  ASSERT_NE(grazing, nullptr) << branch.ended;
  // The free orbit is a circle of radius gain * e about 0; it touches where gain * e + 0.3 = 1. Penetrations
  // below the orbit's resolution of turning points are passed over: (1e-6)^(1/1).
  EXPECT_NEAR(grazing->at.parameter, 0.7 / gain, 1e-4);
}

TEST(Continuation, FollowsNamesThatAreNoFieldsOfTheMachine) {
  // Figure 6.2's motion of period 1 in contact, along the length and the direction of the displacement and
  // along the clearance: the branch ends where the lanes settle to, and the derivative is that of
  // differences.
  const std::pair<const char*, double> ways[] = {
      {"misalignment", 0.66}, {"misalignment_angle_deg", 215.0}, {"clearance", 0.97}};
  const NamedValues all = {{"frequency_ratio", 0.905},
                           {"misalignment", 0.62},
                           {"misalignment_angle_deg", 230.0},
                           {"clearance", 1.0}};
  for (const auto& [name, to] : ways) {
    ContinuationProblem problem;
    problem.parameter = name;
    double from = 0.0;
    for (const auto& [key, value] : all) {
      if (key == name) {
        from = value;
      } else {
        problem.parameters.emplace_back(key, value);
      }
    }
    const auto settledAt = [&](double value) {
      BasicLaneOptions run;
      run.steps_per_turn = 1000;
      run.turns_skipped = 960;
      run.turns_kept = 0;
      return runBasicLanes({problem.machineAt(value)}, {{}}, run).end.front();
    };
    BasicOrbitOptions orbit = problem.orbit;
    orbit.direction = problem.directionAt(from);
    const auto start = settledAt(from);
    const double h = 1e-5 * (to - from);
    const auto found = basicOrbit(problem.machineAt(from), start, 1, orbit);
    const auto above = basicOrbit(problem.machineAt(from + h), start, 1, orbit).end;
    const auto below = basicOrbit(problem.machineAt(from - h), start, 1, orbit).end;
    // Differences over 1e-5 of the way: 1e-10 of the square of it, and the orbit's 1e-10 over h.
    EXPECT_NEAR(found.by_parameter[0], (above.x - below.x) / (2.0 * h), 1e-5 * (1.0 + 1e-5 / std::abs(h)))
        << name;
    EXPECT_GT(found.touch_downs, 0) << name;

    ContinuationOptions options;
    options.from = std::min(from, to);
    options.to = std::max(from, to);
    const Branch branch = followBranch(problem, options, from, start, 1);
    double nearest = 1e9;
    BranchPoint at;
    for (const auto& point : branch.points) {
      if (std::abs(point.parameter - to) < nearest) {
        nearest = std::abs(point.parameter - to);
        at = point;
      }
    }
    ASSERT_LT(nearest, 0.2 * std::abs(to - from)) << name << ": " << branch.ended;
    // The lanes' section is within 1e-4 of the event-accurate one at 1000 steps a turn.
    EXPECT_NEAR(at.state.x, settledAt(at.parameter).x, 2e-4) << name << " at " << at.parameter;
    EXPECT_TRUE(at.stable) << name;
  }
}

TEST(Continuation, ADoubledMotionEndsAtTheFlipsOfTheMotionItBranchesFrom) {
  // The displaced bearing of figure 6.2: between two flips of the motion of period 1 there is one of
  // period 2.
  ContinuationProblem problem;
  problem.parameter = "frequency_ratio";
  problem.parameters = {{"misalignment", 0.62}, {"misalignment_angle_deg", 230.0}};
  ContinuationOptions options;
  options.from = 0.85;
  options.to = 1.0;
  const auto settledAt = [&](double eta) {
    BasicLaneOptions run;
    run.turns_skipped = 960;
    run.turns_kept = 0;
    return runBasicLanes({problem.machineAt(eta)}, {{}}, run).end.front();
  };
  const Branch single = followBranch(problem, options, 0.9, settledAt(0.9), 1);
  double flip = 0.0;
  for (const auto& found : single.bifurcations) {
    if (flip == 0.0 && found.kind == BifurcationKind::flip) flip = found.at.parameter;
  }
  ASSERT_GT(flip, 0.9) << single.ended;

  options.to = 1.3;
  const Branch doubled = followBranch(problem, options, 1.1, settledAt(1.1), 2);
  EXPECT_NE(doubled.ended.find("joins"), std::string::npos) << doubled.ended;
  double nearest = 1.0, least = 2.0;
  for (const auto& point : doubled.points) {
    nearest = std::min(nearest, std::abs(point.parameter - flip));
    least = std::min(least, point.parameter);
  }
  // Both points of the doubled motion meet like a square root of the distance: 1e-6 apart is 1e-12 behind the
  // flip, but the corrector's matrix is singular there, which stops the bisection near 1e-5.
  EXPECT_LT(nearest, 1e-4);
  EXPECT_GT(least, flip - 1e-4) << "it ran on along the motion of period 1";
  // A motion of period 1 is none of period 2.
  EXPECT_THROW(followBranch(problem, options, 0.9, settledAt(0.9), 2), InputError);
}

}  // namespace
}  // namespace amb_rotor
