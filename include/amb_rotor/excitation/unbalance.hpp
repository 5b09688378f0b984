#pragma once
// Force of an unbalance U = m e [kg m] at phase p in the rotor: U times minus the second derivative of
// (cos, sin)(angle + p):  F = U (Omega^2 (cos, sin) + Omega' (sin, -cos)).   (thesis 3.33)
#include "amb_rotor/common/shaft.hpp"

namespace amb_rotor {

template <class S>
Vec2<S> unbalanceForce(const S& moment, const Vec2<S>& direction, const Shaft<S>& shaft) {
  const S centrifugal = moment * shaft.speed * shaft.speed;
  const S tangential = moment * shaft.acceleration;
  return {centrifugal * direction.x + tangential * direction.y,
          centrifugal * direction.y - tangential * direction.x};
}

}  // namespace amb_rotor
