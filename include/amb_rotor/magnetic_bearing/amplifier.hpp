#pragma once
// Amplifier of one axis: first-order lag behind a limited command that is constant between instants,
// so its current is known exactly at any time in between:
//   c = limited(command + excitation),  i(t) = c + (i(t0) - c) exp(-2 pi f (t - t0))
// Limit: the coils carry bias +- i, each within 0 and the largest current (none is left where the bias exceeds it).
// Valid: as long as the amplifier has the voltage for the current's slew; coil.hpp has that limit.
// Source: thesis 3.2.2, figure 3.11 (the amplifier in the loop), 4.1 (5 A); the lag itself is assumed, the thesis gives none.
// Left out: ripple of a switched amplifier, its dead time and its supply.
#include "amb_rotor/common/units.hpp"
#include "amb_rotor/model/rig.hpp"

namespace amb_rotor {

template <class S>
class Amplifier {
 public:
  Amplifier() = default;
  explicit Amplifier(const Rig<S>& rig)
      : rate_(S(two_pi) * rig.amb.amplifier_bandwidth_hz),
        limit_(maximum(minimum(rig.amb.bias_current_A, rig.amb.max_current_A - rig.amb.bias_current_A), S(0.0))) {}

  S limited(const S& command) const { return maximum(minimum(command, limit_), -limit_); }
  /// exp(-2 pi f dt), the share of the difference that is left after dt [s].
  S decay(double dt) const { return exponential(-rate_ * S(dt)); }
  const S& rate() const { return rate_; }

 private:
  S rate_ = S(1.0), limit_ = S(0.0);
};

}  // namespace amb_rotor
