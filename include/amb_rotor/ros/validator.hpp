#pragma once
// Node validator: a running model against what a rig publishes, live or from a bag (validation/live.hpp). Of the steps it
// reads what a rig can measure: shaft, sensor signals, control currents, and from the injection the current added to the
// commands and which axes are on; never the machine's state. doc/nodes.md
#include <diagnostic_updater/diagnostic_updater.h>
#include <ros/ros.h>
#include <visualization_msgs/MarkerArray.h>

#include <map>
#include <memory>
#include <string>

#include "amb_rotor/ros/messages.hpp"
#include "amb_rotor/validation/live.hpp"

namespace amb_rotor {

class Validator {
 public:
  Validator(const ros::NodeHandle& nodes, const ros::NodeHandle& own);

 private:
  void takeState(const RotorState::ConstPtr& state);
  void takeInjection(const Injection::ConstPtr& injection);
  void join();
  void take(const RotorState& state, const Injection* injection);
  void begin(const RotorState& state);
  void publish(const RotorState& last);
  void draw(const RotorState& last);
  void diagnose(diagnostic_updater::DiagnosticStatusWrapper& status);

  struct Sum {
    double squares = 0.0;
    unsigned blocks = 0;
  };

  ros::NodeHandle nodes_;
  Model model_;
  std::uint64_t hash_;
  LiveOptions options_;
  bool with_injection_;
  double clearance_shown_;
  std::unique_ptr<LiveComparison> live_;  ///< of the present run
  std::uint64_t run_ = 0;
  std::map<std::uint64_t, RotorState::ConstPtr> states_;  ///< by step, not joined yet
  std::map<std::uint64_t, Injection::ConstPtr> injections_;
  std::map<std::string, Sum> regimes_;
  ModelResidual residual_;                ///< of the last block
  bool any_ = false;
  ros::Publisher residual_publisher_, marker_publisher_;
  ros::Subscriber state_subscriber_, injection_subscriber_;
  diagnostic_updater::Updater updater_;
  ros::WallTimer timer_;
};

}  // namespace amb_rotor
