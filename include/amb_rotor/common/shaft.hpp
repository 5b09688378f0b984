#pragma once
#include "amb_rotor/common/scalar.hpp"

namespace amb_rotor {

enum End : int { end_a = 0, end_b = 1 };

/// The shaft's rotation at an instant, and the instant. angle is 0 at the rising edge of the tacho pulse and grows with the
/// spin (positive about z).
template <class S>
struct Shaft {
  S angle = S(0.0);         ///< [rad]
  S cosine = S(1.0);        ///< of the angle
  S sine = S(0.0);          ///< of the angle
  S speed = S(0.0);         ///< [rad/s]
  S acceleration = S(0.0);  ///< [rad/s^2]
  double time = 0.0;        ///< of the run [s], for all lanes

  static Shaft at(const S& angle, const S& speed, const S& acceleration) {
    Shaft shaft;
    shaft.angle = angle;
    sineCosine(angle, shaft.sine, shaft.cosine);
    shaft.speed = speed;
    shaft.acceleration = acceleration;
    return shaft;
  }
};

/// (cos, sin) of an angle measured in the rotor; turn() brings it to the stator frame at a shaft angle
/// without a further sine.
template <class S>
struct RotorPhase {
  S cosine = S(1.0), sine = S(0.0);
  RotorPhase() = default;
  explicit RotorPhase(const S& phase) { sineCosine(phase, sine, cosine); }
  /// (cos, sin)(angle + phase)
  Vec2<S> turn(const Shaft<S>& shaft) const {
    return {shaft.cosine * cosine - shaft.sine * sine, shaft.sine * cosine + shaft.cosine * sine};
  }
  /// (cos, sin)(2 angle + phase)
  Vec2<S> turnTwice(const Shaft<S>& shaft) const {
    const S c2 = shaft.cosine * shaft.cosine - shaft.sine * shaft.sine;
    const S s2 = S(2.0) * shaft.sine * shaft.cosine;
    return {c2 * cosine - s2 * sine, s2 * cosine + c2 * sine};
  }
};

}  // namespace amb_rotor
