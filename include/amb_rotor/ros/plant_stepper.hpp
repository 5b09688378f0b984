#pragma once
// The machine over one step of the node graph: event-accurate integration with the contact laws, commands and
// forces that the partners answered. Touch-down and lift-off are located by the law's gap and force; with set-valued
// friction the ends' sliding, too, whose modes are in the machine's state (machine/set_valued_friction.hpp).
//
// Masses of mounts, rings and foundation are in the machine's own state, so the centre of a bearing and the
// speed of its ring move on inside the step from what the partner said at its start.
#include <memory>

#include "amb_rotor/integration/event_integrator.hpp"
#include "amb_rotor/machine/machine.hpp"
#include "amb_rotor/machine/simulator.hpp"
#include "amb_rotor/machine/state.hpp"
#include "amb_rotor/ros/messages.hpp"

namespace amb_rotor {

/// What holds over one step.
struct StepInputs {
  double from = 0.0, to = 0.0;      ///< [s]
  double target[4] = {0, 0, 0, 0};  ///< limited commands at the amplifiers [A]
  const ContactForces* contact = nullptr;
  const Injection* injection = nullptr;
};

class PlantStepper {
 public:
  PlantStepper(const Machine<double>& machine, double relative_tolerance);
  ~PlantStepper();

  /// Advances the state to inputs.to. @return false: the integration failed, see result().
  bool advance(const StepInputs& inputs, MachineState<double>& state);
  const IntegrationResult& result() const { return result_; }
  /// What keeps an end sticking at the end of the last step [N]; 0: it does not stick.
  const double* stickForce() const { return stick_force_; }

 private:
  class System;
  std::unique_ptr<System> system_;
  std::unique_ptr<EventIntegrator> integrator_;
  CurrentTrack<double> track_;
  IntegrationResult result_;
  double stick_force_[2] = {0.0, 0.0};
};

}  // namespace amb_rotor
