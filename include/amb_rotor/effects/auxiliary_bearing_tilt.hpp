#pragma once
// Auxiliary bearing tilt: the axis of the auxiliary bearing of an end leans by the small slopes (sx, sy) = dx/dz, dy/dz
// [rad] of its axis against the stator's. Over the width w [m] its edges then lie at +- s w/2 beside its centre, and the
// rotor meets the edge whose centre is farther from its own:
//   d = |r| - C  with r from the edge's centre  c - sign(s . r_c) s w/2,  r_c from the bearing's centre c
// so that the clearance shrinks by w/2 |s . n|: in the plane of the lean, not at right angles to it. The penetration is
// continuous where the edge changes (s . r_c = 0), the direction of the force turns by |s| w/C there.
// Seen only in contact. Left out: the rotor's own tilt against the bearing, both edges at once, the spread of the
// contact along the edge, the drag of a misaligned ball bearing.
// Valid: slopes whose square counts for nothing, a width far below the distance of the two bearings.
// Source: geometry of the two edges of a ring, as above.
#include "amb_rotor/effects/effect.hpp"

namespace amb_rotor::effects {

struct AuxiliaryBearingTilt {
  static EffectSchema schema() {
    return {"auxiliary_bearing_tilt", "the auxiliary bearing leans: its edges carry", "contact: rubs and drops",
            {parameter("slope_ax_rad", "rad", -0.1, 0.1, 2e-3, 0.0, "dx/dz of the axis, end A"),
             parameter("slope_ay_rad", "rad", -0.1, 0.1, 2e-3, 0.0, "dy/dz of the axis, end A"),
             parameter("slope_bx_rad", "rad", -0.1, 0.1, 2e-3, 0.0, "dx/dz of the axis, end B"),
             parameter("slope_by_rad", "rad", -0.1, 0.1, 2e-3, 0.0, "dy/dz of the axis, end B"),
             parameter("width_m", "m", 1e-4, 1.0, 0.012, 0.012, "of the bearing", ParameterRole::fixed)},
            true, true};
  }

  template <class S>
  class Physics final : public EffectPhysics<S> {
   public:
    explicit Physics(const std::vector<S>& p)
        : edge_{{S(0.5) * p[4] * p[0], S(0.5) * p[4] * p[1]}, {S(0.5) * p[4] * p[2], S(0.5) * p[4] * p[3]}} {}
    unsigned roles() const override { return acts_on_contact_edge; }
    void contactEdge(int end, const Vec2<S>& offset, Vec2<S>& centre) const override {
      const S side = select(edge_[end].dot(offset) > S(0.0), S(-1.0), S(1.0));
      centre += side * edge_[end];
    }

   private:
    Vec2<S> edge_[2];
  };
};

}  // namespace amb_rotor::effects
