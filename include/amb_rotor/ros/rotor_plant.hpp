#pragma once
// Node rotor_plant: publishes step k, waits for its partners' answers, takes the step; owns /clock.
// doc/nodes.md
#include <diagnostic_updater/diagnostic_updater.h>
#include <ros/ros.h>

#include <memory>

#include "amb_rotor/ros/messages.hpp"
#include "amb_rotor/ros/plant_core.hpp"

namespace amb_rotor {

class RotorPlant {
 public:
  RotorPlant(const ros::NodeHandle& nodes, const ros::NodeHandle& own);

 private:
  template <class Answer>
  using Slot = boost::shared_ptr<const Answer>;

  template <class Answer>
  void take(const Slot<Answer>& answer, Slot<Answer>& slot);
  void publishState();
  void step();
  void pace();
  void end(std::uint8_t state);
  void watch();
  bool everybodyListens() const;
  void publishClock(bool always);
  void publishStatus();
  void diagnose(diagnostic_updater::DiagnosticStatusWrapper& status);
  ros::Time stamp(double time) const { return ros::Time(time + clock_offset_); }

  ros::NodeHandle nodes_;
  PlantCore core_;
  double rate_, clock_offset_, clock_period_, repeat_after_, alarm_after_, linger_;
  int listeners_;
  std::vector<std::string> wait_for_;
  bool exit_at_end_;

  ros::Publisher state_publisher_, clock_publisher_, model_publisher_, status_publisher_, tacho_publisher_;
  ros::Subscriber control_subscriber_, contact_subscriber_, injection_subscriber_;
  ros::WallTimer watch_timer_, pace_timer_;
  diagnostic_updater::Updater updater_;

  Slot<ControlCommand> control_;
  Slot<ContactForces> contact_;
  Slot<Injection> injection_;
  boost::shared_ptr<const RotorState> published_;
  PlantStatus status_;
  double last_clock_ = -1.0;
  bool ended_ = false;
  ros::WallTime first_answer_, last_progress_, last_publication_, last_status_, end_;
};

}  // namespace amb_rotor
