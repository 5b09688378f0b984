#pragma once
// Gyroscopic coupling: the polar inertia Ip [kg m2] couples the tilting axes (rotor/modal_rotor.hpp); it takes the
// place of the rig's own value. Signature: the conical mode splits into forward and backward,
// W_f,b = +- Ip W/(2 It) + sqrt(w^2 + (Ip W/(2 It))^2). Ip <= 2 It by the triangle inequality.
// For a rigid_beam only: a rigid_mass does not tilt, and a flexible rotor has its gyroscopic matrix from its
// geometry. The rules of a model refuse it elsewhere (model/model_rules.hpp).
// Valid: tilts whose square counts for nothing.
// Source: Friswell, Penny, Garvey and Lees, Dynamics of Rotating Machines, Cambridge 2010; derived in doc/physics.md section 1.
// Left out: the term with W', of the order of the tilt.
#include "amb_rotor/effects/effect.hpp"

namespace amb_rotor::effects {

struct GyroscopicCoupling {
  static EffectSchema schema() {
    return {"gyroscopic_coupling", "polar inertia couples the tilting axes",
            "tilting excitation while the shaft turns",
            {inPlaceOf("rotor.polar_inertia_kg_m2", parameter("polar_inertia_kg_m2", "kg m2", 0.0, 1e3, 1e-3, 0.0, "of the rotor"))},
            false};
  }

  template <class S>
  class Physics final : public EffectPhysics<S> {
   public:
    explicit Physics(const std::vector<S>& p) : polar_inertia_(p[0]) {}
    unsigned roles() const override { return acts_on_rig; }
    void rig(Rig<S>& rig) override { rig.rotor.polar_inertia_kg_m2 = polar_inertia_; }

   private:
    S polar_inertia_;
  };
};

}  // namespace amb_rotor::effects
