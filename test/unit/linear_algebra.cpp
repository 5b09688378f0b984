// Each decomposition against its defining equation, on matrices of no special form. Round-off of these sizes
// (8 x 8, condition below 1e3) is some 1e-13; what is wrong is wrong in the first digit.
#include "amb_rotor/common/linear_algebra.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace amb_rotor {
namespace {

using Eigen::MatrixXcd;
using Eigen::MatrixXd;
using Eigen::VectorXcd;
using Eigen::VectorXd;
using Complex = std::complex<double>;

constexpr int size = 8;
constexpr double algebra_round_off = 1e-11;

/// No two entries alike, no symmetry, of full rank.
MatrixXd general() {
  MatrixXd a(size, size);
  for (int i = 0; i < size; ++i)
    for (int j = 0; j < size; ++j)
      a(i, j) = std::sin(1.0 + 3.7 * i + 1.3 * j * j + 0.9 * i * j) + (i == j ? 2.0 : 0.0);
  return a;
}

MatrixXcd toComplex(const MatrixXd& a) { return a.cast<Complex>(); }

/// One product for all: each kind of operands would be instantiated anew.
MatrixXcd times(const MatrixXcd& a, const MatrixXcd& b) { return a.lazyProduct(b); }
MatrixXd times(const MatrixXd& a, const MatrixXd& b) { return times(toComplex(a), toComplex(b)).real(); }
MatrixXd transposed(const MatrixXd& a) { return a.transpose(); }
MatrixXcd adjoint(const MatrixXcd& a) { return a.adjoint(); }
MatrixXd diagonal(const VectorXd& d) { return d.asDiagonal(); }
MatrixXcd diagonal(const VectorXcd& d) { return d.asDiagonal(); }
double distance(const MatrixXcd& a, const MatrixXcd& b) { return (a - b).norm(); }
double distance(const MatrixXd& a, const MatrixXd& b) { return (a - b).norm(); }
MatrixXd one(int n) { return MatrixXd::Identity(n, n); }

MatrixXcd complexGeneral() {
  return toComplex(general()) + Complex(0.0, 1.0) * toComplex(transposed(general()));
}
MatrixXd symmetric() { return general() + transposed(general()) - 3.0 * one(size); }
MatrixXd positive() { return times(general(), transposed(general())); }
VectorXd rightSide() { return VectorXd::LinSpaced(size, -1.0, 2.0); }

TEST(LinearAlgebra, SymmetricEigenvectorsDiagonalise) {
  const SymmetricEigen e = symmetricEigen(symmetric());
  EXPECT_LT(distance(times(symmetric(), e.vectors), times(e.vectors, diagonal(e.values))), algebra_round_off);
  EXPECT_LT(distance(times(transposed(e.vectors), e.vectors), one(size)), algebra_round_off);
  EXPECT_LT(e.values(0), 0.0) << "indefinite, so that the order is seen";
  for (int i = 1; i < size; ++i) EXPECT_GE(e.values(i), e.values(i - 1));
  const MatrixXcd h = complexGeneral() + adjoint(complexGeneral());
  ASSERT_GT(h.imag().norm(), 1.0);
  const HermitianEigen c = hermitianEigen(h);
  EXPECT_LT(distance(times(h, c.vectors), times(c.vectors, toComplex(diagonal(c.values)))),
            algebra_round_off);
}

TEST(LinearAlgebra, GeneralizedEigenvectorsDiagonaliseBoth) {
  const SymmetricEigen e = generalizedSymmetricEigen(symmetric(), positive());
  EXPECT_LT(distance(times(symmetric(), e.vectors), times(times(positive(), e.vectors), diagonal(e.values))),
            algebra_round_off);
  EXPECT_LT(distance(times(transposed(e.vectors), times(positive(), e.vectors)), one(size)),
            algebra_round_off);
  EXPECT_LT((generalizedSymmetricEigenvalues(symmetric(), positive()) - e.values).norm(), algebra_round_off);
}

TEST(LinearAlgebra, GeneralEigenvectorsAndTheSchurForm) {
  const MatrixXcd a = toComplex(general());
  const GeneralEigen e = generalEigen(general());
  ASSERT_TRUE(e.converged);
  EXPECT_GT(e.values.imag().cwiseAbs().maxCoeff(), 0.1) << "a pair, so that complex vectors are seen";
  EXPECT_LT(distance(times(a, e.vectors), times(e.vectors, diagonal(e.values))), algebra_round_off);
  EXPECT_LT((generalEigenvalues(general()) - e.values).norm(), algebra_round_off);
  const SchurForm s = complexSchur(general());
  EXPECT_LT(distance(times(s.u, times(s.t, adjoint(s.u))), a), algebra_round_off);
  EXPECT_LT(distance(times(adjoint(s.u), s.u), toComplex(one(size))), algebra_round_off);
  for (int i = 0; i < size; ++i)
    for (int j = 0; j < i; ++j) EXPECT_EQ(std::abs(s.t(i, j)), 0.0);
}

TEST(LinearAlgebra, SingularValuesRebuildTheMatrix) {
  const SingularValues s = squareSvd(general());
  EXPECT_LT(distance(times(times(s.u, diagonal(s.sigma)), transposed(s.v)), general()), algebra_round_off);
  EXPECT_LT(distance(times(transposed(s.u), s.u), one(size)), algebra_round_off);
  EXPECT_LT(distance(times(transposed(s.v), s.v), one(size)), algebra_round_off);
  for (int i = 1; i < size; ++i) EXPECT_LE(s.sigma(i), s.sigma(i - 1));
  EXPECT_NEAR(spectralNorm(toComplex(general())), s.sigma(0), algebra_round_off);
  EXPECT_NEAR(spectralNorm(Complex(0.0, 2.0) * toComplex(general())), 2.0 * s.sigma(0), algebra_round_off);
  EXPECT_EQ(spectralNorm(MatrixXcd()), 0.0);
}

TEST(LinearAlgebra, LinearSystemsAreSolved) {
  const MatrixXd a = general();
  const VectorXd b = rightSide();
  EXPECT_LT(distance(times(a, solveLu(a, b)), MatrixXd(b)), algebra_round_off);
  EXPECT_LT(distance(times(a, solveFullPivoting(a, b)), MatrixXd(b)), algebra_round_off);
  EXPECT_LT(distance(times(a, solveFullPivotingColumns(a, positive())), positive()), algebra_round_off);
  EXPECT_LT(distance(times(a, inverse(a)), one(size)), algebra_round_off);
  const MatrixXcd c = complexGeneral();
  const VectorXcd d = b.cast<Complex>() * Complex(1.0, 0.5);
  EXPECT_LT(distance(times(c, solveLu(c, d)), MatrixXcd(d)), algebra_round_off);
  EXPECT_LT(distance(times(c, solveLuColumns(c, toComplex(a))), toComplex(a)), algebra_round_off);
}

TEST(LinearAlgebra, SymmetricFactors) {
  const MatrixXd s = symmetric(), p = positive();
  const VectorXd b = rightSide();
  EXPECT_LT(distance(times(s, Ldlt(s).solve(b)), MatrixXd(b)), algebra_round_off);
  EXPECT_LT(distance(times(p, Ldlt(p).solveColumns(s)), s), algebra_round_off);
  // the product of the pivots is the determinant, which no permutation of both sides changes
  EXPECT_NEAR(Ldlt(p).pivots().prod() / symmetricEigen(p).values.prod(), 1.0, algebra_round_off);
  const auto factor = choleskyFactor(p);
  ASSERT_TRUE(factor.has_value());
  EXPECT_LT(distance(times(*factor, transposed(*factor)), p), algebra_round_off);
  for (int i = 0; i < size; ++i)
    for (int j = i + 1; j < size; ++j) EXPECT_EQ((*factor)(i, j), 0.0);
  EXPECT_FALSE(choleskyFactor(s).has_value()) << "indefinite";
  const MatrixXcd h = times(complexGeneral(), adjoint(complexGeneral()));
  const HermitianLdlt hermitian(h);
  ASSERT_TRUE(hermitian.succeeded());
  const VectorXcd d = b.cast<Complex>() * Complex(1.0, 0.5);
  EXPECT_LT(distance(times(h, hermitian.solve(d)), MatrixXcd(d)), algebra_round_off);
  EXPECT_GT(hermitian.pivots().minCoeff(), 0.0);
}

TEST(LinearAlgebra, WhatAMatrixLeavesFree) {
  const MatrixXd few = general().leftCols(3);
  const MatrixXd free = orthogonalComplement(few);
  ASSERT_EQ(free.cols(), size - 3);
  EXPECT_LT(times(transposed(few), free).norm(), algebra_round_off);
  EXPECT_LT(distance(times(transposed(free), free), one(size - 3)), algebra_round_off);
  const MatrixXd wide = general().topRows(size - 1);
  const VectorXd zero = nullVector(wide);
  EXPECT_GT(zero.norm(), 0.1);
  EXPECT_LT(times(wide, zero).norm(), algebra_round_off * zero.norm());
  // what least squares leaves stands on the columns
  const MatrixXd left = rightSide() - times(few, leastSquares(few, rightSide()));
  EXPECT_GT(left.norm(), 0.1);
  EXPECT_LT(times(transposed(few), left).norm(), algebra_round_off);
}

TEST(LinearAlgebra, TheExponentialIsThatOfTheEigenvalues) {
  // A = V D V^-1 with a pair -a +- iw as a block of D: exp(A) = V exp(D) V^-1, exp of the block is e^-a (cos w, -+sin w)
  const double w = 2.3, a = 0.7;
  const VectorXd rates = VectorXd::LinSpaced(size, -3.0, 1.0);
  MatrixXd block = diagonal(rates), grown = MatrixXd::Zero(size, size);
  for (int i = 2; i < size; ++i) grown(i, i) = std::exp(block(i, i));
  block(0, 0) = block(1, 1) = -a;
  block(1, 0) = w, block(0, 1) = -w;
  grown(0, 0) = grown(1, 1) = std::exp(-a) * std::cos(w);
  grown(1, 0) = std::exp(-a) * std::sin(w), grown(0, 1) = -grown(1, 0);
  const MatrixXd v = general(), back = inverse(general());
  EXPECT_LT(distance(matrixExponential(times(times(v, block), back)), times(times(v, grown), back)), algebra_round_off);
  EXPECT_LT(distance(matrixExponential(MatrixXd::Zero(size, size)), one(size)), algebra_round_off);
  // large: scaled and squared. Half of it twice is all of it
  const MatrixXd half = matrixExponential(-20.0 * one(size) + 10.0 * times(times(v, block), back));
  const MatrixXd whole = matrixExponential(-40.0 * one(size) + 20.0 * times(times(v, block), back));
  // round-off grows with the exponent's size (some 100) and the vectors' condition (below 1e3)
  EXPECT_LT(distance(times(half, half), whole), 1e-9 * whole.norm());
  EXPECT_GT(whole.norm(), 0.0);
}

}  // namespace
}  // namespace amb_rotor
