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
// Three ways:
//  - modal: the lowest free-free modes. Static flexibility of the modes left out is lost.
//  - Craig-Bampton (Craig & Bampton 1968, AIAA J. 6, 1313): the displacements of the kept planes with their
//    static shapes, plus the lowest modes with those planes held; made diagonal again. A static force at a
//    kept plane bends the rotor exactly as in the full model.
//  - all modes: the full finite element rotor in the same form.
// Proportional damping stays diagonal; modal damping is given by the ratio of each bending mode kept. With
// Craig-Bampton the higher ones of these modes are not modes of the full rotor; they take the ratio of their
// number.
// Balanced truncation gives a state space, not a rotor: balanced_truncation.hpp.
// Valid: below about half the highest frequency kept (modal), or half that of the held modes (Craig-Bampton).
// Left out: the coupling by the gyroscopic matrix to modes left out.
// Errors: InputError for a number of modes or planes that does not fit.

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

}  // namespace amb_rotor
