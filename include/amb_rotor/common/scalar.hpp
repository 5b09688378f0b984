#pragma once
// The Scalar of all right-hand sides: double, or a pack of SIMD lanes (one lane, one machine).
// This header gives the few functions that a right-hand side may use, with the same names for both,
// so that the physics is written once. Branches on a Scalar are written with select().
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <type_traits>
#include <xsimd/xsimd.hpp>

namespace amb_rotor {

/// A pack of lanes for an instruction set (xsimd::avx2, ...).
template <class Arch>
using Lanes = xsimd::batch<double, Arch>;

template <class S>
struct ScalarTraits;

template <>
struct ScalarTraits<double> {
  static constexpr std::size_t lanes = 1;
  using Mask = bool;
};

template <class Arch>
struct ScalarTraits<xsimd::batch<double, Arch>> {
  static constexpr std::size_t lanes = xsimd::batch<double, Arch>::size;
  using Mask = xsimd::batch_bool<double, Arch>;
};

template <class S>
using MaskOf = typename ScalarTraits<S>::Mask;

// ---- double
inline double select(bool condition, double yes, double no) { return condition ? yes : no; }
inline bool any(bool condition) { return condition; }
inline double maximum(double a, double b) { return a > b ? a : b; }
inline double minimum(double a, double b) { return a < b ? a : b; }
/// a b + c
inline double multiplyAdd(double a, double b, double c) { return a * b + c; }
inline double squareRoot(double a) { return std::sqrt(a); }
/// a^(-1/4) of what is positive
inline double inverseFourthRoot(double a) { return 1.0 / std::sqrt(std::sqrt(a)); }
inline double exponential(double a) { return std::exp(a); }
inline double hyperbolicTangent(double a) { return std::tanh(a); }
inline double logarithm(double a) { return std::log(a); }
inline double magnitude(double a) { return std::fabs(a); }
inline void sineCosine(double a, double& sine, double& cosine) {
  sine = std::sin(a);
  cosine = std::cos(a);
}
/// atan2: the angle of (x, y) [rad]
inline double arcTangent(double y, double x) { return std::atan2(y, x); }
inline double laneValue(double a, std::size_t) { return a; }
inline void setLane(double& a, std::size_t, double value) { a = value; }

// ---- lanes
template <class A>
using Batch = xsimd::batch<double, A>;
template <class A>
using BatchMask = xsimd::batch_bool<double, A>;

template <class A>
inline Batch<A> select(const BatchMask<A>& condition, const Batch<A>& yes, const Batch<A>& no) {
  return xsimd::select(condition, yes, no);
}
template <class A>
inline bool any(const BatchMask<A>& condition) {
  return xsimd::any(condition);
}
template <class A>
inline Batch<A> maximum(const Batch<A>& a, const Batch<A>& b) {
  return xsimd::max(a, b);
}
template <class A>
inline Batch<A> minimum(const Batch<A>& a, const Batch<A>& b) {
  return xsimd::min(a, b);
}
template <class A>
inline Batch<A> multiplyAdd(const Batch<A>& a, const Batch<A>& b, const Batch<A>& c) {
  return xsimd::fma(a, b, c);
}
template <class A>
inline Batch<A> squareRoot(const Batch<A>& a) {
  return xsimd::sqrt(a);
}
template <class A>
inline Batch<A> inverseFourthRoot(const Batch<A>& a) {
#ifdef __AVX512F__
  if constexpr (std::is_base_of<xsimd::avx512f, A>::value) {
    // roots and divisions are slow in a pack this wide: an estimate good to 2^-13 and three Newton steps, z (5 - a z^4)/4
    Batch<A> z = _mm512_rsqrt14_pd(_mm512_mul_pd(a, _mm512_rsqrt14_pd(a)));
    const Batch<A> quarter_a = Batch<A>(-0.25) * a;
    for (int step = 0; step < 3; ++step) {
      const Batch<A> square = z * z;
      z = z * xsimd::fma(quarter_a, square * square, Batch<A>(1.25));
    }
    return z;
  }
#endif
  return Batch<A>(1.0) / xsimd::sqrt(xsimd::sqrt(a));
}
template <class A>
inline Batch<A> exponential(const Batch<A>& a) {
  return xsimd::exp(a);
}
/// tanh by the exponential of a negative argument: exact to a few ulp where it matters here
/// (friction regularisation), without overflow, and faster than the library's.
template <class A>
[[gnu::noinline]] Batch<A> tangentByExponential(Batch<A> a) {
  const Batch<A> e = xsimd::exp(Batch<A>(-2.0) * xsimd::min(xsimd::abs(a), Batch<A>(20.0)));
  const Batch<A> t = (Batch<A>(1.0) - e) / (Batch<A>(1.0) + e);
  return xsimd::select(a < Batch<A>(0.0), -t, t);
}
template <class A>
[[gnu::always_inline]] inline Batch<A> hyperbolicTangent(const Batch<A>& a) {
  // sliding in every lane, as friction mostly has it: tanh(20) is 1 to the last digit. A call would put all else that is
  // at hand into memory
  if (__builtin_expect(!xsimd::any(xsimd::abs(a) < Batch<A>(20.0)), 1))
    return xsimd::select(a < Batch<A>(0.0), Batch<A>(-1.0), Batch<A>(1.0));
  return tangentByExponential(a);
}
template <class A>
inline Batch<A> logarithm(const Batch<A>& a) {
  return xsimd::log(a);
}
template <class A>
inline Batch<A> magnitude(const Batch<A>& a) {
  return xsimd::abs(a);
}
template <class A>
inline void sineCosine(const Batch<A>& a, Batch<A>& sine, Batch<A>& cosine) {
  const auto both = xsimd::sincos(a);
  sine = both.first;
  cosine = both.second;
}
template <class A>
inline Batch<A> arcTangent(const Batch<A>& y, const Batch<A>& x) {
  return xsimd::atan2(y, x);
}
template <class A>
inline double laneValue(const Batch<A>& a, std::size_t lane) {
  return a.get(lane);
}
template <class A>
inline void setLane(Batch<A>& a, std::size_t lane, double value) {
  alignas(64) double buffer[Batch<A>::size];
  a.store_aligned(buffer);
  buffer[lane] = value;
  a = Batch<A>::load_aligned(buffer);
}

/// Two components in a plane at right angles to the shaft: x horizontal, y vertical.
template <class S>
struct Vec2 {
  S x = S(0.0), y = S(0.0);
  Vec2& operator+=(const Vec2& o) {
    x += o.x;
    y += o.y;
    return *this;
  }
  Vec2& operator-=(const Vec2& o) {
    x -= o.x;
    y -= o.y;
    return *this;
  }
  friend Vec2 operator+(Vec2 a, const Vec2& b) { return a += b; }
  friend Vec2 operator-(Vec2 a, const Vec2& b) { return a -= b; }
  friend Vec2 operator*(const S& k, const Vec2& a) { return {k * a.x, k * a.y}; }
  S dot(const Vec2& o) const { return x * o.x + y * o.y; }
};

}  // namespace amb_rotor
