#pragma once
// A force law by its terms: what the diagnosis proposes where no physical effect of the catalogue explains a residual. A
// hypothesis, not a mechanism. At each magnetic bearing, while it is on, with p the rotor's displacement there, v its
// velocity, p' = (-p_y, p_x), W the speed, t the shaft angle and i the current that makes the force:
//   F = k p + k2 |p| p + k3 |p|^2 p + d v + d2 |v| v + f v/|v| + q p' + qw W p' + kw W^2 p + dw |W| v
//       + (a cos t - b sin t, a sin t + b cos t) + (c cos 2t - e sin 2t, c sin 2t + e cos 2t) + g i + g3 |i|^2 i
// v/|v| is rounded off below 1 mm/s. Positive coefficients push outwards. Left out: products of these terms, memory.
#include "amb_rotor/effects/effect.hpp"

namespace amb_rotor::effects {

struct ForceLaw {
  static EffectSchema schema() {
    const double wide = 1e30;
    EffectSchema s{"force_law", "a force by its terms in position, velocity, speed, angle and current: a hypothesis",
                   "whatever moves the quantities of its terms", {}, false};
    s.parameters = {
        parameter("position_N_per_m", "N/m", -wide, wide, -1e3, 0.0, "position: p"),
        parameter("position_square_N_per_m2", "N/m2", -wide, wide, -1e8, 0.0, "position: |p| p"),
        parameter("position_cube_N_per_m3", "N/m3", -wide, wide, -1e12, 0.0, "position: |p|^2 p"),
        parameter("velocity_N_s_per_m", "N s/m", -wide, wide, -3.0, 0.0, "velocity: v"),
        parameter("velocity_square_N_s2_per_m2", "N s2/m2", -wide, wide, -3e2, 0.0, "velocity: |v| v"),
        parameter("velocity_sign_N", "N", -wide, wide, -0.1, 0.0, "velocity: v/|v|"),
        parameter("cross_N_per_m", "N/m", -wide, wide, 1e3, 0.0, "position: (-p_y, p_x)"),
        parameter("cross_speed_N_s_per_m", "N s/m", -wide, wide, 1.0, 0.0, "position, spin speed: W (-p_y, p_x)"),
        parameter("position_speed_N_s2_per_m", "N s2/m", -wide, wide, -1e-3, 0.0, "position, spin speed: W^2 p"),
        parameter("velocity_speed_N_s2_per_m", "N s2/m", -wide, wide, -1e-3, 0.0, "velocity, spin speed: |W| v"),
        parameter("turning_cosine_N", "N", -wide, wide, 1.0, 0.0, "shaft angle: (cos t, sin t)"),
        parameter("turning_sine_N", "N", -wide, wide, 1.0, 0.0, "shaft angle: (-sin t, cos t)"),
        parameter("twice_cosine_N", "N", -wide, wide, 1.0, 0.0, "shaft angle: (cos 2t, sin 2t)"),
        parameter("twice_sine_N", "N", -wide, wide, 1.0, 0.0, "shaft angle: (-sin 2t, cos 2t)"),
        parameter("current_N_per_A", "N/A", -wide, wide, 1.0, 0.0, "control current: i"),
        parameter("current_cube_N_per_A3", "N/A3", -wide, wide, 1.0, 0.0, "control current: |i|^2 i")};
    s.hypothesis = true;
    return s;
  }

  template <class S>
  class Physics final : public EffectPhysics<S> {
   public:
    explicit Physics(const std::vector<S>& p) : c_(p) {}
    unsigned roles() const override { return acts_on_bearing_force; }
    void bearingForce(const BearingSite<S>& site, Vec2<S>& force) const override {
      const Vec2<S>& p = site.position;
      const Vec2<S>& v = site.velocity;
      const Vec2<S>& i = site.current;
      const Shaft<S>& shaft = *site.shaft;
      const S square = p.dot(p), radius = squareRoot(square + S(1e-24));
      const S speed = squareRoot(v.dot(v) + S(1e-24));
      const S turn = magnitude(shaft.speed);
      const S along = c_[0] + c_[1] * radius + c_[2] * square + c_[8] * shaft.speed * shaft.speed;
      const S with = c_[3] + c_[4] * speed + c_[5] * hyperbolicTangent(speed * S(1e3)) / speed + c_[9] * turn;
      const S across = c_[6] + c_[7] * shaft.speed;
      const S magnetic = c_[14] + c_[15] * i.dot(i);
      const S c2 = shaft.cosine * shaft.cosine - shaft.sine * shaft.sine;
      const S s2 = S(2.0) * shaft.sine * shaft.cosine;
      force += {along * p.x + with * v.x - across * p.y + magnetic * i.x + c_[10] * shaft.cosine -
                    c_[11] * shaft.sine + c_[12] * c2 - c_[13] * s2,
                along * p.y + with * v.y + across * p.x + magnetic * i.y + c_[10] * shaft.sine +
                    c_[11] * shaft.cosine + c_[12] * s2 + c_[13] * c2};
    }

   private:
    std::vector<S> c_;
  };
};

}  // namespace amb_rotor::effects
