#include "amb_rotor/ros/conversions.hpp"

#include "amb_rotor/common/error.hpp"
#include "amb_rotor/effects/catalogue.hpp"
#include "amb_rotor/model/model_hash.hpp"

namespace amb_rotor {

AxisValues axisValues(const double value[4]) {
  AxisValues message;
  message.ax = value[0];
  message.ay = value[1];
  message.bx = value[2];
  message.by = value[3];
  return message;
}

AxisValues axisValues(const Vec2<double> value[2]) {
  const double flat[4] = {value[0].x, value[0].y, value[1].x, value[1].y};
  return axisValues(flat);
}

double axisOf(const AxisValues& values, int axis) {
  return axis == 0 ? values.ax : axis == 1 ? values.ay : axis == 2 ? values.bx : values.by;
}

void readAxes(const AxisValues& message, double value[4]) {
  for (int a = 0; a < 4; ++a) value[a] = axisOf(message, a);
}

ShaftState shaftMessage(const Shaft<double>& shaft) {
  ShaftState message;
  message.angle = shaft.angle;
  message.speed = shaft.speed;
  message.acceleration = shaft.acceleration;
  return message;
}

Shaft<double> shaftFrom(const ShaftState& message, double later) {
  return Shaft<double>::at(message.angle + (message.speed + 0.5 * message.acceleration * later) * later,
                           message.speed + message.acceleration * later, message.acceleration);
}

std::vector<ControllerMemory> memoryMessage(const PidMemory<double> memory[4]) {
  std::vector<ControllerMemory> message(4);
  for (int a = 0; a < 4; ++a) {
    message[a].previous_signal = memory[a].previous_signal;
    message[a].derivative = memory[a].derivative;
    message[a].integral = memory[a].integral;
  }
  return message;
}

void readMemory(const std::vector<ControllerMemory>& message, PidMemory<double> memory[4]) {
  AMB_ROTOR_CHECK(message.size() == 4, "a controller memory for each of the four axes");
  for (int a = 0; a < 4; ++a)
    memory[a] = {message[a].previous_signal, message[a].derivative, message[a].integral};
}

std::vector<QueuedCommand> queueMessage(const std::vector<PendingCommand<double>>& queue) {
  std::vector<QueuedCommand> message(queue.size());
  for (std::size_t i = 0; i < queue.size(); ++i) {
    message[i].due = queue[i].due;
    message[i].command = axisValues(queue[i].command);
  }
  return message;
}

std::vector<PendingCommand<double>> readQueue(const std::vector<QueuedCommand>& message) {
  std::vector<PendingCommand<double>> queue(message.size());
  for (std::size_t i = 0; i < queue.size(); ++i) {
    queue[i].due = message[i].due;
    readAxes(message[i].command, queue[i].command);
  }
  return queue;
}

FaultMessage faultMessage(const FaultEvent& event) {
  FaultMessage message;
  message.type = static_cast<std::uint8_t>(static_cast<int>(event.type) + 1);
  message.start_mode = FaultMessage::ABSOLUTE;
  message.start = event.start_s;
  message.ramp = event.ramp_s;
  message.duration = event.duration_s;
  message.end = static_cast<std::uint8_t>(event.end + 1);
  message.axis = static_cast<std::uint8_t>(event.axis + 1);
  message.amount = event.amount;
  message.plane_z = event.plane_z_m;
  message.phase = event.phase_rad;
  return message;
}

FaultEvent faultFrom(const FaultMessage& message, double now) {
  static_assert(FaultMessage::UNBALANCE_STEP == static_cast<int>(FaultType::unbalance_step) + 1,
                "order of types");
  static_assert(FaultMessage::SPEED_CHANGE == static_cast<int>(FaultType::speed_change) + 1,
                "order of types");
  std::vector<amb_rotor::Fault> wrong;
  const auto limit = [&](const char* key, int value, int low, int high, const std::string& rule) {
    if (value < low || value > high) wrong.push_back({"", 0, key, std::to_string(value), rule});
  };
  limit("type", message.type, FaultMessage::UNBALANCE_STEP, FaultMessage::SPEED_CHANGE,
        "must be one of the types of amb_rotor/Fault (1 to 7)");
  limit("start_mode", message.start_mode, 0, 1, "must be DELAY (0) or ABSOLUTE (1)");
  limit("end", message.end, 0, 2, "must be BOTH (0), END_A (1) or END_B (2)");
  limit("axis", message.axis, 0, 2, "must be BOTH (0), AXIS_X (1) or AXIS_Y (2)");
  if (message.start < 0.0)
    wrong.push_back({"", 0, "start", std::to_string(message.start), "must be from 0 s"});
  if (!wrong.empty()) throw InputError(wrong);
  FaultEvent event;
  event.type = static_cast<FaultType>(message.type - 1);
  event.start_s = message.start_mode == FaultMessage::ABSOLUTE ? message.start : now + message.start;
  event.ramp_s = message.ramp;
  event.duration_s = message.duration;
  event.end = message.end - 1;
  event.axis = message.axis - 1;
  event.amount = message.amount;
  event.plane_z_m = message.plane_z;
  event.phase_rad = message.phase;
  return event;
}

double parabola(double start, double middle, double end, double share) {
  const double slope = -3.0 * start + 4.0 * middle - end;
  const double curve = 2.0 * start - 4.0 * middle + 2.0 * end;
  return start + share * (slope + share * curve);
}

std::uint64_t hashNumber(const Model& model) {
  return std::stoull(modelHash(model, effectCatalogue()), nullptr, 16);
}

}  // namespace amb_rotor
