#pragma once
// Products of a full matrix with a vector, by the widest instructions that this processor has: Eigen's own
// are compiled for the oldest. Matrices are column-major, as Eigen's are; sums are in another order from set
// to set, so results differ by round-off between processors.
#include <Eigen/Core>

namespace amb_rotor {

/// y = A x (add: y += A x) for `columns` columns of `rows` numbers that follow each other from `a` on.
void product(const double* a, Eigen::Index rows, Eigen::Index columns, const double* x, double* y, bool add);

/// Of a matrix that is kept whole (Eigen's own, or one of common/aligned_matrix.hpp).
template <class Matrix>
void product(const Matrix& a, const Eigen::VectorXd& x, Eigen::VectorXd& y) {
  product(a.data(), a.rows(), a.cols(), x.data(), y.data(), false);
}

/// One function a set; product() takes the best that runs.
using DenseProduct = void (*)(const double*, Eigen::Index, Eigen::Index, const double*, double*, bool);
DenseProduct denseProductBaseline();
DenseProduct denseProductAvx2();    ///< null: not in this build
DenseProduct denseProductAvx512();  ///< likewise

}  // namespace amb_rotor
