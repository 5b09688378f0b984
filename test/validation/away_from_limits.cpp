// Where fits begin anew that have left an effect at a limit of its parameters.
#include <gtest/gtest.h>

#include "../../src/validation/candidates.hpp"
#include "../support/made_sets.hpp"
#include "amb_rotor/validation/starts.hpp"

namespace amb_rotor {
namespace {

constexpr const char* falling_friction = "velocity_dependent_friction";

TEST(AwayFromLimits, WhatStandsThereGoesBackToAStartAloneAndWithTheOthers) {
  const MadeSet& set = madeSet(4300147, "auxiliary_bearing_misalignment", 0.0, true, {"chirp_1", "rub_1", "drop_1"});
  const Candidates candidates(set.dataset.belief, set.dataset);
  std::string unused;
  const auto starts = startingValues(falling_friction, set.dataset.belief, set.recordings, unused);
  ASSERT_FALSE(starts.empty());
  const std::vector<double>& middle = starts[starts.size() / 2];
  const auto away = [&](const std::vector<double>& values) {
    const EffectSetting effect{falling_friction, values};
    const FitSpace space(set.dataset.belief, {effect});
    return candidates.awayFromLimits(space, space.start(), effect);
  };
  const double most = effectCatalogue().find(falling_friction)->parameters[0].upper;
  EXPECT_TRUE(away({0.3, 0.06, 1.7}).empty());
  const auto both = away({most, 0.06, 0.2});
  ASSERT_EQ(both.size(), 2u);
  EXPECT_EQ(both[0].values, (std::vector<double>{middle[0], 0.06, 0.2}));
  EXPECT_EQ(both[1].values, middle);
  EXPECT_EQ(away({most, middle[1], middle[2]}).size(), 1u) << "the others are there already";
}

}  // namespace
}  // namespace amb_rotor
