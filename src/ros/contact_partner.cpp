#include <algorithm>
#include <cmath>

#include "amb_rotor/machine/assembly.hpp"
#include "amb_rotor/ros/conversions.hpp"
#include "amb_rotor/ros/partners.hpp"

namespace amb_rotor {
namespace {

/// Nearer to touching than this share of the clearance, a law that is not linear is followed in contact
/// steps.
constexpr double near_share = 0.02;
/// Share of the predicted time to touch-down that a step may take.
constexpr double approach_share = 0.8;

bool has(const Model& model, const char* effect) {
  return std::any_of(model.effects.begin(), model.effects.end(),
                     [&](const EffectSetting& e) { return e.id == effect; });
}

/// Velocity of the bearing's centre: the rotor's less the one that the contact sees.
Vec2<double> centreVelocity(const Contact<double>& contact, const Vec2<double>& rotor, double surface_speed) {
  const double tangential = contact.slip - surface_speed;
  return {rotor.x - (contact.rate * contact.normal.x - tangential * contact.normal.y),
          rotor.y - (contact.rate * contact.normal.y + tangential * contact.normal.x)};
}

}  // namespace

ContactPartner::ContactPartner(const Model& model, double contact_step)
    : machine_(std::make_unique<Machine<double>>(std::vector<const Model*>{&model})),
      model_hash_(hashNumber(model)),
      contact_step_(contact_step),
      bent_law_(has(model, "hertzian_contact")),
      varying_(has(model, "velocity_dependent_friction") || has(model, "auxiliary_bearing_tilt")) {
  AMB_ROTOR_CHECK(contact_step > 0.0, "the contact step is above 0");
}

Inputs<double> ContactPartner::inputs(const RotorState& state, Modes& modes) const {
  AMB_ROTOR_CHECK(static_cast<int>(state.mechanics.size()) >= machine_->stateSize() &&
                      state.contact_mode.size() == 2 && state.sliding.size() == 2 && state.stick_force.size() == 2,
                  "the step's mechanics belong to this model");
  Inputs<double> in;
  in.shaft = shaftFrom(state.shaft);
  for (int end = 0; end < 2; ++end) {
    modes.contact[end] = state.contact_mode[end];
    modes.sliding[end] = state.sliding[end];
  }
  in.contact_mode = modes.contact;
  in.sliding = modes.sliding;
  in.stick_force = state.stick_force.data();
  return in;
}

ContactForces ContactPartner::answer(const RotorState& state) const {
  Modes modes;
  const Inputs<double> in = inputs(state, modes);
  Observation<double> seen;
  machine_->observe(in, state.mechanics.data(), nullptr, seen);
  const auto& bearing = machine_->rig().auxiliary_bearing;
  ContactForces answer;
  answerTo(state, model_hash_, answer);
  answer.record = state.record;
  answer.valid_until = state.horizon;
  answer.ends.resize(2);
  for (int end = 0; end < 2; ++end) {
    const Contact<double>& now = seen.contact[end];
    EndContact& out = answer.ends[end];
    const double arm = bearing.rotor_radius_m + bearing.clearance_m;
    out.surface_speed = bearing.rotor_radius_m * in.shaft.speed - arm * seen.ring_speed[end];
    const double surface = out.surface_speed - std::max(now.penetration, 0.0) * seen.ring_speed[end];
    const Vec2<double> velocity = centreVelocity(now, seen.aux_velocity[end], surface);
    out.centre_x = now.centre.x;
    out.centre_y = now.centre.y;
    out.centre_velocity_x = velocity.x;
    out.centre_velocity_y = velocity.y;
    out.clearance = bearing.clearance_m;
    out.penetration = out.present_penetration = now.penetration;
    out.rate = now.rate;
    out.force = now.uncut_force;
    out.slope = now.slope;
    out.damping = now.damping;
    out.friction_coefficient = now.friction_coefficient;
    out.ring_speed = seen.ring_speed[end];
    out.normal_force = now.normal_force;
    out.friction_force = now.friction_force;
    out.slip = now.slip;
    out.force_x = now.force.x;
    out.force_y = now.force.y;
    if (bent_law_ || varying_) predict(state, end, out, answer.valid_until);
  }
  return answer;
}

void ContactPartner::predict(const RotorState& state, int end, EndContact& out, double& valid_until) const {
  const double d = out.present_penetration, rate = out.rate;
  if (d < -near_share * out.clearance) {  // free: not beyond touch-down
    if (rate > 0.0)
      valid_until = std::min(valid_until, state.time + std::max(contact_step_, approach_share * -d / rate));
    return;
  }
  valid_until = std::min(valid_until, state.time + contact_step_);
  if (!bent_law_) return;
  // Where the motion will be: the middle of the step while in contact; its end, as a chord from touch-down,
  // before it.
  const double h = valid_until - state.time;
  const bool inside = d > 0.0;
  std::vector<double> ahead = state.mechanics;
  const int n = machine_->coordinates();
  for (int i = 0; i < n; ++i) ahead[i] += (inside ? 0.5 * h : h) * state.mechanics[n + i];
  Modes modes;
  const Inputs<double> in = inputs(state, modes);
  Contact<double> there[2];
  machine_->contacts(in, ahead.data(), there);
  const Contact<double>& next = there[end];
  if (next.penetration <= 0.0) return;  // no contact in this step, the law at the present says 0
  out.rate = next.rate;
  out.damping = next.damping;
  if (inside) {
    out.penetration = next.penetration;
    out.force = next.uncut_force;
    out.slope = next.slope;
  } else {
    out.penetration = 0.0;
    out.force = 0.0;
    out.slope = std::max(0.0, next.uncut_force) / next.penetration;
  }
}

}  // namespace amb_rotor
