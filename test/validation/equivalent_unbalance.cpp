// Two unbalances that a rigid rotor cannot tell apart: the sum and the couple stay, the belief decides.
#include "amb_rotor/validation/equivalent_unbalance.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace amb_rotor {
namespace {

std::complex<double> coupleOf(const UnbalancePair& pair, double own_z) {
  return pair.own * own_z + pair.second * pair.second_z_m;
}

TEST(EquivalentUnbalance, TheBeliefFindsThePlaneAgain) {
  const BelievedUnbalance believed = {0.008, 7e-5, 7e-6, 2.0, 0.05};
  for (const double z : {-0.05, 0.03, 0.12}) {
    const UnbalancePair truth = {std::polar(7e-5, 2.0), std::polar(5e-5, -2.4), z};
    const std::complex<double> sum = truth.own + truth.second;
    for (const double other : {-0.15, -0.02, 0.05, 0.2}) {  // the same sum and couple from another plane
      UnbalancePair found;
      found.second = truth.second * (z - 0.008) / (other - 0.008);
      found.own = sum - found.second;
      found.second_z_m = other;
      ASSERT_NEAR(std::abs(coupleOf(found, 0.008) - coupleOf(truth, 0.008)), 0.0, 1e-15);
      const UnbalancePair best = likeliestUnbalance(found, believed, 0.25);
      // as near as forty halvings of the scan's step lead: the cost is flat to second order at its foot
      EXPECT_NEAR(best.second_z_m, z, 1e-5) << other;
      EXPECT_NEAR(std::abs(best.second - truth.second), 0.0, 1e-8) << other;
      EXPECT_NEAR(std::abs(best.own + best.second - sum), 0.0, 1e-15);
      EXPECT_NEAR(std::abs(coupleOf(best, 0.008) - coupleOf(truth, 0.008)), 0.0, 1e-15);
    }
  }
}

TEST(EquivalentUnbalance, StaysInsideTheRotorAndWithoutACouple) {
  const BelievedUnbalance believed = {0.0, 1e-5, 1e-6, 0.0, 0.05};
  // the belief asks for a pure couple, a plane at infinity
  const UnbalancePair found = {std::polar(1e-5, 0.0), std::polar(1e-6, 1.0), 0.1};
  EXPECT_LE(std::fabs(likeliestUnbalance(found, believed, 0.2).second_z_m), 0.2);
  const UnbalancePair none = {std::polar(1e-5, 0.0), 0.0, 0.1};
  EXPECT_EQ(likeliestUnbalance(none, believed, 0.2).second_z_m, 0.1);
}

}  // namespace
}  // namespace amb_rotor
