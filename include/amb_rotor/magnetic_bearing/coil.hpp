#pragma once
// Current of one axis driven by a limited voltage. Both coils of the axis carry i0 +- i; each is L, R and moves past
// the rotor:
//   v = R i + L i' + (Ki/2) x'          a coil's voltage less R i0 of the bias; its partner has -v
//   v = clip(R i + a L (c - i), V - R i0)    current loop of bandwidth a [rad/s] to the command c
// so without the limit i' = a (c - i) - (Ki/2L) x': the first-order lag, disturbed by the rotor's motion. At the limit
// the current slews with V/L less drop and motion, and comes to rest at v/R as exp(-t R/L).
// i [A] control current, x' [m/s] of the rotor towards the + coil, R [ohm], L [H], V [V] of one coil and its amplifier.
//
// The motional constant follows from the force: with flux linkages L (i0 +- i)(1 +- x/s0) the coils' co-energy has the
// slope Ki i along x where Ki = 2 L i0/s0, and d(linkage)/dt = +-(L i' + (Ki/2) x'). Energy: both coils take in
//   2 v i = 2 R i^2 + d(L i^2)/dt + Ki i x',
// and Ki i x' is what the control force gives the rotor.
// Valid: rotor near the centre of the gap, iron below its knee, both coils carrying current.
// Source: thesis 4.1 (120 V, 5 A); energies as above; Schweitzer and Maslen (eds.), Magnetic Bearings, Springer 2009.
// Left out: change of L with position and saturation, mutual inductance, current ripple, supply of the bias (which
// gives the power of Ks x).
#include "amb_rotor/common/scalar.hpp"
#include "amb_rotor/common/units.hpp"
#include "amb_rotor/model/control_options.hpp"
#include "amb_rotor/model/rig.hpp"

namespace amb_rotor {

template <class S>
class Coil {
 public:
  Coil(const Rig<S>& rig, const CoilCircuit& circuit)
      : resistance_(circuit.resistance_ohm),
        inductance_(circuit.inductance_H),
        rate_(S(two_pi) * rig.amb.amplifier_bandwidth_hz),
        motional_(S(0.5) * rig.amb.current_stiffness_N_per_A),
        limit_(maximum(S(circuit.voltage_limit_V) - S(circuit.resistance_ohm) * rig.amb.bias_current_A, S(0.0))) {}

  /// Voltage of the + coil less that of the bias [V].
  S voltage(const S& command, const S& current) const {
    const S wanted = S(resistance_) * current + rate_ * S(inductance_) * (command - current);
    return maximum(minimum(wanted, limit_), -limit_);
  }
  /// i' [A/s] at a velocity of the rotor [m/s].
  S slope(const S& command, const S& current, const S& velocity) const {
    return (voltage(command, current) - S(resistance_) * current - motional_ * velocity) / S(inductance_);
  }
  const S& limit() const { return limit_; }
  /// Current by velocity that the motion adds, Ki/(2 L) [A/m].
  S motionalGain() const { return motional_ / S(inductance_); }

 private:
  double resistance_, inductance_;
  S rate_, motional_, limit_;
};

}  // namespace amb_rotor
