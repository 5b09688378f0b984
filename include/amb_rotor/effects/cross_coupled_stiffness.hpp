#pragma once
// Cross-coupled stiffness of a seal or impeller at axial position z: a force at right angles to the displacement,
//   F = q (W/W_ref)^n (-y, x)
// q [N/m] at the reference speed W_ref [Hz] (a fixed reference, not fitted), n how it grows. It drives forward whirl:
// a mode becomes unstable where q reaches c w. Not seen in steady synchronous motion alone. At standstill it is 0.
// Left out: its direct stiffness and damping.
// Valid: whirl small against the seal's gap, where the force is linear in it.
// Source: Alford, J. Eng. Power 87 (1965) 333; Friswell, Penny, Garvey and Lees, Dynamics of Rotating Machines, Cambridge 2010.
#include "amb_rotor/effects/effect.hpp"

namespace amb_rotor::effects {

struct CrossCoupledStiffness {
  static EffectSchema schema() {
    return {"cross_coupled_stiffness",
            "seal or impeller: a force at right angles to the displacement, in the spin's direction",
            "excitation (chirp, step) while the shaft turns, at two or more speeds",
            {parameter("stiffness_N_per_m", "N/m", -1e8, 1e8, 1e4, 0.0, "at the reference speed"),
             parameter("reference_speed_hz", "Hz", 1e-3, 1e5, 100.0, 100.0, "fixed reference", ParameterRole::fixed),
             parameter("speed_exponent", "1", 0.0, 4.0, 1.0, 1.0, "growth with speed"),
             parameter("z_m", "m", -2.0, 2.0, 0.0, 0.0, "axial position")},
            false};
  }

  template <class S>
  class Physics final : public EffectPhysics<S> {
   public:
    explicit Physics(const std::vector<S>& p)
        : stiffness_(p[0]), per_reference_(S(1.0) / (S(two_pi) * p[1])), exponent_(p[2]), z_(p[3]) {}
    unsigned roles() const override { return acts_on_rotor | acts_on_rotor_force; }
    void rotor(const Rig<S>&, RotorPort<S>& port) override { plane_ = port.addPlane(z_); }
    void rotorForce(const Shaft<S>& shaft, RotorForces<S>& rotor) const override {
      // |W|^n by the logarithm; the tiny constant makes the standstill 0 instead of a fault
      const S ratio = magnitude(shaft.speed) * per_reference_ + S(1e-12);
      const S turn = select(shaft.speed < S(0.0), S(-1.0), S(1.0));
      const S q = turn * stiffness_ * exponential(exponent_ * logarithm(ratio));
      const Vec2<S> w = rotor.position(plane_);
      rotor.push(plane_, {-q * w.y, q * w.x});
    }

   private:
    S stiffness_, per_reference_, exponent_, z_;
    int plane_ = 0;
  };
};

}  // namespace amb_rotor::effects
