#pragma once
// Foundation resonance: the stator stands on a flexible foundation, one mass m that moves in x and y, carries the
// sensors and all bearings and takes their reaction and that of seal, motor, internal damping and laws at the
// rotor:  m f'' + 2 zeta m w f' + m w^2 f = -(sum of these forces on the rotor).
// Signature: a resonance and an antiresonance near w. State: f, f' (x, y each).
// Left out: tilting of the foundation.
// Valid: below the foundation's second mode; the same in x and y.
// Source: Newton's law of the mass, as above.
#include "amb_rotor/effects/effect.hpp"

namespace amb_rotor::effects {

struct FoundationResonance {
  static EffectSchema schema() {
    EffectSchema schema = {"foundation_resonance", "the stator stands on a flexible foundation",
                           "chirp or run-up through the foundation's frequency",
                           {parameter("mass_kg", "kg", 1e-3, 1e6, 30.0, 1e6, "moving with the stator"),
                            parameter("frequency_hz", "Hz", 0.5, 5e3, 50.0, 50.0, "undamped, rotor locked away"),
                            parameter("damping_ratio", "1", 0.0, 2.0, 0.03, 0.03, "of critical")},
                           false};
    schema.mimic = "rotor.mass_kg";  // far above it the rotor moves against the stator as if it were m M/(m + M)
    return schema;
  }

  template <class S>
  class Physics final : public EffectPhysics<S> {
   public:
    explicit Physics(const std::vector<S>& p)
        : inverse_mass_(S(1.0) / p[0]), omega_(S(two_pi) * p[1]), damping_(S(2.0) * p[2] * omega_) {}
    unsigned roles() const override { return is_stator; }
    int stateSize() const override { return 4; }
    void statorPosition(const S* state, Vec2<S>& position, Vec2<S>& velocity) const override {
      position = {state[0], state[1]};
      velocity = {state[2], state[3]};
    }
    void statorRates(const Vec2<S>& reaction, const S* state, S* rate) const override {
      rate[0] = state[2];
      rate[1] = state[3];
      rate[2] = reaction.x * inverse_mass_ - damping_ * state[2] - omega_ * omega_ * state[0];
      rate[3] = reaction.y * inverse_mass_ - damping_ * state[3] - omega_ * omega_ * state[1];
    }

   private:
    S inverse_mass_, omega_, damping_;
  };
};

}  // namespace amb_rotor::effects
