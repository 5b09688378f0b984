#pragma once
// What kind of motion a machine of the lanes settled to, decided from numbers:
//
//   diverged          not finite, or farther than 1e6 clearances
//   full_annular_rub  in contact all the time, one forward turn about the bearing's centre a turn of the
//   shaft dry_whirl         in contact all the time and whirling backward about the bearing's centre
//   no_contact        never in contact and repeats every turn
//   period            repeats after n <= 16 turns: the section points n turns apart differ by less than
//                     `period_tolerance` (velocities by twice that), over all kept turns
//   chaotic           none of these, largest Lyapunov exponent above `chaos_growth` / kept turns a turn
//   quasi_periodic    the rest
//
// The period is decided before the exponent: a transient that has not died out within the skipped turns shows
// as quasi_periodic, not as a period.
// Dry whirl with spin friction has nothing that limits it (the friction never reverses), so it ends as
// diverged where the damping does not hold it; sliding friction limits it at rolling.
#include <string>
#include <vector>

#include "amb_rotor/machine/basic_lanes.hpp"

namespace amb_rotor {

enum class BasicRegime { no_contact, period, quasi_periodic, chaotic, full_annular_rub, dry_whirl, diverged };
const char* name(BasicRegime regime);

struct BasicRegimeOptions {
  int largest_period = 16;         ///< [turns]
  double period_tolerance = 1e-3;  ///< [clearance]
  double chaos_growth =
      2.5;  ///< growth of a tangent over all kept turns [natural logarithm] that is no chaos yet
};

struct BasicMotion {
  BasicRegime regime = BasicRegime::diverged;
  int period = 0;  ///< turns after which the motion repeats; 0: not within the largest period
};

/// Smallest n for which all section points n turns apart agree; 0: none, or fewer than 2 n points.
int basicPeriod(const BasicState<double>* sections, int turns, const BasicRegimeOptions& options = {});

/// The motion of each machine of a result. @throw InvariantError: no kept turns, or no Lyapunov exponents.
std::vector<BasicMotion> basicMotions(const BasicLaneResult& result, const BasicRegimeOptions& options = {});

}  // namespace amb_rotor
