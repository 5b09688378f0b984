#pragma once
// Balanced truncation of a stable rotor on its supports (thesis 3.1.3, figures 3.6 and 3.7).
//
//   s' = A s + B u,  w = C s        u forces [N], w displacements [m] at given planes
//   A P + P A^T + B B^T = 0,  A^T Q + Q A + C^T C = 0,
//   sigma_i = sqrt(eig_i(P Q)): Hankel singular values [m/N]
//   error of order r:  max over w of |H - H_r| <= 2 (sigma_r+1 + ... + sigma_n)       (Glover 1984)
//
// The thesis takes sigma from K - lambda M; these are squared natural frequencies, not Hankel singular
// values. The free rotor has none (its rigid motions are not stable): it is reduced as it stands on its
// supports, with damping in every mode.
// Method: Lyapunov equations by the complex Schur form (Bartels & Stewart 1972), square-root
// balancing (Laub et al. 1987). A sigma below about 1e-12 of the first is round-off.
// Valid: any stable linear system up to a few hundred states.
// Source: thesis 3.1.3 (its task and its 20 states); the papers named above for the method.
// Left out: the second-order structure (a truncated system is no rotor any more; reduction.hpp has one that is),
// frequency weights, exact static gain.
// Errors: InputError if the system is not stable or the order does not fit.

#include <Eigen/Core>
#include <complex>
#include <vector>

#include "amb_rotor/rotor/rotor_modes.hpp"

namespace amb_rotor {

struct StateSpace {
  Eigen::MatrixXd a;
  Eigen::MatrixXd b;
  Eigen::MatrixXd c;

  Eigen::MatrixXcd transfer(std::complex<double> s) const;  ///< C (s - A)^-1 B
};

/// Inputs: forces in x at each plane of z_in, then in y; outputs likewise. With `both_planes` false only x,
/// which is right at standstill without cross coupling.
StateSpace rotorStateSpace(const ReducedRotor& rotor, const std::vector<RotorSupport>& supports, double speed,
                           const std::vector<double>& z_in, const std::vector<double>& z_out,
                           bool both_planes);

struct BalancedSystem {
  StateSpace system;       ///< of the order asked for, balanced
  Eigen::VectorXd hankel;  ///< all singular values, descending
  double error_bound = 0.0;
};

/// Solves A X + X A^T + R = 0 for a stable A and a symmetric R.
Eigen::MatrixXd solveLyapunov(const Eigen::MatrixXd& a, const Eigen::MatrixXd& r);

Eigen::VectorXd hankelSingularValues(const StateSpace& system);
BalancedSystem balancedTruncation(const StateSpace& system, int order);

}  // namespace amb_rotor
