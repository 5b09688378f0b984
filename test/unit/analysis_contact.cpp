// Contact statistics of forces whose integrals are known.
#include <gtest/gtest.h>

#include <cmath>

#include "amb_rotor/analysis/contact.hpp"
#include "amb_rotor/common/error.hpp"

namespace amb_rotor {
namespace {

TEST(AnalysisContact, TrianglesOfForce) {
  // Two triangular impacts of peak 10 N and 2 s at 1..3 and 5..7 s, sampled each second: linear, so exact.
  const std::vector<double> t = {0, 1, 2, 3, 4, 5, 6, 7, 8};
  const std::vector<double> n = {0, 0, 10, 0, 0, 0, 10, 0, 0};
  const std::vector<double> x(9, 1.0), y(9, 1.0);
  const ContactStatistics s = contactStatistics(t, n, x, y);
  EXPECT_DOUBLE_EQ(s.duration, 8.0);
  EXPECT_DOUBLE_EQ(s.contact_fraction, 0.5);
  EXPECT_EQ(s.impacts, 2u);
  EXPECT_DOUBLE_EQ(s.max_force, 10.0);
  EXPECT_DOUBLE_EQ(s.impulse, 20.0);
  EXPECT_DOUBLE_EQ(s.mean_force, 2.5);
  EXPECT_DOUBLE_EQ(s.rms_force_in_contact, 10.0 / std::sqrt(3.0));  // of a triangle
  EXPECT_DOUBLE_EQ(s.rms_force, 10.0 / std::sqrt(6.0));
  EXPECT_DOUBLE_EQ(s.longest_contact, 2.0);
  EXPECT_DOUBLE_EQ(s.mean_contact, 2.0);
  EXPECT_NEAR(s.mean_direction, M_PI / 4.0, 1e-15);
  EXPECT_NEAR(s.direction_spread, 0.0, 1e-15);
  EXPECT_NEAR(s.rub_arc, M_PI / 180.0, 1e-15);  // one bin
}

TEST(AnalysisContact, CrossingsOfTheThresholdAreInterpolated) {
  ContactOptions options;
  options.touch_force = 2.0;
  options.release_force = 1.0;
  // Up 0..4 in 1 s (touches at 0.5 s), down 4..0 in 1 s (leaves at 1.75 s).
  const ContactStatistics s = contactStatistics({0, 1, 2}, {0, 4, 0}, {1, 1, 1}, {0, 0, 0}, options);
  EXPECT_DOUBLE_EQ(s.contact_fraction, 1.25 / 2.0);
  EXPECT_EQ(s.impacts, 1u);
}

TEST(AnalysisContact, HysteresisKeepsNoiseFromMakingImpacts) {
  ContactOptions options;
  options.touch_force = 2.0;
  options.release_force = 1.0;
  const std::vector<double> t = {0, 1, 2, 3, 4, 5}, n = {0, 2.1, 1.9, 2.1, 1.9, 0}, x(6, 1.0), y(6, 0.0);
  EXPECT_EQ(contactStatistics(t, n, x, y, options).impacts, 1u);
  options.release_force = 2.0;
  EXPECT_EQ(contactStatistics(t, n, x, y, options).impacts, 2u);
}

TEST(AnalysisContact, RubArcThroughTheNegativeAxis) {
  // Contact from 150 to 210 degrees, sampled each degree in the middle of the bins.
  ContactAccumulator accumulator;
  for (int i = 0; i < 360; ++i) {
    const double angle = (i + 0.5) * M_PI / 180.0;
    accumulator.add(i, i >= 150 && i < 210 ? 5.0 : 0.0, std::cos(angle), std::sin(angle));
  }
  const ContactStatistics s = accumulator.statistics();
  EXPECT_NEAR(s.rub_arc, 60.0 * M_PI / 180.0, 1e-12);
  EXPECT_NEAR(std::fabs(s.mean_direction), M_PI, 0.02);  // within a sample
  // Resultant of an arc of 60 degrees: sin(30 deg)/(pi/6).
  EXPECT_NEAR(s.direction_spread, 1.0 - 3.0 / M_PI, 2e-3);
}

TEST(AnalysisContact, DirectionsWeighByTime) {
  // 3 s at 0 degrees and 1 s at 90 degrees: resultant sqrt(9 + 1)/4, direction atan(1/3).
  const ContactStatistics s = contactStatistics({0, 3, 4}, {5, 5, 5}, {0, 1, 0}, {1, 0, 1});
  EXPECT_NEAR(s.mean_direction, std::atan2(1.0, 3.0), 1e-15);
  EXPECT_NEAR(s.direction_spread, 1.0 - std::sqrt(10.0) / 4.0, 1e-15);
}

TEST(AnalysisContact, AllTheTimeAndNever) {
  const std::vector<double> t = {0, 1, 2}, x(3, 1.0), y(3, 0.0);
  const ContactStatistics always = contactStatistics(t, {3, 3, 3}, x, y);
  EXPECT_DOUBLE_EQ(always.contact_fraction, 1.0);
  EXPECT_EQ(always.impacts, 0u);
  EXPECT_DOUBLE_EQ(always.mean_contact, 2.0);
  const ContactStatistics never = contactStatistics(t, {0, 0, 0}, x, y);
  EXPECT_EQ(never.contact_fraction, 0.0);
  EXPECT_EQ(never.rub_arc, 0.0);
  EXPECT_EQ(contactStatistics({}, {}, {}, {}).contact_fraction, 0.0);
}

TEST(AnalysisContact, NotANumberEndsTheInterval) {
  const ContactStatistics s = contactStatistics({0, 1, 2, 3}, {4, 4, NAN, 4}, {1, 1, 1, 1}, {0, 0, 0, 0});
  EXPECT_EQ(s.non_finite, 1u);
  EXPECT_DOUBLE_EQ(s.duration, 1.0);
  EXPECT_THROW(contactStatistics({0}, {}, {}, {}), InputError);
  ContactOptions bad;
  bad.release_force = 1.0;
  EXPECT_THROW(ContactAccumulator{bad}, InputError);
}

}  // namespace
}  // namespace amb_rotor
