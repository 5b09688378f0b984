#pragma once
// Unbalanced magnetic pull of the motor: a negative stiffness away from the bearings, F = +k (x, y) at axial
// position z [m], k [N/m] positive pulls outwards. Left out: its dependence on the motor's current and slip.
// Valid: displacements small against the motor's gap, where the pull is linear.
// Source: Exzentrizitaetsfelder als Ursache von Laufinstabilitaeten bei Asynchronmaschinen 1, Archiv fuer Elektrotechnik.
#include "amb_rotor/effects/effect.hpp"

namespace amb_rotor::effects {

struct MotorMagneticPull {
  static EffectSchema schema() {
    return {"motor_magnetic_pull", "the motor pulls the rotor off centre",
            "excitation of both rigid modes (chirp, step)",
            {parameter("stiffness_N_per_m", "N/m", -1e8, 1e8, 1e4, 0.0, "positive pulls outwards"),
             parameter("z_m", "m", -2.0, 2.0, 0.0, 0.0, "axial position")},
            false};
  }

  template <class S>
  class Physics final : public EffectPhysics<S> {
   public:
    explicit Physics(const std::vector<S>& p) : stiffness_(p[0]), z_(p[1]) {}
    unsigned roles() const override { return acts_on_rotor | acts_on_rotor_force; }
    void rotor(const Rig<S>&, RotorPort<S>& port) override { plane_ = port.addPlane(z_); }
    void rotorForce(const Shaft<S>&, RotorForces<S>& rotor) const override {
      rotor.push(plane_, stiffness_ * rotor.position(plane_));
    }

   private:
    S stiffness_, z_;
    int plane_ = 0;
  };
};

}  // namespace amb_rotor::effects
