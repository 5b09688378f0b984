// Standard deviations of what moves with the stator, a ring: chi2 is rough through impacts, and the bottom of one hollow is not
// the valley's.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>

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

TEST(RoughValleys, ARingInAHollowIsNotStatedCloserThanHollowsAreDeep) {
  const Ring ring(4300154);
  // in which hollow a fit ends hangs on the last digits: with AVX-512 in one 3 deviations off, with AVX2 at the truth
  if (!(ring.off() > 3.0 * ring.deviation(ring.found))) GTEST_SKIP() << "by this processor's arithmetic the fit ends at the truth";
  EXPECT_LT(ring.off(), 3.0 * ring.deviation(ring.widened));
}

TEST(RoughValleys, WhereChi2IsSmoothTheCovarianceStays) {
  const Ring ring(4300150);
  EXPECT_LT(ring.off(), 3.0 * ring.deviation(ring.found));
  EXPECT_EQ(ring.unchanged.fit.covariance, ring.free.fit.covariance) << "without contact there are no hollows";
  // where the fit ends hangs on the last digits of its sums: from some ends another hollow is in reach here, too
  if (!(ring.widened.fit.covariance == ring.found.fit.covariance)) {
    EXPECT_GE(ring.deviation(ring.widened), ring.deviation(ring.found)) << "never stated closer";
    GTEST_SKIP() << "by this processor's arithmetic the fit ends beside another hollow";
  }
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
}

}  // namespace
}  // namespace amb_rotor
