#pragma once
// Magnetic saturation: the iron's flux stays behind the current. With b the flux of a coil relative to its bias flux,
//   b -> b/(1 + (b/bk)^4)^(1/4),  bk = knee flux density / bias flux density,  F = Ki i0/4 (b+^2 - b-^2).
// Needs the rig's bias flux density. Left out: hysteresis, different knees of yoke and pole.
// Valid: small signals and the limit of large ones; between them the knee's shape is a choice.
// Source: none is printed: the smooth passage from slope 1 to 0 is ours; flux as in thesis 3.16.
#include "amb_rotor/effects/effect.hpp"

namespace amb_rotor::effects {

struct MagneticSaturation {
  static EffectSchema schema() {
    EffectSchema schema{"magnetic_saturation", "the iron saturates: force grows less than the current squared",
            "large control currents beside small ones",
            {parameter("knee_flux_density_T", "T", 0.05, 10.0, 1.2, 10.0, "of the iron")},
            false, false, "amb.bias_flux_density_T"};
    schema.mimic = "amb.current_stiffness_N_per_A";  // iron near its knee gives less force, too
    return schema;
  }

  template <class S>
  class Physics final : public EffectPhysics<S> {
   public:
    explicit Physics(const std::vector<S>& p) : knee_(p[0]) {}
    unsigned roles() const override { return acts_on_rig | acts_on_flux; }
    void rig(Rig<S>& rig) override { inverse_knee_ = rig.amb.bias_flux_density_T / knee_; }
    void flux(const Rig<S>&, const S&, const S&, CoilFlux<S>& flux) const override {
      flux = {saturatedFlux(flux.plus, inverse_knee_), saturatedFlux(flux.minus, inverse_knee_)};
    }

   private:
    S knee_, inverse_knee_ = S(1.0);
  };
};

}  // namespace amb_rotor::effects
