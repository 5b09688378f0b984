#pragma once
// A force law by its terms at one plane z of the rotor: a seal, an impeller, a motor or whatever else acts between or beside
// the bearings and is not in the catalogue. A hypothesis, not a mechanism; terms, symbols and signs: effects/law_terms.hpp,
// without those of the current. What pushes stands on the stator.
// Left out: moments, more planes than one, and what law_terms leaves out.
// Valid: where it was fitted, as far as the runs went. Source: a fit, no mechanism.
#include "amb_rotor/effects/law_terms.hpp"

namespace amb_rotor::effects {

struct ForceLawAtPlane : LawTerms {
  static constexpr const char* id = "force_law_at_plane";

  static EffectSchema schema() {
    EffectSchema s{id,
                   "a force at one plane by its terms in position, velocity, speed, angle and time: a hypothesis",
                   "whatever moves the quantities of its terms; the plane: translation and tilt",
                   {},
                   false};
    addRows(plane_term_count, s.parameters);
    s.parameters.push_back(parameter("z_m", "m", -2.0, 2.0, 0.0, 0.0, "axial position"));
    s.only_by_name = true;
    return s;
  }

  template <class S>
  class Physics final : public EffectPhysics<S> {
   public:
    explicit Physics(const std::vector<S>& p) : sum_(p, plane_term_count), z_(p[plane_term_count + 1]) {}
    unsigned roles() const override { return acts_on_rotor | acts_on_rotor_force; }
    void rotor(const Rig<S>&, RotorPort<S>& port) override { plane_ = port.addPlane(z_); }
    void rotorForce(const Shaft<S>& shaft, RotorForces<S>& rotor) const override {
      rotor.push(plane_, sum_.at(shaft, rotor.position(plane_), rotor.velocity(plane_), {}, 0));
    }

   private:
    Sum<S> sum_;
    S z_;
    int plane_ = 0;
  };
};

}  // namespace amb_rotor::effects
