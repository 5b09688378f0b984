#pragma once
// Amplifier lag: the current follows its command with another bandwidth [Hz] than believed, first order.
// Valid: commands within the limits of current and voltage; beyond the latter see `coil` (magnetic_bearing/coil.hpp).
// Source: the current-controlled amplifier as one pole, Schweitzer and Maslen (eds.), Magnetic Bearings, Springer 2009.
// Left out: resonances and delay of the amplifier itself, another bandwidth for each axis.
#include "amb_rotor/effects/effect.hpp"

namespace amb_rotor::effects {

struct AmplifierLag {
  static EffectSchema schema() {
    return {"amplifier_lag", "the current follows its command more slowly than believed",
            "the current channels beside the excitation (chirp, step)",
            {inPlaceOf("amb.amplifier_bandwidth_hz", parameter("bandwidth_hz", "Hz", 10.0, 1e6, 1000.0, std::nan(""), "first order"))},
            false, false, "amb.amplifier_bandwidth_hz"};
  }

  template <class S>
  class Physics final : public EffectPhysics<S> {
   public:
    explicit Physics(const std::vector<S>& p) : bandwidth_(p[0]) {}
    unsigned roles() const override { return acts_on_rig; }
    void rig(Rig<S>& rig) override { rig.amb.amplifier_bandwidth_hz = bandwidth_; }

   private:
    S bandwidth_;
  };
};

}  // namespace amb_rotor::effects
