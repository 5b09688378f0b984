#pragma once
// What tilts the rotor, by the two magnetic bearings' planes: p = (p_b - p_a)/2 [m] with its rate, and a couple as +F at
// bearing b and -F at a [N]: a moment (z_b - z_a) F about the axes, no force. Left out: what bends the rotor between them.
#include "amb_rotor/effects/effect.hpp"

namespace amb_rotor::effects {

template <class S>
class TiltPlanes {
 public:
  TiltPlanes() = default;
  TiltPlanes(const Rig<S>& rig, RotorPort<S>& port) : a_(port.addPlane(rig.planes.amb[0])), b_(port.addPlane(rig.planes.amb[1])) {}
  Vec2<S> position(const RotorForces<S>& rotor) const { return S(0.5) * (rotor.position(b_) - rotor.position(a_)); }
  Vec2<S> velocity(const RotorForces<S>& rotor) const { return S(0.5) * (rotor.velocity(b_) - rotor.velocity(a_)); }
  void push(RotorForces<S>& rotor, const Vec2<S>& force) const {
    rotor.push(b_, force);
    rotor.push(a_, S(-1.0) * force);
  }

 private:
  int a_ = 0, b_ = 0;
};

}  // namespace amb_rotor::effects
