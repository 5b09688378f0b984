#include "amb_rotor/machine/basic_regime.hpp"

#include <cmath>

#include "amb_rotor/common/check.hpp"

namespace amb_rotor {
namespace {

BasicMotion motionOf(const BasicLaneResult& r, std::size_t i, const BasicRegimeOptions& options) {
  BasicMotion motion;
  MotionFacts facts;
  facts.finite = !r.diverged[i];
  facts.max_radius = r.max_radius[i];
  facts.touched = r.contact_fraction[i] > 0.0;
  facts.contact_fraction = r.contact_fraction[i];
  facts.backward = r.whirl[i] < -0.5;
  facts.whirl_ratio = r.whirl[i];
  if (facts.finite) {
    facts.period =
        basicPeriod(&r.sections[i * static_cast<std::size_t>(r.turns_kept)], r.turns_kept, options);
  }
  motion.regime = regimeByRules(facts, options.rules);
  if (motion.regime == Regime::diverged) return motion;
  motion.period = facts.period;
  if (motion.regime == Regime::undecided) {
    motion.regime = exponentIsChaotic(r.lyapunov[i], r.turns_kept, options.rules) ? Regime::chaotic
                                                                                  : Regime::quasi_periodic;
  }
  return motion;
}

}  // namespace

int basicPeriod(const BasicState<double>* s, int turns, const BasicRegimeOptions& options) {
  const auto same = [&](int a, int b) {
    return std::hypot(s[b].x - s[a].x, s[b].y - s[a].y) < options.period_tolerance &&
           std::hypot(s[b].vx - s[a].vx, s[b].vy - s[a].vy) < 2.0 * options.period_tolerance;
  };
  for (int n = 1; n <= options.largest_period && 2 * n <= turns; ++n) {
    bool repeats = true;
    for (int t = 0; t + n < turns && repeats; ++t) repeats = same(t, t + n);
    // Steps that are small each time may still go round a closed curve, or settle: first against last.
    for (int t = 0; t < n && repeats; ++t) repeats = same(t, t + (turns - 1 - t) / n * n);
    if (repeats) return n;
  }
  return 0;
}

std::vector<BasicMotion> basicMotions(const BasicLaneResult& result, const BasicRegimeOptions& options) {
  AMB_ROTOR_CHECK(result.turns_kept > 0 && result.lyapunov.size() == result.machines,
                  "a regime needs kept turns and Lyapunov exponents");
  std::vector<BasicMotion> motions;
  motions.reserve(result.machines);
  for (std::size_t i = 0; i < result.machines; ++i) motions.push_back(motionOf(result, i, options));
  return motions;
}

}  // namespace amb_rotor
