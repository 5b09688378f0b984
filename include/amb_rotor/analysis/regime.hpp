#pragma once
// What kind of motion it is, decided by numbers: from stroboscopic points, contact and whirl in one plane.
//
// The rules and their order are those of common/motion_regime.hpp, with the facts from the measured series:
// backward is a whirl that is resolved and whose path is forward for at most dry_whirl_forward. A motion that
// does not repeat is
//   chaotic           by its largest Lyapunov exponent; without one: 0-1 test K > 0.5, predictable
//   quasi_periodic    else
//   undecided         too few points (period 0, certain = false)
// Scatter that cannot be predicted from the points before (determinism.hpp) is noise, not chaos: the motion
// is then the period n of its class means, with certain = false and the scatter given.
//
// Period: e_n = rms |p_(k+n) - p_k| / clearance. n is the smallest with e_n <= tolerance and
// e_n <= max(tolerance/5, 2 min_m e_m), and the points n m turns apart (m large) must be within the tolerance
// too, else it is a slow drift round a closed curve. Measurement noise of s clearances rms an axis gives e_n
// = 2 s in every e_n: a tolerance of 0.01 stands noise of 0.5 %, and tells a period doubling apart from noise
// of 0.1 % when the two points are more than 0.4 % of the clearance apart.
//
// Units: SI; frame inertial, spin positive. The transient is the caller's to leave out.
// Valid: 3 n points for period n; 120 points, better 300, to tell quasi-periodic from chaotic without
// exponent. Source: thesis 5.4, 6.1; specification of the command line (names). Left out: coexisting motions,
// hysteresis (a regime is of one run).
#include <Eigen/Core>
#include <optional>
#include <string>
#include <vector>

#include "amb_rotor/analysis/contact.hpp"
#include "amb_rotor/analysis/poincare.hpp"
#include "amb_rotor/analysis/whirl.hpp"
#include "amb_rotor/common/motion_regime.hpp"

namespace amb_rotor {

struct RegimeInput {
  std::vector<PoincarePoint> points;  ///< stroboscopic, consecutive turns
  double clearance = 0.0;             ///< [m] > 0
  double max_radius = 0.0;            ///< [m] about the bearing's centre
  double spin = 0.0;                  ///< [rad/s]
  double rotor_radius = 0.0;          ///< [m] at the auxiliary bearing; 0: not known, slip stays undefined
  ContactStatistics contact;
  WhirlState whirl;                        ///< about the auxiliary bearing's centre
  std::optional<double> largest_lyapunov;  ///< per turn
};

struct RegimeOptions {
  RegimeRules rules;
  int max_period = 16;
  double dry_whirl_forward = 0.1;   ///< largest forward share of the path
  double rolling_tolerance = 0.05;  ///< slip speed over surface speed
  double chaos_number = 0.5;        ///< K of the 0-1 test above this: not regular
  double forecast_limit = 0.7;      ///< forecast ratio above this: random
};

struct RegimeResult {
  Regime regime = Regime::undecided;
  int period = 0;                       ///< n; 0: does not repeat within max_period
  bool certain = false;                 ///< false: too few points, or noise larger than the tolerance
  SlipKind slip = SlipKind::undefined;  ///< of dry whirl
  double repeat_error = 0.0;            ///< e_n of the period, else the smallest e_n [clearances]
  double scatter = 0.0;                 ///< [clearances] rms about the class means where it is noise
  double winding_number =
      0.0;  ///< turns of the points about their centroid per shaft turn, quasi-periodic only
  double chaos_number = 0.0;    ///< K, where it was needed
  double forecast_ratio = 0.0;  ///< where it was needed
  std::string reason;           ///< one line for people
};

/// Period of a series of states.
struct PeriodDetection {
  int period = 0;             ///< 0: none
  double repeat_error = 0.0;  ///< see RegimeResult
};

/// @param points one state a column, in units in which the tolerance is meant (clearances).
/// @throw InputError: tolerance not above 0, max_period below 1.
PeriodDetection detectPeriod(const Eigen::MatrixXd& points, double tolerance, int max_period = 16);

/// @param tolerance of the period detection, in clearances; 0.01 suits measured and simulated motion, 1e-4 a
/// clean simulation in which fine period doublings are to be seen.
/// @throw InputError: tolerance or clearance not above 0.
RegimeResult decideRegime(const RegimeInput& input, double tolerance, const RegimeOptions& options = {});

}  // namespace amb_rotor
