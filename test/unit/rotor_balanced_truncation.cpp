#include <gtest/gtest.h>

#include <cmath>

#include "amb_rotor/common/error.hpp"
#include "amb_rotor/common/linear_algebra.hpp"
#include "amb_rotor/rotor/balanced_truncation.hpp"

namespace amb_rotor {
namespace {

StateSpace twoStates() {
  StateSpace system;
  system.a = Eigen::Vector2d(-1.0, -2.0).asDiagonal();
  system.b = Eigen::Vector2d(1.0, 1.0);
  system.c = Eigen::RowVector2d(1.0, 1.0);
  return system;
}

ReducedRotor shaft(double modal_ratio) {
  RotorGeometry geometry;
  geometry.max_element_length = 0.02;
  geometry.sections = {{0.12, 0.02, 0.02, 0.0, 0.0, {7850.0, 206e9, 0.3}, 0.0},
                       {0.2, 0.045, 0.045, 0.0, 0.0, {7850.0, 206e9, 0.3}, 0.0}};
  geometry.damping.modal_ratios = {modal_ratio};
  return reduceModal(FlexibleRotor(geometry), 12);
}

TEST(RotorBalancedTruncation, HankelValuesOfTwoFirstOrderStates) {
  // P = Q = [1/2 1/3; 1/3 1/4]: sigma are its eigenvalues, trace 3/4, determinant 1/72.
  const Eigen::VectorXd sigma = hankelSingularValues(twoStates());
  const double root = std::sqrt(0.5625 - 4.0 / 72.0);
  EXPECT_NEAR(sigma(0), 0.5 * (0.75 + root), 1e-12);
  EXPECT_NEAR(sigma(1), 0.5 * (0.75 - root), 1e-12);
}

TEST(RotorBalancedTruncation, HankelValuesOfADampedOscillator) {
  // 1/(s^2 + 2 zeta w s + w^2): sigma = (sqrt(1 + zeta^2) +- zeta)/(4 zeta w^2); here a rigid shaft in
  // translation on a centred spring, so 1/m more.
  RotorGeometry geometry;
  geometry.max_element_length = 0.05;
  geometry.sections = {{0.2, 0.03, 0.03, 0.0, 0.0, {7850.0, 206e9, 0.3}, 0.0}};
  ReducedRotor rotor = reduceModal(FlexibleRotor(geometry), 2);
  // The tilt must be stable too; at the centre of gravity it is neither driven nor seen.
  rotor.stiffness(1) = 1e5;
  rotor.damping(1) = 10.0;
  const double w = 600.0;
  const double zeta = 0.05;
  const double mass = rotor.inertia.mass;
  const StateSpace system = rotorStateSpace(
      rotor, {isotropicSupport(0.0, mass * w * w, 2.0 * zeta * w * mass)}, 0.0, {0.0}, {0.0}, false);
  const Eigen::VectorXd sigma = hankelSingularValues(system);
  const double unit = 1.0 / (4.0 * zeta * w * w * mass);
  EXPECT_NEAR(sigma(0), (std::sqrt(1.0 + zeta * zeta) + zeta) * unit, 1e-9 * unit);
  EXPECT_NEAR(sigma(1), (std::sqrt(1.0 + zeta * zeta) - zeta) * unit, 1e-9 * unit);
  EXPECT_LT(sigma(2), 1e-7 * unit) << "the tilt is unseen: round-off under a square root";
}

TEST(RotorBalancedTruncation, LyapunovResidualIsRoundOff) {
  const StateSpace system =
      rotorStateSpace(shaft(0.01), {isotropicSupport(-0.09, 6e5, 100.0), isotropicSupport(0.09, 6e5, 100.0)},
                      1000.0, {-0.09}, {0.09}, true);
  const Eigen::MatrixXd r = system.b * system.b.transpose();
  const Eigen::MatrixXd x = solveLyapunov(system.a, r);
  const Eigen::MatrixXd residual = system.a * x + x * system.a.transpose() + r;
  // Backward stable: against |A| |X|, with the dimension (48) and a few digits to spare.
  EXPECT_LT(residual.norm(), 1e-12 * system.a.norm() * x.norm());
}

TEST(RotorBalancedTruncation, ErrorStaysBelowItsBound) {
  const StateSpace system =
      rotorStateSpace(shaft(0.005), {isotropicSupport(-0.09, 6e5, 100.0), isotropicSupport(0.09, 6e5, 100.0)},
                      0.0, {-0.09, 0.09}, {-0.11, 0.11}, false);
  double previous = 1e9;
  for (int order : {4, 8, 12}) {
    const BalancedSystem balanced = balancedTruncation(system, order);
    ASSERT_EQ(balanced.hankel.size(), 24);
    double worst = 0.0;
    double largest = 0.0;
    for (double hz = 1.0; hz < 30000.0; hz *= 1.02) {
      const std::complex<double> s(0.0, 2.0 * std::acos(-1.0) * hz);
      const Eigen::MatrixXcd exact = system.transfer(s);
      const Eigen::MatrixXcd difference = exact - balanced.system.transfer(s);
      // The bound is on the spectral norm.
      worst = std::max(worst, spectralNorm(difference));
      largest = std::max(largest, exact.norm());
    }
    EXPECT_LE(worst, balanced.error_bound * (1.0 + 1e-6)) << order;
    EXPECT_LT(balanced.error_bound, 0.5 * previous) << order;
    EXPECT_GT(worst, 1e-3 * balanced.error_bound) << "a bound far off would show nothing";
    // Four states are the two rigid modes. Bending is 1e-3 as compliant, but rings 1/(2 zeta) = 100 times
    // higher.
    EXPECT_LT(worst, (order == 4 ? 0.1 : 0.01) * largest) << order;
    previous = balanced.error_bound;
  }
}

TEST(RotorBalancedTruncation, FullOrderIsTheSameSystem) {
  const BalancedSystem balanced = balancedTruncation(twoStates(), 2);
  const std::complex<double> s(0.3, 1.7);
  const std::complex<double> exact = 1.0 / (s + 1.0) + 1.0 / (s + 2.0);
  EXPECT_LT(std::abs(balanced.system.transfer(s)(0, 0) - exact), 1e-12);
  EXPECT_EQ(balanced.error_bound, 0.0);
}

TEST(RotorBalancedTruncation, RefusesTheFreeRotor) {
  const StateSpace free = rotorStateSpace(shaft(0.01), {}, 0.0, {0.0}, {0.0}, false);
  EXPECT_THROW(hankelSingularValues(free), InputError);
  EXPECT_THROW(balancedTruncation(twoStates(), 3), InputError);
}

}  // namespace
}  // namespace amb_rotor
