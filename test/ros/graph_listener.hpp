#pragma once
// Hears a run from its first step to its end, and what tests do to it meanwhile.
#include <ros/network.h>
#include <signal.h>
#include <xmlrpcpp/XmlRpc.h>

#include <functional>
#include <iterator>
#include <map>
#include <optional>
#include <string>

#include "amb_rotor/ros/node_setup.hpp"
#include "comparison.hpp"

namespace amb_rotor::testing {

constexpr double time_limit_s = 100.0;  // of the wall
constexpr std::uint64_t steps_until_it_dies = 100;  // that a run may go on while a signal is on its way

/// All that a run sent, by step.
struct Listener {
  std::map<std::uint64_t, RotorState::ConstPtr> states;
  std::map<std::uint64_t, ContactForces::ConstPtr> contacts;
  Injection::ConstPtr injection;  ///< the last one
  PlantStatus status;
  std::function<void(const RotorState&)> at_step;  ///< called at each new step

  explicit Listener(ros::NodeHandle& nodes) {
    subscribers_ = {
        nodes.subscribe<Injection>("injector/injection", keep_all,
                                   [this](const Injection::ConstPtr& m) { injection = m; }),
        nodes.subscribe<ContactForces>(
            "auxiliary_bearing/contact", keep_all,
            [this](const ContactForces::ConstPtr& m) { contacts.emplace(m->step, m); }),
        nodes.subscribe<PlantStatus>("rotor/status", keep_all,
                                     [this](const PlantStatus::ConstPtr& m) { status = *m; }),
        nodes.subscribe<RotorState>("rotor/state", keep_all, [this](const RotorState::ConstPtr& m) {
          if (states.emplace(m->step, m).second && at_step) at_step(*m);
        })};
  }

  bool complete() const {
    return status.state == PlantStatus::FINISHED && states.count(status.step) > 0 &&
           contacts.count(status.step) > 0;
  }
  /// Hears the run to its end. @return whether it came.
  bool hear() const {
    const ros::WallTime end = ros::WallTime::now() + ros::WallDuration(time_limit_s);
    while (ros::ok() && !complete() && ros::WallTime::now() < end) {
      ros::spinOnce();
      ros::WallDuration(0.001).sleep();
    }
    return complete();
  }
  /// @param killed_at  step at which we heard that the contact node was to be killed: it may have died between its answer to the plant
  ///                   and the same to us, which is then taken as the step before
  Recording recording(std::optional<std::uint64_t> killed_at = {}) const {
    Recording out;
    for (const auto& [step, state] : states) {
      auto contact = contacts.find(step);
      if (contact == contacts.end() && killed_at && step >= *killed_at && step < *killed_at + steps_until_it_dies &&
          contacts.begin()->first < step) {
        killed_at.reset();  // one answer
        contact = std::prev(contacts.lower_bound(step));
      }
      EXPECT_TRUE(contact != contacts.end()) << "no contact for step " << step;
      if (contact != contacts.end()) append(out, *state, *contact->second);
    }
    return out;
  }

 private:
  std::vector<ros::Subscriber> subscribers_;
};

/// Process of a node; 0: there is none.
inline int processOf(const std::string& node) {
  XmlRpc::XmlRpcValue request, answer, payload;
  request[0] = ros::this_node::getName();
  request[1] = node;
  if (!ros::master::execute("lookupNode", request, answer, payload, false)) return 0;
  std::string host;
  std::uint32_t port = 0;
  if (!ros::network::splitURI(payload, host, port)) return 0;
  XmlRpc::XmlRpcClient client(host.c_str(), static_cast<int>(port), "/");
  XmlRpc::XmlRpcValue caller, reply;
  caller[0] = ros::this_node::getName();
  if (!client.execute("getPid", caller, reply) || reply.size() < 3) return 0;
  return static_cast<int>(reply[2]);
}

}  // namespace amb_rotor::testing
