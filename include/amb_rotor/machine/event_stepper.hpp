#pragma once
// Event-accurate stepper for the complete machine in double: touch-down and lift-off of each end are located, between
// them the motion is smooth (integration/event_integrator.hpp). The reference for the lanes.
#include <functional>
#include <memory>

#include "amb_rotor/integration/event_integrator.hpp"
#include "amb_rotor/machine/simulator.hpp"

namespace amb_rotor {

class EventStepper {
 public:
  /// @param relative_tolerance  of each state; scales are 1e-5 m and 1e-2 m/s (tilts and modes likewise)
  EventStepper(const Machine<double>& machine, double relative_tolerance = 1e-8);
  ~EventStepper();

  bool advance(const Simulator<double>& sim, double from, double to, MachineState<double>& state,
               const Simulator<double>::Held& held);

  const IntegrationResult& result() const { return result_; }
  const IntegratorStatistics& statistics() const { return integrator_->statistics(); }
  /// Called at each touch-down (true) and lift-off (false): end, time, mechanics.
  void setContactObserver(std::function<void(int, bool, double, const double*)> observer);

 private:
  class System;
  std::unique_ptr<System> system_;
  std::unique_ptr<EventIntegrator> integrator_;
  IntegrationResult result_;
};

}  // namespace amb_rotor
