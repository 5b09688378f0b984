#pragma once
// Event-accurate stepper that uses the structure of the machine: between contacts most machines are linear at
// constant speed, with unbalance as a harmonic force and currents that decay to held commands. Then the
// motion is exact in modal coordinates (integration/linear_flow.hpp), and contact is two forces at each of
// two ends (integration/contact_flow.hpp).
// The step does not depend on how fast the highest modes of a flexible rotor swing.
//
// The linear equations are read from the machine's own derivatives, for whatever effects it has, and checked
// against them at random states; so are displacement, velocity and force of the contacts. What is not linear
// there, or not known behind held commands, goes to the event stepper (event_stepper.hpp), interval by
// interval, and reason() says why: changing speed, spin as a state, forces and unbalances of a schedule,
// coils and filters as states, lags of the current, set-valued friction, spinning rings, nonlinear magnetic
// forces, edges that move with the rotor's tilt.
//
// The tolerance is EventStepper's: relative, of 1e-5 m and 1e-2 m/s or more, here of the ends' displacement
// and velocity in their bearings. Left out: sharing of x and y planes by isotropic rotors, which would halve
// the work of many modes.
#include <functional>
#include <memory>
#include <string>

#include "amb_rotor/machine/event_stepper.hpp"

namespace amb_rotor {

class ModalStepper {
 public:
  explicit ModalStepper(const Machine<double>& machine, double relative_tolerance = 1e-8);
  ~ModalStepper();

  bool advance(const Simulator<double>& sim, double from, double to, MachineState<double>& state,
               const Simulator<double>::Held& held);

  const IntegrationResult& result() const { return result_; }
  /// Of both steppers together.
  IntegratorStatistics statistics() const;
  /// Why the last interval was not taken in modal coordinates; empty: it was.
  const std::string& reason() const { return reason_; }
  void setContactObserver(std::function<void(int, bool, double, const double*)> observer);

 private:
  class Linear;
  /// The linear machine of these bearings and this speed; null: it is not linear, or the interval is not.
  Linear* linearFor(const Simulator<double>& sim, double from, double to,
                    const Simulator<double>::Held& held);

  const Machine<double>& machine_;
  double tolerance_;
  EventStepper general_;
  std::unique_ptr<Linear> known_[2];  ///< e.g. with the bearings on and off
  int last_ = 0;
  std::string fixed_reason_, reason_;
  IntegrationResult result_;
  std::function<void(int, bool, double, const double*)> observer_;
};

}  // namespace amb_rotor
