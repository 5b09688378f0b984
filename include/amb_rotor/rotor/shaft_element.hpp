#pragma once
// Finite element of a shaft in bending, one lateral plane.
//
//   energies   T = 1/2 int rho_A w'^2 + rho_I psi'^2 dz     (' with time)
//              U = 1/2 int E_I (dpsi/dz)^2 + kGA (dw/dz - psi)^2 dz
//   result     M, K, G of [w_1 psi_1 w_2 psi_2], all symmetric
//
//   w        lateral displacement                                    [m]
//   psi      rotation of the cross section, dw/dz plus shear; with
//            Euler-Bernoulli psi = dw/dz. In plane x psi = beta, in
//            plane y psi = -alpha (alpha, beta: rotations about x, y) [rad]
//   rho_A    mass per length                                         [kg/m]
//   rho_I    diametral inertia per length; 2 rho_I is the polar one  [kg m]
//   E_I      bending stiffness                                       [N m2]
//   kGA      shear stiffness with the shear factor k                 [N]
//
// Frame: z along the shaft; spin positive about z, x turning towards y. Then both planes share M and K, and
//   M x'' + W G y' + K x = F_x,   M y'' - W G x' + K y = F_y       (W: spin, rad/s).
// Shapes: cubic, with the shear parameter Phi = 12 E_I / (kGA l^2) (Przemieniecki 1968; Friswell et al.
// 2010); Phi = 0 gives the thesis's 3.13 and 3.14 (its 3.5 has a sign error: H4 is -l xi^2 (1 - xi)).
// Sections may be hollow, layered and conical: integrals by Gauss with five points, exact for the cone's
// polynomials. A displacement method: frequencies come from above. With wave number q the relative error is
// about (q l)^4/1440, and with shear (q^2 E_I/kGA) (q l)^2/24 more; a cone, whose Phi is its mean section's,
// adds about the square of the diameter's relative change over the element.
// Shear factor: Hutchinson 2001 (J. Appl. Mech. 68, 87), or given.
// Valid: circular sections, small slopes, shaft stiff against the change of its section's shape (wall
// thickness not small against the radius).
// Source: thesis 3.1.2, 3.2 to 3.14, for the slender element; Przemieniecki, Friswell et al. and Hutchinson for the rest.
// Left out: axial force and torque stiffening, torsion, axial motion, centrifugal softening, internal
// damping, slip between shrunk layers.
// Errors: InputError for lengths, densities or diameters that are not positive or do not fit.

#include <Eigen/Core>
#include <vector>

namespace amb_rotor {

enum class BeamTheory { euler_bernoulli, timoshenko };

struct Material {
  double density = 0.0;         ///< [kg/m3]
  double youngs_modulus = 0.0;  ///< [Pa]; 0: mass only, e.g. a stack of laminations
  double poisson_ratio = 0.3;   ///< [-], -1 to 0.5

  double shearModulus() const { return 0.5 * youngs_modulus / (1.0 + poisson_ratio); }
};

/// One coaxial ring of material; diameters vary linearly along the element.
struct ShaftLayer {
  double outer_diameter_left = 0.0;   ///< [m]
  double outer_diameter_right = 0.0;  ///< [m]
  double inner_diameter_left = 0.0;   ///< [m]; 0: solid
  double inner_diameter_right = 0.0;  ///< [m]
  Material material;
  double shear_factor = 0.0;  ///< [-]; 0: Hutchinson's
};

struct ShaftElement {
  double length = 0.0;  ///< [m]
  std::vector<ShaftLayer> layers;
  BeamTheory theory = BeamTheory::timoshenko;
  bool rotary_inertia = true;  ///< rho_I in M; false for the thesis's 3.13
  bool gyroscopic = true;      ///< 2 rho_I in G
};

/// A cylinder of one material.
ShaftElement cylinder(double length, double outer_diameter, double inner_diameter, const Material& material,
                      BeamTheory theory = BeamTheory::timoshenko);

struct SectionProperties {
  double mass_per_length = 0.0;     ///< rho_A [kg/m]
  double inertia_per_length = 0.0;  ///< rho_I [kg m]
  double bending_stiffness = 0.0;   ///< E_I [N m2]
  double shear_stiffness = 0.0;     ///< kGA [N]
};

/// Section at xi = 0 (left) to 1 (right).
SectionProperties sectionAt(const ShaftElement& element, double xi);

/// Hutchinson's shear factor of a circular ring; diameter_ratio = inner/outer, 0 to below 1.
double hutchinsonShearFactor(double diameter_ratio, double poisson_ratio);

/// Cowper's (1966) factor of a solid circle, which ROSS and older books use.
double cowperShearFactor(double poisson_ratio);

/// Values of the four shapes at xi, for displacement and for the section's rotation.
struct ShapeValues {
  Eigen::Vector4d displacement;  ///< [-, m, -, m]
  Eigen::Vector4d rotation;      ///< [1/m, -, 1/m, -]
};
ShapeValues shapeValues(double xi, double length, double shear_parameter);

struct ElementMatrices {
  Eigen::Matrix4d mass = Eigen::Matrix4d::Zero();
  Eigen::Matrix4d stiffness = Eigen::Matrix4d::Zero();
  Eigen::Matrix4d gyroscopic = Eigen::Matrix4d::Zero();  ///< per rad/s of spin
  double shear_parameter = 0.0;                          ///< Phi [-]
};
ElementMatrices elementMatrices(const ShaftElement& element);

}  // namespace amb_rotor
