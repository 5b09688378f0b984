#pragma once
// Inner ring spin: the friction turns the inner ring of the ball bearing, so that sliding stops. For each end
//   J w' = arm * (friction force on the ring) - T tanh(w / 1 rad/s),  arm = rotor radius + clearance + penetration
//   slip v = rotor surface speed + whirl - arm w
// J [kg m2], T [N m] drag torque. State: w [rad/s] of each end. Left out: balls and cage, speed-dependent drag.
// Valid: drag that does not depend on load and speed.
// Source: the ring's angular momentum under the friction of thesis 3.38 (doc/physics.md section 7); drag by definition.
#include "amb_rotor/effects/effect.hpp"

namespace amb_rotor::effects {

struct InnerRingSpin {
  static EffectSchema schema() {
    EffectSchema schema = {
        "inner_ring_spin", "the inner ring of the ball bearing is dragged along, so sliding stops",
        "lasting contact of a turning rotor: rubs and drops",
        {parameter("inertia_kg_m2", "kg m2", 1e-9, 1.0, 1e-5, std::nan(""), "of the ring"),
         parameter("drag_torque_N_m", "N m", 0.0, 1e2, 0.005, std::nan(""), "against its spin")},
        true};
    schema.mimic = "auxiliary_bearing.friction_coefficient";  // less friction slips less, too
    schema.lasting = true;
    return schema;
  }

  template <class S>
  class Physics final : public EffectPhysics<S> {
   public:
    explicit Physics(const std::vector<S>& p) : inverse_inertia_(S(1.0) / p[0]), drag_(p[1]) {}
    unsigned roles() const override { return is_ring; }
    int stateSize() const override { return 2; }
    S ringSpeed(int end, const S* state) const override { return state[end]; }
    void ringRates(int end, const S& torque, const S* state, S* rate) const override {
      rate[end] = (torque - drag_ * hyperbolicTangent(state[end])) * inverse_inertia_;
    }

   private:
    S inverse_inertia_, drag_;
  };
};

}  // namespace amb_rotor::effects
