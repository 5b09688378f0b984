#pragma once
// Eigenvalues of a rotor on linear supports: whirl modes, Campbell diagram, critical speeds, receptance.
//
//   (lambda^2 M + lambda (D + D_s + W Gam) + K + K_s) [X; Y] = 0,   Gam = [0 G; -G 0]
//
//   lambda   eigenvalue; |lambda| natural, Im(lambda) damped frequency [rad/s], -Re/|lambda| damping ratio
//   W        spin, positive about z                                    [rad/s]
//   D_s,K_s  supports: F = -k [x y]^T - d [x' y']^T at plane z         [N/m], [N s/m]
//   [X; Y]   complex amplitudes of the modal coordinates, motion Re([X; Y] exp(lambda t))
//
// Whirl: with f = |X + jY|^2 and b = |X - jY|^2 the measure (f - b)/(f + b) is 1 for a forward circle (x
// turns towards y, as the spin), -1 for a backward one, 0 for a line. It weighs the whole rotor by its
// kinetic energy, so a mode that turns forward at one end and backward at the other gets the sign that
// prevails. At standstill without cross coupling the planes are solved apart, and all modes are lines.
// Critical speeds are those of the undamped rotor: (K + K_s - W^2 (M - j Gam)) v = 0, a linear problem in
// W^2; the supports must hold the rotor and be symmetric.
// Left out: supports that depend on frequency or speed; evaluate at each frequency with its own k and d.
// Valid: linear supports, constant spin, motions so small that contact and the magnets' own limits do not matter.
// Source: thesis 4.2 and figure 4.4; Genta, Dynamics of Rotating Systems (2005).
// Errors: InputError for planes outside the rotor and for critical speeds of a rotor that is not held.

#include <Eigen/Core>
#include <complex>
#include <vector>

#include "amb_rotor/rotor/reduction.hpp"

namespace amb_rotor {

struct RotorSupport {
  double z = 0.0;                                       ///< [m] from the centre of gravity
  Eigen::Matrix2d stiffness = Eigen::Matrix2d::Zero();  ///< [N/m]
  Eigen::Matrix2d damping = Eigen::Matrix2d::Zero();    ///< [N s/m]
};

RotorSupport isotropicSupport(double z, double stiffness, double damping = 0.0);

enum class Whirl { forward, backward, planar };

struct RotorMode {
  std::complex<double> eigenvalue;  ///< [rad/s], Im above 0
  double natural_frequency = 0.0;   ///< [rad/s]
  double damped_frequency = 0.0;    ///< [rad/s]
  double damping_ratio = 0.0;       ///< [-]
  Whirl whirl = Whirl::planar;
  double whirl_measure = 0.0;  ///< -1 to 1
  Eigen::VectorXcd x;          ///< modal amplitudes
  Eigen::VectorXcd y;
};

struct RotorModes {
  double speed = 0.0;                  ///< [rad/s]
  std::vector<RotorMode> oscillating;  ///< by ascending damped frequency
  std::vector<double> real;  ///< roots without oscillation [1/s], ascending; 0 for a free rigid motion
};

RotorModes rotorModes(const ReducedRotor& rotor, const std::vector<RotorSupport>& supports, double speed);

/// Complex displacement [x, y] of a mode at z.
Eigen::Vector2cd modeShape(const ReducedRotor& rotor, const RotorMode& mode, double z);

std::vector<RotorModes> campbell(const ReducedRotor& rotor, const std::vector<RotorSupport>& supports,
                                 const std::vector<double>& speeds);

struct CriticalSpeed {
  double speed = 0.0;  ///< [rad/s]
  Whirl whirl = Whirl::planar;
  double whirl_measure = 0.0;
};

/// Speeds at which an undamped mode turns with the spin's frequency, ascending. Unbalance excites the forward
/// ones, and with unequal supports every one whose measure is above -1.
std::vector<CriticalSpeed> criticalSpeeds(const ReducedRotor& rotor,
                                          const std::vector<RotorSupport>& supports);

/// Displacement amplitude [x, y] at z_out for harmonic forces [x, y] of 1 N at z_in, exp(j frequency t)
/// [m/N].
Eigen::Matrix2cd receptance(const ReducedRotor& rotor, const std::vector<RotorSupport>& supports,
                            double speed, double frequency, double z_out, double z_in);

/// Both planes' matrices with the supports: M = 1, damping (with spin) and stiffness, 2 modes x 2 modes.
struct SupportedMatrices {
  Eigen::MatrixXd damping;
  Eigen::MatrixXd stiffness;
};
SupportedMatrices supportedMatrices(const ReducedRotor& rotor, const std::vector<RotorSupport>& supports,
                                    double speed);

/// State matrix of s = [S q; q'], S diagonal: the size of each coordinate's frequency [rad/s], so that the
/// eigenvalues do not drown in round-off of the highest one.
struct ScaledState {
  Eigen::MatrixXd a;
  Eigen::VectorXd scale;
};
ScaledState scaledState(const Eigen::MatrixXd& damping, const Eigen::MatrixXd& stiffness);

}  // namespace amb_rotor
