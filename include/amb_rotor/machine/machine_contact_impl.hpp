#pragma once
// What machine.hpp tells of the contacts at a state: places, sliding, guards. Part of machine_impl.hpp.
#include "amb_rotor/machine/machine.hpp"

namespace amb_rotor {

// As in evaluate(), effects get copies in branches of their own.
template <class S>
inline ContactGeometry<S> Machine<S>::geometryAt(int end, const S* state) const {
  const S* v = state + 2 * rotor_.modes();
  const Vec2<S> position = rotor_.at(plane_aux + end, state);
  Vec2<S> centre, centre_velocity;
  if (stator_ != nullptr || mount_ != nullptr || !centring_.empty() || !edging_.empty()) {
    Vec2<S> place, speed;
    if (stator_ != nullptr) stator_->physics->statorPosition(state + stator_->offset, place, speed);
    for (const auto* effect : centring_) effect->contactCentre(end, place);
    if (mount_ != nullptr) mount_->physics->mountPosition(end, state + mount_->offset, place, speed);
    for (const auto* effect : edging_) effect->contactEdge(end, position - place, place);
    centre = place;
    centre_velocity = speed;
  }
  return contactGeometry(position - centre, rotor_.at(plane_aux + end, v) - centre_velocity,
                         rig_.auxiliary_bearing.clearance_m);
}

/// The law at a penetration and its rate.
template <class S>
inline NormalForce<S> Machine<S>::normalForce(const ContactGeometry<S>& g) const {
  const auto& bearing = rig_.auxiliary_bearing;
  const NormalForce<S> n =
      linearContact(bearing.stiffness_N_per_m, contact_compliance_, bearing.damping_N_s_per_m, g.penetration, g.rate);
  if (normal_.empty()) return n;
  return normalForceByEffects(g.penetration, g.rate, n);
}

template <class S>
NormalForce<S> Machine<S>::normalForceByEffects(S penetration, S rate, NormalForce<S> n) const {
  for (const auto* effect : normal_) effect->normalForce(penetration, rate, n);
  return n;
}

/// At a sliding speed.
template <class S>
inline S Machine<S>::frictionCoefficient(const S& slip) const {
  if (friction_.empty()) return rig_.auxiliary_bearing.friction_coefficient;
  return frictionByEffects(slip, rig_.auxiliary_bearing.friction_coefficient);
}

template <class S>
S Machine<S>::frictionByEffects(S slip, S coefficient) const {
  for (const auto* effect : friction_) effect->friction(slip, coefficient);
  return coefficient;
}

template <class S>
S Machine<S>::slip(int end, const Inputs<S>& in, const S* state) const {
  const S speed = spin_ == Spin::prescribed ? in.shaft.speed : state[size_ - 1];
  const S ring = ring_ != nullptr ? ring_->physics->ringSpeed(end, state + ring_->offset) : S(0.0);
  const ContactGeometry<S> g = geometryAt(end, state);
  return rig_.auxiliary_bearing.rotor_radius_m * speed + g.tangential_rate - ringArm(g.penetration) * ring;
}

template <class S>
S Machine<S>::slipRate(int end, const Inputs<S>& in, const S* state, const S* rate) const {
  const ContactGeometry<S> g = geometryAt(end, state);
  // Mount, stator and ring map their states linearly to positions and velocities: their rates to velocities and
  // accelerations.
  Vec2<S> velocity, acceleration;
  if (mount_ != nullptr)
    mount_->physics->mountPosition(end, rate + mount_->offset, velocity, acceleration);
  else if (stator_ != nullptr)
    stator_->physics->statorPosition(rate + stator_->offset, velocity, acceleration);
  const Vec2<S> relative = rotor_.at(plane_aux + end, rate + 2 * rotor_.modes()) - acceleration;
  const S spin = spin_ == Spin::prescribed ? in.shaft.acceleration : rate[size_ - 1];
  S ring(0.0), ring_rate(0.0);
  if (ring_ != nullptr) {
    ring = ring_->physics->ringSpeed(end, state + ring_->offset);
    ring_rate = ring_->physics->ringSpeed(end, rate + ring_->offset);
  }
  const S arm_rate = select(g.penetration > S(0.0), g.rate, S(0.0));
  return rig_.auxiliary_bearing.rotor_radius_m * spin + g.normal.x * relative.y - g.normal.y * relative.x -
         g.tangential_rate * g.rate / g.distance - ringArm(g.penetration) * ring_rate - arm_rate * ring;
}

template <class S>
void Machine<S>::approach(int end, const S* state, S& penetration, S& rate) const {
  const ContactGeometry<S> g = geometryAt(end, state);
  penetration = g.penetration;
  rate = g.rate;
}

template <class S>
S Machine<S>::contactGuard(int end, const S* state) const {
  const ContactGeometry<S> g = geometryAt(end, state);
  return minimum(g.penetration, normalForce(g).margin);
}

template <class S>
void Machine<S>::contactPace(int end, const Inputs<S>& in, const S* state, double dt, S& guard, S& friction_rate) const {
  const auto& bearing = rig_.auxiliary_bearing;
  const ContactGeometry<S> g = geometryAt(end, state);
  const NormalForce<S> n = normalForce(g);
  guard = minimum(g.penetration, n.margin);
  friction_rate = S(0.0);
  if (!any(guard > S(0.0))) return;
  const S speed = spin_ == Spin::prescribed ? in.shaft.speed : state[size_ - 1];
  const S ring = ring_ != nullptr ? ring_->physics->ringSpeed(end, state + ring_->offset) : S(0.0);
  const S slip = bearing.rotor_radius_m * speed + g.tangential_rate - ringArm(g.penetration) * ring;
  const S coefficient = frictionCoefficient(slip);
  S inverse_mass(0.0);
  for (int k = 0; k < rotor_.modes(); ++k) {
    const S& shape = rotor_.shape(plane_aux + end, k);
    inverse_mass += shape * shape / rotor_.mass(k);
  }
  constexpr double v0 = friction_regularisation_m_s, near = 4.0;  // tanh'(4) is 0.001
  const S rate = coefficient * maximum(n.force, S(0.0)) * inverse_mass * S(1.0 / v0);
  const MaskOf<S> sticky = magnitude(slip) < S(v0) * (S(near) + rate * S(dt));
  friction_rate = select(sticky, select((guard > S(0.0)), rate, S(0.0)), S(0.0));
}

template <class S>
void Machine<S>::contacts(const Inputs<S>& in, const S* state, Contact<S> contact[2]) const {
  Observation<S> seen;
  evaluate(in, state, nullptr, &seen);
  contact[0] = seen.contact[0];
  contact[1] = seen.contact[1];
}

}  // namespace amb_rotor
