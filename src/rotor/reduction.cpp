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

/// What the bending modes are to forces and displacements at planes.
struct PositionBalance {
  FreeModes modes;
  Eigen::VectorXd damping;     ///< of the bending modes [1/s]
  Eigen::VectorXd sigma;       ///< position singular values [m/N], falling
  Eigen::MatrixXd directions;  ///< in the bending modes, a column for each
};

/// Share of the largest singular value below which a direction is round-off.
constexpr double weakest_share = 1e-12;

/// L with L L^T = G. Rows and columns are brought to one size first, so that what is weakly driven keeps its digits.
Eigen::MatrixXd gramianRoot(const Eigen::MatrixXd& gramian) {
  const Eigen::VectorXd size = gramian.diagonal().cwiseMax(0.0).cwiseSqrt();
  const Eigen::VectorXd scale = (size.array() > 0.0).select(size.cwiseInverse(), 0.0);
  const SymmetricEigen eigen = symmetricEigen(scale.asDiagonal() * gramian * scale.asDiagonal());
  return size.asDiagonal() * eigen.vectors * eigen.values.cwiseMax(0.0).cwiseSqrt().asDiagonal();
}

/// Orthonormal columns with the same span, of columns that are independent.
Eigen::MatrixXd orthonormalColumns(const Eigen::MatrixXd& columns) {
  const Eigen::MatrixXd even = columns * columns.colwise().norm().cwiseInverse().asDiagonal();
  const SymmetricEigen gram = symmetricEigen(even.transpose() * even);
  return even * gram.vectors * gram.values.cwiseSqrt().cwiseInverse().asDiagonal();
}

PositionBalance positionBalance(const FlexibleRotor& rotor, const std::vector<double>& planes) {
  PositionBalance balance;
  balance.modes = freeModes(rotor);
  const Eigen::Index n = rotor.freedoms() - 2;
  const Eigen::VectorXd w2 = balance.modes.frequency.tail(n).cwiseAbs2();
  balance.damping = rotorOf(rotor, balance.modes.vectors, balance.modes.frequency).damping.tail(n);
  const Eigen::VectorXd& d = balance.damping;
  if (!(d.minCoeff() > 0.0)) {
    throw InputError({{"", 0, "damping", std::to_string(d.minCoeff()),
                       "above 0 1/s in each bending mode: a mode without damping has no Gramian, so it cannot be balanced"}});
  }
  Eigen::MatrixXd shapes(planes.size(), n);
  for (std::size_t p = 0; p < planes.size(); ++p)
    shapes.row(p) = rotor.grid().displacementShape(planes[p]).transpose() * balance.modes.vectors.rightCols(n);
  Eigen::MatrixXd control = shapes.transpose() * shapes, observe(n, n);
  for (Eigen::Index i = 0; i < n; ++i) {
    for (Eigen::Index j = 0; j < n; ++j) {
      const double sum = d(i) + d(j), apart = w2(i) - w2(j);
      control(i, j) *= sum / (sum * (d(i) * w2(j) + d(j) * w2(i)) + apart * apart);
      observe(i, j) = control(i, j) * (d(i) * d(j) + (d(i) * w2(i) + d(j) * w2(j)) / sum);
    }
  }
  const Eigen::MatrixXd driven = gramianRoot(control);
  const SingularValues product = squareSvd(gramianRoot(observe).transpose() * driven);
  balance.sigma = product.sigma;
  balance.directions = driven * product.v;
  return balance;
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

Eigen::VectorXd positionSingularValues(const FlexibleRotor& rotor, const std::vector<double>& planes) {
  return positionBalance(rotor, planes).sigma;
}

ReducedRotor reduceBalanced(const FlexibleRotor& rotor, const std::vector<double>& planes, int modes) {
  const PositionBalance balance = positionBalance(rotor, planes);
  const double least = weakest_share * balance.sigma(0);
  const int most = 2 + static_cast<int>((balance.sigma.array() > least).count());
  if (modes < 2 || modes > most) {
    throw InputError({{"", 0, "modes", std::to_string(modes),
                       "from 2 (rigid) to " + std::to_string(most) + ", which is all that the planes drive and see"}});
  }
  if (modes == 2) return reduceModal(rotor, 2);  // nothing bends
  const Eigen::Index bending = modes - 2;
  const Eigen::VectorXd all = balance.modes.frequency.tail(balance.modes.frequency.size() - 2);
  const Eigen::MatrixXd span = orthonormalColumns(balance.directions.leftCols(bending));
  const SymmetricEigen diagonal = symmetricEigen(span.transpose() * all.cwiseAbs2().asDiagonal() * span);
  const Eigen::MatrixXd shares = span * diagonal.vectors;  // of the free modes in those kept: orthonormal columns
  Eigen::MatrixXd vectors(rotor.freedoms(), modes);
  vectors << balance.modes.vectors.leftCols(2), balance.modes.vectors.rightCols(all.size()) * shares;
  Eigen::VectorXd frequency = Eigen::VectorXd::Zero(modes);
  frequency.tail(bending) = diagonal.values.cwiseMax(0.0).cwiseSqrt();
  ReducedRotor reduced = rotorOf(rotor, vectors, frequency);
  reduced.damping.tail(bending) = shares.cwiseAbs2().transpose() * balance.damping;
  return reduced;
}

}  // namespace amb_rotor
