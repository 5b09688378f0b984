#pragma once
// What kind of motion a machine of the lanes settled to: the rules of common/motion_regime.hpp, with the
// facts of the lanes:
//
//   period    repeats after n <= 16 turns: the section points n turns apart differ by less than
//             period_tolerance (velocities by twice that), over all kept turns, and so do the first and the
//             last of each class, so that a slow drift round a closed curve is no period. Stricter than for
//             measured series, because a lane has no noise
//   backward  more than half a turn backward about the bearing's centre a turn of the shaft (no circle
//             about a point on one side of the centre gives that)
//   contact, radius, whirl: over the kept turns
//
// A motion that does not repeat is chaotic or quasi_periodic by its Lyapunov exponent. The period is decided
// before the exponent: a transient that has not died out within the skipped turns shows as quasi_periodic,
// not as a period. Dry whirl with spin friction has nothing that limits it (the friction never reverses), so
// it ends as diverged where the damping does not hold it; sliding friction limits it at rolling.
#include <vector>

#include "amb_rotor/common/motion_regime.hpp"
#include "amb_rotor/machine/basic_lanes.hpp"

namespace amb_rotor {

struct BasicRegimeOptions {
  RegimeRules rules;
  int largest_period = 16;         ///< [turns]
  double period_tolerance = 1e-3;  ///< [clearance]
};

struct BasicMotion {
  Regime regime = Regime::diverged;
  int period = 0;  ///< turns after which the motion repeats; 0: not within the largest period
};

/// Smallest n for which all section points n turns apart agree; 0: none, or fewer than 2 n points.
int basicPeriod(const BasicState<double>* sections, int turns, const BasicRegimeOptions& options = {});

/// The motion of each machine of a result. @throw InvariantError: no kept turns, or no Lyapunov exponents.
std::vector<BasicMotion> basicMotions(const BasicLaneResult& result, const BasicRegimeOptions& options = {});

}  // namespace amb_rotor
