#pragma once
// Between the core's types and messages; the one place where it is done.
#include <string>
#include <vector>

#include "amb_rotor/common/shaft.hpp"
#include "amb_rotor/machine/state.hpp"
#include "amb_rotor/model/model.hpp"
#include "amb_rotor/model/scenario.hpp"
#include "amb_rotor/ros/messages.hpp"

namespace amb_rotor {

/// Frame in which all vectors of the messages are.
constexpr const char* stator_frame = "stator";
/// Instants closer than this are one [s].
constexpr double instant_tolerance_s = 1e-12;

AxisValues axisValues(const double value[4]);
AxisValues axisValues(const Vec2<double> value[2]);
/// Component of an axis: 0 ax, 1 ay, 2 bx, 3 by.
double axisOf(const AxisValues& values, int axis);
void readAxes(const AxisValues& message, double value[4]);

ShaftState shaftMessage(const Shaft<double>& shaft);
/// The shaft `later` seconds after the one in the message, with its acceleration kept.
Shaft<double> shaftFrom(const ShaftState& message, double later = 0.0);

std::vector<ControllerMemory> memoryMessage(const PidMemory<double> memory[4]);
void readMemory(const std::vector<ControllerMemory>& message, PidMemory<double> memory[4]);
std::vector<QueuedCommand> queueMessage(const std::vector<PendingCommand<double>>& queue);
std::vector<PendingCommand<double>> readQueue(const std::vector<QueuedCommand>& message);

/// A fault as a message, its start absolute.
FaultMessage faultMessage(const FaultEvent& event);
/// A message as a fault; `now` is the simulated time from which a delay counts [s]. Throws InputError for an
/// unknown constant; the rules of the values are checkFaultEvent's.
FaultEvent faultFrom(const FaultMessage& message, double now);

/// Parabola through values at the start, the middle and the end of an interval, at a share of it.
double parabola(double start, double middle, double end, double share);

/// modelHash() as a number.
std::uint64_t hashNumber(const Model& model);

/// A copy of the header of what is answered.
template <class Answer>
void answerTo(const RotorState& state, std::uint64_t model_hash, Answer& answer) {
  answer.header = state.header;
  answer.run = state.run;
  answer.step = state.step;
  answer.model_hash = model_hash;
}

}  // namespace amb_rotor
