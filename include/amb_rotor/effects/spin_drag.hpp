#pragma once
// Spin drag: the shaft slows down where no drive holds or drives its speed,
//   W' = -decay W - torque/Ip   (the torque only where the polar inertia is above 0)
// decay [1/s] of the air, torque [N m] of dry friction, which stops at rest. Left out: W^2 terms (thesis 4.3 is
// the speed law `decay` of a scenario).
// Valid: speeds about which the air's drag is linear.
// Source: by definition; measured as the slope of a run-down.
#include "amb_rotor/effects/effect.hpp"

namespace amb_rotor::effects {

struct SpinDrag {
  static EffectSchema schema() {
    return {"spin_drag", "the rotor's speed decays: air and contact friction",
            "runs of constant speed that last: the tacho",
            {parameter("decay_per_s", "1/s", 0.0, 1e2, 0.05, 0.0, "of the air"),
             parameter("torque_N_m", "N m", 0.0, 1e3, 0.0, 0.0, "dry friction; only with a polar inertia")},
            false};
  }

  template <class S>
  class Physics final : public EffectPhysics<S> {
   public:
    explicit Physics(const std::vector<S>& p) : decay_(p[0]), torque_(p[1]) {}
    unsigned roles() const override { return acts_on_spin; }
    void spin(const Rig<S>& rig, const S& speed, S& acceleration) const override {
      const S inertia = rig.rotor.polar_inertia_kg_m2;
      const S dry = select(inertia > S(0.0), torque_ / maximum(inertia, S(1e-12)), S(0.0));
      acceleration -= decay_ * speed + dry * hyperbolicTangent(speed);
    }

   private:
    S decay_, torque_;
  };
};

}  // namespace amb_rotor::effects
