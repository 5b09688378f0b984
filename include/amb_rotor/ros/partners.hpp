#pragma once
// What the plant's partners answer to a step: pure functions of the step's message. Nothing is remembered
// between two calls but what follows from the model, the scenario and the messages (caches), so a partner
// that was killed and started again goes on where it was.
#include <memory>
#include <vector>

#include "amb_rotor/excitation/schedule.hpp"
#include "amb_rotor/excitation/shaft_path.hpp"
#include "amb_rotor/machine/machine.hpp"
#include "amb_rotor/model/model.hpp"
#include "amb_rotor/model/scenario.hpp"
#include "amb_rotor/ros/messages.hpp"

namespace amb_rotor {

/// The sampled controller with its delay.
class ControllerPartner {
 public:
  explicit ControllerPartner(const Model& model);
  ControlCommand answer(const RotorState& state) const;

 private:
  Machine<double> machine_;  ///< for its parameters behind all effects
  Controller<double> controller_;
  std::uint64_t model_hash_;
};

/// The contact laws of both auxiliary bearings. A linear law is answered exactly for as long as the plant
/// likes; one that is not (Hertz, a friction coefficient that depends on the sliding speed, a tilted bearing
/// whose edges change) as its tangent half a contact step ahead, for one contact step.
class ContactPartner {
 public:
  /// @param contact_step  [s] > 0
  ContactPartner(const Model& model, double contact_step);
  ContactForces answer(const RotorState& state) const;

 private:
  struct Modes {
    int contact[2], sliding[2];
  };
  /// `modes` and the state stay with the inputs.
  Inputs<double> inputs(const RotorState& state, Modes& modes) const;
  void predict(const RotorState& state, int end, EndContact& contact, double& valid_until) const;

  std::unique_ptr<Machine<double>> machine_;
  std::uint64_t model_hash_;
  double contact_step_;
  bool bent_law_, varying_;
};

/// Scenario and faults: what is done to the machine from outside.
class InjectorPartner {
 public:
  InjectorPartner(const Model& model, const Scenario& scenario);

  /// @param arrived  faults that came since the last answer, as they came; those that break a rule are left
  /// out
  /// @param refused  why, one text for each fault left out
  Injection answer(const RotorState& state, const std::vector<FaultMessage>& arrived,
                   std::vector<std::string>& refused);

 private:
  struct Plan {
    std::vector<FaultEvent> faults;  ///< beyond the scenario's
    Schedule schedule;
    PiecewiseShaft path{0.0, 0.0};
  };
  void plan(const std::vector<FaultEvent>& faults);
  void accept(const FaultMessage& message, double now, std::vector<FaultEvent>& faults) const;
  double nextKink(double time, double limit) const;
  void fill(double from, double to, Injection& answer) const;

  Model model_;
  Scenario scenario_;
  std::uint64_t model_hash_;
  double sample_rate_hz_;  ///< of the controller: excitation currents are held from sample to sample; 0: none
  Plan plan_;
};

}  // namespace amb_rotor
