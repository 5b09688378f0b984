#pragma once
// Excitations and faults of a scenario as functions of time: what acts on the machine from outside.
//
// A fault begins at start_s, grows linearly over ramp_s to its amount, and ends duration_s after its start
// (0: never). An impulse is a half sine over duration_s. Waveforms: step A; impulse A sin(pi t/T); sine
// A sin(2 pi f t); chirp A sin(2 pi (f0 t + (f1 - f0) t^2/(2 T))), linear in frequency.
//
// Valid: starts, ends and ramps are instants that a run does not integrate over.
// Source: thesis 4.2.1 (step of a current), 4.3 (power failure, overload); the other waveforms by definition.
// Left out: forces that depend on the motion (effects have them), noise.
#include <array>
#include <vector>

#include "amb_rotor/model/rig.hpp"
#include "amb_rotor/model/scenario.hpp"

namespace amb_rotor {

/// Starts and ends are told apart from an instant by this [s]: 0.1 + 0.2 is the instant 0.3.
constexpr double schedule_tolerance_s = 1e-10;

/// Value of an excitation at a time [N or A]. Whether it is on is decided at the instant `since`: between two
/// instants nothing starts or ends, so an integrator that comes from `since` sees a smooth force up to the next one.
double waveformValue(const Excitation& excitation, double time, double since);
inline double waveformValue(const Excitation& excitation, double time) {
  return waveformValue(excitation, time, time);
}

/// Share of its amount that a fault has at a time, 0..1 (impulse: its half sine); `since` as above.
double faultShare(const FaultEvent& fault, double time, double since);
inline double faultShare(const FaultEvent& fault, double time) { return faultShare(fault, time, time); }

class Schedule {
 public:
  Schedule() = default;
  Schedule(const std::vector<Excitation>& excitations, const std::vector<FaultEvent>& faults);

  /// Axial positions of the forces, and unbalances, that a machine must know planes for (ExtraPlanes).
  const std::vector<double>& forcePlanes() const { return force_planes_; }
  const std::vector<Unbalance<double>>& unbalances() const { return unbalances_; }

  /// Forces at forcePlanes() [N] at a time between the instant `since` and the next.
  void forces(double time, double since, std::vector<Vec2<double>>& out) const;
  void forces(double time, std::vector<Vec2<double>>& out) const { forces(time, time, out); }
  /// Whether a force is on from an instant on, whatever its value there.
  bool forcesOn(double since) const;
  /// Factors of unbalances().
  void unbalanceFactors(double time, double since, std::vector<double>& out) const;
  void unbalanceFactors(double time, std::vector<double>& out) const { unbalanceFactors(time, time, out); }
  /// Excitation current of an axis (0 ax, 1 ay, 2 bx, 3 by) [A]: the waveforms at `sampled`, the instant from which
  /// they are held, of what is on at `now` (what starts between the two is held at its start).
  double current(int axis, double sampled, double now) const;
  /// Offset of a sensor axis [m] at a time between the instant `since` and the next.
  double sensorOffset(int axis, double time, double since) const;
  double sensorOffset(int axis, double time) const { return sensorOffset(axis, time, time); }
  /// Whether a bearing axis is on. Instants count from their time on.
  bool bearingOn(int axis, double time) const;
  /// Instants at which something jumps or kinks, sorted.
  const std::vector<double>& breakpoints() const { return breakpoints_; }
  bool empty() const { return excitations_.empty() && faults_.empty(); }

 private:
  std::vector<Excitation> excitations_;
  std::vector<FaultEvent> faults_;
  std::vector<double> force_planes_, breakpoints_;
  std::vector<Unbalance<double>> unbalances_;
};

/// Whether a fault addresses an axis (0 ax, 1 ay, 2 bx, 3 by).
inline bool addresses(const FaultEvent& fault, int axis) {
  return (fault.end < 0 || fault.end == axis / 2) && (fault.axis < 0 || fault.axis == axis % 2);
}

}  // namespace amb_rotor
