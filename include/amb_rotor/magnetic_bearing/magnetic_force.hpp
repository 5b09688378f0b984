#pragma once
// Force of one bearing axis from its control current i [A] and the rotor's position x [m] in it,
// differential winding (bias +- control current), written by the flux of its two coils relative to the
// bias flux with the rotor centred, b+ and b-:
//   F = Ki i0/4 (b+^2 - b-^2)
//   linear flux:        b+- = 1 +- (i/i0 + Ks x/(Ki i0))     ->  F = Ki i + Ks x
//   gap-dependent flux: b+- = (1 +- i/i0)/(1 -+ x/s0)        ->  thesis 3.16, 3.18 (slope Ks = Ki i0/s0)
//   saturating iron:    b -> b/(1 + (b/bk)^4)^(1/4), bk the knee over the bias flux density
// Positive x towards the + coil; positive Ks destabilises.
// Valid: abs(x) below the air gap s0, where runs end (machine/run.hpp); abs(i) up to i0. Linear flux: x/s0 and i/i0 well below
// 1; at x = 0.4 s0, i = 0 the gap-dependent law has 1/(1 - 0.4^2)^2 = 1.42 times the force Ks x.
// Source: thesis 3.16 to 3.20; the saturation curve is this project's (doc/physics.md section 2).
// Left out: hysteresis, leakage, cross-coupling of the axes by the force angle.
#include "amb_rotor/common/scalar.hpp"

namespace amb_rotor {

template <class S>
struct CoilFlux {
  S plus = S(1.0), minus = S(1.0);
};

template <class S>
S linearMagneticForce(const S& ki, const S& ks, const S& current, const S& position) {
  return ki * current + ks * position;
}

template <class S>
CoilFlux<S> linearFlux(const S& ki, const S& ks, const S& bias, const S& current, const S& position) {
  const S change = current / bias + ks * position / (ki * bias);
  return {S(1.0) + change, S(1.0) - change};
}

/// The gap is kept above 2 % of the air gap: beyond it the rotor lies on the pole and the law has no meaning.
template <class S>
CoilFlux<S> gapFlux(const S& bias, const S& air_gap, const S& current, const S& position) {
  const S ratio = maximum(minimum(position / air_gap, S(0.98)), S(-0.98));
  const S share = current / bias;
  return {(S(1.0) + share) / (S(1.0) - ratio), (S(1.0) - share) / (S(1.0) + ratio)};
}

/// @param inverse_knee  1/bk
template <class S>
S saturatedFlux(const S& flux, const S& inverse_knee) {
  const S ratio = flux * inverse_knee;
  const S square = ratio * ratio;
  return flux * inverseFourthRoot(S(1.0) + square * square);
}

template <class S>
S fluxForce(const S& ki, const S& bias, const CoilFlux<S>& flux) {
  return S(0.25) * ki * bias * (flux.plus * flux.plus - flux.minus * flux.minus);
}

}  // namespace amb_rotor
