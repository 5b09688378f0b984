#include "amb_rotor/rotor/rotor_modes.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "amb_rotor/common/error.hpp"

namespace amb_rotor {
namespace {

// Closed forms of two-mode rotors: a four by four eigenvalue problem, round-off only.
constexpr double modes_round_off = 1e-9;

/// A shaft with a thin ring (Ip = 2 It) at its middle; rigid.
ReducedRotor ringRotor() {
  RotorGeometry geometry;
  geometry.max_element_length = 0.02;
  geometry.sections = {{0.2, 0.01, 0.01, 0.0, 0.0, {7850.0, 206e9, 0.3}, 0.0}};
  geometry.discs = {{0.1, 2.0, 2.0 * 0.0064, 0.0064}};
  return reduceModal(FlexibleRotor(geometry), 2);
}

TEST(RotorModes, SpinningRingSplitsTheConicalModeOnly) {
  const ReducedRotor rotor = ringRotor();
  const double k = 4e5;
  const double arm = 0.08;
  const double speed = 900.0;
  const RotorModes modes = rotorModes(rotor, {isotropicSupport(-arm, k), isotropicSupport(arm, k)}, speed);
  ASSERT_EQ(modes.oscillating.size(), 4u);
  // It w^2 -+ Ip W w - 2 k a^2 = 0 (forward, backward); the cylindrical pair stays at sqrt(2 k/m).
  const double half = 0.5 * rotor.inertia.polar * speed / rotor.inertia.transverse;
  const double still = 2.0 * k * arm * arm / rotor.inertia.transverse;
  const double forward = half + std::sqrt(half * half + still);
  const double backward = -half + std::sqrt(half * half + still);
  const double cylindrical = std::sqrt(2.0 * k / rotor.inertia.mass);
  std::vector<double> found;
  for (const RotorMode& mode : modes.oscillating) found.push_back(mode.damped_frequency);
  std::vector<double> expected = {forward, backward, cylindrical, cylindrical};
  std::sort(expected.begin(), expected.end());
  for (int i = 0; i < 4; ++i) EXPECT_NEAR(found[i], expected[i], modes_round_off * expected[i]);
  for (const RotorMode& mode : modes.oscillating) {
    if (std::abs(mode.damped_frequency - forward) < 1.0) {
      EXPECT_EQ(mode.whirl, Whirl::forward);
    }
    if (std::abs(mode.damped_frequency - backward) < 1.0) {
      EXPECT_EQ(mode.whirl, Whirl::backward);
    }
  }
  EXPECT_GT(forward / backward, 1.5) << "the split must be large enough to mean something";
}

TEST(RotorModes, ForwardTurnsFromXTowardsY) {
  const RotorModes modes =
      rotorModes(ringRotor(), {isotropicSupport(-0.08, 4e5), isotropicSupport(0.08, 4e5)}, 900.0);
  const RotorMode& fastest = modes.oscillating.back();
  ASSERT_EQ(fastest.whirl, Whirl::forward);
  const ReducedRotor rotor = ringRotor();
  const Eigen::Vector2cd shape = modeShape(rotor, fastest, 0.05);
  // x = cos, y = sin: y lags by a quarter turn, Y = -j X.
  EXPECT_LT(std::abs(shape.y() + std::complex<double>(0.0, 1.0) * shape.x()), 1e-6 * std::abs(shape.x()));
}

TEST(RotorModes, DampedCylindricalModeHasItsRatio) {
  const ReducedRotor rotor = ringRotor();
  const double k = 4e5;
  const double d = 60.0;
  const RotorModes modes =
      rotorModes(rotor, {isotropicSupport(-0.08, k, d), isotropicSupport(0.08, k, d)}, 0.0);
  const double natural = std::sqrt(2.0 * k / rotor.inertia.mass);
  const double ratio = d / (rotor.inertia.mass * natural);  // 2 d/(2 m w)
  const RotorMode& mode = modes.oscillating.front();
  EXPECT_NEAR(mode.natural_frequency, natural, modes_round_off * natural);
  EXPECT_NEAR(mode.damping_ratio, ratio, modes_round_off);
  EXPECT_EQ(mode.whirl, Whirl::planar);
}

TEST(RotorModes, FreeAndOverdampedMotionsAreRealRoots) {
  const ReducedRotor rotor = ringRotor();
  const RotorModes free = rotorModes(rotor, {}, 0.0);
  EXPECT_EQ(free.oscillating.size(), 0u);
  ASSERT_EQ(free.real.size(), 8u);
  EXPECT_EQ(free.real.front(), 0.0);
  const RotorModes slow =
      rotorModes(rotor, {isotropicSupport(-0.08, 100.0, 1e4), isotropicSupport(0.08, 100.0, 1e4)}, 0.0);
  EXPECT_EQ(slow.oscillating.size(), 0u);
  EXPECT_LT(slow.real.back(), 0.0);
}

TEST(RotorModes, CrossCouplingDestabilisesTheForwardMode) {
  // One rigid mass: m w'' + c w' + (k - j q) w = 0 turns unstable at q = c sqrt(k/m), forward for q > 0
  // with F_x = -q y, F_y = q x.
  const ReducedRotor rotor = ringRotor();
  const auto growth = [&](double q) {
    std::vector<RotorSupport> supports = {isotropicSupport(-0.08, 2e5, 40.0),
                                          isotropicSupport(0.08, 2e5, 40.0)};
    for (RotorSupport& support : supports) support.stiffness << 2e5, 0.5 * q, -0.5 * q, 2e5;
    double largest = -1e9;
    Whirl whirl = Whirl::planar;
    for (const RotorMode& mode : rotorModes(rotor, supports, 0.0).oscillating) {
      if (mode.eigenvalue.real() <= largest) continue;
      largest = mode.eigenvalue.real();
      whirl = mode.whirl;
    }
    return std::make_pair(largest, whirl);
  };
  const double limit = 80.0 * std::sqrt(4e5 / rotor.inertia.mass);
  EXPECT_LT(growth(0.999 * limit).first, 0.0);
  EXPECT_GT(growth(1.001 * limit).first, 0.0);
  EXPECT_EQ(growth(1.001 * limit).second, Whirl::forward);
}

TEST(RotorModes, CriticalSpeedsAreWhereTheCampbellLinesMeetTheSpin) {
  const ReducedRotor rotor = ringRotor();
  const std::vector<RotorSupport> supports = {isotropicSupport(-0.08, 4e5), isotropicSupport(0.06, 3e5)};
  const std::vector<CriticalSpeed> speeds = criticalSpeeds(rotor, supports);
  // Ip > It: the forward conical mode runs away from the spin; three critical speeds are left of four.
  ASSERT_EQ(speeds.size(), 3u);
  for (const CriticalSpeed& critical : speeds) {
    double nearest = 1e9;
    for (const RotorMode& mode : rotorModes(rotor, supports, critical.speed).oscillating) {
      if (mode.whirl != critical.whirl) continue;
      nearest = std::min(nearest, std::abs(mode.damped_frequency - critical.speed));
    }
    EXPECT_LT(nearest, modes_round_off * critical.speed);
  }
  EXPECT_THROW(criticalSpeeds(rotor, {isotropicSupport(0.0, 4e5)}), InputError);
}

TEST(RotorModes, CampbellHasOnePointASpeed) {
  const std::vector<RotorModes> diagram = campbell(
      ringRotor(), {isotropicSupport(-0.08, 4e5), isotropicSupport(0.08, 4e5)}, {0.0, 500.0, 1000.0});
  ASSERT_EQ(diagram.size(), 3u);
  EXPECT_EQ(diagram[2].speed, 1000.0);
  // Highest line: forward conical, it must rise; lowest: backward conical, it must fall.
  EXPECT_GT(diagram[2].oscillating.back().damped_frequency, diagram[1].oscillating.back().damped_frequency);
  EXPECT_LT(diagram[2].oscillating.front().damped_frequency, diagram[1].oscillating.front().damped_frequency);
}

}  // namespace
}  // namespace amb_rotor
