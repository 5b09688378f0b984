// Steps of a fit through contact that are longer than its windows' normal equations say.
#include "../../src/validation/window_ease.hpp"

#include <gtest/gtest.h>

#include <Eigen/Dense>

namespace amb_rotor {
namespace {

/// Windows whose squares are a parabola of so much of the curvature that their normal equations say.
struct Valley {
  Eigen::Matrix2d h = (Eigen::Matrix2d() << 4.0, 1.0, 1.0, 3.0).finished();
  Eigen::Vector2d x{5.0, -2.0};  // the bottom is at 0
  double share;
  Eigen::Vector2d g() const { return -share * (h * x); }
  void go(WindowEase& ease) {
    Eigen::MatrixXd relieved = h;
    ease.relieve(h, {}, relieved);
    const Eigen::Vector2d before = g(), step = relieved.inverse() * before;
    x += step;
    ease.learn(h, before, g(), step);
  }
};

TEST(WindowEase, AParabolaNeedsNone) {
  Valley valley;
  valley.share = 1.0;
  WindowEase ease;
  valley.go(ease);
  EXPECT_EQ(ease.value(), 1.0);
  EXPECT_LT(valley.x.norm(), 1e-12);
}

TEST(WindowEase, LeadsStepsThatCreepToTheBottom) {
  Valley creeping, eased;
  creeping.share = eased.share = 0.02;
  WindowEase ease;
  for (int step = 0; step < 6; ++step) {
    WindowEase unlearned;
    creeping.go(unlearned);
    eased.go(ease);
  }
  EXPECT_GT(creeping.x.norm(), 0.85 * Valley().x.norm());  // 0.98 to the power 6 is 0.886
  EXPECT_LT(eased.x.norm(), 1e-9);                                // 4, 16, then the 50 that make it a whole step
  EXPECT_NEAR(ease.value(), 50.0, 1e-6);
}

/// Twice the noise or next to it: a fit that had come so near still crept. What right models leave ends in hollows.
TEST(WindowEase, IsWantedAboveTheNoise) {
  WindowEase ease;
  EXPECT_FALSE(ease.isWanted(5.0)) << "a parabola so far";
  ease.learn(Eigen::Matrix2d::Identity(), Eigen::Vector2d::Ones(), Eigen::Vector2d::Ones(), Eigen::Vector2d::Ones());
  ASSERT_EQ(ease.value(), 4.0);
  for (const double level : {5.0, 2.0, 1.18}) EXPECT_TRUE(ease.isWanted(level)) << level;
  for (const double level : {0.93, 0.5}) EXPECT_FALSE(ease.isWanted(level)) << level;
}

TEST(WindowEase, GrowsWhereTheGradientDoesNotFallAndIsTakenBackWhereAStepFails) {
  const Eigen::Matrix2d h = Eigen::Matrix2d::Identity();
  const Eigen::Vector2d g{1.0, 0.0}, more{1.5, 0.0};
  WindowEase ease;
  ease.learn(h, g, more, g);
  EXPECT_EQ(ease.value(), 4.0);
  for (int step = 0; step < 10; ++step) ease.learn(h, g, more, g);
  EXPECT_EQ(ease.value(), 100.0);
  ease.shorten();
  EXPECT_EQ(ease.value(), 25.0);
  for (int failed = 0; failed < 4; ++failed) ease.shorten();
  EXPECT_EQ(ease.value(), 1.0);
}

TEST(WindowEase, LeavesWhatOtherRunsTellAndWhatIsHeld) {
  const Eigen::Matrix3d windows = Eigen::Matrix3d::Constant(2.0), all = Eigen::Matrix3d::Constant(5.0);
  WindowEase ease;
  ease.learn(Eigen::Matrix3d::Identity(), Eigen::Vector3d::Ones(), Eigen::Vector3d::Ones(), Eigen::Vector3d::Ones());
  ASSERT_EQ(ease.value(), 4.0);
  Eigen::MatrixXd relieved = all;
  ease.relieve(windows, {false, true, false}, relieved);
  EXPECT_DOUBLE_EQ(relieved(0, 2), 5.0 - 2.0 * 0.75);
  EXPECT_EQ(relieved(1, 1), 5.0);
  EXPECT_EQ(relieved(0, 1), 5.0);
}

}  // namespace
}  // namespace amb_rotor
