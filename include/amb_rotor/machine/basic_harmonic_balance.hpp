#pragma once
// Periodic motion of the basic model by harmonic balance, alternating between frequency and time: the
// cross-check of the shooting in basic_continuation.hpp, with which it shares the right-hand side and nothing
// else (no time stepping, no events, no initial state).
//
//   x(phi) = a_0 + sum_(k=1..H) a_k cos(k phi / n) + b_k sin(k phi / n),  y the same,  n turns, H harmonics
//   R = D c - P f(E c, E' c) = 0
// c the coefficients, D = -(k/n)^2 of the second derivative by phase, E and E' the values and slopes at M = 8
// H instants of the n turns, f the acceleration (basic_model.hpp in units of phase), P the discrete Fourier
// projection (E^T scaled). Newton with the exact Jacobian D - P (f_x E + f_v E'), halving steps that do not
// bring the residual down.
//
// Accuracy: the slope of the contact force jumps at touch-down and lift-off. The coefficients of the
// displacement therefore fall like 1/k^4 (left out behind harmonic H: O(H^-3)), and the sums over M instants
// in place of integrals miss O(M^-2) at each jump, which is what remains: at 64 harmonics a turn the state is
// within 2e-4 of shooting's, and it converges like H^-2 (test/reference/basic_harmonic_balance_test.cpp). A
// synchronous full annular rub has one harmonic and no jump, and is exact.
//
// Units: dimensionless as in basic_model.hpp; phase [rad]. Valid: stable and unstable motions alike. A Newton
// iteration that does not converge is a result (converged = false). Errors: InputError for counts below 1.
// Source: Cameron and Griffin, J. Appl. Mech. 56 (1989) 149; Krack and Gross, Harmonic Balance for Nonlinear
// Vibration Problems (2019). Left out: stability (Hill), quasi-periodic motion.
#include <Eigen/Core>
#include <vector>

#include "amb_rotor/machine/basic_lanes.hpp"

namespace amb_rotor {

struct HarmonicBalanceOptions {
  BasicContact contact = BasicContact::linear;
  BasicFriction friction = BasicFriction::spin;
  int turns = 1;             ///< n, the motion's period
  int harmonics = 64;        ///< H, of the motion's own frequency
  double tolerance = 1e-11;  ///< largest residual [clearance per squared radian]
  int most_iterations = 60;
};

struct HarmonicBalance {
  bool converged = false;
  int iterations = 0;
  double residual = 0.0;        ///< largest
  Eigen::VectorXd x, y;         ///< a_0, a_1, b_1, a_2, b_2, ...
  BasicState<double> state;     ///< at phase 0 (velocities in clearance w_n)
  double last_harmonics = 0.0;  ///< largest amplitude among the last tenth of the harmonics
};

/// @param guess states evenly spaced over the n turns, from phase 0; empty: the motion without contact.
HarmonicBalance harmonicBalance(const BasicParameters<double>& p,
                                const std::vector<BasicState<double>>& guess,
                                const HarmonicBalanceOptions& options = {});

}  // namespace amb_rotor
