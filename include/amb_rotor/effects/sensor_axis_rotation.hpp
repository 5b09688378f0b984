#pragma once
// Sensor axis rotation: a sensor pair is turned about the shaft axis by an angle a [rad], for each end:
//   s_x = x cos a + y sin a,  s_y = y cos a - x sin a
// The controller then acts cross-coupled: a rotation a of both pairs destabilises like k sin a.
// Left out: non-orthogonality of the pair.
// Valid: every angle. Source: rotation of the axes, by definition.
#include "amb_rotor/effects/effect.hpp"

namespace amb_rotor::effects {

struct SensorAxisRotation {
  static EffectSchema schema() {
    return {"sensor_axis_rotation", "a sensor pair is turned about the shaft axis",
            "excitation in one axis at a time (step, chirp)",
            {parameter("angle_a_rad", "rad", -0.8, 0.8, 0.03, 0.0, "at end A"),
             parameter("angle_b_rad", "rad", -0.8, 0.8, 0.03, 0.0, "at end B")},
            false};
  }

  template <class S>
  class Physics final : public EffectPhysics<S> {
   public:
    explicit Physics(const std::vector<S>& p) {
      for (int e = 0; e < 2; ++e) sineCosine(p[e], sine_[e], cosine_[e]);
    }
    unsigned roles() const override { return acts_on_sensor; }
    void sense(const Shaft<S>&, Vec2<S> signal[2]) const override {
      for (int e = 0; e < 2; ++e) {
        const Vec2<S> w = signal[e];
        signal[e] = {w.x * cosine_[e] + w.y * sine_[e], w.y * cosine_[e] - w.x * sine_[e]};
      }
    }

   private:
    S sine_[2], cosine_[2];
  };
};

}  // namespace amb_rotor::effects
