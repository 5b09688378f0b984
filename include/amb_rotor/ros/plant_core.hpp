#pragma once
// The plant without its topics: holds the machine's state, says what step k looks like, and takes the step
// with the partners' answers. Deterministic: the same answers give the same bits.
#include <memory>
#include <string>
#include <vector>

#include "amb_rotor/machine/run.hpp"
#include "amb_rotor/model/model.hpp"
#include "amb_rotor/model/scenario.hpp"
#include "amb_rotor/ros/messages.hpp"
#include "amb_rotor/ros/plant_stepper.hpp"

namespace amb_rotor {

class PlantCore {
 public:
  /// Starts where the scenario says. @throw InputError: scenario and model do not go together, or the run-in
  /// failed.
  PlantCore(const Model& model, const Scenario& scenario, std::uint64_t run, const RunOptions& options = {});
  ~PlantCore();

  /// The step that is to be answered now; header.stamp is the caller's.
  const RotorState& state() const { return message_; }
  bool finished() const { return finished_; }
  /// Takes the step that was answered. False: the run has ended by divergence, at a magnet or by a failed
  /// integration, see reason().
  bool advance(const ControlCommand& control, const ContactForces& contact, const Injection& injection);
  bool diverged() const { return diverged_; }
  const std::string& reason() const { return reason_; }
  /// What a recording says of the run; header and clock offset are the caller's.
  ModelInfo info() const;
  /// Tacho pulses of the last step.
  const std::vector<Tacho>& pulses() const { return pulses_; }

 private:
  void start(const RunOptions& options);
  void buildMachine(const Injection& injection);
  void describe(const Shaft<double>& shaft, const double sensor_offset[4], const bool bearing_on[4],
                const double stick_force[2]);
  /// What acts at the present state, but for the commands and forces that the partners have yet to answer.
  Inputs<double> present(const Shaft<double>& shaft, const bool bearing_on[4]) const;
  void findPulses(double from, const Shaft<double>& before, const Shaft<double>& after);

  Model model_;
  Scenario scenario_;
  double tolerance_;
  std::vector<double> planes_;  ///< of the machine as it is built now: what decides whether to build it anew
  std::unique_ptr<Machine<double>> machine_;
  std::unique_ptr<PlantStepper> stepper_;
  MachineState<double> state_;
  RotorState message_;
  std::vector<Tacho> pulses_;
  bool finished_ = false, diverged_ = false;
  std::string reason_;
};

}  // namespace amb_rotor
