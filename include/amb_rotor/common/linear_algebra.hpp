#pragma once
// Dense decompositions of matrices whose size is known at run time, compiled once: Eigen's templates for them
// cost five to twenty seconds in each file that instantiates them. Symbols: A any matrix, S symmetric (H
// Hermitian), P positive definite. What is symmetric is read from its lower triangle. Nothing here has a
// unit: an argument's unit goes through.
//
// Not for loops over small matrices of a fixed size (3 x 3 and the like): those stay with Eigen's own,
// inline. Source: Golub and Van Loan, Matrix Computations; the algorithms are Eigen 3.4's of the same name.
#include <Eigen/Core>
#include <complex>
#include <memory>
#include <optional>

namespace amb_rotor {

/// S x = lambda x, or S x = lambda P x: eigenvalues rise; the vectors are columns, orthonormal (with P: X^T P
/// X = 1).
struct SymmetricEigen {
  Eigen::VectorXd values;
  Eigen::MatrixXd vectors;
};
struct HermitianEigen {
  Eigen::VectorXd values;
  Eigen::MatrixXcd vectors;
};
SymmetricEigen symmetricEigen(const Eigen::MatrixXd& s);
HermitianEigen hermitianEigen(const Eigen::MatrixXcd& h);
SymmetricEigen generalizedSymmetricEigen(const Eigen::MatrixXd& s, const Eigen::MatrixXd& p);
Eigen::VectorXd generalizedSymmetricEigenvalues(const Eigen::MatrixXd& s, const Eigen::MatrixXd& p);

/// A x = lambda x: conjugate pairs side by side, in no other order; columns of length 1.
struct GeneralEigen {
  Eigen::VectorXcd values;
  Eigen::MatrixXcd vectors;
  bool converged = false;
};
GeneralEigen generalEigen(const Eigen::MatrixXd& a);
Eigen::VectorXcd generalEigenvalues(const Eigen::MatrixXd& a);

/// A = U T U^H, T upper triangular, U unitary.
struct SchurForm {
  Eigen::MatrixXcd t, u;
};
SchurForm complexSchur(const Eigen::MatrixXd& a);

/// A = U diag(sigma) V^T of a square matrix by Jacobi's rotations without a preconditioner, which keep small
/// singular values accurate; they fall.
struct SingularValues {
  Eigen::MatrixXd u;
  Eigen::VectorXd sigma;
  Eigen::MatrixXd v;
};
SingularValues squareSvd(const Eigen::MatrixXd& a);
/// The largest singular value, as the root of the largest eigenvalue of A^H A: to round-off, for that one.
double spectralNorm(const Eigen::MatrixXcd& a);

/// A x = b by LU with partial pivoting: A square and not singular.
Eigen::VectorXd solveLu(const Eigen::MatrixXd& a, const Eigen::VectorXd& b);
Eigen::VectorXcd solveLu(const Eigen::MatrixXcd& a, const Eigen::VectorXcd& b);
Eigen::MatrixXcd solveLuColumns(const Eigen::MatrixXcd& a, const Eigen::MatrixXcd& b);
Eigen::MatrixXd inverse(const Eigen::MatrixXd& a);
/// exp(A) of a square matrix, by Pade approximants after scaling (Higham 2005).
Eigen::MatrixXd matrixExponential(const Eigen::MatrixXd& a);
/// With complete pivoting: for matrices whose rows and columns differ in size by orders, or that may be
/// singular.
Eigen::VectorXd solveFullPivoting(const Eigen::MatrixXd& a, const Eigen::VectorXd& b);
Eigen::MatrixXd solveFullPivotingColumns(const Eigen::MatrixXd& a, const Eigen::MatrixXd& b);
/// A vector that A takes to zero (A with fewer rows than columns, or of less than full rank).
Eigen::VectorXd nullVector(const Eigen::MatrixXd& a);

/// Orthonormal columns that span what A^T x = 0 leaves free: n x (n - m) of an n x m matrix of rank m < n.
Eigen::MatrixXd orthogonalComplement(const Eigen::MatrixXd& a);
/// min |A x - b|, columns pivoted.
Eigen::VectorXd leastSquares(const Eigen::MatrixXd& a, const Eigen::VectorXd& b);

/// P = L L^T; nothing where the matrix is not positive definite.
std::optional<Eigen::MatrixXd> choleskyFactor(const Eigen::MatrixXd& p);

/// S = L D L^T with pivots taken along the diagonal: for curvatures that are positive but for round-off. The
/// solutions hold NaN or infinity where S is singular; nothing throws.
class Ldlt {
 public:
  explicit Ldlt(const Eigen::MatrixXd& s);
  Eigen::VectorXd solve(const Eigen::VectorXd& b) const;
  Eigen::MatrixXd solveColumns(const Eigen::MatrixXd& b) const;
  /// The diagonal of D, in the order in which the pivots were taken.
  Eigen::VectorXd pivots() const;

 private:
  struct Factor;
  std::shared_ptr<const Factor> factor_;
};

/// The same of a Hermitian matrix.
class HermitianLdlt {
 public:
  explicit HermitianLdlt(const Eigen::MatrixXcd& h);
  bool succeeded() const;
  Eigen::VectorXcd solve(const Eigen::VectorXcd& b) const;
  Eigen::VectorXd pivots() const;

 private:
  struct Factor;
  std::shared_ptr<const Factor> factor_;
};

}  // namespace amb_rotor
