#include "amb_rotor/common/linear_algebra.hpp"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <Eigen/QR>
#include <unsupported/Eigen/MatrixFunctions>

namespace amb_rotor {

using Eigen::MatrixXcd;
using Eigen::MatrixXd;
using Eigen::VectorXcd;
using Eigen::VectorXd;

VectorXd solveLu(const MatrixXd& a, const VectorXd& b) { return a.partialPivLu().solve(b); }

VectorXcd solveLu(const MatrixXcd& a, const VectorXcd& b) { return a.partialPivLu().solve(b); }

MatrixXcd solveLuColumns(const MatrixXcd& a, const MatrixXcd& b) { return a.partialPivLu().solve(b); }

MatrixXd inverse(const MatrixXd& a) { return a.inverse(); }

MatrixXd matrixExponential(const MatrixXd& a) { return a.exp(); }

VectorXd solveFullPivoting(const MatrixXd& a, const VectorXd& b) { return a.fullPivLu().solve(b); }

MatrixXd solveFullPivotingColumns(const MatrixXd& a, const MatrixXd& b) { return a.fullPivLu().solve(b); }

VectorXd nullVector(const MatrixXd& a) { return a.fullPivLu().kernel().col(0); }

MatrixXd orthogonalComplement(const MatrixXd& a) {
  const Eigen::HouseholderQR<MatrixXd> qr(a);
  const MatrixXd q = qr.householderQ();
  return q.rightCols(a.rows() - a.cols());
}

VectorXd leastSquares(const MatrixXd& a, const VectorXd& b) { return a.colPivHouseholderQr().solve(b); }

std::optional<MatrixXd> choleskyFactor(const MatrixXd& p) {
  const Eigen::LLT<MatrixXd> factor(p);
  if (factor.info() != Eigen::Success) return std::nullopt;
  return MatrixXd(factor.matrixL());
}

struct Ldlt::Factor {
  Eigen::LDLT<MatrixXd> of;
};

Ldlt::Ldlt(const MatrixXd& s) : factor_(new Factor{Eigen::LDLT<MatrixXd>(s)}) {}

VectorXd Ldlt::solve(const VectorXd& b) const { return factor_->of.solve(b); }

MatrixXd Ldlt::solveColumns(const MatrixXd& b) const { return factor_->of.solve(b); }

VectorXd Ldlt::pivots() const { return factor_->of.vectorD(); }

struct HermitianLdlt::Factor {
  Eigen::LDLT<MatrixXcd> of;
};

HermitianLdlt::HermitianLdlt(const MatrixXcd& h) : factor_(new Factor{Eigen::LDLT<MatrixXcd>(h)}) {}

bool HermitianLdlt::succeeded() const { return factor_->of.info() == Eigen::Success; }

VectorXcd HermitianLdlt::solve(const VectorXcd& b) const { return factor_->of.solve(b); }

VectorXd HermitianLdlt::pivots() const { return factor_->of.vectorD().real(); }

}  // namespace amb_rotor
