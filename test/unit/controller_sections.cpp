// Second-order sections and converters: the discrete against the continuous response, limits, rounding.
#include <gtest/gtest.h>

#include <complex>
#include <random>

#include "amb_rotor/magnetic_bearing/biquad.hpp"
#include "amb_rotor/magnetic_bearing/converter.hpp"

namespace amb_rotor {
namespace {

using Complex = std::complex<double>;
constexpr double period = 1e-4;
constexpr double sections_round_off = 1e-12;  // of responses of order 1 to 10

Complex discrete(const Biquad& f, double w) {
  const Complex back = std::exp(Complex(0.0, -w * period));
  return (f.b0 + f.b1 * back + f.b2 * back * back) / (1.0 + f.a1 * back + f.a2 * back * back);
}

Complex leadLag(double w, double zero_hz, double pole_hz) {
  return (1.0 + Complex(0.0, w / radPerSecond(zero_hz))) / (1.0 + Complex(0.0, w / radPerSecond(pole_hz)));
}

Complex notch(double w, double f, double zz, double zp) {
  const double w0 = radPerSecond(f);
  const Complex s(0.0, w);
  return (s * s + 2.0 * zz * w0 * s + w0 * w0) / (s * s + 2.0 * zp * w0 * s + w0 * w0);
}

/// The continuous frequency whose response the section has at w, for the substitution that is exact at w0.
double bent(double w, double w0) { return w0 * std::tan(0.5 * w * period) / std::tan(0.5 * w0 * period); }

TEST(ControllerSections, LeadLagIsExactAtRestAndAtItsMostPhase) {
  const Biquad f = biquadOf({SectionType::lead_lag, {150.0, 1200.0}}, period);
  const double w0 = radPerSecond(std::sqrt(150.0 * 1200.0));
  EXPECT_NEAR(std::abs(discrete(f, 0.0) - 1.0), 0.0, sections_round_off);
  EXPECT_NEAR(std::abs(discrete(f, w0) - leadLag(w0, 150.0, 1200.0)), 0.0, sections_round_off);
  EXPECT_NEAR(std::arg(discrete(f, w0)), std::asin((1200.0 - 150.0) / (1200.0 + 150.0)), sections_round_off)
      << "largest lead";
  for (const double hz : {20.0, 700.0, 3000.0}) {
    const double w = radPerSecond(hz);
    EXPECT_NEAR(std::abs(discrete(f, w) - leadLag(bent(w, w0), 150.0, 1200.0)), 0.0, sections_round_off)
        << hz;
  }
}

TEST(ControllerSections, NotchIsExactAtRestAndAtItsCentre) {
  for (const double depth : {0.0, 0.02}) {
    const Biquad f = biquadOf({SectionType::notch, {900.0, depth, 0.2}}, period);
    const double w0 = radPerSecond(900.0);
    EXPECT_NEAR(std::abs(discrete(f, 0.0) - 1.0), 0.0, sections_round_off);
    EXPECT_NEAR(std::abs(discrete(f, w0)), depth / 0.2, sections_round_off);
    for (const double hz : {20.0, 700.0, 1100.0, 4000.0}) {
      const double w = radPerSecond(hz);
      EXPECT_NEAR(std::abs(discrete(f, w) - notch(bent(w, w0), 900.0, depth, 0.2)), 0.0, sections_round_off)
          << hz;
    }
  }
}

TEST(ControllerSections, TheRecursionHasTheResponseOfItsCoefficients) {
  const Biquad f = biquadOf({SectionType::notch, {400.0, 0.05, 0.3}}, period);
  const double w = radPerSecond(330.0);
  double memory[2] = {0.0, 0.0};
  Complex sum = 0.0;
  for (int n = 0; n < 6000; ++n) {
    const double y = filtered(f, std::cos(w * n * period), memory);
    // 330 Hz has 33 whole turns in 1000 samples; 5000 samples are 25 time constants of the poles
    if (n >= 5000) sum += 2.0 / 1000.0 * y * std::exp(Complex(0.0, -w * n * period));
  }
  EXPECT_NEAR(std::abs(sum - discrete(f, w)), 0.0, 1e-9);
}

TEST(Converter, RoundsToHalfAStepAndSticksAtItsEnds) {
  const Converter ad{12.0, 0.4e-3};
  const double q = 0.8e-3 / 4096.0;
  EXPECT_DOUBLE_EQ(converterStep(ad), q);
  std::mt19937 random(7);
  std::uniform_real_distribution<double> within(-0.39e-3, 0.39e-3);
  double squares = 0.0;
  constexpr int count = 200000;
  for (int i = 0; i < count; ++i) {
    const double x = within(random), y = converted(ad, x);
    ASSERT_LE(std::fabs(y - x), 0.5 * q * (1.0 + 1e-9));
    ASSERT_NEAR(std::remainder(y, q), 0.0, 1e-9 * q);
    squares += (y - x) * (y - x);
  }
  // uniform error: rms q/sqrt(12); the mean of 2e5 squares scatters by 0.2 %
  EXPECT_NEAR(std::sqrt(squares / count), q / std::sqrt(12.0), 0.01 * q);
  EXPECT_DOUBLE_EQ(converted(ad, 1.0), 2047.0 * q) << "one step below +range: two's complement";
  EXPECT_DOUBLE_EQ(converted(ad, -1.0), -2048.0 * q);
  EXPECT_EQ(converted(ad, 0.0), 0.0);
}

}  // namespace
}  // namespace amb_rotor
