#pragma once
// Hertzian contact: N = K d^1.5 (1 + l d') in place of the linear law (auxiliary_bearing/contact_law.hpp),
// K [N/m^1.5], l [s/m] = 1.5 alpha_d of thesis 3.37.
// Valid: smooth elastic surfaces that do not conform, impacts slower than waves cross the bodies, l d' above -1.
// Source: thesis 3.37; Hunt and Crossley, J. Appl. Mech. 42 (1975) 440.
// Left out: plastic dents, wear, the smaller exponent of a rotor that nearly fills its bearing.
#include "amb_rotor/effects/effect.hpp"

namespace amb_rotor::effects {

struct HertzianContact {
  static EffectSchema schema() {
    return {"hertzian_contact", "contact force goes with penetration to the power 3/2, with its damping",
            "contact at different impact speeds: rubs and drops",
            {parameter("stiffness_N_per_m1_5", "N/m^1.5", 1e5, 1e14, 2.4e9, std::nan(""), "K"),
             parameter("damping_s_per_m", "s/m", 0.0, 1e3, 0.5, std::nan(""), "l")},
            true};
  }

  template <class S>
  class Physics final : public EffectPhysics<S> {
   public:
    explicit Physics(const std::vector<S>& p) : stiffness_(p[0]), damping_(p[1]) {}
    unsigned roles() const override { return acts_on_normal_force; }
    void normalForce(const S& d, const S& rate, NormalForce<S>& n) const override {
      n = hertzContact(stiffness_, damping_, d, rate);
    }

   private:
    S stiffness_, damping_;
  };
};

}  // namespace amb_rotor::effects
