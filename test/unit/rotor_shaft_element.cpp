#include <gtest/gtest.h>

#include <cmath>

#include "amb_rotor/common/error.hpp"
#include "amb_rotor/common/linear_algebra.hpp"
#include "amb_rotor/common/units.hpp"
#include "amb_rotor/rotor/shaft_element.hpp"

namespace amb_rotor {
namespace {

// Closed form against sums of a few dozen terms: round-off only.
constexpr double element_round_off = 1e-12;

Material elementSteel() { return {7850.0, 206e9, 0.3}; }

TEST(RotorShaftElement, EulerBernoulliIsTheThesisElement) {
  const double l = 0.04;
  const double d = 0.03;
  ShaftElement element = cylinder(l, d, 0.0, elementSteel(), BeamTheory::euler_bernoulli);
  element.rotary_inertia = false;
  const ElementMatrices matrices = elementMatrices(element);
  Eigen::Matrix4d mass;  // 3.13
  mass << 156, 22 * l, 54, -13 * l, 22 * l, 4 * l * l, 13 * l, -3 * l * l, 54, 13 * l, 156, -22 * l, -13 * l,
      -3 * l * l, -22 * l, 4 * l * l;
  mass *= 7850.0 * pi * d * d / 4.0 * l / 420.0;
  Eigen::Matrix4d stiffness;  // 3.14
  stiffness << 12, 6 * l, -12, 6 * l, 6 * l, 4 * l * l, -6 * l, 2 * l * l, -12, -6 * l, 12, -6 * l, 6 * l,
      2 * l * l, -6 * l, 4 * l * l;
  stiffness *= 206e9 * pi * std::pow(d, 4) / 64.0 / std::pow(l, 3);
  EXPECT_LT((matrices.mass - mass).norm(), element_round_off * mass.norm());
  EXPECT_LT((matrices.stiffness - stiffness).norm(), element_round_off * stiffness.norm());
}

TEST(RotorShaftElement, TimoshenkoStiffnessIsPrzemienieckis) {
  const double l = 0.05;
  const double d = 0.06;
  const ElementMatrices matrices = elementMatrices(cylinder(l, d, 0.02, elementSteel()));
  const double area = pi / 4.0 * (d * d - 0.02 * 0.02);
  const double moment = pi / 64.0 * (std::pow(d, 4) - std::pow(0.02, 4));
  const double shear_modulus = 206e9 / 2.6;
  const double phi =
      12.0 * 206e9 * moment / (hutchinsonShearFactor(1.0 / 3.0, 0.3) * shear_modulus * area * l * l);
  Eigen::Matrix4d stiffness;
  stiffness << 12, 6 * l, -12, 6 * l, 6 * l, (4 + phi) * l * l, -6 * l, (2 - phi) * l * l, -12, -6 * l, 12,
      -6 * l, 6 * l, (2 - phi) * l * l, -6 * l, (4 + phi) * l * l;
  stiffness *= 206e9 * moment / (std::pow(l, 3) * (1.0 + phi));
  EXPECT_NEAR(matrices.shear_parameter, phi, element_round_off * phi);
  EXPECT_LT((matrices.stiffness - stiffness).norm(), element_round_off * stiffness.norm());
}

TEST(RotorShaftElement, ShearFactors) {
  // Hutchinson 2001: 6 (1+nu)^2 / (7 + 12 nu + 4 nu^2) for the solid circle.
  EXPECT_NEAR(hutchinsonShearFactor(0.0, 0.3), 6.0 * 1.69 / (7.0 + 3.6 + 0.36), element_round_off);
  // Thin tube: (1+nu)/(2+nu), his limit; the ring of 0.999 is within the square of its wall ratio.
  EXPECT_NEAR(hutchinsonShearFactor(0.999, 0.3), 1.3 / 2.3, 1e-5);
  EXPECT_NEAR(cowperShearFactor(0.2992610837438423), 0.8863063567628116, element_round_off);
}

TEST(RotorShaftElement, RigidMotionsStrainNothingAndCarryTheMass) {
  ShaftElement element = cylinder(0.05, 0.04, 0.01, elementSteel());
  element.layers[0].outer_diameter_right = 0.06;
  element.layers.push_back({0.07, 0.07, 0.061, 0.061, {7650.0, 0.0, 0.3}, 0.0});
  const ElementMatrices matrices = elementMatrices(element);
  const Eigen::Vector4d shift(1.0, 0.0, 1.0, 0.0);
  const Eigen::Vector4d tilt(0.0, 1.0, 0.05, 1.0);
  EXPECT_LT((matrices.stiffness * shift).norm(), element_round_off * matrices.stiffness.norm());
  EXPECT_LT((matrices.stiffness * tilt).norm(), element_round_off * matrices.stiffness.norm());
  const double cone = pi * 0.05 / 12.0 * (0.0016 + 0.0024 + 0.0036) - pi / 4.0 * 0.0001 * 0.05;
  const double ring = pi / 4.0 * (0.0049 - 0.061 * 0.061) * 0.05;
  const double mass = 7850.0 * cone + 7650.0 * ring;
  EXPECT_NEAR(shift.dot(matrices.mass * shift), mass, element_round_off * mass);
}

TEST(RotorShaftElement, ConeBendsAsTheClosedForm) {
  // A cantilever cone, load at the tip: w = 64 F L^3 / (3 pi E d_tip d_root^3). Euler-Bernoulli.
  const double length = 0.2;
  const double root = 0.04;
  const double tip = 0.02;
  const auto tipDeflection = [&](int count) {
    Eigen::MatrixXd stiffness = Eigen::MatrixXd::Zero(2 * count + 2, 2 * count + 2);
    for (int i = 0; i < count; ++i) {
      ShaftElement element = cylinder(length / count, root, 0.0, elementSteel(), BeamTheory::euler_bernoulli);
      element.layers[0].outer_diameter_left = root + (tip - root) * i / count;
      element.layers[0].outer_diameter_right = root + (tip - root) * (i + 1) / count;
      stiffness.block<4, 4>(2 * i, 2 * i) += elementMatrices(element).stiffness;
    }
    Eigen::VectorXd force = Eigen::VectorXd::Zero(2 * count);
    force(2 * count - 2) = 1.0;
    const Eigen::MatrixXd held = stiffness.bottomRightCorner(2 * count, 2 * count);
    return inverse(held)(2 * count - 2, 2 * count - 2);
  };
  const double exact = 64.0 * std::pow(length, 3) / (3.0 * pi * 206e9 * tip * std::pow(root, 3));
  const double coarse = std::abs(tipDeflection(8) / exact - 1.0);
  const double fine = std::abs(tipDeflection(32) / exact - 1.0);
  // Energy error of a cubic is of order h^2 (curvature linear) squared: h^4, but the cone's own change a
  // element also enters squared. 32 elements of 2 % change each: below 1e-5; four times finer: 4^3 at least.
  EXPECT_LT(fine, 1e-5);
  EXPECT_GT(coarse / fine, 64.0);
}

TEST(RotorShaftElement, TimoshenkoConeConverges) {
  // No shape function is exact for the cone with shear: halving the element must gain the order 2.
  const auto tipDeflection = [](int count) {
    Eigen::MatrixXd stiffness = Eigen::MatrixXd::Zero(2 * count + 2, 2 * count + 2);
    for (int i = 0; i < count; ++i) {
      ShaftElement element = cylinder(0.2 / count, 0.08, 0.0, elementSteel());
      element.layers[0].outer_diameter_left = 0.08 - 0.04 * i / count;
      element.layers[0].outer_diameter_right = 0.08 - 0.04 * (i + 1) / count;
      stiffness.block<4, 4>(2 * i, 2 * i) += elementMatrices(element).stiffness;
    }
    return inverse(stiffness.bottomRightCorner(2 * count, 2 * count))(2 * count - 2, 2 * count - 2);
  };
  // Bending as above plus shear F L / (k G A) integrated: 4 F L / (pi k G d_tip d_root).
  const double shear = 4.0 * 0.2 / (pi * hutchinsonShearFactor(0.0, 0.3) * 206e9 / 2.6 * 0.04 * 0.08);
  const double exact = 64.0 * 0.008 / (3.0 * pi * 206e9 * 0.04 * std::pow(0.08, 3)) + shear;
  const double coarse = std::abs(tipDeflection(8) / exact - 1.0);
  const double fine = std::abs(tipDeflection(16) / exact - 1.0);
  // The square of the diameter's change over an element, up to 6 %.
  EXPECT_LT(fine, 3e-3);
  // 4 for order 2; 3.5 leaves room for the next order.
  EXPECT_GT(coarse / fine, 3.5);
}

TEST(RotorShaftElement, RefusesWhatIsNoShaft) {
  ShaftElement element = cylinder(-0.1, 0.02, 0.03, {0.0, 206e9, 0.6});
  try {
    elementMatrices(element);
    FAIL() << "accepted";
  } catch (const InputError& error) {
    // Length, inner diameter on both sides, density, Poisson's ratio: all at once.
    EXPECT_EQ(error.faults().size(), 5u) << error.what();
  }
  EXPECT_THROW(elementMatrices(cylinder(0.1, 0.02, 0.0, {7850.0, 0.0, 0.3})), InputError);
}

}  // namespace
}  // namespace amb_rotor
