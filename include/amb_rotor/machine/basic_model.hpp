#pragma once
// The thesis's basic model: a rigid rotor on the equivalent spring and damper of its magnetic bearings,
// with unbalance, inside one rigidly mounted auxiliary bearing. Two freedoms.
//
//   x'' + d x' + k x = eta^2 e cos(eta t + theta0) - n (u - s v)
//   y'' + d y' + k y = eta^2 e sin(eta t + theta0) - n (v + s u)
//   u = x - x_s,  v = y - y_s,  r = sqrt(u^2 + v^2),  n = N / r,  N = normal force >= 0, s = friction / N
//
//   linear contact   N = alpha max(0, r - 1)                                               (3.34, 5.4)
//   Hertz contact    N = kappa max(0, r - 1)^1.5 max(0, 1 + 1.5 a (r - 1)')                (3.37)
//   spin friction    s = sign mu: full Coulomb friction against the sliding of a rotor that spins in the
//                    positive sense, however it whirls (5.6). sign = +1 is the physical direction, -1 the
//                    reversed one (see doc/thesis.md, figure 6.2).
//   sliding friction s = sign mu tanh(v_s / v_0), v_s = eta rho + (u y' - v x') / r: sliding velocity of
//                    the rotor's surface on the ring, regularised; allows rolling (v_s = 0).
//
// | symbol   | name                  | unit                   | valid range                             |
// | eta      | frequency_ratio       | speed / sqrt(k1/m)     | > 0 (spin is positive)                  |
// | d        | damping               | d1 / (m w_n)           | >= 0; twice the damping ratio           |
// | k        | support_stiffness     | over k1                | > 0; 1 except in figure 6.3             |
// | e        | eccentricity          | clearance              | >= 0                                    |
// | alpha    | contact_stiffness     | k1                     | >= 0                                    |
// | kappa    | hertz_stiffness       | k1 / sqrt(clearance)   | >= 0                                    |
// | a        | hertz_damping         | 1 / (clearance w_n)    | >= 0                                    |
// | mu       | friction              | 1                      | >= 0                                    |
// | sign     | friction_sign         | 1                      | +1 physical, -1 reversed                |
// | x_s, y_s | misalignment_x, _y    | clearance              | any                                     |
// | theta0   | unbalance_phase       | rad                    | any                                     |
// | rho      | surface_radius        | rotor radius/clearance | >= 0, sliding friction only             |
// | v_0      | regularisation_speed  | clearance w_n          | > 0, sliding friction only              |
//
// Frame: inertial, x horizontal, y vertical, positive rotation from x to y. Dimensionless as in (5.3): time
// times w_n = sqrt(k1/m), lengths over the clearance. The vector field is continuous at touch-down and
// lift-off for all laws here (N and the friction vanish there), so the saltation matrix of a contact event
// is the identity.
//
// Valid: a rotor that does not tilt, on bearings that stay linear springs: displacements well below the air gap.
// Errors: none; the ranges are the caller's to check (checkBasicParameters in basic_lanes.hpp).
// Source: thesis, chapter 5.1, equations 5.3 to 5.6, and 3.34 to 3.37.
// Left out: gyroscopic effect, weight, viscous linear contact damping (3.36; its force jumps at
// touch-down), the mount's and the ring's own motion (the complete machine has them).
#include "amb_rotor/common/dual.hpp"
#include "amb_rotor/common/scalar.hpp"

namespace amb_rotor {

// Members are set as `= S(value)`: braces would read a pack's lanes from a list of one number.
template <class S>
struct BasicParameters {
  S frequency_ratio = S(1.0);
  S damping = S(0.0347);
  S support_stiffness = S(1.0);
  S eccentricity = S(0.0973);
  S contact_stiffness = S(13.68);
  S hertz_stiffness = S(0.0);
  S hertz_damping = S(0.0);
  S friction = S(0.015);
  S friction_sign = S(1.0);
  S misalignment_x = S(0.0);
  S misalignment_y = S(0.0);
  S unbalance_phase = S(0.0);
  S surface_radius = S(50.0);
  S regularisation_speed = S(0.01);

  template <class P, class F>
  static void visit(P& p, F&& f) {
    f("frequency_ratio", p.frequency_ratio);
    f("damping", p.damping);
    f("support_stiffness", p.support_stiffness);
    f("eccentricity", p.eccentricity);
    f("contact_stiffness", p.contact_stiffness);
    f("hertz_stiffness", p.hertz_stiffness);
    f("hertz_damping", p.hertz_damping);
    f("friction", p.friction);
    f("friction_sign", p.friction_sign);
    f("misalignment_x", p.misalignment_x);
    f("misalignment_y", p.misalignment_y);
    f("unbalance_phase", p.unbalance_phase);
    f("surface_radius", p.surface_radius);
    f("regularisation_speed", p.regularisation_speed);
  }
};

template <class S>
struct BasicState {
  S x = S(0.0), y = S(0.0);    ///< displacement [clearance]
  S vx = S(0.0), vy = S(0.0);  ///< velocity [clearance w_n], or [clearance per step] in step units
};

/// What the right-hand side needs, after the parameters have been put into a unit of time.
template <class S>
struct BasicCoefficients {
  S forcing = S(0.0), damping = S(0.0), stiffness = S(1.0), contact = S(0.0), contact_damping = S(0.0),
    friction = S(0.0);
  S misalignment_x = S(0.0), misalignment_y = S(0.0), surface_speed = S(0.0), regularisation = S(0.0);
};

/// @param unit unit of time [1/w_n]: 1 for dimensionless time, the step for velocities per step (then the
///             arithmetic of a Runge-Kutta step has no multiplication with the step).
/// The unbalance phase is not in it: rotate misalignment and state by -theta0 instead (the model is
/// isotropic), see rotatedToPhaseZero.
template <class Contact, class S>
BasicCoefficients<S> basicCoefficients(const BasicParameters<S>& p, const S& unit) {
  BasicCoefficients<S> c;
  const S square = unit * unit;
  c.forcing = square * p.frequency_ratio * p.frequency_ratio * p.eccentricity;
  c.damping = unit * p.damping;
  c.stiffness = square * p.support_stiffness;
  c.contact = square * Contact::stiffness(p);
  c.contact_damping = S(1.5) * p.hertz_damping / unit;
  c.friction = p.friction_sign * p.friction;
  c.misalignment_x = p.misalignment_x;
  c.misalignment_y = p.misalignment_y;
  c.surface_speed = unit * p.frequency_ratio * p.surface_radius;
  c.regularisation = S(1.0) / (unit * p.regularisation_speed);
  return c;
}

// ---- contact laws: N / r from r >= 1, 1 / r and r' (the radial velocity)
struct LinearContact {
  static constexpr bool needs_rate = false;
  template <class S>
  static S stiffness(const BasicParameters<S>& p) {
    return p.contact_stiffness;
  }
  template <class C, class T>
  static T forceOverRadius(const BasicCoefficients<C>& c, const T&, const T& inverse_radius, const T&) {
    using S = typename PlainType<T>::type;
    return c.contact * (S(1.0) - inverse_radius);
  }
};

struct HertzContact {
  static constexpr bool needs_rate = true;
  template <class S>
  static S stiffness(const BasicParameters<S>& p) {
    return p.hertz_stiffness;
  }
  template <class C, class T>
  static T forceOverRadius(const BasicCoefficients<C>& c, const T& radius, const T& inverse_radius,
                           const T& rate) {
    using S = typename PlainType<T>::type;
    // sqrt(max(depth, tiny)): the slope of the root stays finite in a Dual, and the force stays 0.
    const T depth = radius - S(1.0);
    const T root = squareRoot(maximum(depth, S(1e-30)));
    const T dissipation = maximum(c.contact_damping * rate + S(1.0), S(0.0));
    return c.contact * (depth * root) * dissipation * inverse_radius;
  }
};

// ---- friction laws: signed friction coefficient from the tangential velocity (positive sense)
struct SpinFriction {
  static constexpr bool needs_rate = false;
  template <class C, class T>
  static C coefficient(const BasicCoefficients<C>& c, const T&) {
    return c.friction;
  }
};

struct SlidingFriction {
  static constexpr bool needs_rate = true;
  template <class C, class T>
  static T coefficient(const BasicCoefficients<C>& c, const T& tangential) {
    return c.friction * hyperbolicTangent((tangential + c.surface_speed) * c.regularisation);
  }
};

/// Which branch of the force is evaluated. by_radius: as the radius says (no mask: clamped at the clearance).
/// The event-accurate integration names the branch of the mode it is in, so that a step is smooth.
enum class BasicBranch { by_radius, free, contact };

template <class ContactLaw, class FrictionLaw>
struct BasicModel {
  using Contact = ContactLaw;
  using Friction = FrictionLaw;

  /// Acceleration at one instant. C: type of the coefficients, T: of the state (C or Dual of it).
  /// @param fx,fy unbalance force over mass, in the coefficients' unit of time
  template <BasicBranch branch = BasicBranch::by_radius, class C, class T, class F>
  static inline void acceleration(const BasicCoefficients<C>& c, const F& fx, const F& fy, const T& x,
                                  const T& y, const T& vx, const T& vy, T& ax, T& ay) {
    using S = typename PlainType<T>::type;
    if constexpr (branch == BasicBranch::free) {
      ax = fx - c.damping * vx - c.stiffness * x;
      ay = fy - c.damping * vy - c.stiffness * y;
      return;
    }
    const T u = x - c.misalignment_x;
    const T v = y - c.misalignment_y;
    const T square = u * u + v * v;
    // Clamped at the clearance: the depth and with it every contact force is 0 inside, without a mask.
    T radius;
    if constexpr (branch == BasicBranch::by_radius) {
      radius = squareRoot(maximum(square, S(1.0)));
    } else {
      radius = squareRoot(square);
    }
    const T inverse = inverseOf(radius);
    T normal, tx, ty;
    if constexpr (Contact::needs_rate) {
      normal = Contact::forceOverRadius(c, radius, inverse, (u * vx + v * vy) * inverse);
    } else {
      normal = Contact::forceOverRadius(c, radius, inverse, inverse);
    }
    if constexpr (Friction::needs_rate) {
      const auto s = Friction::coefficient(c, (u * vy - v * vx) * inverse);
      tx = u - s * v;
      ty = v + s * u;
    } else {
      const auto s = Friction::coefficient(c, inverse);
      tx = u - s * v;
      ty = v + s * u;
    }
    ax = fx - c.damping * vx - c.stiffness * x - normal * tx;
    ay = fy - c.damping * vy - c.stiffness * y - normal * ty;
  }
};

/// The same machine with unbalance phase 0, seen in axes turned by theta0: misalignment turned by -theta0.
BasicParameters<double> rotatedToPhaseZero(const BasicParameters<double>& p);
/// State turned by `angle` [rad].
BasicState<double> rotated(const BasicState<double>& state, double angle);

}  // namespace amb_rotor
