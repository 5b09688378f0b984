// The launched graph against the machine in process: listens to a run from its first step, then simulates the same
// model and scenario. Parameters: `contact` (whether the rotor touches), `settled_from` [s].
#include <gtest/gtest.h>

#include <map>

#include "amb_rotor/ros/node_setup.hpp"
#include "comparison.hpp"

namespace amb_rotor {
namespace {

using namespace testing;

constexpr double time_limit_s = 100.0;  // of the wall

/// All that a run sent, by step.
struct Listener {
  std::map<std::uint64_t, RotorState::ConstPtr> states;
  std::map<std::uint64_t, ContactForces::ConstPtr> contacts;
  PlantStatus status;

  void listen(ros::NodeHandle& nodes) {
    subscribers = {
        nodes.subscribe<RotorState>("rotor/state", keep_all,
                                    [this](const RotorState::ConstPtr& m) { states.emplace(m->step, m); }),
        nodes.subscribe<ContactForces>("auxiliary_bearing/contact", keep_all,
                                       [this](const ContactForces::ConstPtr& m) { contacts.emplace(m->step, m); }),
        nodes.subscribe<PlantStatus>("rotor/status", keep_all,
                                     [this](const PlantStatus::ConstPtr& m) { status = *m; })};
  }
  bool complete() const {
    return status.state == PlantStatus::FINISHED && states.count(status.step) > 0 && contacts.count(status.step) > 0;
  }
  std::vector<ros::Subscriber> subscribers;
};

TEST(Graph, EqualsMachine) {
  ros::NodeHandle nodes, own("~");
  Listener heard;
  heard.listen(nodes);
  const ros::WallTime end = ros::WallTime::now() + ros::WallDuration(time_limit_s);
  while (ros::ok() && !heard.complete() && ros::WallTime::now() < end) {
    ros::spinOnce();
    ros::WallDuration(0.002).sleep();
  }
  ASSERT_TRUE(heard.complete()) << "the run did not end; last step " << heard.status.step;
  const Model model = modelOf(own);
  const Scenario scenario = scenarioOf(own);
  Recording graph;
  for (const auto& [step, state] : heard.states) {
    ASSERT_TRUE(heard.contacts.count(step) > 0) << "no contact for step " << step;
    append(graph, *state, *heard.contacts[step]);
  }
  const Simulation machine = simulate(model, scenario);
  ASSERT_EQ(machine.outcome.status, RunStatus::ok) << machine.outcome.reason;
  std::printf("%llu steps, %.0f us a step\n", static_cast<unsigned long long>(heard.status.step),
              1e6 * heard.status.wall_time / static_cast<double>(heard.status.step));
  expectEqual(graph, recordingOf(machine), model.rig.auxiliary_bearing.clearance_m,
              model.rig.auxiliary_bearing.rotor_radius_m, numberOr(own, "settled_from", 0.0),
              switchOr(own, "contact", false));
  EXPECT_EQ(heard.status.foreign_answers, 0U);
}

}  // namespace
}  // namespace amb_rotor

int main(int argc, char** argv) {
  ::testing::InitGoogleTest(&argc, argv);
  ros::init(argc, argv, "graph_equals_machine");
  return RUN_ALL_TESTS();
}
