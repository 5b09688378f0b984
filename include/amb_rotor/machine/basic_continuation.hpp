#pragma once
// Branches of periodic motion of the basic model, stable and unstable, with their bifurcations.
//
// A motion of period n turns is a fixed point of the map P over n turns (shooting, with located contact
// events: basic_orbit.hpp). Unknowns are the 4 states and the scaled parameter; the branch is followed by its
// arc length (predictor along the tangent, Newton corrector at right angles to it), so it goes round folds.
// Multipliers are the eigenvalues of dP: stable where all are inside the unit circle. Bifurcations, each
// bisected on the arc length:
//   fold            the branch turns back in the parameter (a multiplier at +1)
//   flip            a multiplier passes -1: a motion of twice the period begins
//   neimark_sacker  a complex pair passes the unit circle: quasi-periodic motion begins
//   grazing         the number of touch-downs in a period changes
//
// Units: dimensionless. Valid: orbits without tangential contact but at isolated grazing points (dP is
// continuous there, because the force is, but its slope is not). Errors: InputError for a start that does not
// settle to the period asked for, or repeats earlier. A branch that ends says why in `ended`; one of n turns
// ends where it joins a motion of fewer turns (the flip at which it begins or ends).
// Source: Seydel, Practical Bifurcation and Stability Analysis.
#include <array>
#include <complex>
#include <functional>
#include <string>
#include <vector>

#include "amb_rotor/machine/basic_orbit.hpp"
#include "amb_rotor/machine/basic_sweep.hpp"

namespace amb_rotor {

struct BranchPoint {
  double parameter = 0.0;
  BasicState<double> state;                           ///< at phase 0
  std::array<std::complex<double>, 4> multipliers{};  ///< largest first
  bool stable = false;
  double max_radius = 0.0, contact_fraction = 0.0;
  int touch_downs = 0;  ///< in a period
};

enum class BifurcationKind { fold, flip, neimark_sacker, grazing };
const char* name(BifurcationKind kind);

struct Bifurcation {
  BifurcationKind kind = BifurcationKind::fold;
  BranchPoint at;
  std::array<double, 4> direction{};  ///< flip: eigenvector of the multiplier -1, in phase units
};

struct Branch {
  int turns = 1;
  std::vector<BranchPoint> points;
  std::vector<Bifurcation> bifurcations;
  std::string ended;  ///< why, at both ends
};

struct ContinuationOptions {
  double from = 0.0, to = 0.0;  ///< of the parameter
  double first_step = 0.01, smallest_step = 1e-7,
         largest_step = 0.05;  ///< arc length, parameter scaled by to - from
  int most_points = 200;       ///< in each direction
  int most_turns = 4;          ///< flips are followed up to this period
  double newton_tolerance = 1e-9;
  std::function<void()> alive;  ///< called at every step; may throw to stop
};

/// One machine with one parameter free.
struct ContinuationProblem {
  NamedValues parameters;  ///< all but the free one
  std::string parameter;
  BasicOrbitOptions orbit;

  BasicParameters<double> machineAt(double value) const;
  /// d(machine)/d(value).
  BasicParameters<double> directionAt(double value) const;
};

/// The branch through the motion of `turns` turns near the given state. @throw InputError: there is none.
Branch followBranch(const ContinuationProblem& problem, const ContinuationOptions& options, double at,
                    const BasicState<double>& near, int turns);

/// What a sweep file's `continuation` leaves free. @throw InputError: a parameter that cannot be followed.
ContinuationProblem continuationProblem(const BasicSweep& sweep);

/// The branches of a sweep file's `continuation`, with those that begin at their flips.
/// At most 12 branches. `alive` is called at every step and may throw to stop.
std::vector<Branch> runContinuation(const BasicSweep& sweep, const std::function<void()>& alive = {});

}  // namespace amb_rotor
