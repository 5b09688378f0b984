#include "amb_rotor/analysis/harmonics.hpp"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>

#include "amb_rotor/common/linear_algebra.hpp"
#include "amb_rotor/common/units.hpp"
#include "argument.hpp"

namespace amb_rotor {
namespace {

using Complex = std::complex<double>;
// Below this ratio of the smallest to the largest pivot the samples do not tell the orders apart
// (for whole turns sampled densely the matrix is nearly a multiple of the identity, ratio near 1).
constexpr double pivot_limit = 1e-6;

}  // namespace

const OrderComponent* OrderAnalysis::find(double order) const {
  for (const OrderComponent& component : components) {
    if (std::fabs(component.order - order) < 1e-9) return &component;
  }
  return nullptr;
}

OrderAccumulator::OrderAccumulator(OrderOptions options) : options_(options), half_(0) {
  requireArgument(options.max_order >= 1, "max_order", options.max_order, "must be at least 1");
  requireArgument(options.subdivision >= 1, "subdivision", options.subdivision, "must be at least 1");
  requireArgument(options.turns >= 0, "turns", options.turns, "must be at least 0");
  half_ = options.max_order * options.subdivision;
  moments_.assign(2 * half_ + 1, Complex(0.0));
  right_.assign(2 * half_ + 1, Complex(0.0));
}

void OrderAccumulator::add(double angle, double x, double y) {
  if (!std::isfinite(angle) || !std::isfinite(x) || !std::isfinite(y)) {
    ++non_finite_;
    return;
  }
  if (samples_ == 0) first_angle_ = angle;
  last_angle_ = angle;
  ++samples_;
  const Complex z(x, y);
  square_sum_ += std::norm(z);
  const Complex unit = std::polar(1.0, angle / options_.subdivision);
  Complex power = 1.0;
  for (int d = 0; d <= 2 * half_; ++d) {
    moments_[d] += power;
    if (d <= half_) {
      right_[half_ + d] += std::conj(power) * z;
      if (d > 0) right_[half_ - d] += power * z;
    }
    power *= unit;
  }
}

double OrderAccumulator::turns() const { return (last_angle_ - first_angle_) / two_pi; }

OrderAnalysis OrderAccumulator::analysis() const {
  OrderAnalysis result;
  result.turns = turns();
  result.samples = samples_;
  result.non_finite = non_finite_;
  const int size = 2 * half_ + 1;
  if (samples_ < static_cast<std::size_t>(size)) {
    result.reason = "fewer samples than unknown amplitudes";
    return result;
  }
  // Normal equations, Hermitian and Toeplitz: G_jk = sum exp(i (k - j) theta / subdivision).
  Eigen::MatrixXcd gram(size, size);
  for (int j = 0; j < size; ++j) {
    for (int k = 0; k < size; ++k) gram(j, k) = k >= j ? moments_[k - j] : std::conj(moments_[j - k]);
  }
  const Eigen::Map<const Eigen::VectorXcd> right(right_.data(), size);
  const HermitianLdlt factor(gram);
  const Eigen::VectorXd pivots = factor.pivots();
  if (!factor.succeeded() || !(pivots.minCoeff() > pivot_limit * pivots.maxCoeff())) {
    result.reason = "the samples do not tell the orders apart (too few turns or samples a turn)";
    return result;
  }
  const Eigen::VectorXcd amplitude = factor.solve(right);
  result.valid = true;
  result.mean = amplitude(half_);
  const double explained = amplitude.dot(right).real();
  result.residual_rms = std::sqrt(std::max(0.0, (square_sum_ - explained) / samples_));
  for (int j = 1; j <= half_; ++j) {
    OrderComponent component;
    component.order = static_cast<double>(j) / options_.subdivision;
    component.forward = amplitude(half_ + j);
    component.backward = amplitude(half_ - j);
    component.x = component.forward + std::conj(component.backward);
    component.y = Complex(0.0, -1.0) * (component.forward - std::conj(component.backward));
    component.ellipse = orbitEllipse(component.forward, component.backward);
    result.components.push_back(component);
  }
  return result;
}

void OrderAccumulator::reset() { *this = OrderAccumulator(options_); }

OrderAnalysis orderAnalysis(const std::vector<double>& angle, const std::vector<double>& x,
                            const std::vector<double>& y, const OrderOptions& options) {
  requireSameLength(angle, x, "x");
  requireSameLength(angle, y, "y");
  OrderAccumulator accumulator(options);
  if (angle.size() < 2 || !(angle.back() > angle.front())) {
    OrderAnalysis result;
    result.reason = "the shaft angle does not grow";
    return result;
  }
  // n equal samples cover the turns between them and one step more.
  const double span = angle.back() - angle.front();
  const double step = span / (angle.size() - 1);
  int available = static_cast<int>(std::floor((span + step) / two_pi + 1e-9));
  available -= available % options.subdivision;
  const int wanted = options.turns == 0 ? available : options.turns;
  if (wanted > available || wanted == 0 || wanted % options.subdivision != 0) {
    OrderAnalysis result;
    result.turns = span / two_pi;
    result.samples = angle.size();
    result.reason = "not enough whole turns, or not a multiple of the subdivision";
    return result;
  }
  const double from = angle.back() - two_pi * wanted + 1e-9;
  for (std::size_t i = 0; i < angle.size(); ++i) {
    if (angle[i] > from) accumulator.add(angle[i], x[i], y[i]);
  }
  OrderAnalysis result = accumulator.analysis();
  result.turns = wanted;
  return result;
}

RealOrder realOrder(double order, std::complex<double> amplitude) {
  return {order, amplitude.real(), -amplitude.imag(), std::abs(amplitude), std::arg(amplitude)};
}

}  // namespace amb_rotor
