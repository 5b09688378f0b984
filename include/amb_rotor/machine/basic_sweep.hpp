#pragma once
// Sweeps of the basic model: a file says which parameters are swept over which values, the lanes run every
// point of the grid, and each point gets its regime. The format amb-sweep/1 is described in
// doc/formats_sweep.md.
//
// Errors: InputError with every fault of the file, each with its line and key.
#include <string>
#include <utility>
#include <vector>

#include "amb_rotor/machine/basic_lanes.hpp"
#include "amb_rotor/machine/basic_regime.hpp"

namespace amb_rotor {

/// A value of a parameter as a file names it.
using NamedValues = std::vector<std::pair<std::string, double>>;

/// One axis of the grid.
struct SweptParameter {
  std::string parameter;
  std::vector<double> values;
};

/// The branch that `amb continue` follows; see basic_continuation.hpp.
struct ContinuationRequest {
  bool given = false;
  std::string parameter;
  double from = 0.0, to = 0.0;  ///< range of the parameter
  double first_step = 0.0;      ///< of the arc length
  struct Start {
    double at = 0.0;  ///< value of the parameter at which the lanes settle to the first orbit
    int turns = 1;    ///< period
    double x = 0.0, y = 0.0, vx = 0.0, vy = 0.0;  ///< initial state of that run
  };
  std::vector<Start> starts;
};

/// What a sweep file says.
struct BasicSweep {
  std::string name, title, source;
  NamedValues parameters;                   ///< those that are not swept
  std::vector<BasicState<double>> initial;  ///< one
  std::vector<SweptParameter> swept;        ///< one or two; the last runs fastest
  BasicLaneOptions run;
  BasicRegimeOptions regime;
  ContinuationRequest continuation;

  std::size_t size() const;  ///< points of the grid
  /// Swept values of a point, in the order of `swept`.
  std::vector<double> valuesAt(std::size_t point) const;
  BasicParameters<double> machineAt(std::size_t point) const;
  BasicState<double> initialAt(std::size_t point) const;  ///< over the point's clearance

 private:
  NamedValues namedAt(std::size_t point) const;
};

/// The clearance over the one that all other lengths of a file are over, c: the same machine in a wider or
/// narrower bearing. Its own dimensionless values are e/c, x_s/c, y_s/c, rho/c, v_0/c, kappa sqrt(c) and a c,
/// its states over its own clearance. 1 where it is not named.
extern const char* const clearance_name;
/// Names that a file may give or sweep: those of BasicParameters, with the polar form of the misalignment
/// (misalignment, misalignment_angle_deg) and unbalance_phase_deg instead of their plain fields, and the
/// clearance.
std::vector<std::string> basicParameterNames();
/// Machine with the named values set. @throw InputError: a name that is not known, a clearance of 0 or less.
BasicParameters<double> basicParametersFrom(const NamedValues& values);
/// The named clearance, 1 without one. @throw InputError: 0 or less.
double clearanceOf(const NamedValues& values);
/// A state over the file's clearance as one over the machine's own.
BasicState<double> overOwnClearance(const BasicState<double>& state, const NamedValues& values);

BasicSweep readBasicSweep(const std::string& path);

/// Points [first, first + count) of the grid: for progress, and to go on after an interruption.
struct BasicSweepPart {
  BasicLaneResult lanes;
  std::vector<BasicMotion> motions;
};
BasicSweepPart runBasicSweep(const BasicSweep& sweep, std::size_t first, std::size_t count);

/// Exponent of the flow [w_n] from that of a turn.
double exponentPerTime(double per_turn, double frequency_ratio);

}  // namespace amb_rotor
