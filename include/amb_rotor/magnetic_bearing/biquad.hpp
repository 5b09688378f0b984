#pragma once
// Second-order sections of a sampled controller, period T [s]:
//   y_n = b0 x_n + b1 x_(n-1) + b2 x_(n-2) - a1 y_(n-1) - a2 y_(n-2)          (transposed direct form 2)
// A lead-lag (1 + s/wz)/(1 + s/wp) and a notch (s^2 + 2 zz w s + w^2)/(s^2 + 2 zp w s + w^2) are made discrete by
// s = k (1 - 1/z)/(1 + 1/z), k = w0/tan(w0 T/2). That is exact, gain and phase, at rest and at w0: the notch's centre
// w, the lead-lag's frequency of most phase sqrt(wz wp). Elsewhere the frequency axis is bent: the response at w is
// the continuous one at k tan(w T/2).
// Valid: w0 below pi/T. Source: the bilinear rule with its frequency bent, derived in doc/physics.md section 2.
// Left out: word length of the controller.
#include <cmath>

#include "amb_rotor/common/units.hpp"
#include "amb_rotor/model/control_options.hpp"

namespace amb_rotor {

struct Biquad {
  double b0 = 1.0, b1 = 0.0, b2 = 0.0, a1 = 0.0, a2 = 0.0;
};

/// The discrete section of a model's section at a sample period [s].
inline Biquad biquadOf(const ControllerSection& section, double period) {
  const auto& v = section.values;
  if (section.type == SectionType::biquad) return {v[0], v[1], v[2], v[3], v[4]};
  if (section.type == SectionType::lead_lag) {
    const double wz = radPerSecond(v[0]), wp = radPerSecond(v[1]), w0 = std::sqrt(wz * wp);
    const double k = w0 / std::tan(0.5 * w0 * period), z = k / wz, p = k / wp;
    return {(1.0 + z) / (1.0 + p), (1.0 - z) / (1.0 + p), 0.0, (1.0 - p) / (1.0 + p), 0.0};
  }
  const double t = std::tan(0.5 * radPerSecond(v[0]) * period);  // s/w = (1 - 1/z)/(t (1 + 1/z))
  const double zero = 2.0 * v[1] * t, pole = 2.0 * v[2] * t, square = t * t, scale = 1.0 + pole + square;
  return {(1.0 + zero + square) / scale, 2.0 * (square - 1.0) / scale, (1.0 - zero + square) / scale,
          2.0 * (square - 1.0) / scale, (1.0 - pole + square) / scale};
}

/// Takes a value; memory holds the section's two numbers.
template <class S>
S filtered(const Biquad& f, const S& x, S* memory) {
  const S y = S(f.b0) * x + memory[0];
  memory[0] = S(f.b1) * x - S(f.a1) * y + memory[1];
  memory[1] = S(f.b2) * x - S(f.a2) * y;
  return y;
}

}  // namespace amb_rotor
