#pragma once
// Internal damping turns with the rotor: F = -d (x' + W y, y' - W x) at axial position z, d [N s/m].
// Stable below, driving forward whirl above the threshold speed W = w (1 + d_ext/d). What drives it comes from the spin, which
// feels the torque M = -(x F_y - y F_x), so that F.v + M W = -d abs(v - W z_hat x r)^2 is never positive.
// Valid: viscous damping at one plane, small against critical.
// Source: Kimball, General Electric Review, April 1924, 244; Friswell, Penny, Garvey and Lees, Dynamics of Rotating Machines,
// Cambridge 2010.
// Left out: hysteretic damping, which does not grow with frequency; damping of the shaft's own modes (rotor.geometry).
#include "amb_rotor/effects/effect.hpp"

namespace amb_rotor::effects {

struct InternalDamping {
  static EffectSchema schema() {
    return {"internal_damping", "damping that turns with the rotor", "excitation at standstill and at speed",
            {parameter("damping_N_s_per_m", "N s/m", 0.0, 1e6, 30.0, 0.0, "in the rotor"),
             parameter("z_m", "m", -2.0, 2.0, 0.0, 0.0, "axial position")},
            false};
  }

  template <class S>
  class Physics final : public EffectPhysics<S> {
   public:
    explicit Physics(const std::vector<S>& p) : damping_(p[0]), z_(p[1]) {}
    unsigned roles() const override { return acts_on_rotor | acts_on_rotor_force; }
    void rotor(const Rig<S>&, RotorPort<S>& port) override { plane_ = port.addPlane(z_); }
    void rotorForce(const Shaft<S>& shaft, RotorForces<S>& rotor) const override {
      const Vec2<S> w = rotor.position(plane_), v = rotor.velocity(plane_);
      const Vec2<S> force = {-damping_ * (v.x + shaft.speed * w.y), -damping_ * (v.y - shaft.speed * w.x)};
      rotor.push(plane_, force);
      rotor.twist(w.y * force.x - w.x * force.y);
    }

   private:
    S damping_, z_;
    int plane_ = 0;
  };
};

}  // namespace amb_rotor::effects
