#pragma once
// Reduction of a flexible rotor to a few coordinates q per plane, diagonal but for the gyroscopic matrix:
//
//   m_i q_x,i'' + d_i q_x,i' + W sum_j G_ij q_y,j' + k_i q_x,i = phi_i(z) f_x      (W: spin, rad/s)
//   m_i q_y,i'' + d_i q_y,i' - W sum_j G_ij q_x,j' + k_i q_y,i = phi_i(z) f_y
//   x(z) = sum_i phi_i(z) q_x,i          z from the centre of gravity [m]
//
//   m_i = 1 (mass normalised), k_i = w_i^2 [1/s2], d_i [1/s], q [m kg^0.5], phi [kg^-0.5], G [-], symmetric.
//   phi_0 = 1/sqrt(m) and phi_1 = z/sqrt(It) are the exact rigid motions; k_0 = k_1 = 0.
//
// Four ways:
//  - modal: the lowest free-free modes. Static flexibility of the modes left out is lost.
//  - Craig-Bampton (Craig & Bampton 1968, AIAA J. 6, 1313): the displacements of the kept planes with their
//    static shapes, plus the lowest modes with those planes held; made diagonal again. A static force at a
//    kept plane bends the rotor exactly as in the full model.
//  - balanced: what the kept planes drive and see most (below), at any place and under any force used like the others.
//  - all modes: the full finite element rotor in the same form.
//
// Balanced truncation that keeps the rotor. At rest the free rotor is its two rigid motions, which have no Gramians
// and are kept exactly, beside stable bending modes i, driven and seen at the kept planes z_p:
//   a_ij = sum_p phi_i(z_p) phi_j(z_p),  s = d_i + d_j,
//   P_ij = a_ij s/(s (d_i w_j^2 + d_j w_i^2) + (w_i^2 - w_j^2)^2)      controllability of the displacements
//   Q_ij = P_ij (d_i d_j + (d_i w_i^2 + d_j w_j^2)/s)                  observability of the displacements
// the upper left blocks of the Gramians of balanced_truncation.hpp, in closed form: with S = [D 1; 1 0] S A is symmetric
// and S B = C^T, so the second Gramian is S (first) S. sigma_i = sqrt(eig_i(P Q)) [m/N] are the position singular values
// (Meyer & Srinivasan 1996, IEEE Trans. Autom. Control 41, 1632; Chahlaoui et al. 2006, Linear Algebra Appl. 415, 373);
// as the damping goes to zero each is one of a pair of Hankel singular values, phi^2/(4 zeta w^2). The directions of the
// largest span what is kept, and M, D, K, G are all projected on it from both sides alike: M and D stay positive, K
// not negative, so the reduced rotor is passive as the full one is, whatever the control and contact do to it. Unlike with
// two different projections there is no bound on its error; `amb reduce` measures it.
// Proportional damping stays diagonal; modal damping is given by the ratio of each bending mode kept. With
// Craig-Bampton the higher ones of these modes are not modes of the full rotor; they take the ratio of their
// number. Balanced ones take the mean of the modes' damping over their shares, without what couples them (of the order
// of zeta, and none with proportional damping).
// Valid: below about half the highest frequency kept (modal), or half that of the held modes (Craig-Bampton).
// Source: thesis 3.1.3 (the task); the papers named above; the closed forms derived in doc/physics.md section 1.
// Left out: the coupling by the gyroscopic matrix to modes left out, and the spin in the Gramians.
// Errors: InputError for a number of modes or planes that does not fit; balanced: for a bending mode without damping.

#include <Eigen/Core>
#include <vector>

#include "amb_rotor/rotor/flexible_rotor.hpp"

namespace amb_rotor {

struct ReducedRotor {
  int modes = 0;
  Eigen::VectorXd modal_mass;  ///< 1, one a mode
  Eigen::VectorXd stiffness;   ///< [1/s2]
  Eigen::VectorXd damping;     ///< [1/s]
  Eigen::MatrixXd gyroscopic;  ///< symmetric, multiplies the spin in rad/s
  RotorInertia inertia;        ///< of the rotor that was reduced
  BeamGrid grid;
  Eigen::MatrixXd vectors;  ///< nodal values of the modes, one a column

  Eigen::VectorXd shape(double z) const;     ///< phi(z) [kg^-0.5]
  Eigen::VectorXd rotation(double z) const;  ///< section's rotation [1/(m kg^0.5)]: where a moment enters
  double left() const { return grid.z.front(); }
  double right() const { return grid.z.back(); }
};

/// The lowest `modes` free-free modes, the two rigid ones included; 2 or more.
ReducedRotor reduceModal(const FlexibleRotor& rotor, int modes);

/// The full rotor.
ReducedRotor allModes(const FlexibleRotor& rotor);

/// Keeps the displacement at `planes` (z from the centre of gravity, two or more, all different) and adds
/// `held_modes` modes with the planes held: planes + held_modes coordinates.
ReducedRotor reduceCraigBampton(const FlexibleRotor& rotor, const std::vector<double>& planes,
                                int held_modes);

/// Position singular values [m/N] of the bending modes for forces and displacements at `planes`, falling.
Eigen::VectorXd positionSingularValues(const FlexibleRotor& rotor, const std::vector<double>& planes);

/// `modes` coordinates a plane, the two rigid ones included: 2 or more, and no more than `planes` drive and see.
ReducedRotor reduceBalanced(const FlexibleRotor& rotor, const std::vector<double>& planes, int modes);

}  // namespace amb_rotor
