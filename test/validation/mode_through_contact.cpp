// The shapes of a bending mode at the auxiliary bearings, of which runs without contact know nothing.
#include <gtest/gtest.h>

#include <cmath>

#include "../support/through_contact.hpp"

namespace amb_rotor {
namespace {

/// A mode as a fit without contact may leave it: the products of its shapes are right, how they are shared is not, and those at the
/// auxiliary bearings stand between their neighbours'.
EffectSetting sharedOtherwise(EffectSetting mode, double times) {
  for (const int seen : {4, 5}) mode.values[seen] *= times;
  for (const int driven : {2, 3, 8}) mode.values[driven] /= times;
  for (int end = 0; end < 2; ++end) mode.values[6 + end] = 0.5 * (mode.values[2 + end] + mode.values[4 + end]);
  return mode;
}

TEST(ModeThroughContact, ItsShapesThereAreFoundFromOtherSharesOfTheSameProducts) {
  const MadeSet& set = madeSet(454, "shaft_flexibility", 0.0, true, {"chirp_1", "steady_1", "rub_1"});
  const EffectSetting truth = set.truth().effects.at(0);
  const Candidates candidates(set.dataset.belief, set.dataset);
  const Eigen::VectorXd own = FitSpace(set.dataset.belief, {}).start();
  const std::vector<LocalState> local(set.recordings.size());
  const Trial free = candidates.fit({sharedOtherwise(truth, 3.0)}, &own, local, {Through::free, 10});
  ASSERT_LT(free.fit.squares, 1.1 * free.fit.count);
  const Trial found = candidates.withContactsNumbers(free);
  ASSERT_TRUE(found.fit.finite);
  EXPECT_FALSE(isAstray(found));
  const EffectSetting at = found.effects().at(0);
  for (const int aux : {6, 7}) EXPECT_NEAR(at.values[aux], truth.values[aux], 0.05 * std::fabs(truth.values[aux]));
  EXPECT_EQ(candidates.withContactsNumbers(candidates.fit({}, nullptr, local, {Through::free, 2})).effects().size(), 0u);
}

}  // namespace
}  // namespace amb_rotor
