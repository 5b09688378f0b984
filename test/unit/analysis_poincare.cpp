// Sections against motions whose crossings are known.
#include <gtest/gtest.h>

#include <cmath>

#include "amb_rotor/analysis/poincare.hpp"
#include "amb_rotor/common/error.hpp"

namespace amb_rotor {
namespace {

struct WhirlSamples {
  std::vector<double> time, angle, x, y, vx, vy;
};

/// Whirl of radius 1 at 0.73 of a speed that rises, h the sample step.
/// angle = w t + a t^2/2; x = cos(0.73 angle), y = sin(0.73 angle).
WhirlSamples whirl(double h) {
  WhirlSamples r;
  for (int i = 0; i * h <= 1.0; ++i) {
    const double t = i * h + 0.013, rate = 2.0 * M_PI * (20.0 + 10.0 * t);
    const double angle = 2.0 * M_PI * (20.0 * t + 5.0 * t * t);
    r.time.push_back(t);
    r.angle.push_back(angle);
    r.x.push_back(std::cos(0.73 * angle));
    r.y.push_back(std::sin(0.73 * angle));
    r.vx.push_back(-0.73 * rate * std::sin(0.73 * angle));
    r.vy.push_back(0.73 * rate * std::cos(0.73 * angle));
  }
  return r;
}

double worstError(const std::vector<PoincarePoint>& points) {
  double worst = 0.0;
  for (const PoincarePoint& p : points) {
    const double angle = 2.0 * M_PI * static_cast<double>(p.index);
    const double t = -2.0 + std::sqrt(4.0 + angle / (2.0 * M_PI) / 5.0);
    worst = std::max(worst, std::fabs(p.x - std::cos(0.73 * angle)));
    worst = std::max(worst, std::fabs(p.y - std::sin(0.73 * angle)));
    worst = std::max(worst, std::fabs(p.time - t));
  }
  return worst;
}

TEST(AnalysisPoincare, StroboscopicPointsOfAWhirlWithRisingSpeed) {
  const WhirlSamples r = whirl(1e-3);
  const auto with = stroboscopicSection(r.time, r.angle, r.x, r.y, r.vx, r.vy);
  const auto without = stroboscopicSection(r.time, r.angle, r.x, r.y);
  // Angle from 2 pi 0.26 to 2 pi 25.4: turns 1 to 25.
  ASSERT_EQ(with.size(), 25u);
  ASSERT_EQ(without.size(), 25u);
  EXPECT_EQ(with.front().index, 1);
  EXPECT_EQ(with.back().index, 25);
  // w h = 0.73 2 pi 30 1e-3 = 0.138: Hermite (w h)^4/384 = 9e-7, Lagrange 3 (w h)^4/128 = 8e-6; one-sided
  // at the ends, three samples: (w h)^3/16 = 1.6e-4, but no crossing is there.
  EXPECT_LT(worstError(with), 1e-6);
  EXPECT_LT(worstError(without), 1e-5);
  EXPECT_GT(worstError(with), 1e-13);  // the bounds above are not met by accident
}

TEST(AnalysisPoincare, ErrorFallsWithTheFourthPower) {
  const WhirlSamples coarse = whirl(2e-3), fine = whirl(1e-3);
  const double ratio =
      worstError(stroboscopicSection(coarse.time, coarse.angle, coarse.x, coarse.y, coarse.vx, coarse.vy)) /
      worstError(stroboscopicSection(fine.time, fine.angle, fine.x, fine.y, fine.vx, fine.vy));
  // 2^4 = 16; where in the step the worst crossing lies changes it by a factor below 2.
  EXPECT_GT(ratio, 8.0);
  EXPECT_LT(ratio, 32.0);
}

TEST(AnalysisPoincare, EveryTurnOnceThoughASampleLiesOnTheSection) {
  std::vector<double> time, angle, x;
  for (int i = 0; i <= 100; ++i) {
    time.push_back(i);
    angle.push_back(2.0 * M_PI * i / 10.0);
    x.push_back(i);
  }
  const auto points = stroboscopicSection(time, angle, x, x);
  ASSERT_EQ(points.size(), 10u);
  for (std::size_t k = 0; k < points.size(); ++k) {
    EXPECT_EQ(points[k].index, static_cast<long>(k) + 1);
    EXPECT_NEAR(points[k].x, 10.0 * (static_cast<double>(k) + 1.0), 1e-11);
    EXPECT_NEAR(points[k].vx, 1.0, 1e-11);  // slope of the straight line, round-off of values to 100
  }
  EXPECT_EQ(stroboscopicSection(time, angle, x, x, {}, {}, M_PI).size(), 10u);
  EXPECT_NEAR(stroboscopicSection(time, angle, x, x, {}, {}, M_PI)[0].x, 5.0, 1e-12);
}

TEST(AnalysisPoincare, RadialTurningPoints) {
  // Radius 2 + cos(t): radial velocity -sin(t), falling through 0 at t = 2 pi k: the farthest points.
  std::vector<double> time, g, x, y;
  for (int i = 0; i < 1000; ++i) {
    const double t = 0.5 + 0.05 * i;
    const double radius = 2.0 + std::cos(t), vr = -std::sin(t);
    const double vx = vr * std::cos(3 * t) - 3 * radius * std::sin(3 * t);
    const double vy = vr * std::sin(3 * t) + 3 * radius * std::cos(3 * t);
    time.push_back(t);
    x.push_back(radius * std::cos(3 * t));
    y.push_back(radius * std::sin(3 * t));
    g.push_back(radialVelocity(x.back(), y.back(), vx, vy));
  }
  const auto far = surfaceSection(time, g, x, y, CrossingDirection::falling);
  const auto near = surfaceSection(time, g, x, y, CrossingDirection::rising);
  // t from 0.5 to 50.45: 2 pi k for k = 1..8, and pi + 2 pi k for k = 0..7.
  ASSERT_EQ(far.size(), 8u);
  ASSERT_EQ(near.size(), 8u);
  EXPECT_EQ(surfaceSection(time, g, x, y, CrossingDirection::both).size(), 16u);
  for (std::size_t k = 0; k < far.size(); ++k) {
    EXPECT_NEAR(far[k].time, 2.0 * M_PI * (static_cast<double>(k) + 1.0), 1e-6);  // cubic, (0.05)^4/40
    // Components turn at 4 rad per unit time: 3 (4 0.05)^4/128 times the radius 3 is 1e-4.
    EXPECT_NEAR(std::hypot(far[k].x, far[k].y), 3.0, 1.2e-4);
    EXPECT_EQ(far[k].index, -1);
  }
}

TEST(AnalysisPoincare, AccumulatorEqualsBatchAndCountsWhatItDrops) {
  const WhirlSamples r = whirl(1e-3);
  const auto batch = stroboscopicSection(r.time, r.angle, r.x, r.y, r.vx, r.vy);
  PoincareAccumulator accumulator;
  std::vector<PoincarePoint> points;
  for (std::size_t i = 0; i < r.time.size(); ++i) {
    MotionSample sample{r.time[i], r.angle[i], r.x[i], r.y[i], r.vx[i], r.vy[i], 0.0};
    for (const PoincarePoint& p : accumulator.add(sample)) points.push_back(p);
    for (const PoincarePoint& p : accumulator.add(sample)) points.push_back(p);  // an event written twice
    sample.x = MotionSample::unknown;
    EXPECT_TRUE(accumulator.add(sample).empty());
  }
  for (const PoincarePoint& p : accumulator.finish()) points.push_back(p);
  ASSERT_EQ(points.size(), batch.size());
  for (std::size_t i = 0; i < points.size(); ++i) EXPECT_EQ(points[i].x, batch[i].x);
  EXPECT_EQ(accumulator.dropped(), r.time.size());
  EXPECT_THROW(stroboscopicSection({0.0}, {}, {0.0}, {0.0}), InputError);
}

TEST(AnalysisPoincare, StandstillHasNoPoints) {
  const std::vector<double> time = {0, 1, 2, 3, 4}, zero(5, 0.0);
  EXPECT_TRUE(stroboscopicSection(time, zero, zero, zero).empty());
  EXPECT_TRUE(stroboscopicSection({}, {}, {}, {}).empty());
}

}  // namespace
}  // namespace amb_rotor
