#pragma once
// Shaft crack (breathing): the stiffness is lower once a turn in one direction of the rotor; with relative depth h,
//   F = h k (1 + cos u)/2 n (n.p),  n = (cos u, sin u),  u = t + phase,  k = Ki kp - Ks
// at each magnetic bearing, p the displacement there. Signature: 2X at half the critical speed under a static load.
// F = -dV/dp of what the spring k (n.p)^2/2 has less, V = -h k (1 + cos u)/4 (n.p)^2 [J], so a free spin feels
//   -dV/du = h k (n.p) ((1 + cos u)/2 (n'.p) - sin u/4 (n.p)),  n' = (-sin u, cos u)      [N m]
// With one axis of a bearing off the force has no potential, and no torque.
// Left out: crack breathing by the orbit, local flexibility at the crack's own plane.
// Valid: weight dominates: the motion is small against the sag, so that the crack opens and closes with the turn.
// Source: Gasch, J. Sound Vib. 160 (1993) 313; (1 + cos u)/2 of Mayes and Davies, J. Vib. Acoust. 106 (1984) 139.
#include "amb_rotor/effects/effect.hpp"

namespace amb_rotor::effects {

struct ShaftCrack {
  static EffectSchema schema() {
    return {"shaft_crack", "stiffness varies once a turn: 2X at half the critical speed",
            "rotation under a static load near half the critical speed",
            {parameter("relative_depth", "1", 0.0, 1.0, 0.05, 0.0, "share of the net stiffness",
                       ParameterRole::amplitude),
             parameter("phase_rad", "rad", -7.0, 7.0, 0.0, 0.0, "in the rotor", ParameterRole::phase)},
            false};
  }

  template <class S>
  class Physics final : public EffectPhysics<S> {
   public:
    explicit Physics(const std::vector<S>& p) : depth_(p[0]), phase_(p[1]) {}
    unsigned roles() const override { return acts_on_bearing_force; }
    void bearingForce(const BearingSite<S>& site, Vec2<S>& force) const override {
      const Vec2<S> n = phase_.turn(*site.shaft);
      const S open = S(0.5) * (S(1.0) + n.x);
      force += (depth_ * site.net_stiffness * open * n.dot(site.position)) * n;
    }
    S bearingTorque(const BearingSite<S>& site) const override {
      const Vec2<S> n = phase_.turn(*site.shaft);
      const S along = n.dot(site.position), across = n.x * site.position.y - n.y * site.position.x;
      return site.on.x * site.on.y * depth_ * site.net_stiffness * along *
             (S(0.5) * (S(1.0) + n.x) * across - S(0.25) * n.y * along);
    }

   private:
    S depth_;
    RotorPhase<S> phase_;
  };
};

}  // namespace amb_rotor::effects
