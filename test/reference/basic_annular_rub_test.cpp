// The synchronous full annular rub: closed form against the simulation.
#include "amb_rotor/machine/basic_annular_rub.hpp"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <cmath>

#include "amb_rotor/machine/basic_orbit.hpp"
#include "amb_rotor/machine/basic_regime.hpp"

namespace amb_rotor {
namespace {

BasicParameters<double> table51(double eta) {
  BasicParameters<double> p;
  p.frequency_ratio = eta;
  return p;
}

TEST(AnnularRub, IsAMotionOfPeriodOneOfTheModel) {
  for (double eta : {0.97, 1.05, 1.3}) {
    const auto p = table51(eta);
    for (double radius : annularRubRadii(p)) {
      const auto start = annularRubState(p, radius);
      EXPECT_NEAR(std::hypot(start.x, start.y), radius,
                  1e-10);  // round-off, amplified by the near-cancellation of stiffness at small depth
      const auto orbit = advanceBasic(p, start, 1, {});
      // Tolerance 1e-10 a step, about 100 steps.
      EXPECT_NEAR(orbit.end.x, start.x, 2e-8) << eta << " " << radius;
      EXPECT_NEAR(orbit.end.vy, start.vy, 2e-8) << eta << " " << radius;
    }
  }
}

TEST(AnnularRub, ExponentsAreTheMultipliersOfTheMonodromyMatrix) {
  const auto p = table51(1.05);
  const double radius = annularRubRadii(p).back();
  const auto orbit = basicOrbit(p, annularRubState(p, radius), 1, {});
  // A rotating frame returns after a turn, so the multipliers are exp(lambda T): compare trace and
  // determinant.
  const double turn = 2.0 * M_PI / p.frequency_ratio;
  std::complex<double> trace = 0.0, determinant = 1.0;
  for (const auto& lambda : annularRubExponents(p, radius)) {
    trace += std::exp(lambda * turn);
    determinant *= std::exp(lambda * turn);
  }
  EXPECT_NEAR(orbit.monodromy.trace(), trace.real(), 1e-6);
  EXPECT_NEAR(orbit.monodromy.determinant(), determinant.real(), 1e-6);
}

TEST(AnnularRub, LimitWithoutClearanceIsTheCorrectedCriterion) {
  // With a large unbalance the orbit is large, and the clearance does not count.
  auto p = table51(1.2);
  p.eccentricity = 1e5;
  // Relative error of the order of clearance over radius times the stiffness ratio.
  EXPECT_NEAR(annularRubFrictionBorder(p), frictionBorderWithoutClearance(p), 2e-5);
  EXPECT_NEAR(frictionBorderWithoutClearance(p), 0.0097, 5e-5);  // as stated for table 5.1
}

/// Does a small kick die out within 4000 turns?
bool settles(BasicParameters<double> p, double friction) {
  p.friction = friction;
  const auto radii = annularRubRadii(p);
  auto start = annularRubState(p, radii.back());
  start.vx += 1e-4;
  BasicLaneOptions options;
  options.turns_skipped = 4000;
  options.turns_kept = 16;
  const auto result = runBasicLanes({p}, {start}, options);
  return !result.diverged.front() && std::abs(result.max_radius.front() - result.min_radius.front()) < 1e-4 &&
         std::abs(result.max_radius.front() - radii.back()) < 1e-4;
}

TEST(AnnularRub, SimulationFindsTheSameBorder) {
  for (double eta : {1.05, 1.3}) {
    const auto p = table51(eta);
    const double border = annularRubFrictionBorder(p);
    EXPECT_NEAR(border, eta == 1.05 ? 0.021 : 0.018, 0.0006) << "as stated to two digits";
    EXPECT_TRUE(settles(p, 0.98 * border)) << eta << " border " << border;
    EXPECT_FALSE(settles(p, 1.02 * border)) << eta << " border " << border;
  }
}

TEST(AnnularRub, TwoRubsMeetAtAFold) {
  const auto folds = annularRubFolds(table51(1.0), 0.5, 4.0);
  ASSERT_FALSE(folds.empty());
  const double fold = folds.back();
  EXPECT_FALSE(annularRubRadii(table51(fold - 1e-4)).empty());
  EXPECT_TRUE(annularRubRadii(table51(fold + 1e-4)).empty());
  const auto near = annularRubRadii(table51(fold - 1e-9));
  // Both sides of a fold: a multiplier at +1, that is the constant coefficient vanishes like the square root
  // of the distance.
  EXPECT_NEAR(annularRubPolynomial(table51(fold - 1e-9), near.back())[4], 0.0, 1e-2);
}

}  // namespace
}  // namespace amb_rotor
