#pragma once
// The terms of a force law that is a hypothesis: at a place of the rotor F is the sum of coefficients times the vectors of the
// table below, with p the rotor's displacement there [m], v its velocity [m/s], i the current that makes a magnetic bearing's
// force [A], t the shaft angle [rad], W the spin speed [rad/s], s the time of the run [s], e_x, e_y the stator's axes and, of
// a vector w, w' = (-w_y, w_x). Positive coefficients push outwards. v/|v| is rounded off below 1 mm/s (0.1 mm/s where it is sharp),
// a current's step over a width w [A] that is a number of its effect.
// The terms after `current` are of magnetic bearings alone; those after `antisym_` have the other sign at end a: what tilts
// the rotor. The four terms in time that repeat do so with a frequency that is given, not fitted.
// Left out: memory, products beyond those listed, harmonics above the third.
// Valid: where it was fitted, as far as the runs went. Source: a fit, no mechanism.
#include "amb_rotor/effects/effect.hpp"

namespace amb_rotor::effects {

struct LawTerms {
  enum Term : int {
    position,
    position_square,
    position_cube,
    position_fourth,
    position_axes,
    position_mixed,
    position_axes_cube,
    velocity,
    velocity_axes,
    velocity_mixed,
    velocity_cross,
    velocity_square,
    velocity_axes_square,
    velocity_sign,
    velocity_sharp_sign,
    velocity_position,
    sign_position,
    cross,
    cross_speed,
    position_speed,
    position_turn,
    cross_position_speed,
    velocity_speed,
    velocity_cross_speed,
    turning_cosine,
    turning_sine,
    twice_cosine,
    twice_sine,
    thrice_cosine,
    thrice_sine,
    back_cosine,
    back_sine,
    back_twice_cosine,
    back_twice_sine,
    back_thrice_cosine,
    back_thrice_sine,
    turning_speed_cosine,
    turning_speed_sine,
    turning_position_cosine,
    turning_position_sine,
    speed_x,
    speed_y,
    speed_square_x,
    speed_square_y,
    drift_x,
    drift_y,
    drift_position,
    drift_velocity,
    hum_x_cosine,
    hum_x_sine,
    hum_y_cosine,
    hum_y_sine,
    current,
    current_axes,
    current_mixed,
    current_cross,
    current_square,
    current_cube,
    current_axes_cube,
    current_axes_square,
    current_axes_sign,
    current_position,
    antisym_position,
    antisym_position_cube,
    antisym_velocity,
    antisym_velocity_square,
    antisym_velocity_sign,
    antisym_cross,
    antisym_velocity_speed,
    antisym_turning_cosine,
    antisym_turning_sine,
    antisym_current_cube,
    term_count,
    plane_term_count = current  ///< those that any place of the rotor can have
  };

  /// Rows of the first `count` terms, and of the frequency behind them.
  static void addRows(int count, std::vector<ParameterSchema>& rows) {
    const double wide = 1e30;
    const auto add = [&](const char* name, const char* unit, double typical, const char* meaning) {
      if (static_cast<int>(rows.size()) < count) rows.push_back(parameter(name, unit, -wide, wide, typical, 0.0, meaning));
    };
    add("position_N_per_m", "N/m", -1e3, "position: p");
    add("position_square_N_per_m2", "N/m2", -1e8, "position: |p| p");
    add("position_cube_N_per_m3", "N/m3", -1e12, "position: |p|^2 p");
    add("position_fourth_N_per_m4", "N/m4", -1e16, "position: |p|^3 p");
    add("position_axes_N_per_m", "N/m", -1e3, "position: (p_x, -p_y)");
    add("position_mixed_N_per_m", "N/m", -1e3, "position: (p_y, p_x)");
    add("position_axes_cube_N_per_m3", "N/m3", -1e12, "position: (p_x^3, p_y^3)");
    add("velocity_N_s_per_m", "N s/m", -3.0, "velocity: v");
    add("velocity_axes_N_s_per_m", "N s/m", -3.0, "velocity: (v_x, -v_y)");
    add("velocity_mixed_N_s_per_m", "N s/m", -3.0, "velocity: (v_y, v_x)");
    add("velocity_cross_N_s_per_m", "N s/m", 3.0, "velocity: v'");
    add("velocity_square_N_s2_per_m2", "N s2/m2", -3e2, "velocity: |v| v");
    add("velocity_axes_square_N_s2_per_m2", "N s2/m2", -3e2, "velocity: (|v_x| v_x, |v_y| v_y)");
    add("velocity_sign_N", "N", -0.1, "velocity: v/|v|");
    add("velocity_sharp_sign_N", "N", -0.1, "velocity: v/|v| (sharp)");
    add("velocity_position_N_s_per_m3", "N s/m3", -3e9, "position, velocity: |p|^2 v");
    add("sign_position_N_per_m", "N/m", -1e4, "position, velocity: |p| v/|v|");
    add("cross_N_per_m", "N/m", 1e3, "position: p'");
    add("cross_speed_N_s_per_m", "N s/m", 1.0, "position, spin speed: W p'");
    add("position_speed_N_s2_per_m", "N s2/m", -1e-3, "position, spin speed: W^2 p");
    add("position_turn_N_s_per_m", "N s/m", -1.0, "position, spin speed: |W| p");
    add("cross_position_speed_N_s_per_m2", "N s/m2", 1e5, "position, spin speed: W |p| p'");
    add("velocity_speed_N_s2_per_m", "N s2/m", -1e-3, "velocity, spin speed: |W| v");
    add("velocity_cross_speed_N_s2_per_m", "N s2/m", 1e-3, "velocity, spin speed: W v'");
    add("turning_cosine_N", "N", 1.0, "shaft angle: (cos t, sin t)");
    add("turning_sine_N", "N", 1.0, "shaft angle: (-sin t, cos t)");
    add("twice_cosine_N", "N", 1.0, "shaft angle: (cos 2t, sin 2t)");
    add("twice_sine_N", "N", 1.0, "shaft angle: (-sin 2t, cos 2t)");
    add("thrice_cosine_N", "N", 1.0, "shaft angle: (cos 3t, sin 3t)");
    add("thrice_sine_N", "N", 1.0, "shaft angle: (-sin 3t, cos 3t)");
    add("back_cosine_N", "N", 1.0, "shaft angle: (cos t, -sin t)");
    add("back_sine_N", "N", 1.0, "shaft angle: (sin t, cos t)");
    add("back_twice_cosine_N", "N", 1.0, "shaft angle: (cos 2t, -sin 2t)");
    add("back_twice_sine_N", "N", 1.0, "shaft angle: (sin 2t, cos 2t)");
    add("back_thrice_cosine_N", "N", 1.0, "shaft angle: (cos 3t, -sin 3t)");
    add("back_thrice_sine_N", "N", 1.0, "shaft angle: (sin 3t, cos 3t)");
    add("turning_speed_cosine_N_s", "N s", 1e-3, "shaft angle, spin speed: W (cos t, sin t)");
    add("turning_speed_sine_N_s", "N s", 1e-3, "shaft angle, spin speed: W (-sin t, cos t)");
    add("turning_position_cosine_N_per_m", "N/m", 1e3,
        "position, shaft angle: (p_x cos 2t + p_y sin 2t, p_x sin 2t - p_y cos 2t)");
    add("turning_position_sine_N_per_m", "N/m", 1e3,
        "position, shaft angle: (-p_x sin 2t + p_y cos 2t, p_x cos 2t + p_y sin 2t)");
    add("speed_x_N_s", "N s", 1e-3, "spin speed: W e_x");
    add("speed_y_N_s", "N s", 1e-3, "spin speed: W e_y");
    add("speed_square_x_N_s2", "N s2", 1e-6, "spin speed: W^2 e_x");
    add("speed_square_y_N_s2", "N s2", 1e-6, "spin speed: W^2 e_y");
    add("drift_x_N_per_s", "N/s", 1.0, "time: s e_x");
    add("drift_y_N_per_s", "N/s", 1.0, "time: s e_y");
    add("drift_position_N_per_m_s", "N/(m s)", -1e3, "position, time: s p");
    add("drift_velocity_N_per_m", "N/m", -3.0, "velocity, time: s v");
    add("hum_x_cosine_N", "N", 1.0, "time: cos(2 pi f s) e_x");
    add("hum_x_sine_N", "N", 1.0, "time: sin(2 pi f s) e_x");
    add("hum_y_cosine_N", "N", 1.0, "time: cos(2 pi f s) e_y");
    add("hum_y_sine_N", "N", 1.0, "time: sin(2 pi f s) e_y");
    add("current_N_per_A", "N/A", 1.0, "control current: i");
    add("current_axes_N_per_A", "N/A", 1.0, "control current: (i_x, -i_y)");
    add("current_mixed_N_per_A", "N/A", 1.0, "control current: (i_y, i_x)");
    add("current_cross_N_per_A", "N/A", 1.0, "control current: i'");
    add("current_square_N_per_A2", "N/A2", 1.0, "control current: |i| i");
    add("current_cube_N_per_A3", "N/A3", 1.0, "control current: |i|^2 i");
    add("current_axes_cube_N_per_A3", "N/A3", 1.0, "control current: (i_x^3, i_y^3)");
    add("current_axes_square_N_per_A2", "N/A2", 1.0, "control current: (i_x^2, i_y^2)");
    add("current_axes_sign_N", "N", -1.0, "control current: (tanh(i_x/w), tanh(i_y/w))");
    add("current_position_N_per_A2_m", "N/(A2 m)", -1e3, "position, control current: |i|^2 p");
    add("antisym_position_N_per_m", "N/m", -1e3, "position: -+ p");
    add("antisym_position_cube_N_per_m3", "N/m3", -1e12, "position: -+ |p|^2 p");
    add("antisym_velocity_N_s_per_m", "N s/m", -3.0, "velocity: -+ v");
    add("antisym_velocity_square_N_s2_per_m2", "N s2/m2", -3e2, "velocity: -+ |v| v");
    add("antisym_velocity_sign_N", "N", -0.1, "velocity: -+ v/|v|");
    add("antisym_cross_N_per_m", "N/m", 1e3, "position: -+ p'");
    add("antisym_velocity_speed_N_s2_per_m", "N s2/m", -1e-3, "velocity, spin speed: -+ |W| v");
    add("antisym_turning_cosine_N", "N", 1.0, "shaft angle: -+ (cos t, sin t)");
    add("antisym_turning_sine_N", "N", 1.0, "shaft angle: -+ (-sin t, cos t)");
    add("antisym_current_cube_N_per_A3", "N/A3", 1.0, "control current: -+ |i|^2 i");
    rows.push_back(parameter("time_frequency_hz", "Hz", 1e-3, 1e5, 50.0, 50.0,
                             "of the terms in time that repeat", ParameterRole::fixed));
  }

  /// Whether a term is a function of the shaft's angle.
  static bool readsAngle(int term) {
    return (term >= turning_cosine && term <= turning_position_sine) || term == antisym_turning_cosine ||
           term == antisym_turning_sine;
  }

  /// Whether some effect of the catalogue makes such a force, or one that looks like it.
  static bool alsoInCatalogue(int term) {
    switch (term) {
      case position:
      case position_axes:
      case velocity:
      case cross:
      case cross_speed:
      case velocity_cross_speed:
      case current:
      case current_axes:
      case current_cross:
      case antisym_position:
      case antisym_velocity:
      case antisym_cross:
      case antisym_velocity_speed:
        return true;
      default:
        return (term >= turning_cosine && term <= twice_sine) || (term >= back_cosine && term <= back_twice_sine) ||
               (term >= turning_speed_cosine && term <= turning_position_sine) || term == antisym_turning_cosine ||
               term == antisym_turning_sine;
    }
  }

  /// The term that one after `antisym_` has at end b.
  static Term symmetric(Term term) {
    constexpr Term base[] = {position, position_cube,  velocity,       velocity_square, velocity_sign,
                             cross,    velocity_speed, turning_cosine, turning_sine,    current_cube};
    return base[term - antisym_position];
  }

  static constexpr double rounded_s_per_m = 1e3, sharp_s_per_m = 1e4;  ///< a velocity's length over itself is tanh of so many times it

  /// The quantities at a place, and a term's vector there.
  template <class S>
  struct Place {
    const Vec2<S>&p, &v, &i;
    const Shaft<S>& shaft;
    S square, radius, rate, turn, c2, s2, c3, s3, frequency_, per_step_;

    Place(const Shaft<S>& at, const Vec2<S>& position, const Vec2<S>& velocity, const Vec2<S>& current, const S& frequency,
          const S& per_step)
        : p(position), v(velocity), i(current), shaft(at) {
      square = p.dot(p);
      radius = squareRoot(square + S(1e-24));
      rate = squareRoot(v.dot(v) + S(1e-24));
      turn = magnitude(shaft.speed);
      c2 = shaft.cosine * shaft.cosine - shaft.sine * shaft.sine;
      s2 = S(2.0) * shaft.sine * shaft.cosine;
      c3 = shaft.cosine * c2 - shaft.sine * s2;
      s3 = shaft.sine * c2 + shaft.cosine * s2;
      frequency_ = frequency;
      per_step_ = per_step;
    }
    /// (cos, sin) of the phase that repeats in time.
    Vec2<S> hum() const {
      S sine, cosine;
      sineCosine(S(two_pi * shaft.time) * frequency_, sine, cosine);
      return {cosine, sine};
    }
    S sign(double per_m_s = rounded_s_per_m) const { return hyperbolicTangent(rate * S(per_m_s)) / rate; }
    Vec2<S> vector(Term term) const {
      const S zero = S(0.0);
      const S c = shaft.cosine, s = shaft.sine, w = shaft.speed, time = S(shaft.time);
      switch (term) {
        case position:
          return p;
        case position_square:
          return radius * p;
        case position_cube:
          return square * p;
        case position_fourth:
          return square * radius * p;
        case position_axes:
          return {p.x, -p.y};
        case position_mixed:
          return {p.y, p.x};
        case position_axes_cube:
          return {p.x * p.x * p.x, p.y * p.y * p.y};
        case velocity:
          return v;
        case velocity_axes:
          return {v.x, -v.y};
        case velocity_mixed:
          return {v.y, v.x};
        case velocity_cross:
          return {-v.y, v.x};
        case velocity_square:
          return rate * v;
        case velocity_axes_square:
          return {magnitude(v.x) * v.x, magnitude(v.y) * v.y};
        case velocity_sign:
          return sign() * v;
        case velocity_sharp_sign:
          return sign(sharp_s_per_m) * v;
        case velocity_position:
          return square * v;
        case sign_position:
          return radius * sign() * v;
        case cross:
          return {-p.y, p.x};
        case cross_speed:
          return {-w * p.y, w * p.x};
        case position_speed:
          return w * w * p;
        case position_turn:
          return turn * p;
        case cross_position_speed:
          return {-w * radius * p.y, w * radius * p.x};
        case velocity_speed:
          return turn * v;
        case velocity_cross_speed:
          return {-w * v.y, w * v.x};
        case turning_cosine:
          return {c, s};
        case turning_sine:
          return {-s, c};
        case twice_cosine:
          return {c2, s2};
        case twice_sine:
          return {-s2, c2};
        case thrice_cosine:
          return {c3, s3};
        case thrice_sine:
          return {-s3, c3};
        case back_cosine:
          return {c, -s};
        case back_sine:
          return {s, c};
        case back_twice_cosine:
          return {c2, -s2};
        case back_twice_sine:
          return {s2, c2};
        case back_thrice_cosine:
          return {c3, -s3};
        case back_thrice_sine:
          return {s3, c3};
        case turning_speed_cosine:
          return {w * c, w * s};
        case turning_speed_sine:
          return {-w * s, w * c};
        case turning_position_cosine:
          return {p.x * c2 + p.y * s2, p.x * s2 - p.y * c2};
        case turning_position_sine:
          return {p.y * c2 - p.x * s2, p.x * c2 + p.y * s2};
        case speed_x:
          return {w, zero};
        case speed_y:
          return {zero, w};
        case speed_square_x:
          return {w * w, zero};
        case speed_square_y:
          return {zero, w * w};
        case current:
          return i;
        case current_axes:
          return {i.x, -i.y};
        case current_mixed:
          return {i.y, i.x};
        case current_cross:
          return {-i.y, i.x};
        case current_square:
          return squareRoot(i.dot(i) + S(1e-24)) * i;
        case current_cube:
          return i.dot(i) * i;
        case current_axes_square:
          return {i.x * i.x, i.y * i.y};
        case current_axes_cube:
          return {i.x * i.x * i.x, i.y * i.y * i.y};
        case current_axes_sign:
          return {hyperbolicTangent(per_step_ * i.x), hyperbolicTangent(per_step_ * i.y)};
        case current_position:
          return i.dot(i) * p;
        case drift_x:
          return {time, zero};
        case drift_y:
          return {zero, time};
        case drift_position:
          return time * p;
        case drift_velocity:
          return time * v;
        case hum_x_cosine:
          return {hum().x, zero};
        case hum_x_sine:
          return {hum().y, zero};
        case hum_y_cosine:
          return {zero, hum().x};
        case hum_y_sine:
          return {zero, hum().y};
        default:
          return {zero, zero};
      }
    }
  };

  /// The terms that some lane has, of the first `count`.
  template <class S>
  class Sum {
   public:
    /// @param step_width_A  of a current's step
    Sum(const std::vector<S>& p, int count, const S& step_width_A = S(1.0)) : frequency_(p[count]), per_step_(S(1.0) / step_width_A) {
      for (int term = 0; term < count; ++term) {
        bool there = false;
        for (std::size_t l = 0; l < ScalarTraits<S>::lanes; ++l)
          there = there || laneValue(p[term], l) != 0.0;
        if (there) terms_.push_back({static_cast<Term>(term), p[term]});
      }
    }
    /// @param end  of the magnetic bearing, 0 a, 1 b; for the terms after `antisym_`
    Vec2<S> at(const Shaft<S>& shaft, const Vec2<S>& position, const Vec2<S>& velocity, const Vec2<S>& current, int end) const {
      const Place<S> place(shaft, position, velocity, current, frequency_, per_step_);
      Vec2<S> force;
      for (const auto& one : terms_) {
        const Term base = one.term < antisym_position ? one.term : symmetric(one.term);
        const S c = one.term < antisym_position || end == 1 ? one.coefficient : -one.coefficient;
        force += c * place.vector(base);
      }
      return force;
    }

   private:
    struct Part {
      Term term;
      S coefficient;
    };
    std::vector<Part> terms_;
    S frequency_, per_step_;
  };
};

}  // namespace amb_rotor::effects
