#pragma once
// Flexible rotor, free-free, as assembled finite elements; both lateral planes share the matrices.
//
//   M x'' + D x' + W G y' + K x = sum N(z_k) f_x,k
//   M y'' + D y' - W G x' + K y = sum N(z_k) f_y,k
//
//   x, y   [w_1 psi_1 w_2 psi_2 ..] of the nodes, 2 N each   [m, rad]  (shaft_element.hpp)
//   M, K   mass and stiffness, symmetric                      [kg .., N/m ..]
//   D      damping in the inertial frame, symmetric           [N s/m ..]
//   G      polar inertia, symmetric, so the gyroscopic power W (x'^T G y' - y'^T G x') is zero
//   W      spin about +z, x turning towards y                 [rad/s]
//   N(z)   shapes: displacement at z is N(z)^T x, a force at z enters as N(z) f
//
// z is measured from the rotor's own centre of gravity, positive towards the right end (end B), so that a
// rigid motion is x(z) = x_G + z beta. Mass, centre of gravity and inertias are those of M and G: with
// rotary inertia switched off the shaft's own rho_I is missing from It.
// Left out: see shaft_element.hpp; unequal stiffness in x and y (a crack, a keyway) and internal (rotating)
// damping are effects, not part of this rotor.
// Errors: InputError for a bad geometry or a position outside the rotor.
// Valid: circular sections, small slopes; up to frequencies at which a wave is long against an element
// (shaft_element.hpp says by how much); a spin that changes little in a turn.
// Source: thesis 3.1.2, 3.15; Friswell, Penny, Garvey, Lees: Dynamics of Rotating Machines (2010).

#include <Eigen/Core>
#include <string>
#include <vector>

#include "amb_rotor/rotor/rotor_geometry.hpp"
#include "amb_rotor/rotor/shaft_element.hpp"

namespace amb_rotor {

/// Node positions and shapes of a row of elements; enough to find the motion anywhere between the nodes.
struct BeamGrid {
  std::vector<double> z;                ///< [m] from the centre of gravity, ascending
  std::vector<double> shear_parameter;  ///< one an element

  Eigen::VectorXd displacementShape(double at) const;  ///< N(z)
  Eigen::VectorXd rotationShape(double at) const;      ///< of the section's rotation psi [1/m, -, ..]
};

struct RotorInertia {
  double mass = 0.0;                         ///< [kg]
  double centre_of_gravity_from_left = 0.0;  ///< [m]
  double polar = 0.0;                        ///< [kg m2]
  double transverse = 0.0;                   ///< [kg m2], about the centre of gravity
};

/// A spring from a plane to the ground, the same in x and y.
struct GroundSpring {
  double z = 0.0;          ///< [m] from the centre of gravity
  double stiffness = 0.0;  ///< [N/m]
};

class FlexibleRotor {
 public:
  explicit FlexibleRotor(const RotorGeometry& geometry);
  /// Elements from left to right; discs at any place (a node is not needed).
  FlexibleRotor(const std::vector<ShaftElement>& elements, const std::vector<Disc>& discs,
                ShaftDamping damping = {});

  const BeamGrid& grid() const { return grid_; }
  const RotorInertia& inertia() const { return inertia_; }
  const ShaftDamping& shaftDamping() const { return damping_; }
  int freedoms() const { return static_cast<int>(mass_.rows()); }  ///< of one plane
  double left() const { return grid_.z.front(); }                  ///< [m] from the centre of gravity
  double right() const { return grid_.z.back(); }

  const Eigen::MatrixXd& mass() const { return mass_; }
  const Eigen::MatrixXd& stiffness() const { return stiffness_; }
  const Eigen::MatrixXd& gyroscopic() const { return gyroscopic_; }
  /// D of the shaft's proportional and modal damping.
  Eigen::MatrixXd damping() const;
  /// K with springs to the ground.
  Eigen::MatrixXd stiffnessWith(const std::vector<GroundSpring>& springs) const;
  /// M-normalised rigid motions: column 0 is 1/sqrt(m), column 1 z/sqrt(It).
  Eigen::MatrixXd rigidModes() const;

 private:
  void assemble(const std::vector<ShaftElement>& elements, const std::vector<Disc>& discs);

  BeamGrid grid_;
  RotorInertia inertia_;
  ShaftDamping damping_;
  Eigen::MatrixXd mass_;
  Eigen::MatrixXd stiffness_;
  Eigen::MatrixXd gyroscopic_;
};

/// Natural frequencies [rad/s], ascending, and M-normalised shapes (columns) of K v = w^2 M v; the first two
/// are the exact rigid motions. All of them: as many as freedoms of a plane.
struct FreeModes {
  Eigen::VectorXd frequency;
  Eigen::MatrixXd vectors;
};
FreeModes freeModes(const FlexibleRotor& rotor);

/// zeta of bending mode i (0: the first one).
double modalRatio(const ShaftDamping& damping, int bending_mode);

/// Natural frequencies [rad/s] of one plane on springs, at standstill, undamped, ascending.
Eigen::VectorXd planarFrequencies(const FlexibleRotor& rotor, const std::vector<GroundSpring>& springs);

/// The same with N_k^T x = 0 at the given planes (pinned), and psi = 0 too where clamped.
Eigen::VectorXd constrainedFrequencies(const FlexibleRotor& rotor, const std::vector<double>& pinned,
                                       const std::vector<double>& clamped);

}  // namespace amb_rotor
