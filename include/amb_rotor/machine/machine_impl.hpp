#pragma once
// Template bodies of machine.hpp; included by the one source file of each Scalar.
#include <algorithm>

#include "amb_rotor/common/error.hpp"
#include "amb_rotor/common/fields.hpp"
#include "amb_rotor/effects/all.hpp"
#include "amb_rotor/excitation/unbalance.hpp"
#include "amb_rotor/machine/assembly.hpp"
#include "amb_rotor/machine/machine.hpp"
#include "amb_rotor/machine/machine_contact_impl.hpp"
#include "amb_rotor/machine/state.hpp"
#include "amb_rotor/model/yaml_document.hpp"

namespace amb_rotor {

template <class S>
class Machine<S>::Forces final : public RotorForces<S> {
 public:
  Forces(const ModalRotor<S>& rotor, const S* q, const S* v, const Vec2<S>& stator, const Vec2<S>& stator_velocity,
         S* generalised, Vec2<S>& reaction, S& torque)
      : rotor_(rotor),
        q_(q),
        v_(v),
        stator_(stator),
        stator_velocity_(stator_velocity),
        generalised_(generalised),
        reaction_(reaction),
        torque_(torque) {}
  Vec2<S> position(int plane) const override { return rotor_.at(plane, q_) - stator_; }
  Vec2<S> velocity(int plane) const override { return rotor_.at(plane, v_) - stator_velocity_; }
  void push(int plane, const Vec2<S>& force) override {
    rotor_.push(plane, force, generalised_);
    reaction_ -= force;
  }
  void load(int plane, const Vec2<S>& force) override { rotor_.push(plane, force, generalised_); }
  void twist(const S& torque) override { torque_ += torque; }

 private:
  const ModalRotor<S>& rotor_;
  const S* q_;
  const S* v_;
  Vec2<S> stator_, stator_velocity_;
  S* generalised_;
  Vec2<S>& reaction_;
  S& torque_;
};

/// The physics of an effect that a file defines, its values from each lane; null: the program has it itself.
template <class S>
std::unique_ptr<EffectPhysics<S>> gatherLaw(const std::vector<const Model*>& models, const std::string& id,
                                            std::vector<S>& values) {
  const auto law = effectLaw(id);
  if (law == nullptr || !gatherEffect(models, id, values)) return nullptr;
  return std::make_unique<effects::LawPhysics<S>>(law, values);
}

template <class S>
Machine<S>::Machine(const std::vector<const Model*>& models, Spin spin, const ExtraPlanes<double>& extra)
    : spin_(spin),
      amb_model_(models.at(0)->amb_model),
      control_(models[0]->control),
      chain_(models[0]->signal_chain),
      friction_law_(models[0]->friction_law) {
  gatherRig(models, rig_);
  effects::forEachEffect([&](auto* effect) {
    using Effect = std::remove_pointer_t<decltype(effect)>;
    std::vector<S> values;
    if (!gatherEffect(models, effects::idOf<Effect>(), values)) return;
    Part part;
    part.physics = std::make_unique<typename Effect::template Physics<S>>(values);
    part.roles = part.physics->roles();
    parts_.push_back(std::move(part));
  });
  // effects of files act after those of the catalogue, in the order of the first model
  for (const EffectSetting& setting : models[0]->effects) {
    std::vector<S> values;
    Part part;
    part.physics = gatherLaw(models, setting.id, values);
    if (part.physics == nullptr) continue;
    part.roles = part.physics->roles();
    parts_.push_back(std::move(part));
  }
  for (auto& part : parts_)
    if (part.roles & acts_on_rig) part.physics->rig(rig_);

  RotorAssembly<S> assembly(*models[0], models, rig_);
  for (auto& part : parts_)
    if (part.roles & acts_on_rotor) part.physics->rotor(rig_, assembly);
  unbalance_ = rig_.unbalance;
  own_unbalances_ = unbalance_.size();
  for (const auto& u : extra.unbalance)
    unbalance_.push_back({S(u.plane_z_m), S(u.moment_kg_m), S(u.phase_rad)});
  for (std::size_t i = 0; i < unbalance_.size(); ++i) {
    unbalance_plane_.push_back(assembly.addUnbalancePlane(unbalance_[i].plane_z_m, i == 0));
    unbalance_phase_.emplace_back(unbalance_[i].phase_rad);
  }
  for (double z : extra.force_z_m) extra_force_plane_.push_back(assembly.addPlane(S(z)));
  cg_plane_ = assembly.addCentrePlane();
  rotor_ = assembly.finish();
  if (spin_ == Spin::free) requireFreeSpin();

  int offset = 4 * rotor_.modes();
  for (auto& part : parts_) {
    part.offset = offset;
    offset += part.physics->stateSize();
    const auto* physics = part.physics.get();
    if (part.roles & acts_on_sensor) sensing_.push_back(physics);
    if (part.roles & acts_on_force_current) physics->relaxation(relaxation_weights_, relaxation_rates_);
    if (part.roles & acts_on_flux) flux_.push_back(physics);
    if (part.roles & acts_on_bearing_force) bearing_.push_back(physics);
    if (part.roles & acts_on_rotor_force) pushing_.push_back(physics);
    if (part.roles & acts_on_contact_centre) centring_.push_back(physics);
    if (part.roles & acts_on_contact_edge) edging_.push_back(physics);
    if (part.roles & acts_on_normal_force) normal_.push_back(physics);
    if (part.roles & acts_on_friction) friction_.push_back(physics);
    if (part.roles & acts_on_spin) spinning_.push_back(physics);
    if (part.roles & is_mount) mount_ = &part;
    if (part.roles & is_ring) ring_ = &part;
    if (part.roles & is_stator) stator_ = &part;
  }
  if (amb_model_ == AmbModel::linear) electrics_ = Electrics<S>(rig_, chain_, models[0]->coil);
  electrics_offset_ = offset;
  offset += electrics_.size();
  if (spin_ != Spin::prescribed) offset += 2;
  size_ = offset;
  net_stiffness_ = amb_model_ == AmbModel::equivalent
                       ? rig_.amb.stiffness_N_per_m
                       : rig_.amb.current_stiffness_N_per_A * rig_.controller.kp_A_per_m -
                             rig_.amb.displacement_stiffness_N_per_m;
  if (amb_model_ == AmbModel::linear && !control_.plain()) {
    const bool gains = control_.type == ControllerType::pid;
    const S gain = gains ? rig_.controller.kp_A_per_m * S(staticGain(control_, control_.main, 1.0))
                         : S(staticGain(control_, control_.main, 0.0));
    net_stiffness_ = rig_.amb.current_stiffness_N_per_A * gain - rig_.amb.displacement_stiffness_N_per_m;
  }
  contact_compliance_ = S(1.0) / rig_.auxiliary_bearing.stiffness_N_per_m;
  ring_arm_ = rig_.auxiliary_bearing.rotor_radius_m + rig_.auxiliary_bearing.clearance_m;
}

template <class S>
void Machine<S>::initialise(S* state) const {
  for (int i = 4 * rotor_.modes(); i < size_; ++i) state[i] = S(0.0);
  for (const auto& part : parts_)
    if (part.physics->stateSize() > 0) part.physics->initialState(state + part.offset);
  if (mount_ != nullptr)
    for (int end = 0; end < 2; ++end) {  // unloaded: where the misalignment puts it
      Vec2<S> rest;
      for (const auto* effect : centring_) effect->contactCentre(end, rest);
      state[mount_->offset + 4 * end] = rest.x;
      state[mount_->offset + 4 * end + 1] = rest.y;
    }
}

template <class S>
void Machine<S>::signals(const Shaft<S>& shaft, const S* state, Vec2<S> signal[2]) const {
  Vec2<S> stator, stator_velocity;
  if (stator_ != nullptr) stator_->physics->statorPosition(state + stator_->offset, stator, stator_velocity);
  for (int end = 0; end < 2; ++end) signal[end] = rotor_.at(plane_sensor + end, state) - stator;
  sense(shaft, signal);
}

template <class S>
void Machine<S>::atMagnets(const S* state, Vec2<S> position[2]) const {
  Vec2<S> stator, stator_velocity;
  if (stator_ != nullptr) stator_->physics->statorPosition(state + stator_->offset, stator, stator_velocity);
  for (int end = 0; end < 2; ++end) position[end] = rotor_.at(plane_amb + end, state) - stator;
}

template <class S>
void Machine<S>::electricRates(const Inputs<S>& in, const Shaft<S>& shaft, const S* state, S* rate,
                               Observation<S>* seen) const {
  Vec2<S> signal[2], stator, stator_velocity;
  signals(shaft, state, signal);
  if (stator_ != nullptr) stator_->physics->statorPosition(state + stator_->offset, stator, stator_velocity);
  S input[4], velocity[4], current[4];
  for (int end = 0; end < 2; ++end) {
    const Vec2<S> v = rotor_.at(plane_amb + end, state + 2 * rotor_.modes()) - stator_velocity;
    input[2 * end] = signal[end].x + in.sensor_offset[2 * end];
    input[2 * end + 1] = signal[end].y + in.sensor_offset[2 * end + 1];
    velocity[2 * end] = v.x;
    velocity[2 * end + 1] = v.y;
  }
  const S* own = state + electrics_offset_;
  if (rate != nullptr) electrics_.rates(input, velocity, in.target, own, rate + electrics_offset_);
  if (seen == nullptr || !electrics_.coils()) return;
  electrics_.currents(own, current);
  for (int a = 0; a < 4; ++a) seen->coil_voltage[a] = electrics_.coil().voltage(in.target[a], current[a]);
}

template <class S>
Vec2<S> Machine<S>::magneticForce(const Vec2<S>& current, const Vec2<S>& position, const Vec2<S>& velocity) const {
  if (amb_model_ == AmbModel::equivalent)
    return {-rig_.amb.stiffness_N_per_m * position.x - rig_.amb.damping_N_s_per_m * velocity.x,
            -rig_.amb.stiffness_N_per_m * position.y - rig_.amb.damping_N_s_per_m * velocity.y};
  const S& ki = rig_.amb.current_stiffness_N_per_A;
  const S& ks = rig_.amb.displacement_stiffness_N_per_m;
  if (flux_.empty())
    return {linearMagneticForce(ki, ks, current.x, position.x), linearMagneticForce(ki, ks, current.y, position.y)};
  const S& bias = rig_.amb.bias_current_A;
  CoilFlux<S> x = linearFlux(ki, ks, bias, current.x, position.x);
  CoilFlux<S> y = linearFlux(ki, ks, bias, current.y, position.y);
  for (const auto* effect : flux_) {
    effect->flux(rig_, current.x, position.x, x);
    effect->flux(rig_, current.y, position.y, y);
  }
  return {fluxForce(ki, bias, x), fluxForce(ki, bias, y)};
}

template <class S>
Contact<S> Machine<S>::contactAt(int end, const Vec2<S>& position, const Vec2<S>& velocity, const Shaft<S>& shaft,
                                 const Vec2<S>& centre, const Vec2<S>& centre_velocity, const S& ring_speed,
                                 const Inputs<S>& in) const {
  Contact<S> all;
  contactOf(end, position, velocity, shaft, centre, centre_velocity, ring_speed, in, &all);
  return all;
}

template <class S>
inline ContactPush<S> Machine<S>::contactOf(int end, const Vec2<S>& position, const Vec2<S>& velocity, const Shaft<S>& shaft,
                                            const Vec2<S>& centre, const Vec2<S>& centre_velocity, const S& ring_speed,
                                            const Inputs<S>& in, Contact<S>* all) const {
  const auto& bearing = rig_.auxiliary_bearing;
  const LocalContact<S>* local = in.contact != nullptr ? &in.contact[end] : nullptr;
  const ContactGeometry<S> g = contactGeometry(position - centre, velocity - centre_velocity,
                                               local != nullptr ? local->clearance : bearing.clearance_m);
  NormalForce<S> n;
  S slip, coefficient;
  if (local != nullptr) {
    n.force = local->force + local->slope * (g.penetration - local->penetration0) +
              local->damping * (g.rate - local->rate0);
    n.margin = n.force / maximum(local->slope, S(1.0));
    n.slope = local->slope;
    n.damping = local->damping;
    slip = local->surface_speed + g.tangential_rate - maximum(g.penetration, S(0.0)) * ring_speed;
    coefficient = local->friction_coefficient;
  } else {
    n = normalForce(g);
    slip = bearing.rotor_radius_m * shaft.speed + g.tangential_rate - ringArm(g.penetration) * ring_speed;
    coefficient = frictionCoefficient(slip);
  }
  S normal_force;
  if (in.contact_mode != nullptr)
    normal_force = in.contact_mode[end] != 0 ? n.force : S(0.0);
  else
    normal_force = select((g.penetration > S(0.0)), maximum(n.force, S(0.0)), S(0.0));
  ContactPush<S> push;
  push.penetration = g.penetration;
  if (any(normal_force > S(0.0))) {  // nobody touches: spare the friction
    if (in.sliding == nullptr || in.sliding[end] == sliding_unset)
      push.friction_force = normal_force * coulombFactor(coefficient, slip);
    else if (in.sliding[end] != 0)
      push.friction_force = normal_force * coefficient * S(-1.0 * in.sliding[end]);
    else
      push.friction_force = in.stick_force[end];
    push.force = {-normal_force * g.normal.x - push.friction_force * g.normal.y,
                  -normal_force * g.normal.y + push.friction_force * g.normal.x};
  }
  if (all != nullptr)
    *all = {centre,       push.force, g.normal,    g.penetration, g.rate,   normal_force, push.friction_force,
            slip,         coefficient, n.force, n.margin,     n.slope,  n.damping};
  return push;
}

// What an effect is handed by reference lives in memory from its first value on, whether the effect is there or not, and a
// store of a pack is dear: so effects get copies, in branches of their own.
template <class S>
void Machine<S>::evaluate(const Inputs<S>& in, const S* state, S* rate, Observation<S>* seen) const {
  const int n = rotor_.modes();
  const S* q = state;
  const S* v = state + 2 * n;
  S generalised[2 * max_modes];
  for (int k = 0; k < 2 * n; ++k) generalised[k] = S(0.0);

  Shaft<S> own_shaft;  // of a state's spin
  if (spin_ != Spin::prescribed) {
    own_shaft = shaftOf(state);
    own_shaft.time = in.shaft.time;
  }
  const Shaft<S>& shaft = spin_ == Spin::prescribed ? in.shaft : own_shaft;
  S spin_torque(0.0);
  const bool free_spin = spin_ == Spin::free && !in.hold_speed;
  if (spin_ != Spin::prescribed && !in.hold_speed)
    for (const auto* effect : spinning_) effect->spin(rig_, own_shaft.speed, own_shaft.acceleration);

  Vec2<S> stator, stator_velocity;
  if (stator_ != nullptr) {
    Vec2<S> place, speed;
    stator_->physics->statorPosition(state + stator_->offset, place, speed);
    stator = place;
    stator_velocity = speed;
  }
  Vec2<S> reaction;  // of the bearings, and of what else stands on the stator, on it

  Vec2<S> coil_current[2];
  const Vec2<S>* force_current = in.force_current;
  if (electrics_.coils()) {
    S current[4];
    electrics_.currents(state + electrics_offset_, current);
    coil_current[0] = {current[0], current[1]};
    coil_current[1] = {current[2], current[3]};
    force_current = coil_current;
  }
  for (int end = 0; end < 2; ++end) {
    const Vec2<S> position = rotor_.at(plane_amb + end, q) - stator;
    const Vec2<S> velocity = rotor_.at(plane_amb + end, v) - stator_velocity;
    Vec2<S> force = magneticForce(force_current[end], position, velocity);
    if (!bearing_.empty()) {
      const BearingSite<S> site{&rig_, &shaft, end, position, velocity, force_current[end], net_stiffness_, in.bearing_on[end]};
      Vec2<S> own = force;
      for (const auto* effect : bearing_) effect->bearingForce(site, own);
      force = own;
      if (free_spin)
        for (const auto* effect : bearing_) spin_torque += effect->bearingTorque(site);
    }
    force = {force.x * in.bearing_on[end].x, force.y * in.bearing_on[end].y};
    rotor_.push(plane_amb + end, force, generalised);
    reaction -= force;
    if (seen != nullptr) {
      seen->bearing_force[end] = force;
      seen->amb_position[end] = position;
    }
  }

  S angular[2] = {S(0.0), S(0.0)};
  // far from contact the bearings only matter where they move by themselves or where somebody looks
  const bool skip_contact = in.far_from_contact && mount_ == nullptr && ring_ == nullptr && seen == nullptr;
  for (int end = 0; end < 2 && !skip_contact; ++end) {
    const Vec2<S> position = rotor_.at(plane_aux + end, q);
    const Vec2<S> velocity = rotor_.at(plane_aux + end, v);
    Vec2<S> rest = stator;
    if (!centring_.empty()) {
      Vec2<S> own = rest;
      for (const auto* effect : centring_) effect->contactCentre(end, own);
      rest = own;
    }
    Vec2<S> centre = rest, centre_velocity = stator_velocity;
    if (in.contact != nullptr) {
      centre = in.contact[end].centre;
      centre_velocity = in.contact[end].centre_velocity;
    } else if (mount_ != nullptr || !edging_.empty()) {  // a contact from outside is about the edge that carries, already
      Vec2<S> place = centre, speed = centre_velocity;
      if (mount_ != nullptr) mount_->physics->mountPosition(end, state + mount_->offset, place, speed);
      for (const auto* effect : edging_) effect->contactEdge(end, position - place, place);
      centre = place;
      centre_velocity = speed;
    }
    if (ring_ != nullptr) angular[end] = ring_->physics->ringSpeed(end, state + ring_->offset);
    const ContactPush<S> contact = contactOf(end, position, velocity, shaft, centre, centre_velocity, angular[end], in,
                                             seen != nullptr ? &seen->contact[end] : nullptr);
    rotor_.push(plane_aux + end, contact.force, generalised);
    // the surface of the rotor feels the friction at its own radius
    spin_torque += contact.friction_force * rig_.auxiliary_bearing.rotor_radius_m;
    const Vec2<S> load = {-contact.force.x, -contact.force.y};
    if (mount_ != nullptr && rate != nullptr)
      reaction += mount_->physics->mountRates(end, rest, stator_velocity, load, state + mount_->offset,
                                              rate + mount_->offset);
    else
      reaction += load;
    if (ring_ != nullptr && rate != nullptr)
      ring_->physics->ringRates(end, -contact.friction_force * ringArm(contact.penetration), state + ring_->offset,
                                rate + ring_->offset);
    if (seen != nullptr) {
      seen->aux_position[end] = position;
      seen->aux_velocity[end] = velocity;
      seen->ring_speed[end] = angular[end];
    }
  }
  if (free_spin) own_shaft.acceleration += spin_torque / rig_.rotor.polar_inertia_kg_m2;

  for (std::size_t i = 0; i < actingUnbalances(in); ++i) {
    const Vec2<S> direction = unbalance_phase_[i].turn(shaft);
    rotor_.push(unbalance_plane_[i], unbalanceForce(unbalanceMoment(i, in), direction, shaft), generalised);
  }
  if (in.extra_force != nullptr)
    for (std::size_t i = 0; i < extra_force_plane_.size(); ++i)
      rotor_.push(extra_force_plane_[i], in.extra_force[i], generalised);
  rotor_.push(cg_plane_, {S(0.0), -rig_.rotor.mass_kg * rig_.gravity_m_s2}, generalised);
  S twist(0.0);
  if (!pushing_.empty()) {
    Vec2<S> others;
    S own(0.0);
    Forces port(rotor_, q, v, stator, stator_velocity, generalised, others, own);
    for (const auto* effect : pushing_) effect->rotorForce(shaft, port);
    reaction += others;
    twist = own;
  }

  if (electrics_.size() > 0) electricRates(in, shaft, state, rate, seen);
  const bool reacts = free_spin && (actingUnbalances(in) > 0 || !pushing_.empty());
  if (rate != nullptr || reacts) {
    S seen_only[2 * max_modes];
    S* acceleration = rate != nullptr ? rate + 2 * n : seen_only;
    rotor_.accelerations(q, v, shaft.speed, generalised, acceleration);
    if (reacts) own_shaft.acceleration += spinReaction(in, shaft, twist, acceleration);
  }
  if (rate != nullptr) {
    for (int k = 0; k < 2 * n; ++k) rate[k] = v[k];
    if (stator_ != nullptr)
      stator_->physics->statorRates(reaction, state + stator_->offset, rate + stator_->offset);
    if (spin_ != Spin::prescribed) {
      rate[size_ - 2] = shaft.speed;
      rate[size_ - 1] = shaft.acceleration;
    }
  }
  if (seen != nullptr) {
    seen->shaft = shaft;
    seen->centre = rotor_.at(cg_plane_, q);
    for (int end = 0; end < 2; ++end) seen->sensor_position[end] = rotor_.at(plane_sensor + end, q) - stator;
  }
}

// With t the forces on the coordinates for W' = 1 and a the accelerations for the W' so far:
//   M q'' = M a + t dW',  Ip dW' = torque + t.q'' - g sum U c  ->  (Ip - t M^-1 t) dW' = torque + t.a - g sum U c
template <class S>
S Machine<S>::spinReaction(const Inputs<S>& in, const Shaft<S>& shaft, S torque, S* acceleration) const {
  const int n = rotor_.modes();
  S tangential[2 * max_modes], inertia = rig_.rotor.polar_inertia_kg_m2;
  for (int k = 0; k < 2 * n; ++k) tangential[k] = S(0.0);
  for (std::size_t i = 0; i < actingUnbalances(in); ++i) {
    const S moment = unbalanceMoment(i, in);
    const Vec2<S> direction = unbalance_phase_[i].turn(shaft);
    rotor_.push(unbalance_plane_[i], {moment * direction.y, -moment * direction.x}, tangential);
    torque -= rig_.gravity_m_s2 * moment * direction.x;
  }
  S moved[2 * max_modes];
  for (int k = 0; k < 2 * n; ++k) {
    moved[k] = tangential[k] / rotor_.mass(k % n);
    torque += tangential[k] * acceleration[k];
    inertia -= tangential[k] * moved[k];
  }
  const S change = torque / inertia;
  for (int k = 0; k < 2 * n; ++k) acceleration[k] += moved[k] * change;
  return change;
}

/// Ip about the shaft's axis is more than what the unbalances are of it, with all of them in one direction.
template <class S>
void Machine<S>::requireFreeSpin() const {
  for (std::size_t lane = 0; lane < ScalarTraits<S>::lanes; ++lane) {
    const double inertia = laneValue(rig_.rotor.polar_inertia_kg_m2, lane);
    if (!(inertia > 0.0)) throw InputError({{"", 0, "speed.type", "free", "needs rotor.polar_inertia_kg_m2 > 0"}});
    double beside = 0.0;
    for (int k = 0; k < rotor_.modes(); ++k) {
      double sum = 0.0;
      for (std::size_t i = 0; i < unbalance_.size(); ++i)
        sum += std::fabs(laneValue(unbalance_[i].moment_kg_m, lane) * laneValue(rotor_.shape(unbalance_plane_[i], k), lane));
      beside += sum * sum / laneValue(rotor_.mass(k), lane);
    }
    if (!(inertia > beside))
      throw InputError({{"", 0, "rotor.polar_inertia_kg_m2", numberText(inertia),
                         "must be above " + numberText(beside) +
                             " where speed.type is free: what the unbalance alone has about the shaft's axis"}});
  }
}

}  // namespace amb_rotor
