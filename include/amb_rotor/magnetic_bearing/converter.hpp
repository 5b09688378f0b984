#pragma once
// AD and DA converter with `bits` over +-range [m or A]:
//   step q = 2 range/2^bits,  code = floor(x/q + 1/2) within [-2^(bits-1), 2^(bits-1) - 1],  out = q code
// Error within the range: at most q/2, for a busy signal uniform, rms q/sqrt(12). Above it the value sticks at the end.
// Valid: bits whole, from 1 to 32. Source: thesis 3.23 has both converters in the loop, 4.1.3 a resolution of 14 bits; the law
// is that of an ideal bipolar converter.
// Left out: nonlinearity, offset, noise, aperture time; zero offset of a bipolar converter.
#include <cmath>

#include "amb_rotor/common/scalar.hpp"
#include "amb_rotor/model/control_options.hpp"

namespace amb_rotor {

inline double roundedDown(double a) { return std::floor(a); }
template <class A>
inline Batch<A> roundedDown(const Batch<A>& a) {
  return xsimd::floor(a);
}

inline double converterStep(const Converter& c) { return 2.0 * c.range / std::exp2(c.bits); }

template <class S>
S converted(const Converter& c, const S& x) {
  const double step = converterStep(c), half = std::exp2(c.bits - 1.0);
  const S code = maximum(minimum(roundedDown(x / S(step) + S(0.5)), S(half - 1.0)), S(-half));
  return S(step) * code;
}

}  // namespace amb_rotor
