#pragma once
// The shaft's angle over time where something outside the equations of motion prescribes it.
//   constant  W;  ramp  W linear in time between two speeds;  decay  W = W0/(1 + a (t - t0))
// Valid: speeds that change little in a turn. Source: thesis 4.3 (decay); the others by definition.
// Left out: what the drive needs for it (a free spin is machine/machine.hpp's).
#include <vector>

#include "amb_rotor/model/scenario.hpp"

namespace amb_rotor {

/// Angle [rad], speed [rad/s] and acceleration [rad/s^2] at a time.
struct ShaftInstant {
  double angle = 0.0, speed = 0.0, acceleration = 0.0;
};

class ShaftPath {
 public:
  virtual ~ShaftPath() = default;
  virtual ShaftInstant at(double time) const = 0;
  virtual bool constantSpeed() const { return false; }
};

/// Constant speed: angle = angle0 + speed t, also before t = 0.
class ConstantShaft final : public ShaftPath {
 public:
  ConstantShaft(double angle0, double speed) : angle0_(angle0), speed_(speed) {}
  ShaftInstant at(double time) const override { return {angle0_ + speed_ * time, speed_, 0.0}; }
  bool constantSpeed() const override { return true; }

 private:
  double angle0_, speed_;
};

/// Piecewise motion with closed-form angle: linear speed, or the decay W0/(1 + a t) of thesis 4.3.
class PiecewiseShaft final : public ShaftPath {
 public:
  PiecewiseShaft(double angle0, double speed0);
  /// From `time` on the speed changes at a constant rate to `speed` over `duration` (0: a jump), then stays; what
  /// was planned after `time` is dropped.
  void rampTo(double time, double speed, double duration);
  /// From `time` on the speed falls as W0/(1 + factor (t - time)).
  void decayFrom(double time, double factor);
  ShaftInstant at(double time) const override;
  const std::vector<double>& breakpoints() const { return times_; }

 private:
  struct Piece {
    double start, angle, speed, slope, decay;
  };
  static ShaftInstant within(const Piece& piece, double time);
  void append(double time, double slope, double decay, const double* new_speed);
  std::vector<Piece> pieces_;
  std::vector<double> times_;
};

/// The path of a scenario: its speed law and its speed_change faults.
PiecewiseShaft shaftPath(const Scenario& scenario);

}  // namespace amb_rotor
