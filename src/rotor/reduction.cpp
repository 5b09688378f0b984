#include "amb_rotor/rotor/reduction.hpp"

#include <algorithm>
#include <cmath>
#include <string>

#include "amb_rotor/common/error.hpp"
#include "amb_rotor/common/linear_algebra.hpp"

namespace amb_rotor {
namespace {

/// Fills all but the shapes from M-normalised shapes whose first two are the rigid motions.
ReducedRotor rotorOf(const FlexibleRotor& rotor, const Eigen::MatrixXd& vectors,
                     const Eigen::VectorXd& frequency) {
  ReducedRotor reduced;
  reduced.modes = static_cast<int>(vectors.cols());
  reduced.modal_mass = Eigen::VectorXd::Ones(reduced.modes);
  reduced.stiffness = frequency.cwiseAbs2();
  reduced.damping = Eigen::VectorXd::Constant(reduced.modes, rotor.shaftDamping().mass_proportional) +
                    rotor.shaftDamping().stiffness_proportional * reduced.stiffness;
  for (int i = 2; i < reduced.modes; ++i) {
    reduced.damping(i) += 2.0 * modalRatio(rotor.shaftDamping(), i - 2) * frequency(i);
  }
  const Eigen::MatrixXd gyroscopic = vectors.transpose() * rotor.gyroscopic() * vectors;
  reduced.gyroscopic = 0.5 * (gyroscopic + gyroscopic.transpose());
  reduced.inertia = rotor.inertia();
  reduced.grid = rotor.grid();
  reduced.vectors = vectors;
  return reduced;
}

void checkPlanes(const FlexibleRotor& rotor, const std::vector<double>& planes, int held_modes) {
  std::vector<double> sorted = planes;
  std::sort(sorted.begin(), sorted.end());
  const bool same = std::adjacent_find(sorted.begin(), sorted.end(),
                                       [](double a, double b) { return b - a < 1e-6; }) != sorted.end();
  if (planes.size() < 2 || same) {
    throw InputError({{"", 0, "planes", std::to_string(planes.size()),
                       "two or more planes, at least 1e-6 m apart, to hold the rotor"}});
  }
  const int free = rotor.freedoms() - static_cast<int>(planes.size());
  if (held_modes < 0 || held_modes > free) {
    throw InputError(
        {{"", 0, "held_modes", std::to_string(held_modes), "from 0 to " + std::to_string(free)}});
  }
}

/// Static shapes with displacement 1 at one plane and 0 at the others: K psi = B^T lambda, B psi = unit.
Eigen::MatrixXd constraintShapes(const Eigen::MatrixXd& stiffness, const Eigen::MatrixXd& constraints) {
  const Eigen::Index n = stiffness.rows();
  const Eigen::Index p = constraints.rows();
  // The multipliers are scaled to the size of K, so that the pivoting compares like with like.
  const double scale = stiffness.diagonal().maxCoeff();
  Eigen::MatrixXd system = Eigen::MatrixXd::Zero(n + p, n + p);
  system.topLeftCorner(n, n) = stiffness / scale;
  system.topRightCorner(n, p) = constraints.transpose();
  system.bottomLeftCorner(p, n) = constraints;
  Eigen::MatrixXd right = Eigen::MatrixXd::Zero(n + p, p);
  right.bottomRows(p).setIdentity();
  return solveFullPivotingColumns(system, right).topRows(n);
}

}  // namespace

Eigen::VectorXd ReducedRotor::shape(double z) const {
  return vectors.transpose() * grid.displacementShape(z);
}

Eigen::VectorXd ReducedRotor::rotation(double z) const { return vectors.transpose() * grid.rotationShape(z); }

ReducedRotor reduceModal(const FlexibleRotor& rotor, int modes) {
  if (modes < 2 || modes > rotor.freedoms()) {
    throw InputError({{"", 0, "modes", std::to_string(modes),
                       "from 2 (rigid) to " + std::to_string(rotor.freedoms()) + " (all)"}});
  }
  const FreeModes free = freeModes(rotor);
  return rotorOf(rotor, free.vectors.leftCols(modes), free.frequency.head(modes));
}

ReducedRotor allModes(const FlexibleRotor& rotor) { return reduceModal(rotor, rotor.freedoms()); }

ReducedRotor reduceCraigBampton(const FlexibleRotor& rotor, const std::vector<double>& planes,
                                int held_modes) {
  checkPlanes(rotor, planes, held_modes);
  const Eigen::Index n = rotor.freedoms();
  const Eigen::Index p = static_cast<Eigen::Index>(planes.size());
  Eigen::MatrixXd constraints(p, n);
  for (Eigen::Index i = 0; i < p; ++i) {
    constraints.row(i) = rotor.grid().displacementShape(planes[i]).transpose();
  }
  const Eigen::MatrixXd held = orthogonalComplement(constraints.transpose());
  const SymmetricEigen inner = generalizedSymmetricEigen(
      held.transpose() * rotor.stiffness() * held, held.transpose() * rotor.mass() * held);

  // The static shapes span the rigid motions, which are put in exactly instead.
  const Eigen::MatrixXd rigid = rotor.rigidModes();
  Eigen::MatrixXd others(n, p + held_modes);
  others << constraintShapes(rotor.stiffness(), constraints),
      held * inner.vectors.leftCols(held_modes);
  // Columns of one length before the rigid part is taken out: what is rigid then leaves round-off, not a
  // column.
  const Eigen::VectorXd lengths = (others.transpose() * rotor.mass() * others).diagonal().cwiseSqrt();
  others = others * lengths.cwiseInverse().asDiagonal();
  others -= rigid * (rigid.transpose() * rotor.mass() * others);
  // The rest has rank p + held_modes - 2; an M-orthonormal basis of it comes from its Gram matrix.
  const Eigen::MatrixXd gram = others.transpose() * rotor.mass() * others;
  const SymmetricEigen rank = symmetricEigen(gram);
  const Eigen::Index bending = p + held_modes - 2;
  const Eigen::MatrixXd basis = others * rank.vectors.rightCols(bending) *
                                rank.values.tail(bending).cwiseSqrt().cwiseInverse().asDiagonal();
  const SymmetricEigen diagonal = generalizedSymmetricEigen(
      basis.transpose() * rotor.stiffness() * basis, basis.transpose() * rotor.mass() * basis);

  Eigen::MatrixXd vectors(n, bending + 2);
  vectors << rigid, basis * diagonal.vectors;
  Eigen::VectorXd frequency = Eigen::VectorXd::Zero(bending + 2);
  frequency.tail(bending) = diagonal.values.cwiseMax(0.0).cwiseSqrt();
  return rotorOf(rotor, vectors, frequency);
}

}  // namespace amb_rotor
