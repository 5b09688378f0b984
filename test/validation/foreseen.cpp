// What effects promise to first order, against what their fits find.
#include <gtest/gtest.h>

#include "../../src/validation/foreseen.hpp"
#include "../support/through_contact.hpp"

namespace amb_rotor {
namespace {

std::vector<std::string> wholeCatalogue() {
  std::vector<std::string> names;
  for (const auto& schema : effectCatalogue().all())
    if (!schema.only_by_name) names.push_back(schema.id);
  return names;
}

TEST(Foreseen, NothingIsWhereNothingIsMissing) {
  ThroughContact belief{cleanSet()};
  foresee(belief.candidates, wholeCatalogue(), {}, belief.references);
  ASSERT_GT(belief.references.promises.size(), 15u);
  for (const char* effect : {"sensor_gain_error", "sensor_axis_rotation", "motor_magnetic_pull", "amplifier_lag", "sensor_runout"})
    EXPECT_EQ(belief.references.promises.count(effect), 1u) << effect << " has a promise however it is fitted";
  for (const auto& [effect, promise] : belief.references.promises) {
    EXPECT_LT(promise.evidence, 40.0) << effect;  // a half of chi2 with a noise that is partly coloured
    EXPECT_FALSE(needsContact(effect)) << effect;
  }
}

/// Effects of little size, whose fits are nearly linear: what vanishes at 0, at the belief's own number, and nowhere next to it.
class ForeseenEffect : public ::testing::TestWithParam<const char*> {};

TEST_P(ForeseenEffect, PromisesWhatItsFitFinds) {
  const std::string hidden = GetParam();
  const MadeSet& set = madeSet(21, hidden, 0.5, false);
  ThroughContact belief{set};
  foresee(belief.candidates, wholeCatalogue(), {}, belief.references);
  const std::map<std::string, Promise>& promises = belief.references.promises;
  const Trial found = belief.candidates.fit({set.truth().effects.at(0)}, nullptr, belief.free.local, {Through::free, 10});
  const double evidence = belief.candidates.evidence(found, belief.free);
  ASSERT_GT(evidence, 300.0) << "too little to tell";
  ASSERT_EQ(promises.count(hidden), 1u);
  EXPECT_NEAR(promises.at(hidden).evidence / evidence, 1.0, 0.2);  // a second order of an effect of half the noise
  for (const auto& [effect, promise] : promises) EXPECT_LE(promise.evidence, 1.05 * promises.at(hidden).evidence) << effect;
}

INSTANTIATE_TEST_SUITE_P(Sizes, ForeseenEffect,
                         ::testing::Values("motor_magnetic_pull", "control_delay", "current_saturation", "couple_unbalance"),
                         [](const auto& one) { return std::string(one.param); });

TEST(Foreseen, PromisesHoldBesideWhatShowsThroughContactOnly) {
  const MadeSet& set = madeSet(21, "compliant_mount", 0.0, true);
  ThroughContact belief{set};
  const std::vector<std::string> asked = {"control_delay", "shaft_crack"};
  foresee(belief.candidates, asked, {}, belief.references);
  const EffectSetting mount = set.truth().effects.at(0);
  const Eigen::VectorXd own = belief.free.nuisance();
  const Trial with = belief.candidates.fit({mount}, &own, belief.free.local, {Through::free, 6});
  const auto kept = stillPromised(belief.references, with);
  References anew = belief.candidates.referencesWithoutContact(with, with);
  foresee(belief.candidates, asked, with.effects(), anew);
  ASSERT_EQ(anew.promises.size(), asked.size());
  ASSERT_EQ(kept.size(), asked.size());
  for (const auto& [effect, promise] : anew.promises) {
    EXPECT_NEAR(kept.at(effect).evidence, promise.evidence, 0.5) << effect;
    ASSERT_EQ(kept.at(effect).starts.size(), promise.starts.size()) << effect;
    for (std::size_t i = 0; i < promise.starts.size(); ++i) {
      ASSERT_EQ(kept.at(effect).starts[i].size(), 2u) << effect;
      for (std::size_t k = 0; k < 2; ++k) {
        EXPECT_EQ(kept.at(effect).starts[i][k].id, promise.starts[i][k].id) << effect;
        EXPECT_EQ(kept.at(effect).starts[i][k].values, promise.starts[i][k].values) << effect;
      }
    }
  }
  const Trial delayed = belief.candidates.fit({{"control_delay", {1e-4}}}, &own, belief.free.local, {Through::free, 2});
  EXPECT_TRUE(stillPromised(belief.references, delayed).empty());
  References beside_one = belief.references;
  beside_one.free = delayed;
  EXPECT_TRUE(stillPromised(beside_one, with).empty());
  Trial elsewhere = with;
  elsewhere.fit.chi2 += 10.0;
  EXPECT_TRUE(stillPromised(belief.references, elsewhere).empty());
}

}  // namespace
}  // namespace amb_rotor
