#pragma once
// Sensor gain error: the sensitivity of each sensor is off by a factor, s = factor * (signal so far).
// Factor 1 is a true sensor. The loop gain changes with it. Left out: nonlinearity of the sensor.
// Valid: a factor that depends on neither place nor frequency. Source: by definition.
#include "amb_rotor/effects/effect.hpp"

namespace amb_rotor::effects {

struct SensorGainError {
  static EffectSchema schema() {
    return {"sensor_gain_error", "the sensitivity of a sensor is off",
            "any motion; told from a force error by the ratio of displacement to current",
            {parameter("factor_ax", "1", 0.2, 5.0, 1.03, 1.0, "end A, x", ParameterRole::reciprocal),
             parameter("factor_ay", "1", 0.2, 5.0, 1.03, 1.0, "end A, y", ParameterRole::reciprocal),
             parameter("factor_bx", "1", 0.2, 5.0, 1.03, 1.0, "end B, x", ParameterRole::reciprocal),
             parameter("factor_by", "1", 0.2, 5.0, 1.03, 1.0, "end B, y", ParameterRole::reciprocal)},
            false};
  }

  template <class S>
  class Physics final : public EffectPhysics<S> {
   public:
    explicit Physics(const std::vector<S>& p) : factor_(p) {}
    unsigned roles() const override { return acts_on_sensor; }
    void sense(const Shaft<S>&, Vec2<S> signal[2]) const override {
      for (int e = 0; e < 2; ++e)
        signal[e] = {factor_[2 * e] * signal[e].x, factor_[2 * e + 1] * signal[e].y};
    }

   private:
    std::vector<S> factor_;
  };
};

}  // namespace amb_rotor::effects
