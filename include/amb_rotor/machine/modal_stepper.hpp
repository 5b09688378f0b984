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
// interval, and taken() counts both and says why: changing speed, spin as a state, coils and filters as
// states, lags of the current, set-valued friction, spinning rings, nonlinear magnetic forces, edges that
// move with the rotor's tilt. So does an interval whose contact the modal steps do not get through.
// The trials do not see a force that acts beyond a threshold, in a part of the turn or at some times only, as a
// law written in a file may have it: callers must not use this for such (run.cpp does not). Every effect of the
// catalogue is compared with the event stepper, through failing bearings into contact, in
// test/reference/machine_modal_stepper.cpp.
// Forces and unbalances of a schedule are inputs of the linear machine: while one acts the motion goes by
// steps, with its values at their nodes.
//
// Between instants the state stays in modal coordinates: for many modes the product with the full matrix that
// makes mechanics of it would cost more than all the rest. bring() writes it where it is to be read
// (machine/simulator.hpp does so).
//
// The tolerance is EventStepper's: relative, of 1e-5 m and 1e-2 m/s or more, here of the ends' displacement
// and velocity in their bearings. Left out: sharing of x and y planes by isotropic rotors, which would halve
// the work of many modes.
#include <functional>
#include <memory>
#include <string>

#include "amb_rotor/machine/event_stepper.hpp"

namespace amb_rotor {

/// What a record shows of the mechanics.
struct RotorView {
  Vec2<double> sensor_position[2];  ///< rotor relative to the stator [m]
  Vec2<double> aux_position[2];     ///< rotor, absolute [m]
  Vec2<double> bearing_force[2];    ///< magnetic, on the rotor [N]
  Contact<double> contact[2];
  double ring_speed[2] = {0.0, 0.0};  ///< [rad/s]
  double largest_radius = 0.0;  ///< of the rotor at the planes of bearings and sensors [m]; NaN: one of them is
  /// As the mechanics of a machine show it.
  static RotorView of(const Machine<double>& machine, const Inputs<double>& in, const double* mechanics);
  static double largestRadius(const ModalRotor<double>& rotor, const double* mechanics);
};

class ModalStepper {
 public:
  explicit ModalStepper(const Machine<double>& machine, double relative_tolerance = 1e-8);
  ~ModalStepper();

  bool advance(const Simulator<double>& sim, double from, double to, MachineState<double>& state,
               const Simulator<double>::Held& held);

  /// Mechanics of a state that advance() was given last, where they are not in it yet.
  void bring(MachineState<double>& state);
  /// The rotor at the sensors relative to the stator [m]; false: as the state says.
  bool atSensors(const MachineState<double>& state, Vec2<double> out[2]) const;
  /// The rotor at the magnetic bearings likewise.
  bool atMagnets(const MachineState<double>& state, Vec2<double> out[2]) const;
  /// RotorView::of() a state's mechanics without writing them: a product with 32 rows instead of all; false: ask the state.
  bool view(const Inputs<double>& in, const MachineState<double>& state, RotorView& out) const;

  const IntegrationResult& result() const { return result_; }
  /// Of both steppers together, since countAnew().
  IntegratorStatistics statistics() const;
  /// Why the last interval was not taken in modal coordinates; empty: it was.
  const std::string& reason() const { return reason_; }
  /// Intervals between instants, by the way they were taken, and why the last of the general ones was
  /// general.
  struct Taken {
    long modal = 0, general = 0;
    std::string reason;
    /// In words.
    std::string text() const;
  };
  const Taken& taken() const { return taken_; }
  /// Statistics and intervals taken begin at 0 again; what is known of the machine stays.
  void countAnew();
  void setContactObserver(std::function<void(int, bool, double, const double*)> observer);

 private:
  class Linear;
  /// The linear machine of these bearings and this speed; null: it is not linear, or the interval is not.
  Linear* linearFor(const Simulator<double>& sim, double from, double to,
                    const Simulator<double>::Held& held);

  bool advanceGeneral(const Simulator<double>& sim, double from, double to, MachineState<double>& state,
                      const Simulator<double>::Held& held);

  const Machine<double>& machine_;
  double tolerance_;
  EventStepper general_;
  Taken taken_;
  Linear* holder_ = nullptr;  ///< knows the mechanics of the state; null: they are in it
  const MachineState<double>* held_state_ = nullptr;  ///< whose mechanics holder_ knows
  long told_ = 0, skip_ = 0;          ///< contacts of this interval; those that are told already
  std::unique_ptr<Linear> known_[2];  ///< e.g. with the bearings on and off
  int last_ = 0;
  IntegratorStatistics replaced_;  ///< of linear machines that others have taken the place of
  IntegratorStatistics before_;    ///< all of what countAnew() leaves out
  std::string fixed_reason_, reason_;
  IntegrationResult result_;
  std::function<void(int, bool, double, const double*)> observer_, counted_;
};

}  // namespace amb_rotor
