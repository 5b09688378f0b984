#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "amb_rotor/common/error.hpp"
#include "amb_rotor/common/linear_algebra.hpp"
#include "amb_rotor/common/units.hpp"
#include "amb_rotor/rotor/reduction.hpp"
#include "amb_rotor/rotor/rotor_modes.hpp"

namespace amb_rotor {
namespace {

FlexibleRotor steppedRotor() {
  const Material steel{7850.0, 206e9, 0.3};
  RotorGeometry geometry;
  geometry.max_element_length = 0.012;
  geometry.sections = {{0.05, 0.02, 0.02, 0.0, 0.0, steel, 0.0},
                       {0.2, 0.045, 0.045, 0.0, 0.0, steel, 0.0},
                       {0.02, 0.045, 0.025, 0.0, 0.0, steel, 0.0},
                       {0.05, 0.025, 0.025, 0.005, 0.005, steel, 0.0}};
  geometry.discs = {{0.23, 0.4, 4e-4, 2.2e-4}};
  geometry.damping.modal_ratios = {0.002};
  return FlexibleRotor(geometry);
}

const std::vector<RotorSupport> kSupports = {isotropicSupport(-0.0963, 6e5, 50.0),
                                             isotropicSupport(0.0937, 6e5, 50.0)};

/// Largest relative error of the receptance below `highest` [rad/s], at three pairs of planes, spinning.
double receptanceError(const ReducedRotor& reduced, const ReducedRotor& full, double highest) {
  double error = 0.0;
  const double planes[3][2] = {{-0.0963, -0.0963}, {-0.0963, 0.0937}, {0.12, 0.0937}};
  for (const auto& plane : planes) {
    // Not at rest: there the force at one support does not move the other at all.
    for (int i = 1; i <= 10; ++i) {
      const double w = highest * i / 10.0;
      const Eigen::Matrix2cd exact = receptance(full, kSupports, 1500.0, w, plane[0], plane[1]);
      const Eigen::Matrix2cd found = receptance(reduced, kSupports, 1500.0, w, plane[0], plane[1]);
      error = std::max(error, (found - exact).norm() / exact.norm());
    }
  }
  return error;
}

TEST(RotorReduction, RigidModesAreExact) {
  const FlexibleRotor rotor = steppedRotor();
  const double mass = rotor.inertia().mass;
  const double transverse = rotor.inertia().transverse;
  for (const ReducedRotor& reduced :
       {reduceModal(rotor, 5), reduceCraigBampton(rotor, {-0.0963, 0.0937, 0.12}, 2)}) {
    for (double z : {-0.15, -0.033, 0.0, 0.111}) {
      EXPECT_NEAR(reduced.shape(z)(0), 1.0 / std::sqrt(mass), 1e-12);
      EXPECT_NEAR(reduced.shape(z)(1), z / std::sqrt(transverse), 1e-12);
    }
    EXPECT_EQ(reduced.modes, 5);
    EXPECT_EQ(reduced.stiffness(0), 0.0);
    EXPECT_EQ(reduced.stiffness(1), 0.0);
    // A rigid tilt carries the whole polar inertia: G_11 = Ip/It.
    EXPECT_NEAR(reduced.gyroscopic(1, 1), rotor.inertia().polar / transverse, 1e-10);
    EXPECT_NEAR(reduced.gyroscopic(0, 0), 0.0, 1e-12);
    EXPECT_EQ(reduced.gyroscopic, Eigen::MatrixXd(reduced.gyroscopic.transpose()));
  }
}

TEST(RotorReduction, BothFormsAreDiagonal) {
  const FlexibleRotor rotor = steppedRotor();
  const ReducedRotor reduced = reduceCraigBampton(rotor, {-0.12, -0.0963, 0.0937, 0.12}, 3);
  const Eigen::MatrixXd mass = reduced.vectors.transpose() * rotor.mass() * reduced.vectors;
  EXPECT_LT((mass - Eigen::MatrixXd::Identity(7, 7)).cwiseAbs().maxCoeff(), 1e-9);
  Eigen::MatrixXd stiffness = reduced.vectors.transpose() * rotor.stiffness() * reduced.vectors;
  const double largest = stiffness.diagonal().maxCoeff();
  stiffness.diagonal() -= reduced.stiffness;
  // Round-off of K (1e11 N/m) against the highest reduced mode.
  EXPECT_LT(stiffness.cwiseAbs().maxCoeff(), 1e-7 * largest);
}

TEST(RotorReduction, AllModesIsTheFullRotor) {
  const FlexibleRotor rotor = steppedRotor();
  const ReducedRotor full = allModes(rotor);
  EXPECT_EQ(full.modes, rotor.freedoms());
  const Eigen::VectorXd expected = planarFrequencies(rotor, {{-0.0963, 6e5}, {0.0937, 6e5}});
  const RotorModes modes =
      rotorModes(full, {isotropicSupport(-0.0963, 6e5), isotropicSupport(0.0937, 6e5)}, 0.0);
  // Two planes: each frequency twice. 1e-6: the full model spans 1e2 to 1e7 rad/s, squared, in doubles.
  for (int i = 0; i < 5; ++i) {
    EXPECT_NEAR(modes.oscillating[2 * i].natural_frequency, expected(i), 1e-6 * expected(i)) << i;
  }
}

TEST(RotorReduction, ModalTransferFunctionAgreesBelowHalfTheHighestMode) {
  const FlexibleRotor rotor = steppedRotor();
  const ReducedRotor full = allModes(rotor);
  const double band = 2.0 * pi * 2000.0;
  // Modes left out act as springs; the sum of their compliances falls with 1/w^2 of the first one left out.
  // With 10 modes it is some per cent of the smallest receptance in the band.
  const double ten = receptanceError(reduceModal(rotor, 10), full, band);
  const double twenty = receptanceError(reduceModal(rotor, 20), full, band);
  EXPECT_LT(ten, 0.05);
  EXPECT_LT(twenty, 0.5 * ten) << "more modes must help";
  EXPECT_GT(receptanceError(reduceModal(rotor, 2), full, band), 0.05) << "the check sees a rigid rotor";
}

TEST(RotorReduction, CraigBamptonBeatsModalAtItsPlanes) {
  const FlexibleRotor rotor = steppedRotor();
  const ReducedRotor full = allModes(rotor);
  const double band = 2.0 * pi * 2000.0;
  const ReducedRotor kept = reduceCraigBampton(rotor, {-0.0963, 0.0937, 0.12}, 7);
  const double error = receptanceError(kept, full, band);
  // The static part is exact, so what is left falls with w^4 of the modes left out.
  EXPECT_LT(error, 2e-3);
  EXPECT_LT(error, 0.2 * receptanceError(reduceModal(rotor, 10), full, band));
}

TEST(RotorReduction, CraigBamptonIsExactForStaticForcesAtItsPlanes) {
  const FlexibleRotor rotor = steppedRotor();
  const std::vector<double> planes = {-0.14, -0.0963, 0.0937, 0.12};
  const ReducedRotor kept = reduceCraigBampton(rotor, planes, 0);
  const Eigen::MatrixXd inverse = Ldlt(rotor.stiffnessWith({{planes[1], 6e5}, {planes[2], 6e5}}))
                                      .solveColumns(Eigen::MatrixXd::Identity(rotor.freedoms(), rotor.freedoms()));
  for (double out : planes) {
    for (double in : planes) {
      const double exact =
          rotor.grid().displacementShape(out).dot(inverse * rotor.grid().displacementShape(in));
      const double found = receptance(kept, kSupports, 0.0, 0.0, out, in)(0, 0).real();
      // K and its springs differ by 1e6: ten digits are left of sixteen.
      EXPECT_NEAR(found, exact, 1e-8 * std::abs(exact) + 1e-15);
    }
  }
  // The modal reduction of the same size is not exact: the check can fail.
  const ReducedRotor modal = reduceModal(rotor, 4);
  const double exact =
      rotor.grid().displacementShape(-0.14).dot(inverse * rotor.grid().displacementShape(-0.14));
  EXPECT_GT(std::abs(receptance(modal, kSupports, 0.0, 0.0, -0.14, -0.14)(0, 0).real() / exact - 1.0), 1e-4);
}

TEST(RotorReduction, CraigBamptonWithAllHeldModesIsTheFullRotor) {
  const FlexibleRotor rotor = steppedRotor();
  const ReducedRotor kept = reduceCraigBampton(rotor, {-0.0963, 0.0937}, rotor.freedoms() - 2);
  const ReducedRotor full = allModes(rotor);
  for (int i = 2; i < 8; ++i)
    EXPECT_NEAR(kept.stiffness(i), full.stiffness(i), 1e-6 * full.stiffness(i)) << i;
}

TEST(RotorReduction, GyroscopicPowerIsZeroAndSpinAddsNoDamping) {
  const FlexibleRotor rotor = steppedRotor();
  ReducedRotor reduced = reduceModal(rotor, 6);
  reduced.damping.setZero();
  const RotorModes modes =
      rotorModes(reduced, {isotropicSupport(-0.0963, 6e5), isotropicSupport(0.0937, 6e5)}, 3000.0);
  ASSERT_EQ(modes.oscillating.size(), 12u);
  // Energy is kept: every root on the imaginary axis, but for round-off of the highest (1e5 rad/s).
  for (const RotorMode& mode : modes.oscillating) EXPECT_LT(std::abs(mode.eigenvalue.real()), 1e-8 * 1e5);
}

TEST(RotorReduction, RefusesPlanesThatCannotHoldTheRotor) {
  const FlexibleRotor rotor = steppedRotor();
  EXPECT_THROW(reduceCraigBampton(rotor, {0.1}, 2), InputError);
  EXPECT_THROW(reduceCraigBampton(rotor, {0.1, 0.1}, 2), InputError);
  EXPECT_THROW(reduceCraigBampton(rotor, {0.1, 0.5}, 2), InputError);
  EXPECT_THROW(reduceModal(rotor, 1), InputError);
  EXPECT_THROW(reduceModal(rotor, rotor.freedoms() + 1), InputError);
}

}  // namespace
}  // namespace amb_rotor
