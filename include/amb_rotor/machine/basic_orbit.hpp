#pragma once
// Event-accurate motion of one basic model, with its derivatives: the reference that the lanes are tested
// against, and what the continuation of periodic motions is built from.
//
// Linear contact with spin friction: Taylor series (src/machine/basic_taylor.hpp), whose events are roots of
// the step's own polynomial. Hertz contact and sliding friction: Dormand and Prince 5(4), step control on
// value and derivatives; every touch-down and lift-off is located (root of r^2 - 1 on the step, which is then
// repeated with exactly that length). Between events the branch of the force is fixed, so that no step
// straddles a kink. The independent variable is the phase phi = eta t, so a turn is 2 pi whatever the speed.
//
// Derivatives with respect to the initial state and one parameter are carried as dual numbers. At an event
// they jump by the saltation matrix S = I + (f+ - f-) n^T / (n . f-); the vector field of the basic model is
// continuous across touch-down and lift-off, so S = I and nothing is applied (saltationJump gives S - I at a
// state: a test holds it to round-off).
//
// Units: dimensionless as in basic_model.hpp. Valid: crossings of the clearance; an orbit that only touches
// it (grazing) has one-sided derivatives. Errors: a result with finite = false when the step gets too small.
// Source: Hairer, Norsett, Wanner, Solving Ordinary Differential Equations I, II.5 and II.6; Leine and
// Nijmeijer, Dynamics and Bifurcations of Non-Smooth Mechanical Systems.
#include <Eigen/Core>
#include <functional>
#include <optional>
#include <vector>

#include "amb_rotor/machine/basic_lanes.hpp"

namespace amb_rotor {

struct BasicOrbitOptions {
  BasicContact contact = BasicContact::linear;
  BasicFriction friction = BasicFriction::spin;
  double tolerance = 1e-10;  ///< absolute, of displacement, velocity and their derivatives
  /// d(parameters)/d(the number that is differentiated by), field by field; empty: none.
  std::optional<BasicParameters<double>> direction;
  long step_limit = 10000000;
};

struct BasicOrbit {
  BasicState<double> end;  ///< velocities in clearance w_n
  /// d(end)/d(initial state) and d(end)/d(parameter) in phase units (velocities per radian of phase).
  Eigen::Matrix4d monodromy = Eigen::Matrix4d::Zero();
  Eigen::Vector4d by_parameter = Eigen::Vector4d::Zero();
  int touch_downs = 0;
  double contact_fraction = 0.0;
  double largest_free_radius = 0.0;  ///< largest distance of a turning point that does not touch
  double max_radius = 0.0;           ///< at the ends of steps, or at most 0.15 rad apart
  long steps = 0, evaluations = 0;
  bool finite = true;
};

/// Called at every accepted step and event, and inside steps by series every 0.02 rad: phase [rad], state
/// (velocities in clearance w_n), in contact.
using BasicObserver = std::function<void(double, const BasicState<double>&, bool)>;

/// The motion from phase 0 over whole turns, without derivatives.
BasicOrbit advanceBasic(const BasicParameters<double>& p, const BasicState<double>& initial, int turns,
                        const BasicOrbitOptions& options, const BasicObserver& observer = {});
/// The same with the derivatives.
BasicOrbit basicOrbit(const BasicParameters<double>& p, const BasicState<double>& initial, int turns,
                      const BasicOrbitOptions& options);

/// State in phase units, and back.
Eigen::Vector4d phaseUnits(const BasicState<double>& state, double frequency_ratio);
BasicState<double> timeUnits(const Eigen::Vector4d& state, double frequency_ratio);

/// S - I at a state on the clearance: the jump of the derivatives at a contact event.
Eigen::Matrix4d saltationJump(const BasicParameters<double>& p, const BasicState<double>& state, double phase,
                              const BasicOrbitOptions& options);

}  // namespace amb_rotor
