#pragma once
// Control delay: the whole time from a sample to its command at the amplifier [s], in place of the believed one.
// Signature: loss of phase margin, damping of the higher mode falls.
// Valid: a delay that is the same from sample to sample.
// Source: phase -w t_d of a dead time; Schweitzer and Maslen (eds.), Magnetic Bearings, Springer 2009.
// Left out: jitter, another delay for each axis.
#include "amb_rotor/effects/effect.hpp"

namespace amb_rotor::effects {

struct ControlDelay {
  static EffectSchema schema() {
    return {"control_delay", "a longer time from sample to command", "chirp or step",
            {inPlaceOf("controller.delay_s", parameter("delay_s", "s", 0.0, 5e-3, 2e-4, std::nan(""), "sample to command"))},
            false, false, "controller.sample_rate_hz"};
  }

  template <class S>
  class Physics final : public EffectPhysics<S> {
   public:
    explicit Physics(const std::vector<S>& p) : delay_(p[0]) {}
    unsigned roles() const override { return acts_on_rig; }
    void rig(Rig<S>& rig) override { rig.controller.delay_s = delay_; }

   private:
    S delay_;
  };
};

}  // namespace amb_rotor::effects
