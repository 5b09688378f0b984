#include "amb_rotor/rotor/balanced_truncation.hpp"

#include <cmath>
#include <string>

#include "amb_rotor/common/error.hpp"
#include "amb_rotor/common/linear_algebra.hpp"

namespace amb_rotor {
namespace {

using Complex = std::complex<double>;

/// L with L L^T = P for a P that is positive but for round-off.
Eigen::MatrixXd squareRoot(const Eigen::MatrixXd& gramian) {
  const SymmetricEigen eigen = symmetricEigen(0.5 * (gramian + gramian.transpose()));
  return eigen.vectors * eigen.values.cwiseMax(0.0).cwiseSqrt().asDiagonal();
}

struct Roots {
  Eigen::MatrixXd controllable;
  Eigen::MatrixXd observable;
  SingularValues product;
};

Roots rootsOf(const StateSpace& system) {
  Roots roots;
  roots.controllable = squareRoot(solveLyapunov(system.a, system.b * system.b.transpose()));
  roots.observable = squareRoot(solveLyapunov(system.a.transpose(), system.c.transpose() * system.c));
  roots.product = squareSvd(roots.observable.transpose() * roots.controllable);
  return roots;
}

}  // namespace

Eigen::MatrixXcd StateSpace::transfer(Complex s) const {
  Eigen::MatrixXcd resolvent = -a.cast<Complex>();
  resolvent.diagonal().array() += s;
  return c.cast<Complex>() * solveLuColumns(resolvent, b.cast<Complex>());
}

StateSpace rotorStateSpace(const ReducedRotor& rotor, const std::vector<RotorSupport>& supports, double speed,
                           const std::vector<double>& z_in, const std::vector<double>& z_out,
                           bool both_planes) {
  const int n = rotor.modes;
  const int planes = both_planes ? 2 : 1;
  const int size = planes * n;
  const SupportedMatrices matrices = supportedMatrices(rotor, supports, speed);
  const ScaledState state =
      scaledState(matrices.damping.topLeftCorner(size, size), matrices.stiffness.topLeftCorner(size, size));
  StateSpace system;
  system.a = state.a;
  system.b = Eigen::MatrixXd::Zero(2 * size, planes * static_cast<Eigen::Index>(z_in.size()));
  system.c = Eigen::MatrixXd::Zero(planes * static_cast<Eigen::Index>(z_out.size()), 2 * size);
  for (int plane = 0; plane < planes; ++plane) {
    for (std::size_t i = 0; i < z_in.size(); ++i) {
      system.b.block(size + plane * n, plane * z_in.size() + i, n, 1) = rotor.shape(z_in[i]);
    }
    for (std::size_t i = 0; i < z_out.size(); ++i) {
      system.c.block(plane * z_out.size() + i, plane * n, 1, n) =
          rotor.shape(z_out[i]).cwiseQuotient(state.scale.segment(plane * n, n)).transpose();
    }
  }
  return system;
}

Eigen::MatrixXd solveLyapunov(const Eigen::MatrixXd& a, const Eigen::MatrixXd& r) {
  const Eigen::Index n = a.rows();
  const SchurForm schur = complexSchur(a);
  const Eigen::MatrixXcd& t = schur.t;
  const Eigen::MatrixXcd& u = schur.u;
  const double slowest = t.diagonal().real().maxCoeff();
  if (!(slowest < 0.0)) {
    throw InputError({{"", 0, "eigenvalue real part", std::to_string(slowest),
                       "below 0 1/s: Gramians need a stable system (supports and damping in each mode)"}});
  }
  Eigen::MatrixXcd y = -(u.adjoint() * r.cast<Complex>() * u);
  for (Eigen::Index k = n; k-- > 0;) {
    const Eigen::Index later = n - k - 1;
    if (later > 0) y.col(k) -= y.rightCols(later) * t.row(k).tail(later).adjoint();
    Eigen::MatrixXcd shifted = t;
    shifted.diagonal().array() += std::conj(t(k, k));
    shifted.triangularView<Eigen::Upper>().solveInPlace(y.col(k));
  }
  const Eigen::MatrixXd x = (u * y * u.adjoint()).real();
  return 0.5 * (x + x.transpose());
}

Eigen::VectorXd hankelSingularValues(const StateSpace& system) {
  return rootsOf(system).product.sigma;
}

BalancedSystem balancedTruncation(const StateSpace& system, int order) {
  if (order < 1 || order > system.a.rows()) {
    throw InputError(
        {{"", 0, "order", std::to_string(order), "from 1 to " + std::to_string(system.a.rows())}});
  }
  const Roots roots = rootsOf(system);
  BalancedSystem result;
  result.hankel = roots.product.sigma;
  if (!(result.hankel(order - 1) > 0.0)) {
    throw InputError({{"", 0, "order", std::to_string(order), "not above the order of a minimal system"}});
  }
  const Eigen::VectorXd weight = result.hankel.head(order).cwiseSqrt().cwiseInverse();
  const Eigen::MatrixXd right =
      roots.controllable * roots.product.v.leftCols(order) * weight.asDiagonal();
  const Eigen::MatrixXd left =
      roots.observable * roots.product.u.leftCols(order) * weight.asDiagonal();
  result.system.a = left.transpose() * system.a * right;
  result.system.b = left.transpose() * system.b;
  result.system.c = system.c * right;
  result.error_bound = 2.0 * result.hankel.tail(result.hankel.size() - order).sum();
  return result;
}

}  // namespace amb_rotor
