#pragma once
// Shaft angle and speed from a sampled tacho channel: one pulse a turn, angle 0 at the rising edge.
//
// Edge: where the channel rises through the threshold. The samples of an edge hold intermediate values (a
// ramp over at least two samples), so the crossing is found between samples by a straight line:
//   t_e = t_i + (threshold - s_i)/(s_(i+1) - s_i) (t_(i+1) - t_i),
// exact for a straight ramp; with values rounded to q the error is uniform within q/2 times the ramp's time
// (0.001 and two samples of 0.1 ms: 1e-7 s at most, 6e-8 s rms). A channel without intermediate values has
// the error of half a sample: most edges go from below a tenth of the channel's range to above nine tenths of it between
// two samples. Such edges are only known to lie between these.
//
// Turns: edges are numbered by the turn k (angle 2 pi k). A pulse too many (two intervals that together are
// the period of their neighbours) is left out; an interval of about a whole number of neighbouring periods
// counts as that many turns (missing pulses). Both are reported, with dropouts (NaN samples, gaps in time).
//
// Angle between pulses, two models:
//   constant speed  theta = Omega (t - t_0) [+ a/2 (t - t_0)^2], least squares of the first N turns;
//   spline          the cubic spline (twice continuously differentiable, not-a-knot ends) through
//                   (t_k, 2 pi k); beyond the ends constant acceleration.
//   smoothed        where edges are only known to lie between samples: the first of a parabola and cubic splines of 1, 2,
//                   4 ... equal pieces that stays within that, by least squares of the edges' times. From 40 to 160 Hz in
//                   1.5 s at 10 kHz the spline is 0.018 rad rms off, the parabola 0.0015
//                   (AnalysisTacho.EdgesOfTwoLevelsAreSmoothed).
// Standstill: no pulse, constant value. The angle is then unknown (angle_known = false, speed 0, angle 0).
//
// Units: s, rad, rad/s, rad/s^2. The spin is taken as positive: one channel does not tell its direction.
// Valid: at least 3 samples a pulse, speed changing by less than about 30 % a turn where pulses are missing.
// Errors: InputError for lengths, thresholds. Too few pulses is a result, see TachoState.
// Source: project data sets (doc/formats.md); de Boor, A Practical Guide to Splines, not-a-knot.
#include <cstddef>
#include <optional>
#include <string>
#include <vector>

namespace amb_rotor {

struct TachoOptions {
  double threshold = 0.5;    ///< of the channel's value
  double hysteresis = 0.25;  ///< an edge counts once the value was below threshold - hysteresis; >= 0
};

/// Finds rising edges sample by sample.
class EdgeDetector {
 public:
  /// @throw InputError: threshold not finite, hysteresis below 0.
  explicit EdgeDetector(TachoOptions options = {});

  /// The time of a rising edge completed by this sample. NaN samples end the search for the edge they are in.
  std::optional<double> add(double time, double value);
  std::size_t nonFinite() const { return non_finite_; }

 private:
  TachoOptions options_;
  bool started_ = false, armed_ = false;
  double time_ = 0.0, value_ = 0.0;
  std::size_t non_finite_ = 0;
};

enum class TachoState {
  standstill,  ///< no edge, constant channel
  too_few,     ///< one edge, or changes without an edge: the speed is unknown
  turning      ///< two edges or more
};

/// What could not be taken as it is.
enum class TachoFaultKind { missing_pulse, double_pulse, dropout, irregular };

struct TachoFault {
  TachoFaultKind kind = TachoFaultKind::dropout;
  double time = 0.0;  ///< [s] where it begins
  int count = 1;      ///< pulses missing, samples lost
  std::string text() const;
};

/// Pulses of a record, in order.
struct TachoPulses {
  TachoState state = TachoState::standstill;
  std::vector<double> time;  ///< [s] of the rising edges kept
  std::vector<long> turn;    ///< turn number of each, first 0
  double half_width_s = 0.0;  ///< of the interval in which an edge lies; 0: values between the levels tell it closely
  double rounding_s = 0.0;  ///< standard deviation of an edge's time by the steps in which those values come; 0: none are seen
  std::vector<TachoFault> faults;
};

/// @throw InputError: lengths differ, options out of range.
TachoPulses findPulses(const std::vector<double>& time, const std::vector<double>& signal,
                       const TachoOptions& options = {});

/// Numbers raw edge times: leaves out double pulses, counts missing ones.
TachoPulses numberPulses(std::vector<double> edges);

/// Scatter of the edges' times [s], whatever smooth course the speed takes: the root mean square of their third differences over turns
/// that follow each other, over sqrt(1 + 9 + 9 + 1). 0: fewer than four such.
double edgeScatter(const TachoPulses& pulses);

/// Constant speed (or constant acceleration) from the first turns.
struct SpeedFit {
  bool valid = false;
  double speed = 0.0;         ///< [rad/s] at reference_time
  double speed_std = 0.0;     ///< [rad/s] from the scatter of the edges; 0 where too few to tell
  double acceleration = 0.0;  ///< [rad/s^2]; 0 for the constant speed
  double acceleration_std = 0.0;
  double reference_time = 0.0;  ///< [s] t_0, at which the angle is 0 (near the first edge)
  double edge_rms = 0.0;        ///< [s] of the edges about the fit
  int turns = 0;                ///< used
};

/// @param turns the first N turns; 0: all. @param with_acceleration fits the quadratic too (>= 3 edges).
/// @param edge_std [s] known least error of an edge's time (5.8e-8 for values rounded to 0.001 on a ramp of
/// 0.2 ms). The scatter about the fit alone can be far too small: near a whole number of samples a turn the
/// rounding repeats. @throw InputError: turns or edge_std below 0.
SpeedFit fitSpeed(const TachoPulses& pulses, int turns = 0, bool with_acceleration = false,
                  double edge_std = 0.0);

/// Shaft angle, speed and acceleration as functions of time.
class ShaftAngle {
 public:
  /// Standstill: angle 0, speed 0, angle not known.
  ShaftAngle() = default;
  explicit ShaftAngle(const SpeedFit& fit);
  /// Spline through all pulses; a straight line for two, a parabola for three. Smoothed where pulses have a width.
  explicit ShaftAngle(const TachoPulses& pulses);

  double angle(double time) const;         ///< [rad], 0 at the first rising edge
  double speed(double time) const;         ///< [rad/s]
  double acceleration(double time) const;  ///< [rad/s^2]
  bool angleKnown() const { return !time_.empty(); }
  std::vector<double> angles(const std::vector<double>& time) const;
  std::vector<double> speeds(const std::vector<double>& time) const;

 private:
  bool smooth(const TachoPulses& pulses, const std::vector<double>& angle);
  struct Place {
    std::size_t piece;
    double ahead;  ///< [s] after the piece's start
  };
  Place place(double time) const;

  std::vector<double> time_;  ///< starts of the pieces; the last entry ends the last piece
  std::vector<double> angle_, slope_, half_curvature_, third_;  ///< coefficients of each piece
};

}  // namespace amb_rotor
