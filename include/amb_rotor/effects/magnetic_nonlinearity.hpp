#pragma once
// Magnetic nonlinearity: the force goes with (current/gap)^2 of one-sided coils (thesis 3.16, 3.18),
//   F = Ki i0/4 (((1 + i/i0)/(1 - x/s0))^2 - ((1 - i/i0)/(1 + x/s0))^2)
// with no Ks x beside it: its own slope Ki i0/s0 takes the place of Ks. i0 [A] bias, s0 [m] air gap.
// Signature: stiffness that falls with amplitude, odd harmonics, amplitude-dependent modes.
// Valid: abs(x) below the gap, currents of both coils from 0 on, iron below its knee.
// Source: thesis 3.16, 3.18.
// Left out: coupling of the axes through the yoke, stray flux.
#include "amb_rotor/effects/effect.hpp"

namespace amb_rotor::effects {

struct MagneticNonlinearity {
  static EffectSchema schema() {
    return {"magnetic_nonlinearity", "force goes with (current/gap) squared, one-sided coils",
            "large amplitudes beside small ones",
            {inPlaceOf("amb.bias_current_A", parameter("bias_current_A", "A", 1e-3, 1e3, 2.5, std::nan(""), "i0", ParameterRole::quotient)),
             inPlaceOf("amb.air_gap_m", parameter("air_gap_m", "m", 1e-5, 1e-2, 0.6e-3, std::nan(""), "s0, rotor centred"))},
            false, false, "amb.air_gap_m"};
  }

  template <class S>
  class Physics final : public EffectPhysics<S> {
   public:
    explicit Physics(const std::vector<S>& p) : bias_(p[0]), air_gap_(p[1]) {}
    unsigned roles() const override { return acts_on_rig | acts_on_flux; }
    void rig(Rig<S>& rig) override {
      // what other effects call k = Ki kp - Ks, and the coil limits, follow this law's own slope and bias
      rig.amb.bias_current_A = bias_;
      rig.amb.air_gap_m = air_gap_;
      rig.amb.displacement_stiffness_N_per_m = rig.amb.current_stiffness_N_per_A * bias_ / air_gap_;
    }
    void flux(const Rig<S>&, const S& current, const S& position, CoilFlux<S>& flux) const override {
      flux = gapFlux(bias_, air_gap_, current, position);
    }

   private:
    S bias_, air_gap_;
  };
};

}  // namespace amb_rotor::effects
