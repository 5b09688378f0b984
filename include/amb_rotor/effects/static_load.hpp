#pragma once
// A constant force (F_x, F_y) [N] at the centre of gravity from outside of machine and stator: gravity that nobody
// stated, a belt. It leaves no reaction on a stator that moves (foundation_resonance).
// Valid: a force that depends on nothing. Source: by definition.
// Left out: its moment about the centre of gravity (forces at a plane are excitations of a scenario).
#include "amb_rotor/effects/effect.hpp"

namespace amb_rotor::effects {

struct StaticLoad {
  static EffectSchema schema() {
    EffectSchema schema = {"static_load", "gravity or another constant force", "any run with the bearings on; the mean current",
                           {parameter("force_x_N", "N", -1e5, 1e5, 1.0, 0.0, "horizontal"),
                            parameter("force_y_N", "N", -1e5, 1e5, 1.0, 0.0, "vertical")},
                           false};
    schema.held_as_offset = true;  // the controller holds an offset as it holds a force
    return schema;
  }

  template <class S>
  class Physics final : public EffectPhysics<S> {
   public:
    explicit Physics(const std::vector<S>& p) : force_{p[0], p[1]} {}
    unsigned roles() const override { return acts_on_rotor | acts_on_rotor_force; }
    void rotor(const Rig<S>&, RotorPort<S>& port) override { plane_ = port.addPlane(S(0.0)); }
    void rotorForce(const Shaft<S>&, RotorForces<S>& rotor) const override { rotor.load(plane_, force_); }

   private:
    Vec2<S> force_;
    int plane_ = 0;
  };
};

}  // namespace amb_rotor::effects
