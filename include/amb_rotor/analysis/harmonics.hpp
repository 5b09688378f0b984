#pragma once
// Orders (harmonics of the shaft's turn) of the motion in one plane, with phase, forward and backward.
//
// Thesis 5.10 to 5.19, corrected (the 2/T multiplies the integral; the phase is that of A cos(n theta +
// beta)):
//   q(theta) = U0/2 + sum_n U_n cos(n theta) + V_n sin(n theta) = mean + sum_n A_n cos(n theta + beta_n),
//   A_n = sqrt(U_n^2 + V_n^2), beta_n = atan2(-V_n, U_n).
// Here as complex amplitude Q_n = U_n - i V_n, q_n = Re(Q_n exp(i n theta)), so A = |Q|, beta = arg Q.
// In the plane z = x + i y = mean + sum_n F_n exp(i n theta) + B_n exp(-i n theta); n is a multiple of
// 1/subdivision (subdivision 2 gives 1/2X, 1X, 3/2X, ...). Then X_n = F_n + conj(B_n),
// Y_n = -i (F_n - conj(B_n)).
//
// The amplitudes are the least-squares fit to the samples over a whole number of turns: equal to the
// integrals for dense samples, and exact for a sum of the fitted orders at any sampling, also with varying
// speed.
//
// Symbols: theta shaft angle [rad], 0 at the tacho's rising edge, growing; x, y [m] (any unit; kept).
// Valid: more than 2 max_order samples a turn; at least `subdivision` whole turns.
// Left out: orders above max_order fold in only as far as the samples alias them.
#include <complex>
#include <cstddef>
#include <string>
#include <vector>

#include "amb_rotor/analysis/orbit.hpp"

namespace amb_rotor {

struct OrderOptions {
  int max_order = 5;    ///< highest order n, >= 1
  int subdivision = 1;  ///< orders are multiples of 1/subdivision, >= 1
  int turns = 0;        ///< whole turns used, from the end of the record; 0: as many as there are
};

/// One order of the motion.
struct OrderComponent {
  double order = 0.0;             ///< n [-], > 0
  std::complex<double> forward;   ///< F_n [m]
  std::complex<double> backward;  ///< B_n [m]
  std::complex<double> x;         ///< X_n [m]: x_n = |X| cos(n theta + arg X)
  std::complex<double> y;         ///< Y_n [m]
  OrbitEllipse ellipse;
};

/// Result of an order analysis. Too little data is a result (valid = false), not an exception.
struct OrderAnalysis {
  bool valid = false;
  std::string reason;                      ///< why not valid
  double turns = 0.0;                      ///< turns covered
  std::size_t samples = 0;                 ///< used
  std::size_t non_finite = 0;              ///< left out
  std::complex<double> mean;               ///< x + i y [m]
  std::vector<OrderComponent> components;  ///< ascending order
  double residual_rms = 0.0;               ///< [m] rms of |z - fit|; meaningful above 1e-7 of the rms of z

  /// The component of an order, nullptr where it was not fitted.
  const OrderComponent* find(double order) const;
};

/// Sample-by-sample order analysis: O(max_order subdivision) work and memory a sample.
class OrderAccumulator {
 public:
  /// @throw InputError: max_order or subdivision below 1.
  explicit OrderAccumulator(OrderOptions options = {});

  void add(double angle, double x, double y);
  /// Turns between the first and the last sample.
  double turns() const;
  /// The fit to all samples since the last reset; call it after whole turns.
  OrderAnalysis analysis() const;
  void reset();

 private:
  OrderOptions options_;
  int half_;                                   ///< max_order * subdivision
  std::vector<std::complex<double>> moments_;  ///< sum exp(i d theta/subdivision), d = 0 .. 2 half
  std::vector<std::complex<double>> right_;    ///< sum exp(-i j theta/subdivision) z, j = -half .. half
  double square_sum_ = 0.0, first_angle_ = 0.0, last_angle_ = 0.0;
  std::size_t samples_ = 0, non_finite_ = 0;
};

/// Orders over the last whole turns of a record.
/// @param angle shaft angle [rad], growing. @throw InputError: lengths differ, options out of range.
OrderAnalysis orderAnalysis(const std::vector<double>& angle, const std::vector<double>& x,
                            const std::vector<double>& y, const OrderOptions& options = {});

/// One order of a single channel, with the thesis's letters.
struct RealOrder {
  double order = 0.0;
  double cosine = 0.0;     ///< U_n
  double sine = 0.0;       ///< V_n
  double amplitude = 0.0;  ///< A_n
  double phase = 0.0;      ///< beta_n [rad], (-pi, pi]
};

RealOrder realOrder(double order, std::complex<double> amplitude);

}  // namespace amb_rotor
