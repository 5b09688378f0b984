#pragma once
// The synchronous full annular rub of the basic model in closed form: existence, fold points, stability.
//
// Centred bearing, linear contact, spin friction s = sign mu. z = x + j y = R exp(j (eta t + beta)) in (5.6):
//   (k - eta^2 + j d eta) z + alpha (1 - 1/R) (1 + j s) z = eta^2 e exp(j eta t)
// whose modulus is quadratic in R, with K = k + alpha - eta^2 and D = d eta + s alpha:
//   (K^2 + D^2) R^2 - 2 alpha (K + s D) R + alpha^2 (1 + s^2) - eta^4 e^2 = 0,   R >= 1.
// Two solutions meet at a fold (discriminant 0); one begins at R = 1 (grazing).
//
// Stability: z = (R + p + j q) exp(j (eta t + beta)), linear in p, q, with n = alpha (1 - 1/R), g = alpha /
// R:
//   p'' + d p' - 2 eta q' + (k - eta^2 + n + g) p - (d eta + s n) q = 0
//   q'' + d q' + 2 eta p' + (k - eta^2 + n) q + (d eta + s n + s g) p = 0
// a polynomial of order 4 in the exponent. With the clearance neglected (g = 0, n = alpha) it is
// lambda^2 + d lambda + k + alpha + j s alpha in the inertial frame: stable for
// |s| < d sqrt(k + alpha) / alpha, the corrected (5.20).
//
// Units: dimensionless as in basic_model.hpp. Valid: misalignment 0, linear contact. Errors: InputError for a
// displaced bearing. Source: thesis 5.1.3, 5.1.4; derived here. Left out: Hertz contact, sliding friction.
#include <array>
#include <complex>
#include <vector>

#include "amb_rotor/machine/basic_model.hpp"

namespace amb_rotor {

/// Radii R >= 1 of the synchronous rub, increasing; none, one or two.
std::vector<double> annularRubRadii(const BasicParameters<double>& p);
/// State at phase 0 of the rub of this radius.
BasicState<double> annularRubState(const BasicParameters<double>& p, double radius);
/// Coefficients of the characteristic polynomial, highest power (1) first.
std::array<double, 5> annularRubPolynomial(const BasicParameters<double>& p, double radius);
/// Its roots [w_n], in rotating axes.
std::vector<std::complex<double>> annularRubExponents(const BasicParameters<double>& p, double radius);
bool annularRubStable(const BasicParameters<double>& p, double radius);
/// Frequency ratios in [from, to] at which two rubs meet, with R >= 1.
std::vector<double> annularRubFolds(const BasicParameters<double>& p, double from, double to);
/// Friction coefficient at which the rub with the largest radius loses its stability at this speed;
/// infinity: not below 1; 0: no stable rub without friction, or no rub.
double annularRubFrictionBorder(const BasicParameters<double>& p);
/// The corrected (5.20): the border with the clearance neglected.
double frictionBorderWithoutClearance(const BasicParameters<double>& p);

}  // namespace amb_rotor
