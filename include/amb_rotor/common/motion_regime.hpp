#pragma once
// The names of the regimes of motion and the one set of rules that gives them, for measured series
// (analysis/regime.hpp) and for the machines of the lanes (machine/basic_regime.hpp) alike. Each side finds
// the facts its own way - a recording has noise, a lane has exact section points - and asks here.
//
// In this order:
//   diverged          not finite, or farther from the bearing's centre than diverged_ratio clearances
//   no_contact        never touched (whatever the period)
//   dry_whirl         contact for dry_whirl_fraction of the time (it may bounce), and backward round the
//   centre full_annular_rub  contact for annular_fraction of the time, period 1, once round forward a turn of
//   the shaft period            repeats after n turns undecided         none of these: the exponent, or the
//   series, decides between quasi_periodic and chaotic
//
// A largest Lyapunov exponent that was found over T turns counts as chaos above max(chaos_exponent,
// chaos_growth / T): over a finite time the tangent of a regular motion grows too (a sheared torus: like T,
// that is ln T in the logarithm), by less than e^chaos_growth.
//
// Units: lengths over the clearance, whirl in turns a turn of the shaft, exponents per turn. Errors: none.
// Source: thesis 5.4, 6.1. Left out: slip or roll of dry whirl (analysis/whirl.hpp).
#include <string>

namespace amb_rotor {

enum class Regime {
  no_contact,
  period,
  quasi_periodic,
  chaotic,
  full_annular_rub,
  dry_whirl,
  diverged,
  undecided
};

std::string toString(Regime regime);

struct RegimeRules {
  double diverged_ratio = 10.0;       ///< clearances
  double annular_fraction = 0.999;    ///< least contact fraction of the full annular rub
  double annular_speed_error = 0.01;  ///< whirl against spin, relative
  double dry_whirl_fraction = 0.9;    ///< least contact fraction of dry whirl
  double chaos_exponent = 0.01;       ///< per turn: two points e times further apart in 100 turns
  double chaos_growth = 2.5;          ///< natural logarithm of what a regular motion's tangent may grow
};

/// What is known of a motion.
struct MotionFacts {
  bool finite = true;
  double max_radius = 0.0;        ///< from the bearing's centre [clearances]
  bool touched = false;           ///< at all
  double contact_fraction = 0.0;  ///< of the time
  bool backward = false;          ///< goes round the bearing's centre against the spin all the time
  double whirl_ratio = 0.0;       ///< signed turns about the bearing's centre per turn of the shaft
  int period = 0;                 ///< turns; 0: does not repeat
};

/// The regime by the rules; undecided where the motion does not repeat and none of the others applies.
Regime regimeByRules(const MotionFacts& facts, const RegimeRules& rules = {});

/// Does an exponent [per turn] that was found over so many turns say chaos?
bool exponentIsChaotic(double exponent, double turns, const RegimeRules& rules = {});

}  // namespace amb_rotor
