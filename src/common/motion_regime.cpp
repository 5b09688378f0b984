#include "amb_rotor/common/motion_regime.hpp"

#include <algorithm>
#include <cmath>

namespace amb_rotor {

std::string toString(Regime regime) {
  switch (regime) {
    case Regime::no_contact:
      return "no_contact";
    case Regime::period:
      return "period";
    case Regime::quasi_periodic:
      return "quasi_periodic";
    case Regime::chaotic:
      return "chaotic";
    case Regime::full_annular_rub:
      return "full_annular_rub";
    case Regime::dry_whirl:
      return "dry_whirl";
    case Regime::diverged:
      return "diverged";
    case Regime::undecided:
      break;
  }
  return "undecided";
}

Regime regimeByRules(const MotionFacts& facts, const RegimeRules& rules) {
  if (!facts.finite || !(facts.max_radius <= rules.diverged_ratio)) return Regime::diverged;
  if (!facts.touched) return Regime::no_contact;
  if (facts.backward && facts.contact_fraction >= rules.dry_whirl_fraction) return Regime::dry_whirl;
  if (facts.contact_fraction >= rules.annular_fraction && facts.period == 1 &&
      std::fabs(facts.whirl_ratio - 1.0) <= rules.annular_speed_error) {
    return Regime::full_annular_rub;
  }
  return facts.period > 0 ? Regime::period : Regime::undecided;
}

bool exponentIsChaotic(double exponent, double turns, const RegimeRules& rules) {
  return exponent > std::max(rules.chaos_exponent, rules.chaos_growth / turns);
}

}  // namespace amb_rotor
