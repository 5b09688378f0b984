#pragma once
// Nodes amb_controller, auxiliary_bearing, injector: each answers the plant's steps. doc/nodes.md
#include <diagnostic_updater/diagnostic_updater.h>
#include <ros/ros.h>

#include "amb_rotor/ros/messages.hpp"
#include "amb_rotor/ros/partners.hpp"

namespace amb_rotor {

/// Publishes answers, from the moment on at which as many listen as the parameter `listeners` says: so that a
/// recording misses none of them.
template <class Answer>
class AnswerPublisher {
 public:
  AnswerPublisher(ros::NodeHandle& nodes, const std::string& topic, int listeners)
      : publisher_(nodes.advertise<Answer>(topic, 0)), listeners_(listeners) {}
  bool ready() {
    if (!ready_) ready_ = static_cast<int>(publisher_.getNumSubscribers()) >= listeners_;
    return ready_;
  }
  void publish(Answer&& answer) { publisher_.publish(boost::make_shared<Answer>(std::move(answer))); }

 private:
  ros::Publisher publisher_;
  int listeners_;
  bool ready_ = false;
};

class AmbController {
 public:
  AmbController(const ros::NodeHandle& nodes, const ros::NodeHandle& own);

 private:
  ros::NodeHandle nodes_;
  ControllerPartner partner_;
  AnswerPublisher<ControlCommand> answers_;
  ros::Subscriber state_subscriber_;
};

class AuxiliaryBearing {
 public:
  AuxiliaryBearing(const ros::NodeHandle& nodes, const ros::NodeHandle& own);

 private:
  ros::NodeHandle nodes_;
  ContactPartner partner_;
  AnswerPublisher<ContactForces> answers_;
  ros::Subscriber state_subscriber_;
};

class Injector {
 public:
  Injector(const ros::NodeHandle& nodes, const ros::NodeHandle& own);

 private:
  void answer(const RotorState& state);
  void diagnose(diagnostic_updater::DiagnosticStatusWrapper& status);

  ros::NodeHandle nodes_;
  InjectorPartner partner_;
  AnswerPublisher<Injection> answers_;
  ros::Subscriber state_subscriber_, fault_subscriber_;
  ros::WallTimer timer_;
  diagnostic_updater::Updater updater_;
  std::vector<FaultMessage> arrived_;  ///< since the last answer
  std::vector<FaultMessage>
      offered_;  ///< in the last answer: a step that is published again gets the same one
  std::uint64_t run_ = 0, answered_step_ = 0;
  bool answered_ = false;
  std::uint32_t rejected_ = 0;
  std::string last_refusal_;
};

}  // namespace amb_rotor
