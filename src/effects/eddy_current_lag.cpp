#include "amb_rotor/effects/eddy_current_lag.hpp"

#include <Eigen/Core>
#include <cmath>
#include <complex>

#include "amb_rotor/common/linear_algebra.hpp"

namespace amb_rotor::effects {
namespace {

constexpr int inner = EddyCurrentLag::nodes - 1;  // the last lag is the rest
constexpr double slowest = two_pi * 0.2, fastest = two_pi * 3e4;    // rates [rad/s], by search: the least error
constexpr double lowest = two_pi * 2.0, highest = two_pi * 4000.0;  // where it is least [rad/s]
constexpr double at_once = 1e12;                                    // rate of the rest [1/s]
constexpr int frequencies = 64;

double between(double from, double to, int k, int n) {
  return from * std::pow(to / from, static_cast<double>(k) / (n - 1));
}

/// |1 - H| over a frequency is near sqrt(frequency): the error counts over that.
double weightAt(double frequency) { return 1.0 / std::sqrt(frequency); }

/// What takes the values of 1 - H (real parts, then imaginary) to the weights of least squares: no corner is
/// in it.
Eigen::MatrixXd solver() {
  Eigen::MatrixXd a(2 * frequencies, inner);
  for (int f = 0; f < frequencies; ++f) {
    const std::complex<double> s(0.0, between(lowest, highest, f, frequencies));
    for (int k = 0; k < inner; ++k) {
      const std::complex<double> high = weightAt(s.imag()) * s / (s + between(slowest, fastest, k, inner));
      a(f, k) = high.real();
      a(frequencies + f, k) = high.imag();
    }
  }
  return Ldlt(a.transpose() * a).solveColumns(a.transpose());  // the condition of a is 1e4
}

}  // namespace

std::array<EddyCurrentLag::Lag, EddyCurrentLag::nodes> EddyCurrentLag::rule(double corner) {
  static const Eigen::MatrixXd solve = solver();
  Eigen::VectorXd missing(2 * frequencies);
  for (int f = 0; f < frequencies; ++f) {
    const double frequency = between(lowest, highest, f, frequencies);
    const std::complex<double> root = std::sqrt(std::complex<double>(0.0, frequency / corner));
    const std::complex<double> value = weightAt(frequency) * root / (1.0 + root);
    missing[f] = value.real();
    missing[frequencies + f] = value.imag();
  }
  const Eigen::VectorXd weights = solve * missing;
  std::array<Lag, nodes> lags{};
  for (int k = 0; k < inner; ++k) lags[k] = {weights[k], between(slowest, fastest, k, inner)};
  lags.back() = {1.0 - weights.sum(), at_once};
  return lags;
}

}  // namespace amb_rotor::effects
