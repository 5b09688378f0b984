#pragma once
// Contact of a round rotor inside a round auxiliary bearing.
//
//   r = rotor centre - bearing centre,  n = r/|r|,  d = |r| - clearance (penetration, m)
//   normal force N >= 0 on the rotor along -n, from the penetration d and its rate d'
//   linear:  N = k d + c d'                      (thesis 3.34, 3.36)
//   Hertz:   N = K d^(3/2) (1 + l d')            (thesis 3.37, l = 3/2 alpha_d, Hunt and Crossley)
//   friction against the true sliding velocity of the surfaces
//     v = R Omega + t.(r') - (R + |r|) Omega_ring,  t = (-n_y, n_x):  F_t = -mu N tanh(v / v_0) t
//     The force acts at the rotor's surface, R from its centre and R + |r| from the ring's.
//
// The laws never pull: N is cut off at 0. The margin tells a solver where that happens: contact is
// carried while d > 0 and margin > 0.
// Valid: penetration much below the clearance; Hertz: small impact speeds, l v well below 1.
// Source: thesis 3.34 to 3.38; Hunt and Crossley, J. Appl. Mech. 42 (1975) 440; friction turned against the sliding velocity,
// which the thesis leaves out (doc/physics.md section 7).
// Left out: rolling resistance, edge loading by tilt, wear, heat.
#include "amb_rotor/common/scalar.hpp"

namespace amb_rotor {

/// Sliding speed that regularises Coulomb friction [m/s].
constexpr double friction_regularisation_m_s = 0.01;

template <class S>
struct ContactGeometry {
  Vec2<S> normal;    ///< n, from the bearing's centre to the rotor's
  S distance = S(0.0);   ///< |r| [m]
  S penetration = S(0.0);
  S rate = S(0.0);             ///< d' [m/s]
  S tangential_rate = S(0.0);  ///< t.(r') [m/s], positive with the spin
};

template <class S>
[[gnu::always_inline]] inline ContactGeometry<S> contactGeometry(const Vec2<S>& offset, const Vec2<S>& velocity, const S& clearance) {
  ContactGeometry<S> g;
  // the tiny constant keeps the direction finite at the centre, where there is no contact anyway
  g.distance = squareRoot(offset.dot(offset) + S(1e-30));
  const S inverse = S(1.0) / g.distance;
  g.normal = {offset.x * inverse, offset.y * inverse};
  g.penetration = g.distance - clearance;
  g.rate = g.normal.dot(velocity);
  g.tangential_rate = g.normal.x * velocity.y - g.normal.y * velocity.x;
  return g;
}

/// A normal force before it is cut off at zero.
template <class S>
struct NormalForce {
  S force = S(0.0);   ///< [N], valid for d >= 0
  S margin = S(0.0);  ///< [m], same sign as the force for d > 0
  S slope = S(0.0);   ///< dN/dd [N/m]
  S damping = S(0.0); ///< dN/dd' [N s/m]
};

/// @param compliance  1/k, which a caller has at hand: this is evaluated at every step
template <class S>
NormalForce<S> linearContact(const S& stiffness, const S& compliance, const S& damping, const S& d, const S& rate) {
  const S force = stiffness * d + damping * rate;
  return {force, force * compliance, stiffness, damping};
}

/// @param stiffness  K [N/m^1.5]   @param damping  l [s/m]
template <class S>
NormalForce<S> hertzContact(const S& stiffness, const S& damping, const S& d, const S& rate) {
  const S depth = maximum(d, S(0.0));
  const S root = squareRoot(depth);
  const S elastic = stiffness * depth * root;
  const S factor = S(1.0) + damping * rate;
  // 1 mm scales the dimensionless factor to a length of the order of a penetration
  return {elastic * factor, S(1e-3) * factor, S(1.5) * stiffness * root * factor, elastic * damping};
}

/// Regularised Coulomb friction: the factor of N along t.
template <class S>
S coulombFactor(const S& coefficient, const S& slip) {
  return -coefficient * hyperbolicTangent(slip * S(1.0 / friction_regularisation_m_s));
}

}  // namespace amb_rotor
