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
  const MadeSet& set = madeSet(454, "shaft_flexibility", 0.0, true, {"chirp_1", "steady_1", "drop_1"});
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
  const Trial none = candidates.fit({}, nullptr, local, {Through::free, 2});
  EXPECT_EQ(candidates.withContactsNumbers(none).fit.x, none.fit.x) << "it has no such numbers";
}

TEST(ModeThroughContact, OfItsNumbersThoseThatOnlyContactShowsAreFreeThereAndHeldWithout) {
  const ThroughContact begun{madeSet(454, "shaft_flexibility", 0.0, true, {"chirp_1", "steady_1", "drop_1"})};
  EffectSetting mode = begun.set.truth().effects.at(0);
  for (const int aux : {6, 7}) mode.values[aux] *= 0.9;
  const auto left = [](const Trial& trial) { return trial.effects().at(0).values; };
  const Trial through = begun.fitted({mode}, {Through::contact, 2}, &begun.references.prior);
  const Trial without = begun.fitted({mode}, {Through::free, 2, true});
  ASSERT_TRUE(through.fit.finite && without.fit.finite);
  for (std::size_t i = 0; i < mode.values.size(); ++i) {
    const bool aux = i == 6 || i == 7;
    EXPECT_EQ(std::fabs(left(through)[i] - mode.values[i]) > 1e-6, aux) << i;
    if (aux) { EXPECT_NEAR(left(without)[i], mode.values[i], 1e-9) << i; }
  }
  for (const FittedParameter& p : without.space->effectValues(0, without.fit.x, without.fit.covariance)) {
    if (p.name.rfind("shape_aux", 0) == 0) { EXPECT_NEAR(p.std, 12.0 / std::sqrt(12.0), 1e-9) << "a shape lies between -6 and 6"; }
  }
}

}  // namespace
}  // namespace amb_rotor
