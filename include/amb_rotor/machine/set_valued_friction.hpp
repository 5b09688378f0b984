#pragma once
// Set-valued Coulomb friction: stick without creep, in runs that locate events (in process, the graph's plant, and
// predictions of windows through contact).
//
//   slides:  F = -sign(v) mu N            v the sliding speed of the surfaces [m/s], F the friction on the rotor along
//   sticks:  v = 0, F in [-mu N, mu N]    t = (-n_y, n_x) [N]
//
// Which of the two holds is a mode of each end (MachineState::sliding), and changes at located events: sliding ends where
// v crosses zero (at -eps of the direction it had, eps = 1e-7 m/s, so that round-off starts no second event); sticking
// ends where the force that it needs exceeds mu N, and then slides against that force. mu at v = 0 is the static one
// where velocity_dependent_friction is on.
//
// The force that keeps ends sticking follows from the equations of motion, which are affine in it:
//   v' = s + B F,  v' = -v/tau  ->  F = -B^-1 (s + v/tau)
// s and B from Machine::slipRate of the rates without friction and with 1 N at each sticking end. tau = 0.1 ms takes out
// the eps and what the integrator lets drift. Where both ends of a rigid rotor stick and only the sum of their forces
// matters, B is singular: a share of 1e-9 of its trace on its diagonal takes the solution of least norm.
//
// Lanes of fixed steps refuse it by name: they have no events, and whether an end sticks is a mode of each lane.
// Valid: one friction force an end; ends that touch slowly enough for contacts to be located.
// Source: Coulomb, thesis 3.38; stick derived in doc/physics.md section 3.
// Left out: rolling resistance, a stick that grows with the time at rest, presliding compliance of the surfaces.
#include <string>

#include "amb_rotor/machine/machine.hpp"
#include "amb_rotor/machine/state.hpp"

namespace amb_rotor {

/// Time in which a sticking end loses what it still slides [s].
constexpr double stick_settling_s = 1e-4;
/// Sliding speed by which a reversal must be passed to count [m/s].
constexpr double stick_threshold_m_s = 1e-7;

/// @throw InputError: the law is set_valued
void refuseSetValuedFriction(FrictionLaw law, const std::string& where);

class StickSolver {
 public:
  explicit StickSolver(const Machine<double>& machine);

  /// Forces at the ends with sliding[end] = 0 that carry contact, 0 elsewhere. `in` as for the machine's derivatives.
  void solve(Inputs<double> in, const int sliding[2], const double* state, double force[2]);
  /// mu N of an end [N].
  double limit(Inputs<double> in, int end, const double* state) const;

 private:
  const Machine<double>& machine_;
  std::vector<double> rate_;
};

/// The sliding of both ends as modes of a system whose events are located (integration/event_integrator.hpp): two guards
/// behind those of the contacts. With regularised friction it has none and changes nothing.
class SlidingModes {
 public:
  explicit SlidingModes(const Machine<double>& machine)
      : machine_(machine), solver_(machine), on_(machine.frictionLaw() == FrictionLaw::set_valued) {}

  int guards() const { return on_ ? 2 : 0; }
  /// At the start of an interval: the modes are kept in `state` until the next call. `in` as for the machine's derivatives.
  void begin(const Inputs<double>& in, const double* y, MachineState<double>& state);
  /// Completes inputs by the modes and the forces that keep ends sticking, which stand in `force` as long as they are used.
  void complete(Inputs<double>& in, const double* y, double force[2]) const;
  void guardValues(Inputs<double> in, const double* y, double guard[2]) const;
  /// After the contact of an end has begun or ended, its mode changed already.
  void onContact(int end, Inputs<double> in, const double* y);
  /// After an end's guard has crossed zero.
  void onGuard(int end, Inputs<double> in, const double* y);

 private:
  bool sticking(int end) const { return state_->contact_mode[end] != 0 && state_->sliding[end] == 0; }
  void startSliding(int end, const Inputs<double>& in, const double* y);
  bool bothHold(int other, const Inputs<double>& in, const double* y);

  const Machine<double>& machine_;
  mutable StickSolver solver_;
  bool on_;
  MachineState<double>* state_ = nullptr;
};

}  // namespace amb_rotor
