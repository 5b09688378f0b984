#pragma once
// The control path of a machine as it stands behind all its effects, and the equivalent stiffness and damping that
// follow from it (magnetic_bearing/equivalent_stiffness.hpp).
//
// Ki, Ks and the sensor's gain of each axis are central differences of the machine's own force and signal under a
// translation of the rotor, so effects on coils, bearing forces and sensors are in. Left out, beside what the path
// leaves out: tilts, cross-coupling of the axes, everything that depends on the shaft's angle but at angle 0.
#include <Eigen/Core>
#include <array>
#include <vector>

#include "amb_rotor/machine/machine.hpp"
#include "amb_rotor/magnetic_bearing/equivalent_stiffness.hpp"

namespace amb_rotor {

/// The slopes of one axis at the centre.
struct AxisSlopes {
  double ki = 0.0;           ///< force by current [N/A]
  double ks = 0.0;           ///< force by displacement [N/m]
  double sensor_gain = 1.0;  ///< signal by displacement
};

/// Slopes of ax, ay, bx, by at a spin [rad/s].
std::array<AxisSlopes, 4> axisSlopes(const Machine<double>& machine, double speed);

/// The controller at a constant spin as  w' = a w + b s,  i = c w + d s  from the signals [m] to the commands [A] of
/// ax, ay, bx, by: its own difference equations, taken column by column. Without the converters.
struct ControllerMatrices {
  Eigen::MatrixXd a, b, c, d;
};
ControllerMatrices controllerMatrices(const Machine<double>& machine, double speed);

/// From the rotor's translation to the current of an axis (0 ax, 1 ay, 2 bx, 3 by). Needs AmbModel::linear; the
/// machine must outlive the path.
ControlPath controlPath(const Machine<double>& machine, double speed, int axis, double sensor_gain);

/// k1 and d1 of ax, ay, bx, by, one row a frequency.
std::vector<std::array<EquivalentBearing, 4>> equivalentBearings(const Machine<double>& machine, double speed,
                                                                 const std::vector<double>& frequencies_hz);

}  // namespace amb_rotor
