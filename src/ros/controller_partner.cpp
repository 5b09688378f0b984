#include <limits>

#include "amb_rotor/ros/conversions.hpp"
#include "amb_rotor/ros/partners.hpp"

namespace amb_rotor {

ControllerPartner::ControllerPartner(const Model& model)
    : machine_(std::vector<const Model*>{&model}), controller_(machine_.controller()), model_hash_(hashNumber(model)) {}

ControlCommand ControllerPartner::answer(const RotorState& state) const {
  ControlCommand answer;
  answerTo(state, model_hash_, answer);
  answer.command = state.command;
  answer.controller_memory = state.controller_memory;
  answer.control_state = state.control_state;
  answer.queue = state.queue;
  answer.next_sample = state.next_sample;
  answer.valid_until = state.horizon;
  if (machine_.ambModel() != AmbModel::linear) return answer;  // a spring needs no commands

  const auto& controller = machine_.rig().controller;
  const double soon = state.time + instant_tolerance_s;
  if (static_cast<double>(state.next_sample) / controller.sample_rate_hz <= soon) {
    AMB_ROTOR_CHECK(answer.control_state.size() == controller_.memorySize() &&
                        static_cast<int>(state.mechanics.size()) >= machine_.stateSize(),
                    "the step's state belongs to this model");
    PidMemory<double> memory[4];
    readMemory(state.controller_memory, memory);
    double signal[4], command[4];
    readAxes(state.sensor_signal, signal);
    machine_.electrics().filtered(state.mechanics.data() + machine_.electricsOffset(), signal);
    controller_.sample(signal, state.shaft.speed, memory, answer.control_state.data(), command);
    QueuedCommand queued;
    queued.due = static_cast<double>(state.next_sample) / controller.sample_rate_hz + controller.delay_s;
    queued.command = axisValues(command);
    answer.queue.push_back(queued);
    answer.controller_memory = memoryMessage(memory);
    answer.sampled = true;
    ++answer.next_sample;
  }
  while (!answer.queue.empty() && answer.queue.front().due <= soon) {
    answer.command = answer.queue.front().command;
    answer.queue.erase(answer.queue.begin());
  }
  answer.valid_until = static_cast<double>(answer.next_sample) / controller.sample_rate_hz;
  if (!answer.queue.empty() && answer.queue.front().due < answer.valid_until)
    answer.valid_until = answer.queue.front().due;
  return answer;
}

}  // namespace amb_rotor
