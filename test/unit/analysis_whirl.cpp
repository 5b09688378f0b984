// Whirl of known direction and frequency; slip against roll.
#include <gtest/gtest.h>

#include <cmath>
#include <complex>
#include <functional>

#include "amb_rotor/analysis/whirl.hpp"
#include "amb_rotor/common/error.hpp"

namespace amb_rotor {
namespace {

struct PlaneRecord {
  std::vector<double> time, x, y;
};

PlaneRecord record(double duration, double rate, const std::function<std::complex<double>(double)>& z) {
  PlaneRecord r;
  for (int i = 0; i < duration * rate; ++i) {
    const double t = i / rate;
    r.time.push_back(t + 100.0);
    r.x.push_back(z(t).real());
    r.y.push_back(z(t).imag());
  }
  return r;
}

TEST(AnalysisWhirl, CircleForwardAndBackward) {
  for (double w : {300.0, -300.0}) {
    const PlaneRecord r = record(1.0, 5000.0, [w](double t) { return 0.5 + std::polar(2.0, w * t + 0.3); });
    const WhirlState s = whirlFromOrbit(r.time, r.x, r.y, 0.5, 0.0);
    EXPECT_NEAR(s.frequency, w, 1e-8);  // exact line; round-off of times near 100 s
    EXPECT_EQ(s.direction, w > 0 ? WhirlDirection::forward : WhirlDirection::backward);
    EXPECT_NEAR(s.forward_share, w > 0 ? 1.0 : 0.0, 1e-12);
    EXPECT_NEAR(s.mean_radius, 2.0, 1e-12);
    EXPECT_TRUE(s.resolved);
  }
}

TEST(AnalysisWhirl, LargerVectorDecides) {
  // Backward 2 at 170 rad/s beside forward 1 at 500 rad/s: the angle winds with the larger.
  const PlaneRecord r =
      record(2.0, 5000.0, [](double t) { return std::polar(2.0, -170.0 * t) + std::polar(1.0, 500.0 * t); });
  const WhirlState s = whirlFromOrbit(r.time, r.x, r.y);
  // The angle swings by asin(1/2) about the line: slope error below 6 asin(1/2)/(w T) / T ~ 0.01 rad/s.
  EXPECT_NEAR(s.frequency, -170.0, 0.05);
  EXPECT_EQ(s.direction, WhirlDirection::backward);
  const SpectralWhirl spectral = whirlFromSpectrum(fullSpectrum(r.x, r.y, 5000.0));
  EXPECT_EQ(spectral.direction, WhirlDirection::backward);
  EXPECT_NEAR(spectral.frequency, -170.0, 0.01);  // two-line interpolation, line 3.1 rad/s
  EXPECT_NEAR(spectral.amplitude, 2.0, 1e-3);
  // Squares of the amplitudes; the mean taken off a record of broken periods, 2/(170 rad/s * 2 s), moves
  // (6e-3)^2.
  EXPECT_NEAR(spectral.forward_energy, 1.0, 4e-5);
  EXPECT_NEAR(spectral.backward_energy, 4.0, 4e-5);
}

TEST(AnalysisWhirl, OrbitBesideTheCentreDoesNotWhirlAboutIt) {
  const PlaneRecord r = record(1.0, 5000.0, [](double t) { return 5.0 + std::polar(1.0, 300.0 * t); });
  EXPECT_NE(whirlFromOrbit(r.time, r.x, r.y).direction, WhirlDirection::forward);
  EXPECT_NEAR(whirlFromOrbit(r.time, r.x, r.y).revolutions, 0.0, 0.07);  // swing asin(1/5) = 0.2 rad
}

TEST(AnalysisWhirl, LineIsPlanar) {
  const PlaneRecord r =
      record(1.0, 5000.0, [](double t) { return std::complex<double>(std::cos(300.0 * t), 0.0); });
  EXPECT_EQ(whirlFromSpectrum(fullSpectrum(r.x, r.y, 5000.0)).direction, WhirlDirection::planar);
}

TEST(AnalysisWhirl, TooFewSamplesAreTold) {
  const PlaneRecord r = record(1.0, 100.0, [](double t) { return std::polar(1.0, 2.0 * M_PI * 40.0 * t); });
  EXPECT_FALSE(whirlFromOrbit(r.time, r.x, r.y).resolved);
}

TEST(AnalysisWhirl, RollingBackward) {
  // R = 12 mm, C = 0.2 mm, 100 rad/s: rolls at -6000 rad/s.
  const SlipState rolling = slipState(100.0, -6000.0, 0.012, 2e-4);
  EXPECT_NEAR(rolling.rolling_whirl, -6000.0, 1e-9);
  EXPECT_NEAR(rolling.slip_speed, 0.0, 1e-12);
  EXPECT_EQ(rolling.kind, SlipKind::rolling);
  const SlipState slipping = slipState(100.0, -900.0, 0.012, 2e-4);
  EXPECT_NEAR(slipping.slip_speed, 1.2 - 0.18, 1e-12);
  EXPECT_EQ(slipping.kind, SlipKind::slipping);
  EXPECT_EQ(slipState(100.0, 6000.0, 0.012, 2e-4).kind, SlipKind::slipping);  // forward never rolls
  EXPECT_EQ(slipState(0.0, -900.0, 0.012, 2e-4).kind, SlipKind::undefined);
  EXPECT_THROW(slipState(1.0, 1.0, 0.0, 1.0), InputError);
}

}  // namespace
}  // namespace amb_rotor
