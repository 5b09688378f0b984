// The rules of regimes, fact by fact.
#include "amb_rotor/common/motion_regime.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace amb_rotor {
namespace {

MotionFacts rub() {
  MotionFacts facts;
  facts.max_radius = 1.05;
  facts.touched = true;
  facts.contact_fraction = 1.0;
  facts.whirl_ratio = 1.0;
  facts.period = 1;
  return facts;
}

TEST(MotionRegime, EachFactAloneTurnsTheAnnularRubIntoSomethingElse) {
  EXPECT_EQ(regimeByRules(rub()), Regime::full_annular_rub);
  auto facts = rub();
  facts.whirl_ratio = 0.98;
  EXPECT_EQ(regimeByRules(facts), Regime::period);
  facts = rub();
  facts.period = 2;
  EXPECT_EQ(regimeByRules(facts), Regime::period);
  facts.period = 0;
  EXPECT_EQ(regimeByRules(facts), Regime::undecided);
  facts = rub();
  facts.contact_fraction = 0.99;
  EXPECT_EQ(regimeByRules(facts), Regime::period);
  facts = rub();
  facts.backward = true;
  EXPECT_EQ(regimeByRules(facts), Regime::dry_whirl);
  facts.contact_fraction = 0.89;
  EXPECT_NE(regimeByRules(facts), Regime::dry_whirl);
  facts = rub();
  facts.touched = false;
  EXPECT_EQ(regimeByRules(facts), Regime::no_contact);
}

TEST(MotionRegime, DivergedComesFirst) {
  auto facts = rub();
  facts.backward = true;
  facts.max_radius = 10.1;
  EXPECT_EQ(regimeByRules(facts), Regime::diverged);
  facts.max_radius = std::nan("");
  EXPECT_EQ(regimeByRules(facts), Regime::diverged);
  facts = rub();
  facts.finite = false;
  EXPECT_EQ(regimeByRules(facts), Regime::diverged);
}

TEST(MotionRegime, AShortRecordNeedsAClearExponent) {
  // Over 100 turns 2.5 / 100; over 1000 turns the floor of 0.01.
  EXPECT_FALSE(exponentIsChaotic(0.024, 100.0));
  EXPECT_TRUE(exponentIsChaotic(0.026, 100.0));
  EXPECT_FALSE(exponentIsChaotic(0.009, 1000.0));
  EXPECT_TRUE(exponentIsChaotic(0.011, 1000.0));
}

}  // namespace
}  // namespace amb_rotor
