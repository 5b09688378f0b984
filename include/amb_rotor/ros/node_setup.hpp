#pragma once
// What all nodes share: their parameters, and how a node class becomes a process.
#include <ros/ros.h>

#include <string>
#include <vector>

#include "amb_rotor/common/error.hpp"
#include "amb_rotor/model/model.hpp"
#include "amb_rotor/model/scenario.hpp"

namespace amb_rotor {

/// Queue without a limit: a step that is dropped stops a lock-step, and falsifies an analysis.
constexpr unsigned keep_all = 0;

/// A parameter of the node, or of a namespace above it. @throw InputError where it is missing.
std::string requiredText(const ros::NodeHandle& own, const std::string& name);
/// The same with a value where it is missing.
double numberOr(const ros::NodeHandle& own, const std::string& name, double otherwise);
int integerOr(const ros::NodeHandle& own, const std::string& name, int otherwise);
bool switchOr(const ros::NodeHandle& own, const std::string& name, bool otherwise);
std::string textOr(const ros::NodeHandle& own, const std::string& name, const std::string& otherwise);
/// Words of a text parameter; none where it is missing.
std::vector<std::string> wordsOf(const ros::NodeHandle& own, const std::string& name);
/// Whether all these topics are advertised.
bool areAdvertised(const ros::NodeHandle& nodes, const std::vector<std::string>& topics);

/// The model of the parameters `model` (path) and `overrides` (list of path=value, optional).
Model modelOf(const ros::NodeHandle& own);
/// The scenario of the parameter `scenario` (path).
Scenario scenarioOf(const ros::NodeHandle& own);

/// Small messages at a high rate must not wait for each other.
inline ros::TransportHints noDelay() { return ros::TransportHints().tcpNoDelay(); }

/// Runs a node class until ROS shuts down. @return the exit status: 0, or 2 for bad input.
template <class Node>
int runNode(int argc, char** argv, const char* name) {
  ros::init(argc, argv, name);
  try {
    Node node(ros::NodeHandle(), ros::NodeHandle("~"));
    ros::spin();
  } catch (const InputError& error) {
    ROS_FATAL("%s: %s", name, error.what());
    return 2;
  }
  return 0;
}

}  // namespace amb_rotor
