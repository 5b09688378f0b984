#include "amb_rotor/rotor/rotor_modes.hpp"

#include <algorithm>
#include <cmath>
#include <string>

#include "amb_rotor/common/error.hpp"
#include "amb_rotor/common/linear_algebra.hpp"

namespace amb_rotor {
namespace {

using Complex = std::complex<double>;

/// A line within 0.1 %: far above round-off (1e-10), far below what an orbit plot shows.
constexpr double kPlanar = 1e-3;
/// Roots below this part of the model's highest frequency are zero: round-off of a double root.
constexpr double kZeroRoot = 1e-7;

Whirl whirlOf(double measure) {
  if (std::abs(measure) < kPlanar) return Whirl::planar;
  return measure > 0.0 ? Whirl::forward : Whirl::backward;
}

double whirlMeasure(const Eigen::VectorXcd& x, const Eigen::VectorXcd& y) {
  const double forward = (x + Complex(0.0, 1.0) * y).squaredNorm();
  const double backward = (x - Complex(0.0, 1.0) * y).squaredNorm();
  return (forward - backward) / (forward + backward);
}

enum class Plane { x, y, both };

/// Adds the modes of one block of equations; the block is one plane or both.
void addModes(const Eigen::MatrixXd& damping, const Eigen::MatrixXd& stiffness, Plane plane,
              RotorModes& modes) {
  const ScaledState state = scaledState(damping, stiffness);
  const Eigen::Index n = state.scale.size();
  const GeneralEigen eigen = generalEigen(state.a);
  AMB_ROTOR_CHECK(eigen.converged, "eigenvalues of the rotor did not converge");
  const double zero = kZeroRoot * state.scale.maxCoeff();
  for (Eigen::Index i = 0; i < 2 * n; ++i) {
    const Complex lambda = eigen.values(i);
    if (std::abs(lambda) < zero) {
      modes.real.push_back(0.0);
      continue;
    }
    if (lambda.imag() == 0.0) {
      modes.real.push_back(lambda.real());
      continue;
    }
    if (lambda.imag() < 0.0) continue;
    RotorMode mode;
    mode.eigenvalue = lambda;
    mode.natural_frequency = std::abs(lambda);
    mode.damped_frequency = lambda.imag();
    mode.damping_ratio = -lambda.real() / std::abs(lambda);
    const Eigen::VectorXcd amplitudes =
        (eigen.vectors.col(i).head(n).array() / state.scale.array().cast<Complex>()).matrix();
    const Eigen::VectorXcd nothing = Eigen::VectorXcd::Zero(n);
    mode.x = plane == Plane::both ? Eigen::VectorXcd(amplitudes.head(n / 2))
                                  : (plane == Plane::x ? amplitudes : nothing);
    mode.y = plane == Plane::both ? Eigen::VectorXcd(amplitudes.tail(n / 2))
                                  : (plane == Plane::y ? amplitudes : nothing);
    mode.whirl_measure = whirlMeasure(mode.x, mode.y);
    mode.whirl = whirlOf(mode.whirl_measure);
    modes.oscillating.push_back(std::move(mode));
  }
}

Eigen::MatrixXd gyroscopicBlock(const ReducedRotor& rotor) {
  const int n = rotor.modes;
  Eigen::MatrixXd block = Eigen::MatrixXd::Zero(2 * n, 2 * n);
  block.topRightCorner(n, n) = rotor.gyroscopic;
  block.bottomLeftCorner(n, n) = -rotor.gyroscopic;
  return block;
}

}  // namespace

RotorSupport isotropicSupport(double z, double stiffness, double damping) {
  return {z, stiffness * Eigen::Matrix2d::Identity(), damping * Eigen::Matrix2d::Identity()};
}

SupportedMatrices supportedMatrices(const ReducedRotor& rotor, const std::vector<RotorSupport>& supports,
                                    double speed) {
  const int n = rotor.modes;
  SupportedMatrices result;
  result.damping = speed * gyroscopicBlock(rotor);
  result.stiffness = Eigen::MatrixXd::Zero(2 * n, 2 * n);
  for (int plane = 0; plane < 2; ++plane) {
    result.damping.diagonal().segment(plane * n, n) += rotor.damping;
    result.stiffness.diagonal().segment(plane * n, n) += rotor.stiffness;
  }
  for (const RotorSupport& support : supports) {
    const Eigen::VectorXd shape = rotor.shape(support.z);
    const Eigen::MatrixXd at_plane = shape * shape.transpose();
    for (int row = 0; row < 2; ++row) {
      for (int column = 0; column < 2; ++column) {
        result.stiffness.block(row * n, column * n, n, n) += support.stiffness(row, column) * at_plane;
        result.damping.block(row * n, column * n, n, n) += support.damping(row, column) * at_plane;
      }
    }
  }
  return result;
}

ScaledState scaledState(const Eigen::MatrixXd& damping, const Eigen::MatrixXd& stiffness) {
  const Eigen::Index n = stiffness.rows();
  ScaledState state;
  const Eigen::VectorXd frequency = stiffness.diagonal().cwiseAbs().cwiseSqrt();
  // A coordinate without a spring needs some scale too: a millionth of the largest, or 1 rad/s.
  const double least = std::max(1e-6 * frequency.maxCoeff(), 1.0);
  state.scale = frequency.cwiseMax(least);
  state.a = Eigen::MatrixXd::Zero(2 * n, 2 * n);
  state.a.topRightCorner(n, n) = state.scale.asDiagonal();
  state.a.bottomLeftCorner(n, n) = -stiffness * state.scale.cwiseInverse().asDiagonal();
  state.a.bottomRightCorner(n, n) = -damping;
  return state;
}

RotorModes rotorModes(const ReducedRotor& rotor, const std::vector<RotorSupport>& supports, double speed) {
  const int n = rotor.modes;
  const SupportedMatrices matrices = supportedMatrices(rotor, supports, speed);
  RotorModes modes;
  modes.speed = speed;
  const auto coupled = [n](const Eigen::MatrixXd& matrix) {
    return !matrix.topRightCorner(n, n).isZero(0.0) || !matrix.bottomLeftCorner(n, n).isZero(0.0);
  };
  if (coupled(matrices.damping) || coupled(matrices.stiffness)) {
    addModes(matrices.damping, matrices.stiffness, Plane::both, modes);
  } else {
    addModes(matrices.damping.topLeftCorner(n, n), matrices.stiffness.topLeftCorner(n, n), Plane::x, modes);
    addModes(matrices.damping.bottomRightCorner(n, n), matrices.stiffness.bottomRightCorner(n, n), Plane::y,
             modes);
  }
  std::sort(modes.oscillating.begin(), modes.oscillating.end(),
            [](const RotorMode& a, const RotorMode& b) { return a.damped_frequency < b.damped_frequency; });
  std::sort(modes.real.begin(), modes.real.end());
  return modes;
}

Eigen::Vector2cd modeShape(const ReducedRotor& rotor, const RotorMode& mode, double z) {
  const Eigen::VectorXcd shape = rotor.shape(z).cast<Complex>();
  return {(shape.transpose() * mode.x)(0), (shape.transpose() * mode.y)(0)};
}

std::vector<RotorModes> campbell(const ReducedRotor& rotor, const std::vector<RotorSupport>& supports,
                                 const std::vector<double>& speeds) {
  std::vector<RotorModes> diagram;
  diagram.reserve(speeds.size());
  for (double speed : speeds) diagram.push_back(rotorModes(rotor, supports, speed));
  return diagram;
}

std::vector<CriticalSpeed> criticalSpeeds(const ReducedRotor& rotor,
                                          const std::vector<RotorSupport>& supports) {
  const SupportedMatrices matrices = supportedMatrices(rotor, supports, 0.0);
  const Eigen::MatrixXd& stiffness = matrices.stiffness;
  const bool symmetric = (stiffness - stiffness.transpose()).norm() <= 1e-12 * stiffness.norm();
  const std::optional<Eigen::MatrixXd> factor = choleskyFactor(stiffness);
  if (!symmetric || !factor) {
    throw InputError({{"", 0, "supports", std::to_string(supports.size()),
                       "symmetric springs that hold the rotor against shift and tilt"}});
  }
  // With K = L L^T the inverse squares of the speeds are eigenvalues of the Hermitian L^-1 (M - j Gam) L^-T.
  const int n = rotor.modes;
  Eigen::MatrixXcd inertia =
      Eigen::MatrixXcd::Identity(2 * n, 2 * n) - Complex(0.0, 1.0) * gyroscopicBlock(rotor).cast<Complex>();
  const Eigen::MatrixXcd lower = factor->cast<Complex>();
  lower.triangularView<Eigen::Lower>().solveInPlace(inertia);
  inertia.adjointInPlace();
  lower.triangularView<Eigen::Lower>().solveInPlace(inertia);
  const HermitianEigen eigen = hermitianEigen(0.5 * (inertia + inertia.adjoint()));
  const Eigen::MatrixXcd shapes = lower.adjoint().triangularView<Eigen::Upper>().solve(eigen.vectors);
  std::vector<CriticalSpeed> speeds;
  const double largest = eigen.values.cwiseAbs().maxCoeff();
  for (Eigen::Index i = 2 * n; i-- > 0;) {
    const double inverse_square = eigen.values(i);
    // Forward modes of a body with Ip > It have none: negative. What is round-off of zero is at infinity.
    if (inverse_square <= 1e-14 * largest) continue;
    const double measure = whirlMeasure(shapes.col(i).head(n), shapes.col(i).tail(n));
    speeds.push_back({1.0 / std::sqrt(inverse_square), whirlOf(measure), measure});
  }
  return speeds;
}

Eigen::Matrix2cd receptance(const ReducedRotor& rotor, const std::vector<RotorSupport>& supports,
                            double speed, double frequency, double z_out, double z_in) {
  const int n = rotor.modes;
  const SupportedMatrices matrices = supportedMatrices(rotor, supports, speed);
  Eigen::MatrixXcd dynamic =
      matrices.stiffness.cast<Complex>() + Complex(0.0, frequency) * matrices.damping.cast<Complex>();
  dynamic.diagonal().array() -= frequency * frequency;
  Eigen::MatrixXcd in = Eigen::MatrixXcd::Zero(2 * n, 2);
  Eigen::MatrixXcd out = Eigen::MatrixXcd::Zero(2 * n, 2);
  for (int plane = 0; plane < 2; ++plane) {
    in.block(plane * n, plane, n, 1) = rotor.shape(z_in).cast<Complex>();
    out.block(plane * n, plane, n, 1) = rotor.shape(z_out).cast<Complex>();
  }
  return out.transpose() * solveLuColumns(dynamic, in);
}

}  // namespace amb_rotor
