#pragma once
// The valley along which all sensors' gains, Ki and all loads are one: with signals s = g p of a rotor at p,
//   m s'' = Ks s + g Ki i + g F,
// so that the runs of a machine that is linear but for its currents' limits see g Ki and g F alone. In the coordinates of a fit (1/g, Ki,
// unbalances and loads as they are) that is a ray from 0, along which beliefs alone decide.
// Left out: weight, which a known offset of the sensors tells, iron that is not linear, contact: there chi2 rises along the ray.
#include <Eigen/Core>

#include "amb_rotor/validation/coordinates.hpp"

namespace amb_rotor {

/// The ray's direction at x: what grows with it, as it stands there, 0 elsewhere. 0: Ki, or a gain, is not free.
Eigen::VectorXd alongCommonGain(const FitSpace& space, const Eigen::VectorXd& x);

/// How far the beliefs about the nuisance pull along a direction, in its own length, and their standard deviation there; 0, 0: they say
/// nothing of it.
struct PullOfBeliefs {
  double way = 0.0, deviation = 0.0;
};
PullOfBeliefs pullAlong(const FitSpace& space, const Eigen::VectorXd& x, const Eigen::VectorXd& direction);

/// Widens a covariance along a direction to a deviation there.
void widenAlong(const Eigen::VectorXd& deviation, Eigen::MatrixXd& covariance);

}  // namespace amb_rotor
