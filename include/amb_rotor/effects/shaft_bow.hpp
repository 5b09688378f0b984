#pragma once
// Shaft bow: the rotor is bent at rest. At each bearing the bent shaft is pushed by the net stiffness k:
//   F = k bow (cos, sin)(t + p),  k = Ki kp - Ks
// bow [m] at end A and B, common phase p [rad] in the rotor; not seen by the sensors. Signature: 1X that
// does not grow with speed squared. With u = t + p and r the displacement there, F = -dV/dr of
//   V = -k bow (x cos u + y sin u)          [J]
// so a free spin feels -dV/du = k bow (y cos u - x sin u) [N m]; of an axis that is off, neither.
// Left out: bow that changes with temperature.
// Valid: a loop whose stiffness at the speed is that at rest; a bow small against gap and clearance.
// Source: Nicholas, Gunter and Allaire, J. Eng. Power 98 (1976): a force that speed does not change.
#include "amb_rotor/effects/effect.hpp"

namespace amb_rotor::effects {

struct ShaftBow {
  static EffectSchema schema() {
    return {"shaft_bow", "the rotor is bent at rest: a once-per-turn force that does not grow with speed squared",
            "rotation at two or more speeds, a slow roll above all",
            {parameter("bow_a_m", "m", -1e-3, 1e-3, 3e-6, 0.0, "at bearing A", ParameterRole::amplitude),
             parameter("bow_b_m", "m", -1e-3, 1e-3, 3e-6, 0.0, "at bearing B", ParameterRole::amplitude),
             parameter("phase_rad", "rad", -7.0, 7.0, 0.0, 0.0, "in the rotor", ParameterRole::phase)},
            false};
  }

  template <class S>
  class Physics final : public EffectPhysics<S> {
   public:
    explicit Physics(const std::vector<S>& p) : bow_{p[0], p[1]}, phase_(p[2]) {}
    unsigned roles() const override { return acts_on_bearing_force; }
    void bearingForce(const BearingSite<S>& site, Vec2<S>& force) const override {
      force += (site.net_stiffness * bow_[site.end]) * phase_.turn(*site.shaft);
    }
    S bearingTorque(const BearingSite<S>& site) const override {
      const Vec2<S> e = phase_.turn(*site.shaft);
      return site.net_stiffness * bow_[site.end] *
             (site.on.y * site.position.y * e.x - site.on.x * site.position.x * e.y);
    }

   private:
    S bow_[2];
    RotorPhase<S> phase_;
  };
};

}  // namespace amb_rotor::effects
