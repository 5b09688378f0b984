// Standard deviations of what moves with the stator, a ring: chi2 is rough through impacts, and the bottom of one hollow is not
// the valley's.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>

#include "../support/long_tests.hpp"
#include "../support/through_contact.hpp"

namespace amb_rotor {
namespace {

/// A ring fitted from where it is, and the same with its covariance widened by how rough chi2 is.
struct Ring {
  explicit Ring(std::uint64_t seed) : set(madeSet(seed, "inner_ring_spin", 0.0, true, {"chirp_1", "rub_1", "drop_1"})) {
    const ThroughContact begun{set};
    free = begun.free;
    found = begun.fitted({truth}, {Through::all, 6, true});
    widened = begun.candidates.widenedByHollows(found, begun.references.prior);
    unchanged = begun.candidates.widenedByHollows(free, begun.references.prior);
  }
  /// The inertia's, of the logarithm that is fitted.
  double off() const { return std::fabs(found.fit.x[at()] - std::log(truth.values[0])); }
  double deviation(const Trial& trial) const { return std::sqrt(trial.fit.covariance(at(), at())); }
  int at() const { return found.space->nuisances(); }

  const MadeSet& set;
  EffectSetting truth = set.truth().effects.at(0);
  Trial free, found, widened, unchanged;
};

// In which hollow a fit ends hangs on the last digits of its sums: of several rings one at least is in one.
TEST(RoughValleys, ARingInAHollowIsNotStatedCloserThanHollowsAreDeep) {
  AMB_ROTOR_SKIP_UNLESS_LONG();
  int in_hollows = 0;
  for (const std::uint64_t seed : {4300145, 4300154, 4300158}) {
    const Ring ring(seed);
    EXPECT_LT(ring.off(), 3.0 * ring.deviation(ring.widened)) << seed;
    EXPECT_GE(ring.deviation(ring.widened), ring.deviation(ring.found)) << seed << ": never stated closer";
    if (ring.deviation(ring.widened) > 3.0 * ring.deviation(ring.found)) ++in_hollows;
  }
  EXPECT_GT(in_hollows, 0);
}

TEST(RoughValleys, WhereChi2IsSmoothTheCovarianceStays) {
  AMB_ROTOR_SKIP_UNLESS_LONG();
  int smooth = 0;
  for (const std::uint64_t seed : {4300150, 4300160}) {
    const Ring ring(seed);
    EXPECT_LT(ring.off(), 3.0 * ring.deviation(ring.found)) << seed;
    EXPECT_EQ(ring.unchanged.fit.covariance, ring.free.fit.covariance) << seed << ": without contact there are no hollows";
    EXPECT_GE(ring.deviation(ring.widened), ring.deviation(ring.found)) << seed << ": never stated closer";
    if (ring.widened.fit.covariance == ring.found.fit.covariance) ++smooth;
  }
  EXPECT_GT(smooth, 0) << "other hollows are in reach of every end";
}

/// Deviations that are ten times too large: chi2 rises along them as out of a hollow, far more than by the square of the way. Right ones
/// stay within what windows make of them.
TEST(RoughValleys, WhereTheWaysOutBeginSteepDeviationsGrowByTheRootOfThat) {
  const MadeSet& set = madeSet(2700099, "auxiliary_bearing_misalignment", 0.0, true, {"chirp_1", "rub_1", "drop_1"});
  const ThroughContact begun{set};
  const Trial found = begun.fitted(set.truth().effects, {Through::all, 6, true});
  Trial steep = found;
  steep.fit.covariance *= 100.0;
  const auto spread = [&](const Trial& trial) { return std::sqrt(trial.fit.covariance(found.space->nuisances(), found.space->nuisances())); };
  const double right = spread(begun.candidates.walked(found, begun.references.prior, 6)) / spread(found);
  const double wider = spread(begun.candidates.walked(steep, begun.references.prior, 6)) / spread(steep);
  EXPECT_LT(right, 3.0);
  EXPECT_GT(wider, 4.0);
  // a contact that is a little off where the walk begins, and fitted at all its places
  Trial beside = steep;
  const int contact = beside.space->nuisanceNamed("auxiliary_bearing.contact.stiffness_N_per_m");
  ASSERT_GE(contact, 0);
  beside.fit.x[contact] += 0.3;
  const Trial walked = begun.candidates.walked(beside, begun.references.prior, 6);
  EXPECT_EQ(walked.fit.x, beside.fit.x) << "there is no lower place";
  EXPECT_GT(spread(walked) / spread(steep), 4.0);
}

}  // namespace
}  // namespace amb_rotor
