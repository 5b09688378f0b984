#pragma once
// Sensors whose signal is no straight line, by terms: at each sensor pair
//   y = s + sum of coefficients times the vectors of the table below,
// s = (s_x, s_y) [m] the signal so far (each axis is an instrument of its own: |s_x| s_x, not |s| s_x), w [m] a width,
// t the shaft angle [rad], W the spin speed [rad/s], T the time of the run [s], e_x, e_y the stator's axes. A dead zone, or play,
// is -c tanh(s/w), rounded off over w: for |s| well above w the signal is c too small. A hypothesis, not a mechanism.
// Left out: memory, one sensor unlike the others, harmonics other than the third, what the catalogue has (gains, turned axes, 1X and 2X).
// Valid: where it was fitted, as far as the runs went. Source: a fit, no mechanism.
#include <cmath>

#include "amb_rotor/effects/effect.hpp"

namespace amb_rotor::effects {

struct SignalLaw {
  static constexpr const char* id = "signal_law";

  enum Term : int {
    square,
    even,
    cube,
    step,
    mixed,
    turn,
    drift,
    drift_x,
    drift_y,
    thrice_cosine,
    thrice_sine,
    back_thrice_cosine,
    back_thrice_sine,
    term_count
  };

  static EffectSchema schema() {
    EffectSchema s{id, "signals of the sensors by terms in position, spin speed, shaft angle and time: a hypothesis",
                   "whatever moves the quantities of its terms", {}, false};
    const double wide = 1e30;
    const auto add = [&](const char* name, const char* unit, double typical, const char* meaning) {
      s.parameters.push_back(parameter(name, unit, -wide, wide, typical, 0.0, meaning));
    };
    add("signal_square_per_m", "1/m", 4e2, "position: (|s_x| s_x, |s_y| s_y)");
    add("signal_even_per_m", "1/m", 4e2, "position: (s_x^2, s_y^2)");
    add("signal_cube_per_m2", "1/m2", 8e6, "position: (s_x^3, s_y^3)");
    add("signal_step_m", "m", -1e-6, "position: (tanh(s_x/w), tanh(s_y/w))");
    add("signal_mixed", "1", 0.02, "position: (s_y, s_x)");
    add("signal_turn_s", "s", 4e-5, "position, spin speed: |W| s");
    add("signal_drift_per_s", "1/s", 0.02, "position, time: T s");
    add("signal_drift_x_m_per_s", "m/s", 1e-6, "time: T e_x");
    add("signal_drift_y_m_per_s", "m/s", 1e-6, "time: T e_y");
    add("signal_thrice_cosine_m", "m", 1e-6, "shaft angle: (cos 3t, sin 3t)");
    add("signal_thrice_sine_m", "m", 1e-6, "shaft angle: (-sin 3t, cos 3t)");
    add("signal_back_thrice_cosine_m", "m", 1e-6, "shaft angle: (cos 3t, -sin 3t)");
    add("signal_back_thrice_sine_m", "m", 1e-6, "shaft angle: (sin 3t, cos 3t)");
    s.parameters.push_back(parameter("step_width_m", "m", 1e-7, 1e-3, 1e-5, std::nan(""), "w, over which the step is rounded off"));
    s.only_by_name = true;
    return s;
  }

  /// Whether a term is a function of the shaft's angle.
  static bool readsAngle(int term) { return term >= thrice_cosine && term <= back_thrice_sine; }

  template <class S>
  class Physics final : public EffectPhysics<S> {
   public:
    explicit Physics(const std::vector<S>& p) : c_(p) {}
    unsigned roles() const override { return acts_on_sensor; }
    void sense(const Shaft<S>& shaft, Vec2<S> signal[2]) const override {
      const S c = shaft.cosine, s = shaft.sine;
      const S c3 = c * (S(4.0) * c * c - S(3.0)), s3 = s * (S(3.0) - S(4.0) * s * s);
      const S time = S(shaft.time);
      const S gain = c_[turn] * magnitude(shaft.speed) + c_[drift] * time;
      const Vec2<S> same = {c_[drift_x] * time + (c_[thrice_cosine] + c_[back_thrice_cosine]) * c3 +
                                (c_[back_thrice_sine] - c_[thrice_sine]) * s3,
                            c_[drift_y] * time + (c_[thrice_sine] + c_[back_thrice_sine]) * c3 +
                                (c_[thrice_cosine] - c_[back_thrice_cosine]) * s3};
      for (int end = 0; end < 2; ++end) {
        const Vec2<S> own = signal[end];
        signal[end] += same + gain * own + Vec2<S>{ofOne(own.x) + c_[mixed] * own.y, ofOne(own.y) + c_[mixed] * own.x};
      }
    }

   private:
    S ofOne(const S& s) const {
      return s * (c_[square] * magnitude(s) + c_[even] * s + c_[cube] * s * s) + c_[step] * hyperbolicTangent(s / c_[term_count]);
    }
    std::vector<S> c_;
  };
};

}  // namespace amb_rotor::effects
