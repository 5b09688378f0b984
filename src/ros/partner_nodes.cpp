#include "amb_rotor/ros/partner_nodes.hpp"

#include "amb_rotor/ros/node_setup.hpp"

namespace amb_rotor {
namespace {

constexpr double diagnostics_period_s = 0.5;  // of the wall
constexpr double default_contact_step_s = 1e-5;

}  // namespace

AmbController::AmbController(const ros::NodeHandle& nodes, const ros::NodeHandle& own)
    : nodes_(nodes),
      partner_(modelOf(own)),
      answers_(nodes_, "controller/command", integerOr(own, "listeners", 1)) {
  state_subscriber_ = nodes_.subscribe<RotorState>(
      "rotor/state", keep_all,
      [this](const RotorState::ConstPtr& state) {
        if (answers_.ready()) answers_.publish(partner_.answer(*state));
      },
      nullptr, noDelay());
}

AuxiliaryBearing::AuxiliaryBearing(const ros::NodeHandle& nodes, const ros::NodeHandle& own)
    : nodes_(nodes),
      partner_(modelOf(own), numberOr(own, "contact_step", default_contact_step_s)),
      answers_(nodes_, "auxiliary_bearing/contact", integerOr(own, "listeners", 1)) {
  state_subscriber_ = nodes_.subscribe<RotorState>(
      "rotor/state", keep_all,
      [this](const RotorState::ConstPtr& state) {
        if (answers_.ready()) answers_.publish(partner_.answer(*state));
      },
      nullptr, noDelay());
}

Injector::Injector(const ros::NodeHandle& nodes, const ros::NodeHandle& own)
    : nodes_(nodes),
      partner_(modelOf(own), scenarioOf(own)),
      answers_(nodes_, "injector/injection", integerOr(own, "listeners", 1)),
      updater_(nodes_, own, own.getNamespace()) {
  fault_subscriber_ = nodes_.subscribe<FaultMessage>(
      "fault", keep_all, [this](const FaultMessage::ConstPtr& fault) { arrived_.push_back(*fault); });
  state_subscriber_ = nodes_.subscribe<RotorState>(
      "rotor/state", keep_all, [this](const RotorState::ConstPtr& state) { answer(*state); }, nullptr,
      noDelay());
  updater_.setHardwareID("simulation");
  updater_.add("faults", this, &Injector::diagnose);
  timer_ = nodes_.createWallTimer(ros::WallDuration(diagnostics_period_s),
                                  [this](const ros::WallTimerEvent&) { updater_.force_update(); });
}

void Injector::answer(const RotorState& state) {
  if (!answers_.ready()) return;
  const bool again = answered_ && run_ == state.run && answered_step_ == state.step;
  if (!again) {
    offered_.swap(arrived_);
    arrived_.clear();
  }
  std::vector<std::string> refused;
  Injection answer = partner_.answer(state, offered_, refused);
  for (const auto& reason : refused) {
    if (again) break;
    ++rejected_;
    last_refusal_ = reason;
    ROS_WARN("injector: a fault was refused: %s", reason.c_str());
  }
  answer.rejected = rejected_;
  answered_ = true;
  run_ = state.run;
  answered_step_ = state.step;
  answers_.publish(std::move(answer));
}

void Injector::diagnose(diagnostic_updater::DiagnosticStatusWrapper& status) {
  if (rejected_ > 0)
    status.summary(diagnostic_msgs::DiagnosticStatus::WARN, "a fault was refused: " + last_refusal_);
  else
    status.summary(diagnostic_msgs::DiagnosticStatus::OK, "ready");
  status.add("refused faults", rejected_);
}

}  // namespace amb_rotor
