#include <gtest/gtest.h>

#include <cmath>

#include "amb_rotor/common/error.hpp"
#include "amb_rotor/common/linear_algebra.hpp"
#include "amb_rotor/common/units.hpp"
#include "amb_rotor/rotor/flexible_rotor.hpp"
#include "amb_rotor/rotor/rotor_modes.hpp"

namespace amb_rotor {
namespace {

// Closed form against sums over some 20 elements: round-off of about 1e-15 times the conditioning of m z^2.
constexpr double flexible_round_off = 1e-11;

Material shaftSteel() { return {7850.0, 206e9, 0.3}; }

RotorGeometry cylinderGeometry(double length, double diameter, int elements) {
  RotorGeometry geometry;
  geometry.max_element_length = length / elements;
  geometry.sections.push_back({length, diameter, diameter, 0.0, 0.0, shaftSteel(), 0.0});
  return geometry;
}

TEST(RotorFlexible, InertiaOfACylinder) {
  const FlexibleRotor rotor(cylinderGeometry(0.3, 0.04, 20));
  const double mass = 7850.0 * pi / 4.0 * 0.0016 * 0.3;
  EXPECT_NEAR(rotor.inertia().mass, mass, flexible_round_off * mass);
  EXPECT_NEAR(rotor.inertia().centre_of_gravity_from_left, 0.15, flexible_round_off);
  EXPECT_NEAR(rotor.inertia().polar, 0.5 * mass * 0.0004, flexible_round_off);
  EXPECT_NEAR(rotor.inertia().transverse, mass * (3.0 * 0.0004 + 0.09) / 12.0, flexible_round_off);
  EXPECT_NEAR(rotor.left(), -0.15, flexible_round_off);
  EXPECT_EQ(rotor.freedoms(), 42);
}

TEST(RotorFlexible, InertiaOfAFrustum) {
  // R = 20 mm to r = 10 mm over 0.1 m: closed forms of the frustum.
  RotorGeometry geometry = cylinderGeometry(0.1, 0.04, 3);
  geometry.sections[0].outer_diameter_right = 0.02;
  const FlexibleRotor rotor(geometry);
  const double big = 0.02;
  const double small = 0.01;
  const double mass = 7850.0 * pi * 0.1 / 3.0 * (big * big + big * small + small * small);
  const double cubes = std::pow(big, 3) - std::pow(small, 3);
  const double polar = 0.3 * mass * (std::pow(big, 5) - std::pow(small, 5)) / cubes;
  const double centre = 0.1 / 4.0 * (big * big + 2.0 * big * small + 3.0 * small * small) /
                        (big * big + big * small + small * small);
  EXPECT_NEAR(rotor.inertia().mass, mass, flexible_round_off * mass);
  EXPECT_NEAR(rotor.inertia().polar, polar, flexible_round_off * polar);
  EXPECT_NEAR(rotor.inertia().centre_of_gravity_from_left, centre, flexible_round_off);
}

TEST(RotorFlexible, DiscsAndRingsShiftTheCentreOfGravity) {
  RotorGeometry geometry = cylinderGeometry(0.3, 0.04, 10);
  geometry.discs.push_back({0.0731, 1.5, 0.002, 0.0012});
  geometry.rings.push_back({0.2, 0.25, 0.04, 0.06, {7650.0, 0.0, 0.3}});
  const FlexibleRotor rotor(geometry);
  const double shaft = 7850.0 * pi / 4.0 * 0.0016 * 0.3;
  const double ring = 7650.0 * pi / 4.0 * (0.0036 - 0.0016) * 0.05;
  const double mass = shaft + ring + 1.5;
  const double centre = (shaft * 0.15 + ring * 0.225 + 1.5 * 0.0731) / mass;
  const double ring_squares = 0.0009 + 0.0004;  // R^2 + r^2
  const double transverse = shaft * (3.0 * 0.0004 + 0.09) / 12.0 + shaft * std::pow(0.15 - centre, 2) +
                            ring * (3.0 * ring_squares + 0.0025) / 12.0 + ring * std::pow(0.225 - centre, 2) +
                            0.0012 + 1.5 * std::pow(0.0731 - centre, 2);
  EXPECT_NEAR(rotor.inertia().mass, mass, flexible_round_off * mass);
  EXPECT_NEAR(rotor.inertia().centre_of_gravity_from_left, centre, flexible_round_off);
  EXPECT_NEAR(rotor.inertia().transverse, transverse, flexible_round_off);
  EXPECT_NEAR(rotor.inertia().polar, 0.5 * shaft * 0.0004 + 0.5 * ring * ring_squares + 0.002,
              flexible_round_off);
}

TEST(RotorFlexible, ForceBetweenNodesKeepsResultantAndMoment) {
  const FlexibleRotor rotor(cylinderGeometry(0.3, 0.05, 7));
  const Eigen::MatrixXd rigid = rotor.rigidModes();
  for (double z : {rotor.left(), -0.1234, -0.001, 0.02, 0.0777, rotor.right()}) {
    const Eigen::VectorXd shape = rotor.grid().displacementShape(z);
    EXPECT_NEAR(shape.dot(rigid.col(0)) * std::sqrt(rotor.inertia().mass), 1.0, flexible_round_off);
    EXPECT_NEAR(shape.dot(rigid.col(1)) * std::sqrt(rotor.inertia().transverse), z, flexible_round_off);
    EXPECT_NEAR(rotor.grid().rotationShape(z).dot(rigid.col(1)) * std::sqrt(rotor.inertia().transverse), 1.0,
                flexible_round_off);
  }
  EXPECT_THROW(rotor.grid().displacementShape(0.151), InputError);
  EXPECT_THROW(rotor.grid().displacementShape(std::nan("")), InputError);
}

TEST(RotorFlexible, ForceBetweenNodesBendsAsTheBeamOnTwoSupports) {
  // Euler-Bernoulli, supports of stiffness k at the ends, force at u from the left, deflection at x < u:
  // w = F b x (L^2 - b^2 - x^2)/(6 L E I), b = L - u, plus the supports' own deflection.
  RotorGeometry geometry = cylinderGeometry(0.4, 0.02, 5);
  geometry.theory = BeamTheory::euler_bernoulli;
  const FlexibleRotor rotor(geometry);
  const double k = 1e7;
  const double length = 0.4;
  const double u = 0.2567;  // inside the fourth element
  const double x = 0.16;    // a node: consistent loads are exact there
  const Eigen::MatrixXd stiffness = rotor.stiffnessWith({{rotor.left(), k}, {rotor.right(), k}});
  const Eigen::VectorXd force = rotor.grid().displacementShape(u + rotor.left());
  const double found = rotor.grid().displacementShape(x + rotor.left()).dot(Ldlt(stiffness).solve(force));
  const double bending = 206e9 * pi / 64.0 * std::pow(0.02, 4);
  const double b = length - u;
  const double beam = b * x * (length * length - b * b - x * x) / (6.0 * length * bending);
  const double support = (b / length * (1.0 - x / length) + u / length * x / length) / k;
  // Conditioning of K on these springs is about 1e5.
  EXPECT_NEAR(found, beam + support, 1e-9 * found);
}

TEST(RotorFlexible, FreeModesAreOrthonormalAndStartRigid) {
  RotorGeometry geometry = cylinderGeometry(0.3, 0.04, 15);
  geometry.discs.push_back({0.05, 0.8, 0.001, 0.0006});
  const FlexibleRotor rotor(geometry);
  const FreeModes modes = freeModes(rotor);
  const Eigen::MatrixXd mass = modes.vectors.transpose() * rotor.mass() * modes.vectors;
  EXPECT_LT((mass - Eigen::MatrixXd::Identity(rotor.freedoms(), rotor.freedoms())).cwiseAbs().maxCoeff(),
            1e-10);
  Eigen::MatrixXd stiffness = modes.vectors.transpose() * rotor.stiffness() * modes.vectors;
  const double largest = stiffness.diagonal().maxCoeff();
  stiffness.diagonal() -= modes.frequency.cwiseAbs2();
  // Backward stable eigensolver: errors are round-off of the largest eigenvalue.
  EXPECT_LT(stiffness.cwiseAbs().maxCoeff(), 1e-11 * largest);
  EXPECT_EQ(modes.frequency(0), 0.0);
  EXPECT_EQ(modes.frequency(1), 0.0);
  EXPECT_GT(modes.frequency(2), 1000.0);
}

TEST(RotorFlexible, DampingGivesTheRatiosAskedFor) {
  RotorGeometry geometry = cylinderGeometry(0.3, 0.04, 10);
  geometry.damping = {3.0, 2e-8, {0.004, 0.01}};
  const FlexibleRotor rotor(geometry);
  const FreeModes modes = freeModes(rotor);
  const Eigen::MatrixXd damping = modes.vectors.transpose() * rotor.damping() * modes.vectors;
  for (int i = 0; i < 6; ++i) {
    const double w = modes.frequency(i);
    const double ratio = i < 2 ? 0.0 : (i == 2 ? 0.004 : 0.01);
    const double expected = 3.0 + 2e-8 * w * w + 2.0 * ratio * w;
    // Round-off of the highest mode's damping (about 1e7 /s here) shows in the low ones.
    EXPECT_NEAR(damping(i, i), expected, 1e-6 * (1.0 + expected)) << i;
  }
}

TEST(RotorFlexible, GyroscopicMatrixIsSymmetricSoItsPowerIsZero) {
  RotorGeometry geometry = cylinderGeometry(0.3, 0.05, 10);
  geometry.discs.push_back({0.05, 0.8, 0.001, 0.0006});
  const FlexibleRotor rotor(geometry);
  const Eigen::MatrixXd& g = rotor.gyroscopic();
  EXPECT_LT((g - g.transpose()).norm(), 1e-15 * g.norm());
  std::srand(7);
  const Eigen::VectorXd x = Eigen::VectorXd::Random(g.rows());
  const Eigen::VectorXd y = Eigen::VectorXd::Random(g.rows());
  const double power = x.dot(g * y) - y.dot(g * x);
  EXPECT_LT(std::abs(power), 1e-13 * g.norm() * x.norm() * y.norm());
}

TEST(RotorFlexible, MeshIsFineEnoughWhereHalvingItChangesNothing) {
  RotorGeometry geometry = cylinderGeometry(0.3, 0.05, 16);
  const double coarse = freeModes(FlexibleRotor(geometry)).frequency(2);
  geometry.max_element_length *= 0.5;
  const double fine = freeModes(FlexibleRotor(geometry)).frequency(2);
  // Constant shear in an element: (q^2 E I/(k G A)) (q l)^2/24 = 4e-4 with q = 4.73/L, see the pinned beam.
  EXPECT_NEAR(coarse, fine, 4e-4 * fine);
  EXPECT_GE(coarse, fine * (1.0 - 1e-9)) << "a displacement element is too stiff, never too soft";
}

}  // namespace
}  // namespace amb_rotor
