#pragma once
// Dual numbers: a value with its N directional derivatives, carried through the same right-hand side that
// runs on double and on lanes. Gives exact Jacobians, monodromy matrices and parameter derivatives without
// a second copy of the physics.
//
//   (a + a' e)(b + b' e) = a b + (a' b + a b') e,  e^2 = 0
//
// Left out: second derivatives. At a kink (maximum, minimum, select) the slope of the taken branch is used,
// which is the one-sided derivative.
#include "amb_rotor/common/scalar.hpp"

namespace amb_rotor {

template <class S, int N>
struct Dual {
  S value = S(0.0);
  S slope[N];

  Dual() {
    for (int i = 0; i < N; ++i) slope[i] = S(0.0);
  }
  explicit Dual(double constant) : Dual() { value = S(constant); }
  /// A value without derivative (for S = double this is the constructor above).
  static Dual constant(const S& number) {
    Dual result;
    result.value = number;
    return result;
  }

  Dual operator-() const { return mapped(-value, S(-1.0)); }
  /// The function value `y` with derivative `dy` at this value: the chain rule.
  Dual mapped(const S& y, const S& dy) const {
    Dual result;
    result.value = y;
    for (int i = 0; i < N; ++i) result.slope[i] = dy * slope[i];
    return result;
  }

  friend Dual operator+(const Dual& a, const Dual& b) {
    Dual result;
    result.value = a.value + b.value;
    for (int i = 0; i < N; ++i) result.slope[i] = a.slope[i] + b.slope[i];
    return result;
  }
  friend Dual operator-(const Dual& a, const Dual& b) {
    Dual result;
    result.value = a.value - b.value;
    for (int i = 0; i < N; ++i) result.slope[i] = a.slope[i] - b.slope[i];
    return result;
  }
  friend Dual operator*(const Dual& a, const Dual& b) {
    Dual result;
    result.value = a.value * b.value;
    for (int i = 0; i < N; ++i) result.slope[i] = a.slope[i] * b.value + a.value * b.slope[i];
    return result;
  }
  friend Dual operator/(const Dual& a, const Dual& b) {
    Dual result;
    const S inverse = S(1.0) / b.value;
    result.value = a.value * inverse;
    for (int i = 0; i < N; ++i) result.slope[i] = (a.slope[i] - result.value * b.slope[i]) * inverse;
    return result;
  }
  // With a plain number, which has no derivative.
  friend Dual operator+(const Dual& a, const S& b) {
    Dual result = a;
    result.value = a.value + b;
    return result;
  }
  friend Dual operator+(const S& a, const Dual& b) { return b + a; }
  friend Dual operator-(const Dual& a, const S& b) {
    Dual result = a;
    result.value = a.value - b;
    return result;
  }
  friend Dual operator-(const S& a, const Dual& b) { return b.mapped(a - b.value, S(-1.0)); }
  friend Dual operator*(const Dual& a, const S& b) { return a.mapped(a.value * b, b); }
  friend Dual operator*(const S& a, const Dual& b) { return b.mapped(a * b.value, a); }
};

template <class S, int N>
inline Dual<S, N> maximum(const Dual<S, N>& a, const S& b) {
  return a.mapped(maximum(a.value, b), select(a.value > b, S(1.0), S(0.0)));
}
template <class S, int N>
inline Dual<S, N> squareRoot(const Dual<S, N>& a) {
  const S root = squareRoot(a.value);
  return a.mapped(root, S(0.5) / root);
}
template <class S, int N>
inline Dual<S, N> inverseOf(const Dual<S, N>& a) {
  const S inverse = S(1.0) / a.value;
  return a.mapped(inverse, -(inverse * inverse));
}
template <class S>
inline S inverseOf(const S& a) {
  return S(1.0) / a;
}
template <class S, int N>
inline Dual<S, N> hyperbolicTangent(const Dual<S, N>& a) {
  const S tangent = hyperbolicTangent(a.value);
  return a.mapped(tangent, S(1.0) - tangent * tangent);
}

/// One direction only, lean enough to stay in registers: what the lanes' tangent uses.
template <class S>
struct Tangent {
  S value, slope;

  Tangent() = default;
  Tangent(const S& v, const S& s) : value(v), slope(s) {}
  friend Tangent operator+(const Tangent& a, const Tangent& b) {
    return {a.value + b.value, a.slope + b.slope};
  }
  friend Tangent operator-(const Tangent& a, const Tangent& b) {
    return {a.value - b.value, a.slope - b.slope};
  }
  friend Tangent operator*(const Tangent& a, const Tangent& b) {
    return {a.value * b.value, a.slope * b.value + a.value * b.slope};
  }
  friend Tangent operator+(const Tangent& a, const S& b) { return {a.value + b, a.slope}; }
  friend Tangent operator+(const S& a, const Tangent& b) { return {a + b.value, b.slope}; }
  friend Tangent operator-(const Tangent& a, const S& b) { return {a.value - b, a.slope}; }
  friend Tangent operator-(const S& a, const Tangent& b) { return {a - b.value, -b.slope}; }
  friend Tangent operator*(const Tangent& a, const S& b) { return {a.value * b, a.slope * b}; }
  friend Tangent operator*(const S& a, const Tangent& b) { return {a * b.value, a * b.slope}; }
};

template <class S>
inline Tangent<S> maximum(const Tangent<S>& a, const S& b) {
  return {maximum(a.value, b), select(a.value > b, a.slope, S(0.0))};
}
template <class S>
inline Tangent<S> squareRoot(const Tangent<S>& a) {
  const S root = squareRoot(a.value);
  return {root, S(0.5) * a.slope / root};
}
template <class S>
inline Tangent<S> inverseOf(const Tangent<S>& a) {
  const S inverse = S(1.0) / a.value;
  return {inverse, -(inverse * inverse * a.slope)};
}
template <class S>
inline Tangent<S> hyperbolicTangent(const Tangent<S>& a) {
  const S tangent = hyperbolicTangent(a.value);
  return {tangent, (S(1.0) - tangent * tangent) * a.slope};
}

/// The value without the derivatives.
template <class S>
inline const S& valueOf(const Tangent<S>& a) {
  return a.value;
}
template <class S, int N>
inline const S& valueOf(const Dual<S, N>& a) {
  return a.value;
}
template <class S>
inline const S& valueOf(const S& a) {
  return a;
}

/// The number type below a Dual or Tangent, or the type itself.
template <class T>
struct PlainType {
  using type = T;
};
template <class S, int N>
struct PlainType<Dual<S, N>> {
  using type = S;
};

template <class S>
struct PlainType<Tangent<S>> {
  using type = S;
};

}  // namespace amb_rotor
