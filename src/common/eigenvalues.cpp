// Eigenvalues and singular values; linear_algebra.cpp has what solves for a right-hand side.
#include <Eigen/Eigenvalues>
#include <Eigen/SVD>
#include <algorithm>
#include <cmath>

#include "amb_rotor/common/complex_eigen.hpp"

namespace amb_rotor {

using Eigen::MatrixXcd;
using Eigen::MatrixXd;
using Eigen::VectorXcd;
using Eigen::VectorXd;

SymmetricEigen symmetricEigen(const MatrixXd& s) {
  const Eigen::SelfAdjointEigenSolver<MatrixXd> solver(s);
  return {solver.eigenvalues(), solver.eigenvectors()};
}

HermitianEigen hermitianEigen(const MatrixXcd& h) {
  const Eigen::SelfAdjointEigenSolver<MatrixXcd> solver(h);
  return {solver.eigenvalues(), solver.eigenvectors()};
}

SymmetricEigen generalizedSymmetricEigen(const MatrixXd& s, const MatrixXd& p) {
  const Eigen::GeneralizedSelfAdjointEigenSolver<MatrixXd> solver(s, p);
  return {solver.eigenvalues(), solver.eigenvectors()};
}

VectorXd generalizedSymmetricEigenvalues(const MatrixXd& s, const MatrixXd& p) {
  return Eigen::GeneralizedSelfAdjointEigenSolver<MatrixXd>(s, p, Eigen::EigenvaluesOnly).eigenvalues();
}

GeneralEigen generalEigen(const MatrixXd& a) {
  Eigen::EigenSolver<MatrixXd> solver(a);
  // a rotor that turns slowly has its eigenvalues in close pairs: Francis's iteration may take its 40 passes a row and
  // want more
  if (solver.info() == Eigen::NoConvergence) {
    solver.setMaxIterations(static_cast<Eigen::Index>(4000) * a.rows());
    solver.compute(a);
  }
  return {solver.eigenvalues(), solver.eigenvectors(), solver.info() == Eigen::Success};
}

GeneralEigen complexEigen(const MatrixXcd& a) {
  const Eigen::ComplexEigenSolver<MatrixXcd> solver(a);
  return {solver.eigenvalues(), solver.eigenvectors(), solver.info() == Eigen::Success};
}

VectorXcd generalEigenvalues(const MatrixXd& a) {
  return Eigen::EigenSolver<MatrixXd>(a, false).eigenvalues();
}

SchurForm complexSchur(const MatrixXd& a) {
  const Eigen::ComplexSchur<MatrixXd> schur(a);
  return {schur.matrixT(), schur.matrixU()};
}

SingularValues squareSvd(const MatrixXd& a) {
  const Eigen::JacobiSVD<MatrixXd, Eigen::NoQRPreconditioner> svd(a,
                                                                  Eigen::ComputeFullU | Eigen::ComputeFullV);
  return {svd.matrixU(), svd.singularValues(), svd.matrixV()};
}

double spectralNorm(const MatrixXcd& a) {
  if (a.size() == 0) return 0.0;
  const Eigen::SelfAdjointEigenSolver<MatrixXcd> solver(a.adjoint() * a, Eigen::EigenvaluesOnly);
  return std::sqrt(std::max(0.0, solver.eigenvalues().maxCoeff()));
}

}  // namespace amb_rotor
