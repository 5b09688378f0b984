#include "amb_rotor/machine/basic_regime.hpp"

#include <cmath>

#include "amb_rotor/common/check.hpp"

namespace amb_rotor {
namespace {

constexpr double always = 0.999;       // share of the time that counts as all the time
constexpr double forward_turn = 0.01;  // a forward whirl may miss one turn a turn by this

BasicMotion motionOf(const BasicLaneResult& r, std::size_t i, const BasicRegimeOptions& options) {
  BasicMotion motion;
  if (r.diverged[i]) return motion;
  motion.period = basicPeriod(&r.sections[i * static_cast<std::size_t>(r.turns_kept)], r.turns_kept, options);
  const bool pressed = r.contact_fraction[i] > always;
  // Backward about the centre: no circle about a point on one side of it gives half a turn a turn.
  if (pressed && r.whirl[i] < -0.5) {
    motion.regime = BasicRegime::dry_whirl;
  } else if (pressed && motion.period == 1 && std::abs(r.whirl[i] - 1.0) < forward_turn) {
    motion.regime = BasicRegime::full_annular_rub;
  } else if (motion.period == 1 && r.contact_fraction[i] == 0.0) {
    motion.regime = BasicRegime::no_contact;
  } else if (motion.period > 0) {
    motion.regime = BasicRegime::period;
  } else if (r.lyapunov[i] * r.turns_kept > options.chaos_growth) {
    motion.regime = BasicRegime::chaotic;
  } else {
    motion.regime = BasicRegime::quasi_periodic;
  }
  return motion;
}

}  // namespace

const char* name(BasicRegime regime) {
  switch (regime) {
    case BasicRegime::no_contact:
      return "no_contact";
    case BasicRegime::period:
      return "period";
    case BasicRegime::quasi_periodic:
      return "quasi_periodic";
    case BasicRegime::chaotic:
      return "chaotic";
    case BasicRegime::full_annular_rub:
      return "full_annular_rub";
    case BasicRegime::dry_whirl:
      return "dry_whirl";
    case BasicRegime::diverged:
      return "diverged";
  }
  return "";
}

int basicPeriod(const BasicState<double>* s, int turns, const BasicRegimeOptions& options) {
  for (int n = 1; n <= options.largest_period && 2 * n <= turns; ++n) {
    bool repeats = true;
    for (int t = 0; t + n < turns && repeats; ++t) {
      repeats = std::hypot(s[t + n].x - s[t].x, s[t + n].y - s[t].y) < options.period_tolerance &&
                std::hypot(s[t + n].vx - s[t].vx, s[t + n].vy - s[t].vy) < 2.0 * options.period_tolerance;
    }
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
