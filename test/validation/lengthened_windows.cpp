// Fits through contact in which windows of the usual length go astray.
#include <gtest/gtest.h>

#include "../../src/validation/candidates.hpp"
#include "../support/made_sets.hpp"

namespace amb_rotor {
namespace {

TEST(LengthenedWindows, LeadToABearingThatIsFarAside) {
  // Offsets of up to 70 um at a contact of 1.4e8 N/m: some ten impacts in a window of 10 ms.
  const MadeSet& set = madeSet(4300147, "auxiliary_bearing_misalignment", 0.0, true, {"chirp_1", "rub_1", "drop_1"});
  const EffectSetting truth = set.truth().effects.at(0);
  const Candidates candidates(set.dataset.belief, set.dataset);
  const std::vector<LocalState> fresh(set.recordings.size());
  const Trial free = candidates.fit({}, nullptr, fresh, {Through::free, 10});
  const References references = candidates.referencesOf(free, free);
  const FitEffort effort = {Through::contact, 12, false, true};
  const Eigen::VectorXd own = references.contact.nuisance();
  const Trial astray = candidates.fit({{truth.id, {0.0, 0.0, 0.0, 0.0}}}, &own, references.contact.local, effort, &references.prior);
  ASSERT_TRUE(isAstray(astray)) << "windows of the usual length find it alone, and this shows nothing";
  const Trial found = candidates.lengthened(astray, effort, &references.prior);
  EXPECT_FALSE(isAstray(found));
  for (std::size_t k = 0; k < truth.values.size(); ++k)  // some ten deviations of a fit to all windows, 1 % of what was missing
    EXPECT_NEAR(found.effects()[0].values[k], truth.values[k], 7e-7) << k;
}

}  // namespace
}  // namespace amb_rotor
