#pragma once
// Current saturation: the amplifier's true limit of a coil's current [A] lies below the believed one
// (magnetic_bearing/amplifier.hpp). Seen only where the command reaches it.
// Valid: a hard limit, the same for all coils.
// Source: thesis table 4.1 (5 A).
// Left out: the voltage's limit (magnetic_bearing/coil.hpp), a limit that falls as the amplifier gets hot.
#include "amb_rotor/effects/effect.hpp"

namespace amb_rotor::effects {

struct CurrentSaturation {
  static EffectSchema schema() {
    return {"current_saturation", "amplifier limit below the believed one",
            "commands that reach the limit (strong excitation, critical speeds)",
            {inPlaceOf("amb.max_current_A",
                       parameter("max_current_A", "A", 1e-3, 1e3, 3.0, std::nan(""), "limit of a coil's current"))},
            false, false, "amb.max_current_A"};
  }

  template <class S>
  class Physics final : public EffectPhysics<S> {
   public:
    explicit Physics(const std::vector<S>& p) : limit_(p[0]) {}
    unsigned roles() const override { return acts_on_rig; }
    void rig(Rig<S>& rig) override { rig.amb.max_current_A = limit_; }

   private:
    S limit_;
  };
};

}  // namespace amb_rotor::effects
