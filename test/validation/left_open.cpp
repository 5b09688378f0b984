// An error through contact that the runs to fit leave open is told from one that has structure.
#include <gtest/gtest.h>

#include <cmath>

#include "../../src/validation/candidates.hpp"
#include "../support/long_tests.hpp"
#include "../support/made_sets.hpp"

namespace amb_rotor {
namespace {

/// By which share the contact is stiffer than it was found: several times the noise in what the windows hold.
constexpr double stiffer = 0.4;

class LeftOpenTest : public ::testing::Test {
 protected:
  struct Set {
    const MadeSet& set = madeSet(21, "none", 0.0, true);
    Candidates candidates{set.dataset.belief, set.dataset};
    Trial found = candidates.fit({}, nullptr, std::vector<LocalState>(set.recordings.size()), {Through::all, 6, true});
  };
  static Set& all() {
    static Set once;
    return once;
  }
  /// As found, but with another contact stiffness, said to be known to `std` (of its logarithm).
  Trial stated(double off, double std) const { return stated("auxiliary_bearing.contact.stiffness_N_per_m", off, std); }
  Trial stated(const std::string& name, double off, double std) const {
    Trial out = all().found;
    int k = 0;
    while (out.space->coordinates()[k].name != name) ++k;
    out.fit.x[k] += off;
    out.fit.covariance.row(k).setZero();
    out.fit.covariance.col(k).setZero();
    out.fit.covariance(k, k) = std * std;
    return out;
  }
  static double errorOf(Trial trial) { return all().candidates.judge(trial, true, Judging::anew).validation_error_contact; }
};

TEST_F(LeftOpenTest, WhatMovesWithinItsDeviationsReachesTheRunsToValidate) {
  AMB_ROTOR_SKIP_UNLESS_LONG();
  const Trial off = stated(stiffer, 0.2);
  const double floor = errorOf(all().found);
  ASSERT_GT(errorOf(off), 1.5 * floor) << "it makes no difference, and this shows nothing";
  const LeftOpen open = all().candidates.leftOpen(off, Through::contact);
  EXPECT_LT(open.error, 1.05 * floor);
  EXPECT_GT(open.deviations, 0.9 * stiffer / 0.2);  // a prior of that width holds it back a little
  EXPECT_TRUE(open.byChance()) << open.deviations;
}

TEST_F(LeftOpenTest, SoDoesWhatMovesWithoutContact) {
  const double mass = all().set.dataset.belief.rig.rotor.mass_kg, lighter = -0.05 * mass;
  const Trial off = stated("rotor.mass_kg", lighter, 0.025 * mass);
  const auto freeError = [](Trial trial) { return all().candidates.judge(trial, false, Judging::anew).validation_error_free; };
  const double floor = freeError(all().found);
  ASSERT_GT(freeError(off), 1.2 * floor) << "it makes no difference, and this shows nothing";
  const LeftOpen open = all().candidates.leftOpen(off, Through::free);
  EXPECT_NEAR(open.error, floor, 0.01 * floor);
  EXPECT_GT(std::fabs(errorOf(all().found) - floor), 0.02 * floor) << "the runs with contact would do as well, and this shows nothing";
  EXPECT_TRUE(open.byChance()) << open.deviations;
  EXPECT_FALSE(all().candidates.leftOpen(stated("rotor.mass_kg", lighter, 0.0025 * mass), Through::free).byChance());
}

TEST_F(LeftOpenTest, WhatIsStatedCloserDoesNot) {
  EXPECT_FALSE(all().candidates.leftOpen(stated(stiffer, 0.02), Through::contact).byChance());
}

}  // namespace
}  // namespace amb_rotor
