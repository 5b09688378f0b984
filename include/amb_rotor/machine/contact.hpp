#pragma once
#include "amb_rotor/auxiliary_bearing/contact_law.hpp"

namespace amb_rotor {

/// The contact of one end at an instant. Forces are on the rotor.
template <class S>
struct Contact {
  Vec2<S> centre;             ///< of the auxiliary bearing, absolute [m]
  Vec2<S> force;              ///< normal and friction together [N]
  Vec2<S> normal;             ///< unit vector from the bearing's centre to the rotor's
  S penetration = S(0.0);         ///< [m]; minus the gap while free
  S rate = S(0.0);                ///< of the penetration [m/s]
  S normal_force = S(0.0);        ///< N >= 0 [N]
  S friction_force = S(0.0);      ///< along t = (-n_y, n_x), positive with the spin [N]
  S slip = S(0.0);                ///< sliding speed of the surfaces [m/s]
  S friction_coefficient = S(0.0);
  S uncut_force = S(0.0);         ///< the law's force before the cut at zero [N]
  S margin = S(0.0);              ///< of the law [m]; contact is carried while penetration > 0 and margin > 0
  S slope = S(0.0);               ///< dN/d penetration [N/m]
  S damping = S(0.0);             ///< dN/d rate [N s/m]
};

/// Of a contact what the equations of motion need.
template <class S>
struct ContactPush {
  Vec2<S> force;          ///< normal and friction together [N]
  S friction_force = S(0.0), penetration = S(0.0);  ///< as in Contact
};

/// A contact as another partner describes it over a step: the law linearised about a penetration and a rate,
///   N = max(0, force + slope (d - d0) + damping (d' - rate0)) while d > 0,
/// about a centre that moves evenly, with its friction. Exact for the linear law.
template <class S>
struct LocalContact {
  Vec2<S> centre, centre_velocity;
  S clearance = S(0.0);
  S penetration0 = S(0.0), rate0 = S(0.0);
  S force = S(0.0), slope = S(0.0), damping = S(0.0);
  S friction_coefficient = S(0.0);
  S surface_speed = S(0.0);  ///< R Omega - (R + clearance) Omega_ring: sliding speed without whirl and penetration [m/s]
};

}  // namespace amb_rotor
