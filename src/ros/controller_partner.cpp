#include <limits>

#include "amb_rotor/magnetic_bearing/pid.hpp"
#include "amb_rotor/ros/conversions.hpp"
#include "amb_rotor/ros/partners.hpp"

namespace amb_rotor {

ControllerPartner::ControllerPartner(const Model& model)
    : machine_(std::vector<const Model*>{&model}), model_hash_(hashNumber(model)) {}

ControlCommand ControllerPartner::answer(const RotorState& state) const {
  ControlCommand answer;
  answerTo(state, model_hash_, answer);
  answer.command = state.command;
  answer.controller_memory = state.controller_memory;
  answer.queue = state.queue;
  answer.next_sample = state.next_sample;
  answer.valid_until = state.horizon;
  if (machine_.ambModel() != AmbModel::linear) return answer;  // a spring needs no commands

  const auto& controller = machine_.rig().controller;
  const double soon = state.time + instant_tolerance_s;
  if (static_cast<double>(state.next_sample) / controller.sample_rate_hz <= soon) {
    const Pid<double> pid(machine_.rig());
    PidMemory<double> memory[4];
    readMemory(state.controller_memory, memory);
    double command[4];
    for (int a = 0; a < 4; ++a) command[a] = pid.sample(axisOf(state.sensor_signal, a), memory[a]);
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
