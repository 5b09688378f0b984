// A law is not fitted again where that leads nowhere else.
#include <gtest/gtest.h>

#include "../../src/validation/law_search.hpp"

namespace amb_rotor {
namespace {

Hypothesis law(std::vector<int> terms, double chi2) {
  Hypothesis out;
  out.terms = std::move(terms);
  out.chi2 = chi2;
  return out;
}

constexpr int glance = 2, to_the_end = 5;

TEST(FittedLaws, TwoFitsThatEndAlikeSettleTheirTermsAlone) {
  FittedLaws known;
  EXPECT_EQ(known.settled({7}, glance), nullptr);
  known.add(law({7}, 1000.0), glance);
  EXPECT_EQ(known.settled({7}, glance), nullptr) << "another start may lead elsewhere";
  EXPECT_EQ(known.add(law({7}, 1000.5), glance).chi2, 1000.0);
  ASSERT_NE(known.settled({7}, glance), nullptr);
  EXPECT_EQ(known.settled({7}, glance)->chi2, 1000.0);
  EXPECT_EQ(known.settled({7}, to_the_end), nullptr) << "two iterations are not the end";
  EXPECT_EQ(known.settled({7, 8}, glance), nullptr);
}

TEST(FittedLaws, FourFitsAreTheMost) {
  FittedLaws known;
  for (const double chi2 : {4000.0, 2000.0, 3000.0}) {
    known.add(law({2}, chi2), glance);
    EXPECT_EQ(known.settled({2}, glance), nullptr) << chi2;
  }
  EXPECT_EQ(known.add(law({2}, 5000.0), glance).chi2, 2000.0);
  ASSERT_NE(known.settled({2}, glance), nullptr);
  EXPECT_EQ(known.settled({2}, glance)->chi2, 2000.0) << "the best of them";
}

}  // namespace
}  // namespace amb_rotor
