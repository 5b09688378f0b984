#pragma once
// Eigenvalues of a complex matrix: linear_algebra.hpp's generalEigen() for coordinates x + j y. No units of its own.
// Source: Golub and Van Loan, Matrix Computations; Eigen 3.4's algorithm (complex Schur form).
#include "amb_rotor/common/linear_algebra.hpp"

namespace amb_rotor {

/// A x = lambda x: eigenvalues in no order and no pairs; columns of length 1.
GeneralEigen complexEigen(const Eigen::MatrixXcd& a);

}  // namespace amb_rotor
