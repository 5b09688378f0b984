#pragma once
// A couple by its terms in the tilt: what resists or drives the rotor's tilt (a disc between faces, an axial bearing, a
// coupling) and is not in the catalogue. F of effects/law_terms.hpp, without the terms of the current, with
//   p = (p_b - p_a)/2,  v = p',
// p_a, p_b [m] the displacements at the magnetic bearings, pushes the rotor at bearing b and -F at bearing a: a moment
// (z_b - z_a) F about the axes, no force. A rotor of one mass has no tilt. What pushes stands on the stator, and in sum does
// not move it. A hypothesis, not a mechanism.
// Left out: couples that follow translation, forces that follow the tilt, and what law_terms leaves out.
// Valid: where it was fitted, as far as the runs went. Source: a fit, no mechanism.
#include "amb_rotor/effects/law_terms.hpp"
#include "amb_rotor/effects/tilt_planes.hpp"

namespace amb_rotor::effects {

struct ForceLawOfTilt : LawTerms {
  static constexpr const char* id = "force_law_of_tilt";

  static EffectSchema schema() {
    EffectSchema s{id,
                   "a couple by its terms in tilt, its rate, speed, angle and time: a hypothesis",
                   "whatever tilts the rotor",
                   {},
                   false};
    addRows(plane_term_count, s.parameters);
    s.only_by_name = true;
    return s;
  }

  template <class S>
  class Physics final : public EffectPhysics<S> {
   public:
    explicit Physics(const std::vector<S>& p) : sum_(p, plane_term_count) {}
    unsigned roles() const override { return acts_on_rotor | acts_on_rotor_force; }
    void rotor(const Rig<S>& rig, RotorPort<S>& port) override { tilt_ = TiltPlanes<S>(rig, port); }
    void rotorForce(const Shaft<S>& shaft, RotorForces<S>& rotor) const override {
      tilt_.push(rotor, sum_.at(shaft, tilt_.position(rotor), tilt_.velocity(rotor), {}, 0));
    }

   private:
    Sum<S> sum_;
    TiltPlanes<S> tilt_;
  };
};

}  // namespace amb_rotor::effects
