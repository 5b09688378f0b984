// In which order candidates are looked at: what may make the rest cheap comes first, what takes long comes last.
#include <gtest/gtest.h>

#include "../../src/validation/screening.hpp"

namespace amb_rotor {
namespace {

Trial valued(const char* effect, double evidence, bool looked_at = true) {
  Trial trial;
  trial.effect = effect;
  trial.fit.finite = looked_at;
  trial.evidence = evidence;
  return trial;
}

TEST(ScreeningOrder, WhatStoodOutAloneIsLookedAtFirstTheNextTime) {
  const std::vector<Trial> alone = {valued("static_load", 10.0), valued("shaft_bow", 300.0), valued("control_delay", 20.0),
                                    valued("sensor_runout", 1e9, false)};  // that was not looked at: nothing is known of it
  EXPECT_EQ(likeliestFirst({"sensor_runout", "static_load", "control_delay", "shaft_bow"}, alone),
            (std::vector<std::string>{"shaft_bow", "control_delay", "static_load", "sensor_runout"}));
}

TEST(ScreeningOrder, WhatTakesLongComesLastWhateverItWas) {
  const std::vector<Trial> alone = {valued("compliant_mount", 1e6), valued("hertzian_contact", 1e5), valued("static_load", 10.0)};
  EXPECT_EQ(likeliestFirst({"static_load", "hertzian_contact", "compliant_mount"}, alone),
            (std::vector<std::string>{"static_load", "hertzian_contact", "compliant_mount"}));
}

TEST(ScreeningOrder, ContactComesAfterTheRestInTheOrderGiven) {
  std::vector<std::string> names = {"inner_ring_spin", "auxiliary_bearing_misalignment", "static_load", "compliant_mount", "shaft_bow"};
  slowLast(names);
  EXPECT_EQ(names, (std::vector<std::string>{"static_load", "shaft_bow", "inner_ring_spin", "auxiliary_bearing_misalignment",
                                             "compliant_mount"}));
}

TEST(ScreeningOrder, ContendersKeepTheirOrderWhateverAShortLookGave) {
  // friction that falls and a ring that runs along: looked at in full, friction left nothing, and the ring had led
  const std::vector<Trial> either = {valued("inner_ring_spin", 1.5e5), valued("velocity_dependent_friction", 1.1e5),
                                     valued("auxiliary_bearing_misalignment", 2e3), valued("hertzian_contact", 4e3)};
  EXPECT_EQ(contendersFirst({"auxiliary_bearing_misalignment", "hertzian_contact", "velocity_dependent_friction", "inner_ring_spin"}, either),
            (std::vector<std::string>{"velocity_dependent_friction", "inner_ring_spin", "hertzian_contact", "auxiliary_bearing_misalignment"}));
}

TEST(ScreeningOrder, WhatTakesLongDoesNotWaitForWhatCannotBeIt) {
  const std::vector<std::string> names = {"hertzian_contact", "inner_ring_spin", "compliant_mount"};
  const std::vector<Trial> mount = {valued("hertzian_contact", 3e3), valued("inner_ring_spin", -1e6), valued("compliant_mount", 3e5)};
  EXPECT_EQ(contendersFirst(names, mount), (std::vector<std::string>{"compliant_mount", "hertzian_contact", "inner_ring_spin"}));
  const std::vector<Trial> either = {valued("hertzian_contact", 1e5), valued("inner_ring_spin", 2e3), valued("compliant_mount", 3e5)};
  EXPECT_EQ(contendersFirst(names, either), (std::vector<std::string>{"hertzian_contact", "compliant_mount", "inner_ring_spin"}));
}

/// Beside a bearing that is not linear a ring had a full look first, left little, and the mount that was there none.
TEST(ScreeningOrder, OfTwoThatTakeLongTheLikelierComesFirst) {
  const std::vector<Trial> seen = {valued("velocity_dependent_friction", 1e2), valued("inner_ring_spin", 1.6e4), valued("compliant_mount", 4.5e4)};
  EXPECT_EQ(contendersFirst({"velocity_dependent_friction", "inner_ring_spin", "compliant_mount"}, seen),
            (std::vector<std::string>{"compliant_mount", "inner_ring_spin", "velocity_dependent_friction"}));
}

/// Looks at a ring take all windows, ten times as long as a mount's: a ring that led a short look by 1.7 stood at 4.8 times the noise's
/// square after three minutes, and the mount that was there left nothing.
TEST(ScreeningOrder, ARingIsLookedAtFirstOnlyWhereItIsPlainlyAhead) {
  const std::vector<std::string> names = {"inner_ring_spin", "compliant_mount"};
  EXPECT_EQ(contendersFirst(names, {valued("inner_ring_spin", 1.6e5), valued("compliant_mount", 1.1e5)}),
            (std::vector<std::string>{"compliant_mount", "inner_ring_spin"}));
  EXPECT_EQ(contendersFirst(names, {valued("inner_ring_spin", 3e5), valued("compliant_mount", 1e5)}), names);
}

/// A ring's look ended at 168 times the noise's square, a mount's, which was there, with half of that evidence. The mount's full look took
/// twenty seconds; the ring's came down to four times the noise in four minutes, and was adopted.
TEST(ScreeningOrder, ARingThatIsLeftFarFromTheNoiseComesAfterItsRivals) {
  const std::vector<std::string> names = {"inner_ring_spin", "compliant_mount"};
  for (const double left : {1.2, 168.0}) {
    Trial ring = valued("inner_ring_spin", 2.1e5);
    ring.fit.count = 1e4;
    ring.fit.squares = left * ring.fit.count;
    EXPECT_EQ(contendersFirst(names, {ring, valued("compliant_mount", 1e5)})[0] == "inner_ring_spin", left < 1.5) << left;
  }
}

/// Of a reference 110 times the noise off a ring stood at 0.80 before its look and a mount at 0.81; the ring's look left under a
/// thousandth, which was seven times the noise's square.
TEST(ScreeningOrder, WhatStandsAsNearAsTheFirstIsLookedAt) {
  EXPECT_TRUE(isInSight(0.81, 0.80, true));
  EXPECT_FALSE(isInSight(0.88, 0.80, true));
  EXPECT_TRUE(isInSight(0.49, 0.01, true)) << "at half, wherever the first stood";
  EXPECT_FALSE(isInSight(0.51, 0.01, true));
  EXPECT_TRUE(isInSight(1.4, 0.01, false));
  EXPECT_FALSE(isInSight(1.6, 0.01, false));
}

}  // namespace
}  // namespace amb_rotor
