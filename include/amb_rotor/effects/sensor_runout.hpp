#pragma once
// Sensor runout: the sensor tracks are not round, so that the signal carries the shaft's angle t:
//   s_x = x + r1 cos(t + p1) + r2 cos 2(t + p2)
//   s_y = y + r1 sin(t + p1) - r2 cos 2(t + p2)
// r [m] amplitude and p [rad] phase of first and second harmonic, for each end. It is no force but what
// the controller makes of it, and does not grow with speed. Signature: 1X and 2X at slow roll.
// The second harmonic has opposite sign in y: two sensors at right angles see an oval track so.
// Left out: harmonics above the second, noise of the track (electrical runout).
// Valid: amplitudes small against the track's radius, so that motion and runout add up.
// Source: by definition, the first two harmonics of the track's radius under sensors at right angles.
#include "amb_rotor/effects/effect.hpp"

namespace amb_rotor::effects {

struct SensorRunout {
  static EffectSchema schema() {
    EffectSchema s{"sensor_runout", "the sensor track is not round: 1X and 2X in the signal at all speeds",
                   "rotation at two or more speeds, best on both sides of a critical speed", {}, false};
    for (const char* end : {"a", "b"}) {
      const std::string e = end;
      s.parameters.push_back({e + "_1x_m", "m", 0.0, 1e-4, 1e-6, 0.0, ParameterRole::amplitude, "first harmonic"});
      s.parameters.push_back(
          {e + "_1x_phase_rad", "rad", -7.0, 7.0, 0.0, 0.0, ParameterRole::phase, "its phase"});
      s.parameters.push_back({e + "_2x_m", "m", 0.0, 1e-4, 1e-6, 0.0, ParameterRole::amplitude, "second harmonic"});
      s.parameters.push_back({e + "_2x_phase_rad", "rad", -7.0, 7.0, 0.0, 0.0, ParameterRole::phase,
                              "its phase, as shaft angle", 2});
    }
    return s;
  }

  template <class S>
  class Physics final : public EffectPhysics<S> {
   public:
    explicit Physics(const std::vector<S>& p) {
      for (int e = 0; e < 2; ++e) {
        first_[e] = p[4 * e];
        first_phase_[e] = RotorPhase<S>(p[4 * e + 1]);
        second_[e] = p[4 * e + 2];
        second_phase_[e] = RotorPhase<S>(S(2.0) * p[4 * e + 3]);
      }
    }
    unsigned roles() const override { return acts_on_sensor; }
    void sense(const Shaft<S>& shaft, Vec2<S> signal[2]) const override {
      for (int e = 0; e < 2; ++e) {
        signal[e] += first_[e] * first_phase_[e].turn(shaft);
        const S second = second_[e] * second_phase_[e].turnTwice(shaft).x;
        signal[e] += Vec2<S>{second, -second};
      }
    }

   private:
    S first_[2], second_[2];
    RotorPhase<S> first_phase_[2], second_phase_[2];
  };
};

}  // namespace amb_rotor::effects
