#pragma once
// Stiffness anisotropy: bearing stiffness differs between x and y by the relative difference e,
//   F_x = -e/2 k x,  F_y = +e/2 k y  at each magnetic bearing, k = Ki kp - Ks.
// Signature: split of the modes, elliptical orbit, backward whirl between the two critical speeds.
// Valid: principal axes along x and y. Source: Friswell, Penny, Garvey and Lees, Dynamics of Rotating Machines, Cambridge 2010.
// Left out: principal axes between them, anisotropic damping.
#include "amb_rotor/effects/effect.hpp"

namespace amb_rotor::effects {

struct StiffnessAnisotropy {
  static EffectSchema schema() {
    return {"stiffness_anisotropy", "bearing stiffness differs between x and y",
            "excitation in x and in y, or rotation near a critical speed",
            {parameter("relative_difference", "1", -1.5, 1.5, 0.03, 0.0, "(k_x - k_y)/k")},
            false};
  }

  template <class S>
  class Physics final : public EffectPhysics<S> {
   public:
    explicit Physics(const std::vector<S>& p) : half_(S(0.5) * p[0]) {}
    unsigned roles() const override { return acts_on_bearing_force; }
    void bearingForce(const BearingSite<S>& site, Vec2<S>& force) const override {
      const S k = half_ * site.net_stiffness;
      force += Vec2<S>{-k * site.position.x, k * site.position.y};
    }

   private:
    S half_;
  };
};

}  // namespace amb_rotor::effects
