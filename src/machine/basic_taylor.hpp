#pragma once
// The basic model with linear contact and spin friction by Taylor series: a step is a polynomial, and so are
// the gap, the event and everything in between.
//
// With w = u + j v the displacement from the bearing's centre c, in phase units (a derivative by the phase):
//   w'' = F e^(j phi) - D w' - K (w + c) - C (1 + j s) (w - e),   e = w / r,  r^2 = |w|^2  (in contact)
// The coefficients follow one by one, those of root and quotient by
//   2 r_0 r_k = (|w|^2)_k - sum_(j=1..k-1) r_j r_(k-j),   r_0 e_k = w_k - sum_(j=1..k) r_j e_(k-j)
// (Knuth, The Art of Computer Programming 2, 4.7; Jorba and Zou, A software package for the numerical
// integration of ODEs by means of high-order Taylor methods, 2005). In free flight the series is that of a
// linear oscillator, entire, and costs a few products an order. The step is the largest at which the last two
// terms are below the tolerance; its order grows with the digits.
//
// An event is a root of rho - 1 on the step: the state there is the polynomial's, no step is repeated. Roots
// are looked for between samples, and at the extremum between two samples where the gap turns; samples that
// are deeper than their rates can undo between them are not looked at one by one, and none is taken where all
// terms together cannot undo the contact.
//
// T: double, or Dual for derivatives (the field is continuous at an event: no saltation, basic_orbit.hpp).
// Units: dimensionless. No allocation. Left out: Hertz contact (its root is singular at touch-down), friction
// that depends on the sliding velocity: basic_orbit.cpp has them with Dormand and Prince.
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstring>

#include "amb_rotor/machine/basic_model.hpp"

namespace amb_rotor {

/// Both planes of a coefficient; two doubles are one register.
template <class T>
struct Planar {
  T px, py;
  Planar() = default;
  Planar(const T& x, const T& y) : px(x), py(y) {}
  const T& x() const { return px; }
  const T& y() const { return py; }
  Planar turned() const { return {-py, px}; }  ///< by a right angle
  friend Planar operator+(const Planar& a, const Planar& b) { return {a.px + b.px, a.py + b.py}; }
  friend Planar operator-(const Planar& a, const Planar& b) { return {a.px - b.px, a.py - b.py}; }
  friend Planar operator*(const Planar& a, const Planar& b) { return {a.px * b.px, a.py * b.py}; }
  friend Planar operator*(const Planar& a, const T& b) { return {a.px * b, a.py * b}; }
};
template <>
struct Planar<double> {
  typedef double Two __attribute__((vector_size(16)));
  Two both;
  Planar() = default;
  explicit Planar(Two two) : both(two) {}
  Planar(double x, double y) : both{x, y} {}
  double x() const { return both[0]; }
  double y() const { return both[1]; }
  Planar turned() const { return Planar(Two{-both[1], both[0]}); }
  friend Planar operator+(Planar a, Planar b) { return Planar(a.both + b.both); }
  friend Planar operator-(Planar a, Planar b) { return Planar(a.both - b.both); }
  friend Planar operator*(Planar a, Planar b) { return Planar(a.both * b.both); }
  friend Planar operator*(Planar a, double b) { return Planar(a.both * b); }
};

/// Largest slope; 0 for plain numbers.
template <class T>
double seriesSlope(const T& a) {
  double most = 0.0;
  if constexpr (!std::is_same_v<T, double>)
    for (double s : a.slope) most = std::max(most, std::abs(s));
  return most;
}

template <class T>
class BasicTaylor {
 public:
  static constexpr int most_order = 40;

  BasicTaylor(const BasicCoefficients<T>& c, double tolerance)
      : c_(c), tolerance_(tolerance), order_(orderFor(tolerance)) {}

  /// Half an order a power of e, and a few: by measurement the cheapest, within a tenth, for 2 to 10 of
  /// these.
  static int orderFor(double tolerance) {
    return std::clamp(static_cast<int>(std::ceil(-0.55 * std::log(tolerance))) + 7, 8, most_order - 2);
  }

  /// Series of a state (displacement, velocity) at a phase; returns the step that the tolerance allows.
  double expand(double phase, const T* q, bool contact) {
    const Planar<T> zero = {T(0.0), T(0.0)}, shift = {c_.misalignment_x, c_.misalignment_y};
    w_[0] = {q[0] - c_.misalignment_x, q[1] - c_.misalignment_y};
    w_[1] = {q[2], q[3]};
    const Planar<T> force = {c_.forcing * std::cos(phase), c_.forcing * std::sin(phase)};
    const Planar<T> wave[4] = {force, force.turned(), zero - force, zero - force.turned()};
    const T normal = contact ? c_.contact : T(0.0), tangential = normal * c_.friction;
    const T stiffness = c_.stiffness + normal;
    T inverse = T(0.0);
    Planar<T> first = zero;  // e_0 / r_0
    if (contact) {
      squares_[0] = sum(w_[0] * w_[0]);
      radius_[0] = squareRoot(squares_[0]);
      inverse = T(1.0) / radius_[0];
      direction_[0] = w_[0] * inverse;
      first = direction_[0] * inverse;
    }
    double factorial = 1.0;
    for (int k = 0; k + 2 <= order_; ++k) {
      const double share = reciprocal(k + 1) * reciprocal(k + 2);
      if (k > 0) factorial *= reciprocal(k);
      Planar<T> a = wave[k & 3] * T(factorial) - w_[k] * stiffness - w_[k + 1] * (c_.damping * double(k + 1));
      if (k == 0) a = a - shift * c_.stiffness;
      if (!contact) {
        w_[k + 2] = a * T(share);
        continue;
      }
      a = a - w_[k].turned() * tangential;
      if (k > 0) nextDirection(k, inverse, first);
      w_[k + 2] =
          a * T(share) + (direction_[k] * (normal * share) + direction_[k].turned() * (tangential * share));
    }
    for (int k = contact ? order_ - 1 : 0; k <= order_; ++k) squares_[k] = squareAt(k);
    return step();
  }

  int order() const { return order_; }
  /// State at s after the expansion.
  void at(double s, T* q) const {
    // even and odd terms apart, whose sums do not wait for each other
    const double square = s * s;
    const int even = order_ / 2 * 2, odd = (order_ - 1) / 2 * 2 + 1;
    Planar<T> place[2] = {w_[even], w_[odd]}, velocity[2] = {w_[even] * T(even), w_[odd] * T(odd)};
    for (int k = even - 2; k > 0; k -= 2) {
      place[0] = place[0] * T(square) + w_[k];
      velocity[0] = velocity[0] * T(square) + w_[k] * T(k);
    }
    for (int k = odd - 2; k > 0; k -= 2) {
      place[1] = place[1] * T(square) + w_[k];
      velocity[1] = velocity[1] * T(square) + w_[k] * T(k);
    }
    const Planar<T> there = w_[0] + place[1] * T(s) + place[0] * T(square),
                    rate = velocity[1] + velocity[0] * T(s);
    q[0] = there.x() + c_.misalignment_x;
    q[1] = there.y() + c_.misalignment_y;
    q[2] = rate.x();
    q[3] = rate.y();
  }
  /// Squared distance less 1, and its rate.
  struct Gap {
    double value, rate;
  };
  Gap gap(double s) const {
    double g = valueOf(squares_[order_]), rate = 0.0;
    for (int k = order_ - 1; k >= 0; --k) {
      rate = rate * s + g;
      g = g * s + valueOf(squares_[k]);
    }
    return {g - 1.0, rate};
  }

  /// What a step of a mode does with the gap.
  struct Passage {
    double event = -1.0;  ///< where the mode ends; -1: nowhere in the step
    double turning =
        -2.0;  ///< largest gap (value as Gap) at which a flight turns back without touching; -2: none
    double largest = -1.0;  ///< of the samples, where it is beyond what is known
  };
  /// @param known  largest gap that is known already: where a contact can neither reach it nor end, nothing
  /// is looked at
  Passage passage(double h, bool contact, double known) const {
    if (contact) {
      const double reach = largestChange(h), start = valueOf(squares_[0]) - 1.0;
      if (start > reach && start + reach <= known) return {};
    }
    const double sign = contact ? 1.0 : -1.0;
    const int blocks = std::clamp(static_cast<int>(std::ceil(h / (block * sample_spacing))), 1, most_blocks);
    const double spacing = h / (block * blocks);
    Passage found;
    double before = 0.0;
    Gap last = {valueOf(squares_[0]) - 1.0, valueOf(squares_[1])};
    for (int b = 0; b < blocks; ++b) {
      double at[block], value[block], rate[block];
      for (int i = 0; i < block; ++i) at[i] = spacing * (block * b + i + 1);
      gaps(at, value, rate);
      if (contact && staysDeep(last, value, rate, spacing)) {
        for (const double v : value) found.largest = std::max(found.largest, v);
        before = at[block - 1];
        last = {value[block - 1], rate[block - 1]};
        continue;
      }
      for (int i = 0; i < block; ++i) {
        const double s = at[i];
        double low = before, high = s;
        bool ends = sign * value[i] < -round_off;
        double guess = -1.0;
        // a flight shorter than a sample begins at the other root, away from the one that ends it
        if (ends && sign * last.rate < 0.0 && sign * rate[i] < 0.0)
          guess = crossing(last, {value[i], rate[i]}, low, high);
        // The gap turns between the samples: where it is convex it stays above its two tangents.
        if (!ends && sign * last.rate < 0.0 && sign * rate[i] > 0.0 &&
            (!contact || tangentsMeet(last, {value[i], rate[i]}, s - before) < 0.0)) {
          const double turn = turningPoint(before, s, sign);
          const double extreme = gap(turn).value;
          ends = sign * extreme < -round_off;
          if (ends) high = turn;
          if (!ends && !contact) found.turning = std::max(found.turning, extreme);
        }
        if (ends) {
          found.event = polished(root(low, high, guess, sign), h);
          if (found.event > 0.0) return found;
          found.event = -1.0;  // on the wrong side from the start, by round-off: stay in the mode
        }
        found.largest = std::max(found.largest, value[i]);
        before = s;
        last = {value[i], rate[i]};
      }
    }
    return found;
  }

 private:
  /// Finer than a tenth of the contact's own period for contacts up to a hundred times the support's
  /// stiffness.
  static constexpr double sample_spacing = 0.15;
  /// Just behind an event the gap is 0 within this.
  static constexpr double round_off = 1e-14;
  /// Newton's last step: what it leaves is of the size of its square.
  static constexpr double settled = 1e-9;
  /// By so much round-off may put a root to the wrong side of a place next to it.
  static constexpr double at_root = 1e-12;

  /// Samples whose sums do not wait for each other.
  static constexpr int block = 8, most_blocks = 8;
  /// What the gap changes by within a step at most: all its terms, each as large as it gets.
  double largestChange(double h) const {
    const double square = h * h;
    double even = 0.0, odd = 0.0;
    for (int k = order_; k > 0; --k) {
      double& sum = k % 2 == 0 ? even : odd;
      sum = sum * square + std::abs(valueOf(squares_[k]));
    }
    return even * square + odd * h;
  }
  /// Gap and its rate at a block of samples.
  void gaps(const double* at, double* value, double* rate) const {
    typedef double Two __attribute__((vector_size(16)));
    constexpr int pairs = block / 2;
    Two s[pairs], g[pairs], r[pairs];
    for (int i = 0; i < pairs; ++i) {
      s[i] = Two{at[2 * i], at[2 * i + 1]};
      r[i] = Two{0.0, 0.0};
      g[i] = r[i] + valueOf(squares_[order_]);
    }
    for (int k = order_ - 1; k >= 0; --k) {
      const double c = valueOf(squares_[k]);
      for (int i = 0; i < pairs; ++i) {
        r[i] = r[i] * s[i] + g[i];
        g[i] = g[i] * s[i] + c;
      }
    }
    for (int i = 0; i < block; ++i) {
      value[i] = g[i / 2][i % 2] - 1.0;
      rate[i] = r[i / 2][i % 2];
    }
  }
  /// Whether the gap is too large for its rate to reach 0 between samples, by the tangents there.
  static bool staysDeep(const Gap& last, const double* value, const double* rate, double spacing) {
    double least = last.value, fastest = std::abs(last.rate);
    for (int i = 0; i < block; ++i) {
      least = std::min(least, value[i]);
      fastest = std::max(fastest, std::abs(rate[i]));
    }
    return least > fastest * spacing;
  }

  static double reciprocal(int k) {
    static constexpr struct Table {
      double value[most_order + 3] = {};
      constexpr Table() {
        for (int k = 1; k < most_order + 3; ++k) value[k] = 1.0 / k;
      }
    } table;
    return table.value[k];
  }

  static T sum(const Planar<T>& both) { return both.x() + both.y(); }

  /// Root and quotient of a further order. What the last order gave comes last into each sum, so that the
  /// others do not wait for it; r_0 e_0 = w_0 makes (w_0 w_k) / r_0 of w_k's share of the square.
  void nextDirection(int k, const T& inverse, const Planar<T>& first) {
    const T square = squareRest(k), along = sum(direction_[0] * w_[k]);
    squares_[k] = square + along * (radius_[0] * 2.0);
    T root = (square - rootRest(k)) * (inverse * 0.5) + along;
    Planar<T> quotient = (w_[k] - quotientRest(k)) * inverse;
    if (k > 1) {
      const T second = radius_[1] * inverse;
      if (k > 2) root = root - radius_[k - 1] * second;
      quotient = quotient - direction_[k - 1] * second;
    }
    radius_[k] = root;
    direction_[k] = quotient - first * root;
  }

  // Each sum below is kept in two parts, whose additions do not wait for each other.
  T squareAt(int k) const { return k == 0 ? sum(w_[0] * w_[0]) : squareRest(k) + sum(w_[0] * w_[k]) * 2.0; }
  /// sum_(j=1..k-1) w_j w_(k-j)
  T squareRest(int k) const {
    Planar<T> even = {T(0.0), T(0.0)}, odd = even;
    int j = (k - 1) / 2;
    for (; j > 1; j -= 2) {
      even = even + w_[j] * w_[k - j];
      odd = odd + w_[j - 1] * w_[k - j + 1];
    }
    if (j == 1) even = even + w_[1] * w_[k - 1];
    Planar<T> all = (even + odd) * T(2.0);
    if (k % 2 == 0) all = all + w_[k / 2] * w_[k / 2];
    return sum(all);
  }
  /// sum_(j=2..k-2) r_j r_(k-j); of order 2 all of it
  T rootRest(int k) const {
    if (k == 2) return radius_[1] * radius_[1];
    T even = T(0.0), odd = T(0.0);
    int j = (k - 1) / 2;
    for (; j > 2; j -= 2) {
      even = even + radius_[j] * radius_[k - j];
      odd = odd + radius_[j - 1] * radius_[k - j + 1];
    }
    if (j == 2) even = even + radius_[2] * radius_[k - 2];
    const T all = (even + odd) * 2.0;
    return k % 2 == 0 ? all + radius_[k / 2] * radius_[k / 2] : all;
  }
  /// sum_(j=2..k-1) r_j e_(k-j)
  Planar<T> quotientRest(int k) const {
    Planar<T> even = {T(0.0), T(0.0)}, odd = even;
    int j = 2;
    for (; j + 1 < k; j += 2) {
      even = even + direction_[k - j] * radius_[j];
      odd = odd + direction_[k - j - 1] * radius_[j + 1];
    }
    if (j < k) even = even + direction_[k - j] * radius_[j];
    return even + odd;
  }

  double step() const {
    double exponent = 10.0;
    for (int k = order_ - 1; k <= order_; ++k) {
      const T x = w_[k].x(), y = w_[k].y();
      const double value = std::max(std::abs(valueOf(x)), std::abs(valueOf(y)));
      const double slope = std::max(seriesSlope(x) / (1.0 + seriesSlope(w_[0].x())),
                                    seriesSlope(y) / (1.0 + seriesSlope(w_[0].y())));
      // the gap is a product: its terms are the larger ones (by 2^k in flight), and events are its roots
      const double size = std::max({value, slope, std::abs(valueOf(squares_[k]))});
      if (!std::isfinite(size)) return 0.0;
      if (size > 0.0) exponent = std::min(exponent, roughLog2(tolerance_ / size) * reciprocal(k));
    }
    return std::exp2(static_cast<float>(exponent));
  }
  /// Within 0.09, from a number's own exponent and mantissa: 1 % of a step of any order.
  static double roughLog2(double value) {
    std::int64_t bits;
    std::memcpy(&bits, &value, sizeof bits);
    return static_cast<double>(bits) * 0x1p-52 - 1023.0;
  }

  /// Value at which the tangents at two samples meet.
  static double tangentsMeet(const Gap& left, const Gap& right, double distance) {
    const double at = (right.value - left.value - right.rate * distance) / (left.rate - right.rate);
    return left.value + left.rate * at;
  }

  /// Where the rate of the gap changes from -sign to +sign: regula falsi (Illinois).
  double turningPoint(double low, double high, double sign) const {
    double at_low = sign * gap(low).rate, at_high = sign * gap(high).rate, s = low;
    for (int i = 0, side = 0; i < 60; ++i) {
      s = (low * at_high - high * at_low) / (at_high - at_low);
      const double rate = sign * gap(s).rate;
      if (std::abs(rate) < 1e-8 * (at_high - at_low)) break;
      if (rate < 0.0) {
        low = s, at_low = rate;
        if (side == -1) at_high *= 0.5;
        side = -1;
      } else {
        high = s, at_high = rate;
        if (side == 1) at_low *= 0.5;
        side = 1;
      }
    }
    return s;
  }

  /// Where the gap is 0 between two samples of different sign: the cubic polynomial of the place by the gap.
  static double crossing(const Gap& left, const Gap& right, double low, double high) {
    const double rise = right.value - left.value, u = -left.value / rise, v = 1.0 - u, length = high - low;
    return low + u * u * (3.0 - 2.0 * u) * length + u * v * rise * (v / left.rate - u / right.rate);
  }

  /// Root of the gap between low (on the mode's side) and high (behind it): Newton, kept inside by bisection,
  /// from a guess or from the middle.
  double root(double low, double high, double guess, double sign) const {
    double s = guess > low && guess < high ? guess : 0.5 * (low + high);
    for (int i = 0; i < 80; ++i) {
      const Gap g = gap(s);
      (sign * g.value > 0.0 ? low : high) = s;
      double next = s - g.value / g.rate;
      if (std::abs(next - s) < settled && next > low - at_root && next < high + at_root) return next;
      if (!(next > low && next < high)) next = 0.5 * (low + high);
      s = next;
    }
    return s;
  }

  /// A root of the gap's series as one of the state's own polynomial, from which it differs by the tolerance.
  double polished(double s, double h) const {
    for (int i = 0; i < 3; ++i) {
      T q[4];
      at(s, q);
      const double u = valueOf(q[0]) - valueOf(c_.misalignment_x),
                   v = valueOf(q[1]) - valueOf(c_.misalignment_y);
      const double correction = 0.5 * (u * u + v * v - 1.0) / (u * valueOf(q[2]) + v * valueOf(q[3]));
      // at a grazing touch the rate vanishes and the root stays where it was
      if (!(std::abs(correction) < 0.01 * h) || !(s - correction > 0.0)) break;
      s -= correction;
      if (std::abs(correction) < settled) break;
    }
    return s;
  }

  BasicCoefficients<T> c_;
  double tolerance_;
  int order_;
  Planar<T> w_[most_order + 1], direction_[most_order + 1];
  T squares_[most_order + 1], radius_[most_order + 1];
};

}  // namespace amb_rotor
