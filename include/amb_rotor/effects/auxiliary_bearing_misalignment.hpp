#pragma once
// Auxiliary bearing misalignment: the centre of the auxiliary bearing of an end lies at (offset_x, offset_y) [m]
// from the stator's axis (the thesis's x_s, y_s). Seen only in contact.
// Valid: offsets below the clearance; beyond it the rotor touches in the stator's middle.
// Source: thesis figure 5.2.
// Left out: a bearing that leans (auxiliary_bearing_tilt), offsets that drift with the temperature.
#include "amb_rotor/effects/effect.hpp"

namespace amb_rotor::effects {

struct AuxiliaryBearingMisalignment {
  static EffectSchema schema() {
    return {"auxiliary_bearing_misalignment", "the auxiliary bearing is not concentric", "contact: rubs and drops",
            {parameter("offset_ax_m", "m", -5e-3, 5e-3, 1e-5, 0.0, "end A, x"),
             parameter("offset_ay_m", "m", -5e-3, 5e-3, 1e-5, 0.0, "end A, y"),
             parameter("offset_bx_m", "m", -5e-3, 5e-3, 1e-5, 0.0, "end B, x"),
             parameter("offset_by_m", "m", -5e-3, 5e-3, 1e-5, 0.0, "end B, y")},
            true};
  }

  template <class S>
  class Physics final : public EffectPhysics<S> {
   public:
    explicit Physics(const std::vector<S>& p) : offset_{{p[0], p[1]}, {p[2], p[3]}} {}
    unsigned roles() const override { return acts_on_contact_centre; }
    void contactCentre(int end, Vec2<S>& centre) const override { centre += offset_[end]; }

   private:
    Vec2<S> offset_[2];
  };
};

}  // namespace amb_rotor::effects
