// Balanced truncation that leaves a rotor: its closed Gramians against Lyapunov's equation, what it keeps, what it refuses.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "amb_rotor/common/error.hpp"
#include "amb_rotor/common/linear_algebra.hpp"
#include "amb_rotor/common/units.hpp"
#include "amb_rotor/rotor/balanced_truncation.hpp"
#include "amb_rotor/rotor/reduction.hpp"
#include "amb_rotor/rotor/rotor_modes.hpp"

namespace amb_rotor {
namespace {

/// Stepped, without symmetry; six elements, so that its highest mode is 1e3 times the lowest and Lyapunov's equation keeps
/// its digits.
FlexibleRotor unevenRotor(const ShaftDamping& damping) {
  const Material steel{7850.0, 206e9, 0.3};
  RotorGeometry geometry;
  geometry.max_element_length = 0.06;
  geometry.sections = {{0.08, 0.02, 0.02, 0.0, 0.0, steel, 0.0}, {0.2, 0.04, 0.04, 0.0, 0.0, steel, 0.0}};
  geometry.discs = {{0.05, 0.5, 4e-4, 2.5e-4}};
  geometry.damping = damping;
  return FlexibleRotor(geometry);
}

const std::vector<double> uneven_planes = {-0.09, 0.03, 0.1};

ShaftDamping ratio(double zeta) {
  ShaftDamping damping;
  damping.modal_ratios = {zeta};
  return damping;
}

/// The bending of the free rotor from forces at the planes to displacements there: s = [W q; q'].
StateSpace bendingOf(const ReducedRotor& rotor, const std::vector<double>& planes) {
  const int n = rotor.modes - 2, p = static_cast<int>(planes.size());
  const Eigen::VectorXd w = rotor.stiffness.tail(n).cwiseSqrt();
  StateSpace system;
  system.a = Eigen::MatrixXd::Zero(2 * n, 2 * n);
  system.a.topRightCorner(n, n) = w.asDiagonal();
  system.a.bottomLeftCorner(n, n) = -1.0 * Eigen::MatrixXd(w.asDiagonal());
  system.a.bottomRightCorner(n, n) = -1.0 * Eigen::MatrixXd(rotor.damping.tail(n).asDiagonal());
  system.b = Eigen::MatrixXd::Zero(2 * n, p);
  system.c = Eigen::MatrixXd::Zero(p, 2 * n);
  for (int k = 0; k < p; ++k) {
    const Eigen::VectorXd shape = rotor.shape(planes[k]).tail(n);
    system.b.col(k).tail(n) = shape;
    system.c.row(k).head(n) = shape.cwiseQuotient(w).transpose();
  }
  return system;
}

double largestError(const StateSpace& full, const StateSpace& reduced) {
  double worst = 0.0;
  for (double hz = 10.0; hz < 1e6; hz *= 1.003) {
    const std::complex<double> s(0.0, radPerSecond(hz));
    worst = std::max(worst, spectralNorm(full.transfer(s) - reduced.transfer(s)));
  }
  return worst;
}

TEST(RotorBalancedReduction, ClosedGramiansAreThoseOfLyapunovsEquation) {
  ShaftDamping mixed = ratio(0.02);
  mixed.stiffness_proportional = 2e-5;  // the highest modes are overdamped
  for (const ShaftDamping& damping : {ratio(0.002), ratio(0.4), mixed}) {
    const FlexibleRotor rotor = unevenRotor(damping);
    const ReducedRotor all = allModes(rotor);
    const StateSpace system = bendingOf(all, uneven_planes);
    const int n = all.modes - 2;
    const Eigen::VectorXd w = all.stiffness.tail(n).cwiseSqrt();
    const Eigen::MatrixXd p = solveLyapunov(system.a, system.b * system.b.transpose()).topLeftCorner(n, n);
    const Eigen::MatrixXd q = solveLyapunov(system.a.transpose(), system.c.transpose() * system.c).topLeftCorner(n, n);
    Eigen::VectorXcd squares = generalEigenvalues(p * q);  // states W q: the product is the same
    std::vector<double> expected;
    for (const auto& s : squares) expected.push_back(std::sqrt(std::max(0.0, s.real())));
    std::sort(expected.rbegin(), expected.rend());
    const Eigen::VectorXd found = positionSingularValues(rotor, uneven_planes);
    ASSERT_EQ(found.size(), n);
    // a general eigenvalue problem of a product leaves the square root of round-off of the largest
    for (int i = 0; i < n; ++i) EXPECT_NEAR(found(i), expected[i], 1e-7 * expected[0] + 1e-6 * expected[i]) << i;
  }
}

TEST(RotorBalancedReduction, WithLittleDampingTheyAreHankelsOnePairAMode) {
  const double zeta = 1e-4;
  const FlexibleRotor rotor = unevenRotor(ratio(zeta));
  const Eigen::VectorXd hankel = hankelSingularValues(bendingOf(allModes(rotor), uneven_planes));
  const Eigen::VectorXd position = positionSingularValues(rotor, uneven_planes);
  // of one mode (sqrt(1 + zeta^2) +- zeta)/(4 zeta w^2) phi^2: their mean but for zeta^2; of several, for zeta
  for (int i = 0; i < 6; ++i)
    EXPECT_NEAR(0.5 * (hankel(2 * i) + hankel(2 * i + 1)) / position(i), 1.0, 10.0 * zeta) << i;
}

TEST(RotorBalancedReduction, ErrorLiesBetweenHankelsBounds) {
  for (const double zeta : {0.002, 0.05}) {
    const FlexibleRotor rotor = unevenRotor(ratio(zeta));
    const StateSpace full = bendingOf(allModes(rotor), uneven_planes);
    const Eigen::VectorXd hankel = hankelSingularValues(full);
    for (const int modes : {4, 6, 8}) {
      const int states = 2 * (modes - 2);
      const double error = largestError(full, bendingOf(reduceBalanced(rotor, uneven_planes, modes), uneven_planes));
      // no system of so few states is better than the first value that is cut (Glover 1984); 2 % for the grid
      EXPECT_GT(error, 0.98 * hankel(states)) << zeta << " " << modes;
      // the free projection's bound: one that keeps the rotor comes as near here, though nothing promises it
      EXPECT_LT(error, 2.0 * hankel.tail(hankel.size() - states).sum()) << zeta << " " << modes;
    }
  }
}

TEST(RotorBalancedReduction, KeepsWhatThePlanesSeeNotWhatIsLow) {
  // one plane on a node of the first bending mode: that mode is neither driven nor seen there
  const FlexibleRotor rotor = unevenRotor(ratio(0.002));
  const ReducedRotor all = allModes(rotor);
  double below = all.left(), above = 0.0;
  for (int i = 0; i < 60; ++i) {
    const double middle = 0.5 * (below + above);
    ((all.shape(middle)(2) > 0.0) == (all.shape(below)(2) > 0.0) ? below : above) = middle;
  }
  const std::vector<double> node = {below};
  const StateSpace full = bendingOf(all, node);
  const double balanced = largestError(full, bendingOf(reduceBalanced(rotor, node, 3), node)),
               modal = largestError(full, bendingOf(reduceModal(rotor, 3), node));
  EXPECT_LT(balanced, 0.5 * modal);
  EXPECT_GT(reduceBalanced(rotor, node, 3).stiffness(2), 1.5 * all.stiffness(2)) << "it is not the first";
}

TEST(RotorBalancedReduction, StaysARotor) {
  ShaftDamping damping = ratio(0.01);
  damping.stiffness_proportional = 1e-5;
  const FlexibleRotor rotor = unevenRotor(damping);
  const ReducedRotor kept = reduceBalanced(rotor, uneven_planes, 7), all = allModes(rotor);
  EXPECT_EQ(kept.modes, 7);
  const Eigen::MatrixXd mass = kept.vectors.transpose() * rotor.mass() * kept.vectors;
  EXPECT_LT((mass - Eigen::MatrixXd::Identity(7, 7)).cwiseAbs().maxCoeff(), 1e-9);
  Eigen::MatrixXd stiffness = kept.vectors.transpose() * rotor.stiffness() * kept.vectors;
  stiffness.diagonal() -= kept.stiffness;
  EXPECT_LT(stiffness.cwiseAbs().maxCoeff(), 1e-7 * kept.stiffness.maxCoeff());
  // damping: of the full rotor's matrix the diagonal
  const Eigen::MatrixXd own = kept.vectors.transpose() * rotor.damping() * kept.vectors;
  for (int i = 2; i < 7; ++i) EXPECT_NEAR(kept.damping(i), own(i, i), 1e-7 * own(i, i)) << i;
  EXPECT_EQ(kept.stiffness(1), 0.0);
  EXPECT_NEAR(kept.gyroscopic(1, 1), rotor.inertia().polar / rotor.inertia().transverse, 1e-9);
  // frequencies from above (Rayleigh and Ritz)
  for (int i = 2; i < 7; ++i) EXPECT_GE(kept.stiffness(i), all.stiffness(i) * (1.0 - 1e-9));
  // spring, spin and a bearing that only damps do not make it unstable
  for (const double speed : {0.0, 3000.0})
    for (const RotorMode& mode :
         rotorModes(kept, {isotropicSupport(-0.09, 6e5, 50.0), isotropicSupport(0.1, 6e5, 50.0)}, speed).oscillating)
      EXPECT_LT(mode.eigenvalue.real(), 0.0);
}

TEST(RotorBalancedReduction, AllOfThemAreTheFullRotor) {
  const FlexibleRotor rotor = unevenRotor(ratio(0.01));
  const ReducedRotor all = allModes(rotor), kept = reduceBalanced(rotor, uneven_planes, all.modes);
  for (int i = 2; i < all.modes; ++i) {
    EXPECT_NEAR(kept.stiffness(i), all.stiffness(i), 1e-7 * all.stiffness(i)) << i;
    EXPECT_NEAR(kept.damping(i), all.damping(i), 1e-6 * all.damping(i)) << i;
  }
}

TEST(RotorBalancedReduction, RefusesWhatItCannotBalance) {
  const auto keyOf = [](const ShaftDamping& damping, const std::vector<double>& planes, int modes) {
    try {
      reduceBalanced(unevenRotor(damping), planes, modes);
    } catch (const InputError& error) {
      return error.faults().front().key;
    }
    return std::string();
  };
  EXPECT_EQ(keyOf({}, uneven_planes, 4), "damping");
  EXPECT_EQ(keyOf(ratio(0.01), uneven_planes, 1), "modes");
  EXPECT_EQ(keyOf(ratio(0.01), uneven_planes, 40), "modes");
  EXPECT_EQ(keyOf(ratio(0.01), {0.5}, 4), "z");
  EXPECT_EQ(keyOf(ratio(0.01), uneven_planes, 2), "") << "two are the rigid rotor";
}

}  // namespace
}  // namespace amb_rotor
