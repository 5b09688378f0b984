#pragma once
// Force of an unbalance U = m e [kg m] at phase p in the rotor: U times minus the second derivative of
// (cos, sin)(angle + p):  F = U (Omega^2 (cos, sin) + Omega' (sin, -cos)).   (thesis 3.33)
//
// Where the spin is free, it acts back on it. From the kinetic energy of a rotor whose masses lie beside its axis,
//   T = (m/2)(x'^2 + y'^2) + (Ip/2) Omega^2 + U Omega (c y' - s x'),   c, s = cos, sin(angle + p),
// and the weight's potential m g y + g U s:
//   Ip Omega' = M - U (c y'' - s x'') - g U c
// x, y the shaft's axis at the unbalance's plane [m], M the other torques about that axis [N m], g [m/s^2] along -y, Ip
// about the axis, so that Ip > m e^2. Of several unbalances each has its plane's x, y. Energy and angular momentum with
// these terms are kept exactly (doc/physics.md).
// Valid: eccentricity far below the rotor's radius of gyration. Source: thesis 3.33; the reaction derived in doc/physics.md
// section 5. Left out: what a fault that adds an unbalance brings to Ip.
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
