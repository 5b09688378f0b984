#pragma once
// Velocity-dependent (Stribeck) friction: mu(v) = mu_d + (mu_s - mu_d) exp(-|v|/v_s) in place of the constant one,
// v the sliding speed [m/s].
// Valid: steady sliding; below 0.01 m/s the regularisation of auxiliary_bearing/contact_law.hpp is what counts.
// Source: Armstrong-Helouvry, Dupont and Canudas de Wit, Automatica 30 (1994) 1083.
// Left out: memory of the friction, static friction that grows with the time at rest, a viscous part.
#include "amb_rotor/effects/effect.hpp"

namespace amb_rotor::effects {

struct VelocityDependentFriction {
  static EffectSchema schema() {
    EffectSchema schema = {"velocity_dependent_friction", "friction falls with sliding speed (Stribeck)",
                           "contact at different sliding speeds",
                           {parameter("static_coefficient", "1", 0.0, 2.0, 0.25, std::nan(""), "mu_s, at rest",
                                      ParameterRole::rise),
                            parameter("dynamic_coefficient", "1", 0.0, 2.0, 0.08, std::nan(""), "mu_d, sliding fast"),
                            parameter("speed_m_per_s", "m/s", 1e-4, 1e3, 2.0, std::nan(""), "v_s",
                                      ParameterRole::reciprocal)},
                           true};
    schema.mimic = "auxiliary_bearing.friction_coefficient";  // where all slips are fast, it is less friction
    return schema;
  }

  template <class S>
  class Physics final : public EffectPhysics<S> {
   public:
    explicit Physics(const std::vector<S>& p) : rest_(p[0]), sliding_(p[1]), per_speed_(S(1.0) / p[2]) {}
    unsigned roles() const override { return acts_on_friction; }
    void friction(const S& slip, S& coefficient) const override {
      coefficient = sliding_ + (rest_ - sliding_) * exponential(-magnitude(slip) * per_speed_);
    }

   private:
    S rest_, sliding_, per_speed_;
  };
};

}  // namespace amb_rotor::effects
