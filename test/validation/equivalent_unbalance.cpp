// Two unbalances that a rigid rotor cannot tell apart: the sum and the couple stay, the belief decides.
#include "amb_rotor/validation/equivalent_unbalance.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "../support/models.hpp"

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

TEST(EquivalentUnbalance, WhatTheBeliefLeavesOpenIsStated) {
  using namespace testing_support;
  // one line through the centre: n and U are parallel, so n alone says where along it, and its moment's deviation is U's
  Model belief = withUnbalance(levitated(), 5e-5, 0.4, -0.02);
  belief.uncertainty["unbalance.moment_kg_m"] = 0.1;
  belief.uncertainty["unbalance.phase_rad"] = 0.05;
  const double second = 2e-5, z = 0.06;
  const FitSpace space(belief, {{"couple_unbalance", {second, 0.4, z}}});
  const Eigen::VectorXd x = space.start();
  Eigen::MatrixXd covariance = 1e-12 * Eigen::MatrixXd::Identity(x.size(), x.size());
  for (int k = 0; k < x.size(); ++k) covariance(k, k) *= std::pow(space.coordinates()[k].scale, 2);
  widenAlongEquivalents(belief, space, x, covariance);
  const auto values = space.effectValues(0, x, covariance);
  // the moment's deviation is 0.1 of 5e-5; U (z - z_n) stays. The belief counts the moment's square, whose bend is a parabola
  EXPECT_NEAR(values[0].std, 5e-6, 0.01 * 5e-6);
  EXPECT_NEAR(values[2].std, (z + 0.02) * 5e-6 / second, 0.01 * (z + 0.02) * 5e-6 / second);
  EXPECT_LT(values[1].std, 1e-3);
  const Eigen::MatrixXd wide = 4.0 * covariance;
  Eigen::MatrixXd stays = wide;
  widenAlongEquivalents(belief, space, x, stays);
  EXPECT_NEAR((stays - wide).norm(), 0.0, 1e-6 * wide.norm());
  // a rotor that bends tells the plane itself
  const FitSpace bending(belief, {{"couple_unbalance", {second, 0.4, z}}, {"shaft_flexibility", typicalValues("shaft_flexibility")}});
  const Eigen::VectorXd there = bending.start();
  const Eigen::MatrixXd told = Eigen::MatrixXd::Identity(there.size(), there.size()) * 1e-20;
  Eigen::MatrixXd as_told = told;
  widenAlongEquivalents(belief, bending, there, as_told);
  EXPECT_EQ(as_told, told);
}

}  // namespace
}  // namespace amb_rotor
