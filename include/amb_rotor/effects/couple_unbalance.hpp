#pragma once
// A further unbalance U [kg m] at phase p [rad] in a plane z [m]: with the rig's own it makes static plus couple
// unbalance (ISO 21940). Force: excitation/unbalance.hpp. Signature: 1X growing with speed squared, tilting.
// Valid: an eccentricity far below the rotor's radius; with a free spin m e^2 below Ip.
// Source: ISO 21940-2; thesis 3.33.
// Left out: unbalance that changes with speed or temperature.
#include "amb_rotor/effects/effect.hpp"

namespace amb_rotor::effects {

struct CoupleUnbalance {
  static EffectSchema schema() {
    return {"couple_unbalance", "a second unbalance plane: static plus couple unbalance",
            "rotation at two or more speeds",
            {parameter("moment_kg_m", "kg m", 0.0, 1e-1, 1e-5, 0.0, "mass times eccentricity",
                       ParameterRole::amplitude),
             parameter("phase_rad", "rad", -7.0, 7.0, 0.0, 0.0, "in the rotor", ParameterRole::phase),
             parameter("plane_z_m", "m", -2.0, 2.0, 0.05, 0.0, "axial position")},
            false};
  }

  template <class S>
  class Physics final : public EffectPhysics<S> {
   public:
    explicit Physics(const std::vector<S>& p) : unbalance_{p[2], p[0], p[1]} {}
    unsigned roles() const override { return acts_on_rig; }
    void rig(Rig<S>& rig) override { rig.unbalance.push_back(unbalance_); }

   private:
    Unbalance<S> unbalance_;
  };
};

}  // namespace amb_rotor::effects
