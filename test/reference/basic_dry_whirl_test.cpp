// Dry whirl: the closed-form watershed against the simulation.
#include "amb_rotor/machine/basic_dry_whirl.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "amb_rotor/machine/basic_annular_rub.hpp"
#include "amb_rotor/machine/basic_orbit.hpp"

namespace amb_rotor {
namespace {

double radiusAfter(BasicParameters<double> p, double w, double friction, int turns) {
  p.friction = friction;
  const auto orbit = advanceBasic(p, dryWhirlState(p, w), turns, {});
  EXPECT_TRUE(orbit.finite);
  EXPECT_EQ(orbit.touch_downs, 0) << "it was to stay in contact";
  EXPECT_GT(orbit.contact_fraction, 0.999);
  return std::hypot(orbit.end.x, orbit.end.y);
}

TEST(DryWhirl, GrowsAboveTheFrictionOfTheClosedFormAndDiesOutBelow) {
  BasicParameters<double> p;
  p.eccentricity = 0.0;
  p.frequency_ratio = 1.0;
  for (double w : {1.5, 2.0, 3.0}) {
    const double friction = dryWhirlFriction(p, w), radius = dryWhirlRadius(p, w);
    // On the watershed the circle holds: 8 turns take e^(rate) of the integration's 1e-10 a step.
    EXPECT_NEAR(radiusAfter(p, w, friction, 8), radius, 1e-6) << w;
    EXPECT_GT(radiusAfter(p, w, 1.02 * friction, 8), radius + 2e-4) << w;
    EXPECT_LT(radiusAfter(p, w, 0.98 * friction, 8), radius - 2e-4) << w;
  }
}

TEST(DryWhirl, TheFastestNeedsTheCorrectedCriterion) {
  BasicParameters<double> p;
  const double fastest = std::sqrt(p.support_stiffness + p.contact_stiffness);
  // mu(w) is smooth there: 1e-9 off the end of the range.
  EXPECT_NEAR(dryWhirlFriction(p, fastest - 1e-9), frictionBorderWithoutClearance(p), 1e-9);
  EXPECT_GT(dryWhirlFriction(p, 0.5 * fastest), frictionBorderWithoutClearance(p));
  EXPECT_TRUE(std::isnan(dryWhirlFriction(p, fastest + 0.01)));
  EXPECT_TRUE(std::isnan(dryWhirlRadius(p, 0.9)));
}

}  // namespace
}  // namespace amb_rotor
