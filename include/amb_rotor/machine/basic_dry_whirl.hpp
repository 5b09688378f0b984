#pragma once
// Dry whirl of the basic model in closed form: the rotor runs round inside a centred bearing against its
// spin, at whirl speed w > 0, in contact all the time, with spin friction s = mu.
//
// Circular motion z = R exp(-j w t) in (5.6), without unbalance:
//   radial       k + alpha (1 - 1/R) = w^2
//   tangential   mu alpha (1 - 1/R) = d w        ->  mu(w) = d w / (w^2 - k),  sqrt(k) < w < sqrt(k + alpha)
// mu(w) falls with w, so the circle is a watershed and no attractor: a backward whirl faster than w grows
// (the friction feeds it more than the damping takes), a slower one dies out. Below mu(sqrt(k + alpha)) = d
// sqrt(k + alpha) / alpha, the corrected (5.20), nothing grows. Spin friction does not end at rolling, so
// what grows has no limit.
//
// Units: dimensionless as in basic_model.hpp. Valid: misalignment 0, linear contact, friction_sign +1;
// unbalance shifts the watershed by its share of the force. Errors: a speed outside the range gives NaN.
// Source: derived here, for the rotor and stator of Black (thesis 5.1, its [22]). Left out: rolling (sliding friction has it).
#include "amb_rotor/machine/basic_model.hpp"

namespace amb_rotor {

/// R of the circle with this whirl speed.
double dryWhirlRadius(const BasicParameters<double>& p, double whirl_speed);
/// mu(w): friction above which a backward whirl of this speed grows.
double dryWhirlFriction(const BasicParameters<double>& p, double whirl_speed);
/// State on the circle, at (R, 0).
BasicState<double> dryWhirlState(const BasicParameters<double>& p, double whirl_speed);

}  // namespace amb_rotor
