// Orbit statistics and ellipse against closed forms.
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "amb_rotor/analysis/orbit.hpp"
#include "amb_rotor/common/error.hpp"

namespace amb_rotor {
namespace {

// Closed forms evaluated in double: a few operations of relative round-off 2e-16.
constexpr double orbit_round_off = 1e-13;

TEST(AnalysisOrbit, EllipseOfForwardAndBackwardVectors) {
  const OrbitEllipse e = orbitEllipse(std::polar(3.0, 0.7), std::polar(1.0, 0.3));
  EXPECT_NEAR(e.semi_major, 4.0, orbit_round_off);
  EXPECT_NEAR(e.semi_minor, 2.0, orbit_round_off);
  EXPECT_NEAR(e.inclination, 0.5, orbit_round_off);
  EXPECT_EQ(e.direction, WhirlDirection::forward);
  // At the major phase the point is on the major axis at the largest radius.
  const std::complex<double> z = std::polar(3.0, 0.7 + e.major_phase) + std::polar(1.0, 0.3 - e.major_phase);
  EXPECT_NEAR(std::abs(z), 4.0, orbit_round_off);
  EXPECT_NEAR(std::arg(z), e.inclination, orbit_round_off);
  EXPECT_EQ(orbitEllipse(1.0, std::polar(2.0, 1.0)).direction, WhirlDirection::backward);
  EXPECT_LT(orbitEllipse(1.0, std::polar(2.0, 1.0)).semi_minor, 0.0);
  EXPECT_EQ(orbitEllipse(1.0, std::polar(1.0, 1.0)).direction, WhirlDirection::planar);
  EXPECT_EQ(orbitEllipse(0.0, 0.0).direction, WhirlDirection::none);
}

TEST(AnalysisOrbit, MajorPhaseWhenTheInclinationWraps) {
  const double f = 2.8, b = 3.0;  // (f + b)/2 = 2.9: the axis is folded by pi
  const OrbitEllipse e = orbitEllipse(std::polar(3.0, f), std::polar(1.0, b));
  EXPECT_NEAR(e.inclination, 2.9 - M_PI, orbit_round_off);
  const std::complex<double> z = std::polar(3.0, f + e.major_phase) + std::polar(1.0, b - e.major_phase);
  EXPECT_NEAR(std::arg(z), e.inclination, orbit_round_off);
}

TEST(AnalysisOrbit, StatisticsOfADisplacedCircle) {
  // 1000 points of a circle of radius 0.2 mm about (1, 0) mm; the bearing is at (1, 0.1) mm.
  std::vector<double> x, y;
  for (int i = 0; i < 1000; ++i) {
    x.push_back(1e-3 + 2e-4 * std::cos(2.0 * M_PI * i / 1000));
    y.push_back(2e-4 * std::sin(2.0 * M_PI * i / 1000));
  }
  const OrbitStatistics s = orbitStatistics(x, y, 3e-4, 1e-3, 1e-4);
  // Means over whole periods are exact up to round-off of numbers near 1e-3.
  EXPECT_NEAR(s.mean_x, 1e-3, 1e-16);
  EXPECT_NEAR(s.mean_y, 0.0, 1e-16);
  EXPECT_NEAR(s.rms_about_mean, 2e-4, 1e-15);
  EXPECT_NEAR(s.max_radius, 3e-4, 1e-15);  // a sample lies at -90 degrees exactly
  EXPECT_NEAR(s.min_radius, 1e-4, 1e-15);
  EXPECT_NEAR(s.max_radius_over_clearance, 1.0, 1e-11);
  EXPECT_NEAR(s.peak_to_peak_y, 4e-4, 1e-15);
  EXPECT_EQ(s.samples, 1000u);
}

TEST(AnalysisOrbit, WeightsAreSharesOfTime) {
  OrbitAccumulator accumulator(1.0);
  accumulator.add(0.0, 0.0, 3.0);
  accumulator.add(4.0, 0.0, 1.0);
  EXPECT_NEAR(accumulator.statistics().mean_x, 1.0, orbit_round_off);
  EXPECT_NEAR(accumulator.statistics().rms_about_mean, std::sqrt(3.0), orbit_round_off);
}

TEST(AnalysisOrbit, NotANumberIsCountedAndKeptOut) {
  OrbitAccumulator accumulator(1.0);
  accumulator.add(1.0, 0.0);
  accumulator.add(std::numeric_limits<double>::quiet_NaN(), 0.0);
  EXPECT_EQ(accumulator.statistics().non_finite, 1u);
  EXPECT_EQ(accumulator.statistics().max_radius, 1.0);
}

TEST(AnalysisOrbit, UnitsOfTheClearance) {
  const Orbit orbit = orbitInClearance({3e-4}, {-1e-4}, 2e-4, 1e-4, 1e-4);
  EXPECT_NEAR(orbit.x[0], 1.0, orbit_round_off);
  EXPECT_NEAR(orbit.y[0], -1.0, orbit_round_off);
  EXPECT_THROW(orbitInClearance({1.0}, {1.0}, 0.0), InputError);
  EXPECT_THROW(orbitStatistics({1.0}, {}, 1.0), InputError);
}

}  // namespace
}  // namespace amb_rotor
