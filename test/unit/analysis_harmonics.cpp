// Orders with phase against signals made of known orders.
#include <gtest/gtest.h>

#include <cmath>
#include <complex>
#include <functional>
#include <random>

#include "amb_rotor/analysis/harmonics.hpp"
#include "amb_rotor/common/error.hpp"

namespace amb_rotor {
namespace {

struct Signal {
  std::vector<double> angle, x, y;
};

/// Angle with varying speed (Omega t + a t^2/2), 55 samples a turn at first: as measured.
Signal sampled(double turns, const std::function<std::complex<double>(double)>& z) {
  Signal s;
  for (double t = 0.0;; t += 1e-4) {
    const double angle = 2.0 * M_PI * (180.0 * t + 40.0 * t * t);
    if (angle > 2.0 * M_PI * turns) break;
    const std::complex<double> value = z(angle);
    s.angle.push_back(angle);
    s.x.push_back(value.real());
    s.y.push_back(value.imag());
  }
  return s;
}

// Exact by construction for orders in the fitted set: normal equations of condition near 1, thousands of
// terms.
constexpr double fit_tolerance = 1e-11;

TEST(AnalysisHarmonics, PhaseBelongsToTheCosine) {
  // x = 2 cos(theta + 0.4), y = 0.5 cos(2 theta - 1)
  const Signal s = sampled(20.3, [](double a) {
    return std::complex<double>(2.0 * std::cos(a + 0.4), 0.5 * std::cos(2.0 * a - 1.0));
  });
  const OrderAnalysis analysis = orderAnalysis(s.angle, s.x, s.y);
  ASSERT_TRUE(analysis.valid) << analysis.reason;
  EXPECT_EQ(analysis.turns, 20);
  const RealOrder x1 = realOrder(1.0, analysis.find(1.0)->x);
  EXPECT_NEAR(x1.amplitude, 2.0, fit_tolerance);
  EXPECT_NEAR(x1.phase, 0.4, fit_tolerance);
  EXPECT_NEAR(x1.cosine, 2.0 * std::cos(0.4), fit_tolerance);
  EXPECT_NEAR(x1.sine, -2.0 * std::sin(0.4), fit_tolerance);
  EXPECT_NEAR(std::atan2(-x1.sine, x1.cosine), 0.4, fit_tolerance);  // thesis 5.19 corrected
  const RealOrder y2 = realOrder(2.0, analysis.find(2.0)->y);
  EXPECT_NEAR(y2.amplitude, 0.5, fit_tolerance);
  EXPECT_NEAR(y2.phase, -1.0, fit_tolerance);
  EXPECT_NEAR(std::abs(analysis.find(1.0)->y), 0.0, fit_tolerance);
}

TEST(AnalysisHarmonics, ForwardBackwardMeanAndSubOrders) {
  const auto z = [](double a) {
    return std::complex<double>(0.3, -0.2) + std::polar(1.0, a + 0.1) + std::polar(0.4, -a + 2.0) +
           std::polar(0.2, 0.5 * a - 0.7) + std::polar(0.1, -1.5 * a);
  };
  const Signal s = sampled(13.0, z);
  OrderOptions options;
  options.subdivision = 2;
  options.max_order = 3;
  options.turns = 10;
  const OrderAnalysis analysis = orderAnalysis(s.angle, s.x, s.y, options);
  ASSERT_TRUE(analysis.valid) << analysis.reason;
  EXPECT_EQ(analysis.turns, 10);
  EXPECT_LT(std::abs(analysis.mean - std::complex<double>(0.3, -0.2)), fit_tolerance);
  EXPECT_LT(std::abs(analysis.find(1.0)->forward - std::polar(1.0, 0.1)), fit_tolerance);
  EXPECT_LT(std::abs(analysis.find(1.0)->backward - std::polar(0.4, 2.0)), fit_tolerance);
  EXPECT_LT(std::abs(analysis.find(0.5)->forward - std::polar(0.2, -0.7)), fit_tolerance);
  EXPECT_LT(std::abs(analysis.find(1.5)->backward - 0.1), fit_tolerance);
  EXPECT_EQ(analysis.find(1.0)->ellipse.direction, WhirlDirection::forward);
  EXPECT_EQ(analysis.find(1.5)->ellipse.direction, WhirlDirection::backward);
  EXPECT_EQ(analysis.find(0.25), nullptr);
  // Residual: only the cancellation of equal sums, sqrt(1e-15).
  EXPECT_LT(analysis.residual_rms, 1e-7);
}

TEST(AnalysisHarmonics, AnOrderAboveTheFittedOnesHardlyLeaks) {
  // Order 7 of size 1 beside fitted orders up to 3: over whole turns the leak is that of the integral's
  // discretisation: one step of 50 a turn over 20 turns is 1e-3 at most.
  const Signal s = sampled(20.0, [](double a) { return std::polar(1.0, a) + std::polar(1.0, 7.0 * a); });
  OrderOptions options;
  options.max_order = 3;
  const OrderAnalysis analysis = orderAnalysis(s.angle, s.x, s.y, options);
  ASSERT_TRUE(analysis.valid);
  EXPECT_NEAR(std::abs(analysis.find(1.0)->forward), 1.0, 5e-3);
  EXPECT_LT(std::abs(analysis.find(2.0)->forward), 5e-3);
  EXPECT_NEAR(analysis.residual_rms, 1.0, 5e-3);
}

TEST(AnalysisHarmonics, NoiseGivesTheResidual) {
  std::mt19937 generator(3);
  std::normal_distribution<double> noise(0.0, 0.01);
  const Signal s = sampled(30.0, [&](double a) {
    return std::polar(1.0, a) + std::complex<double>(noise(generator), noise(generator));
  });
  const OrderAnalysis analysis = orderAnalysis(s.angle, s.x, s.y);
  // rms of the plane sqrt(2) 0.01, its standard error 0.0141/sqrt(2 n), n near 1400: 2 %; four of them.
  EXPECT_NEAR(analysis.residual_rms, 0.01414, 0.0012);
  // An amplitude has the standard error 0.0141/sqrt(n) = 4e-4; four of them.
  EXPECT_NEAR(std::abs(analysis.find(1.0)->forward), 1.0, 1.6e-3);
}

TEST(AnalysisHarmonics, TooLittleIsAResultNotAnException) {
  const Signal s = sampled(0.7, [](double a) { return std::polar(1.0, a); });
  EXPECT_FALSE(orderAnalysis(s.angle, s.x, s.y).valid);
  EXPECT_FALSE(orderAnalysis(s.angle, s.x, s.y).reason.empty());
  const std::vector<double> still(100, 0.0);
  EXPECT_FALSE(orderAnalysis(still, still, still).valid);
  // Four samples a turn cannot tell orders up to 5 apart.
  std::vector<double> angle, zero;
  for (int i = 0; i < 200; ++i) {
    angle.push_back(0.5 * M_PI * i);
    zero.push_back(0.0);
  }
  EXPECT_FALSE(orderAnalysis(angle, zero, zero).valid);
  OrderOptions bad;
  bad.max_order = 0;
  EXPECT_THROW(orderAnalysis(angle, zero, zero, bad), InputError);
}

TEST(AnalysisHarmonics, AccumulatorEqualsTheBatch) {
  const Signal s = sampled(5.0, [](double a) { return std::polar(1.0, a) + std::polar(0.3, -2.0 * a); });
  OrderAccumulator accumulator;
  for (std::size_t i = 0; i < s.angle.size(); ++i) accumulator.add(s.angle[i], s.x[i], s.y[i]);
  const OrderAnalysis analysis = accumulator.analysis();
  ASSERT_TRUE(analysis.valid);
  EXPECT_LT(std::abs(analysis.find(2.0)->backward - 0.3), fit_tolerance);
  accumulator.reset();
  EXPECT_FALSE(accumulator.analysis().valid);
}

}  // namespace
}  // namespace amb_rotor
