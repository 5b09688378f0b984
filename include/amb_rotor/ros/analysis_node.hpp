#pragma once
// Node analysis: joins each recorded step with the contact that answered it, and publishes what the motion
// was. doc/nodes.md
#include <ros/ros.h>

#include <deque>
#include <map>
#include <memory>

#include "amb_rotor/ros/block_analysis.hpp"
#include "amb_rotor/ros/messages.hpp"

namespace amb_rotor {

class AnalysisNode {
 public:
  AnalysisNode(const ros::NodeHandle& nodes, const ros::NodeHandle& own);

 private:
  void takeInfo(const ModelInfo::ConstPtr& info);
  void takeState(const RotorState::ConstPtr& state);
  void takeContact(const ContactForces::ConstPtr& contact);
  void join();
  void finishIfDone();
  void publish(const BlockAnalysis::Output& out);

  ros::NodeHandle nodes_;
  BlockOptions options_;
  ros::Publisher orbit_publisher_, point_publisher_, spectrum_publisher_;
  ros::Subscriber model_subscriber_, state_subscriber_, contact_subscriber_, status_subscriber_;

  ModelInfo::ConstPtr info_;
  std::vector<BlockAnalysis> ends_;
  std::map<std::uint64_t, RotorState::ConstPtr> states_;  ///< by step, not joined yet
  std::map<std::uint64_t, ContactForces::ConstPtr> contacts_;
  std::uint64_t joined_ = 0;  ///< steps up to here are done
  std::uint64_t lost_ = 0;    ///< steps without their contact
  std::uint64_t last_step_ = 0;
  bool ending_ = false, finished_ = false;
};

}  // namespace amb_rotor
