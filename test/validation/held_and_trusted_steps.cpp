// What a step of a fit may do: coordinates that are held stay and the others go as if these did not exist;
// through contact a step goes as far as its linear model is trusted.
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "../../src/validation/trusted_step.hpp"
#include "../support/made_sets.hpp"
#include "../support/models.hpp"
#include "../support/own_effect.hpp"
#include "amb_rotor/validation/fit.hpp"

namespace amb_rotor {
namespace {

/// The first instants of one recording of a set.
std::vector<Recording> onlyBeginningOf(const MadeSet& set, const std::string& id, long samples) {
  return {beginningOf(set.recordings.at(set.indexOf(id)), samples)};
}

TEST(FitTest, WhatNoRunDeterminesIsAsUncertainAsItsRange) {
  const MadeSet& set = cleanSet();
  const std::vector<Recording> recordings = onlyBeginningOf(set, "steady_2", 3000);
  const EffectSetting mode = {"shaft_flexibility", testing_support::typicalValues("shaft_flexibility")};
  const FitSpace space(set.dataset.belief, {mode});
  const FitProblem problem(recordings, space, set.offset_std_m);
  FitOptions options;
  options.most_iterations = 1;
  options.scores = true;
  options.held.assign(space.size(), false);
  for (int k = 0; k < space.size(); ++k)
    options.held[k] = space.coordinates()[k].name.rfind("shaft_flexibility.shape_aux", 0) == 0;
  std::vector<LocalState> local(1);
  const FitResult result = fit(problem, space.start(), {0}, local, options);
  ASSERT_TRUE(result.finite);
  int aux = 0;
  for (const FittedParameter& p : space.effectValues(0, result.x, result.covariance)) {
    EXPECT_GT(p.std, 0.0) << p.name;
    if (p.name.rfind("shape_aux", 0) != 0) continue;
    EXPECT_NEAR(p.std, 12.0 / std::sqrt(12.0), 1e-9) << "a shape lies between -6 and 6";
    ++aux;
  }
  EXPECT_EQ(aux, 2);
}

TEST(TrustedStep, AlongWhatHardlyShowsItIsShortAndWholeAlongTheRest) {
  const double free = std::numeric_limits<double>::infinity();
  Eigen::Matrix3d h = Eigen::Vector3d(2e7, 3e5, 1e-4).asDiagonal();
  const Eigen::Vector3d whole(0.004, -0.02, 2e3), lengths(0.5, free, 6.0);
  const Eigen::VectorXd step = trustedStep(h, h * whole, lengths);
  // what holds the third to 6 of 2e3 weighs 1e-4 * 2e3 / 6 = 0.03, of a unit of the first 1.2 / 0.5^2 = 5: nothing to its 2e7; the
  // rest is what is cut off in the end
  EXPECT_NEAR(step[0], whole[0], 2e-3 * std::fabs(whole[0]));
  EXPECT_NEAR(step[1], whole[1], 2e-3 * std::fabs(whole[1])) << "without a bound";
  EXPECT_DOUBLE_EQ(step[2], 6.0);
  EXPECT_EQ(trustedStep(h, h * Eigen::Vector3d(0.004, -0.02, 5.0), lengths)[2], 5.0) << "within: the plain step";
}

TEST(TrustedStep, FollowsAValleyAcrossItsAxes) {
  // two numbers that show by their sum, which is off by 1; their difference shows by next to nothing, and is off by 600
  Eigen::Matrix2d h;
  h << 1e4, 1e4 - 1e-3, 1e4 - 1e-3, 1e4;
  const Eigen::Vector2d lengths(2.0, 2.0), g = h * Eigen::Vector2d(300.5, -299.5);
  const Eigen::VectorXd step = trustedStep(h, g, lengths);
  EXPECT_NEAR(step.sum(), 1.0, 3e-3) << "a share of the whole step would leave 0.993 of it";
  EXPECT_DOUBLE_EQ(step.cwiseAbs().maxCoeff(), 2.0);
}

TEST(FitTest, HeldCoordinatesStayAndTheOthersGoAsWithoutThem) {
  const MadeSet& set = cleanSet();
  const std::vector<Recording> recordings = onlyBeginningOf(set, "steady_2", 3000);
  const Model& belief = set.dataset.belief;
  const FitSpace whole(belief, {});
  // two that the run tells, off from what is believed of them: data and prior pull
  const std::vector<std::string> names = {"rotor.mass_kg", "amb.current_stiffness_N_per_A"};
  Eigen::VectorXd start = whole.start();
  FitOptions options;
  options.held.assign(whole.size(), false);
  int held = 0;
  for (int k = 0; k < whole.size(); ++k)
    for (const auto& name : names)
      if (whole.coordinates()[k].name == name) {
        options.held[k] = true;
        start[k] += 0.7 * whole.coordinates()[k].prior_std;
        ++held;
      }
  ASSERT_EQ(held, 2);
  Model less = whole.model(start);
  for (const auto& name : names) ASSERT_EQ(less.uncertainty.erase(name), 1u);
  const FitSpace rest(less, {});
  ASSERT_EQ(rest.size(), whole.size() - held);

  const FitProblem problem(recordings, whole, set.offset_std_m), smaller(recordings, rest, set.offset_std_m);
  std::vector<LocalState> local(1), local_of_rest(1);
  const FitResult result = fit(problem, start, {0}, local, options);
  const FitResult without = fit(smaller, rest.start(), {0}, local_of_rest, {});
  ASSERT_TRUE(result.finite && without.finite);
  EXPECT_EQ(result.iterations, without.iterations);
  int other = 0, moved = 0;
  for (int k = 0; k < whole.size(); ++k) {
    if (options.held[k]) {
      EXPECT_EQ(result.x[k], start[k]) << whole.coordinates()[k].name;
      continue;
    }
    const Coordinate& c = rest.coordinates()[other];
    ASSERT_EQ(whole.coordinates()[k].name, c.name);
    // the same equations in another order of elimination: round-off
    EXPECT_NEAR(result.x[k], without.x[other], 1e-6 * c.scale) << c.name;
    if (std::fabs(result.x[k] - start[k]) > 0.05 * c.scale) ++moved;
    ++other;
  }
  EXPECT_GE(moved, 1) << "the others had somewhere to go";
  const FitResult all = fit(problem, start, {0}, local, {});
  for (int k = 0; k < whole.size(); ++k)
    if (options.held[k]) {
      EXPECT_GT(std::fabs(all.x[k] - start[k]), 0.05 * whole.coordinates()[k].scale) << "let go, it moves";
    }
}

TEST(FitTest, AStepThroughContactGoesSixScalesOfAnEffect) {
  // A constant force that is not there, tried at 50 of its scales: the motion is linear in it, so that the
  // first step of a fit is the whole way back. The scale is that of the effect's typical size.
  constexpr double scale_N = 0.01, trusted_scales = 6.0, start_N = 50.0 * scale_N;
  ownForce("test_trusted_load", scale_N, "c", "0.3 * c");
  const MadeSet& free_set = cleanSet();
  const MadeSet& contact_set = madeSet(21, "none", 0.0, true);
  for (const bool contact : {false, true}) {
    const MadeSet& set = contact ? contact_set : free_set;
    // the rub begins to touch within these
    const std::vector<Recording> recordings =
        onlyBeginningOf(set, contact ? "rub_1" : "steady_2", contact ? 1000 : 3000);
    ASSERT_EQ(recordings[0].holdsContact(), contact);
    const FitSpace space(set.truth(), {{"test_trusted_load", {start_N}}});
    ASSERT_EQ(space.size(), 1);
    ASSERT_EQ(space.coordinates()[0].scale, scale_N);
    const FitProblem problem(recordings, space, set.offset_std_m);
    std::vector<LocalState> local(1);
    FitOptions options;
    options.most_iterations = 1;
    options.covariance = false;
    const FitResult result = fit(problem, space.start(), {0}, local, options);
    ASSERT_TRUE(result.finite);
    if (contact) {
      EXPECT_NEAR(start_N - result.x[0], trusted_scales * scale_N, 1e-9 * scale_N);
    } else {
      EXPECT_GT(start_N - result.x[0], 0.5 * start_N) << "without contact the whole way at once";
    }
  }
}

}  // namespace
}  // namespace amb_rotor
