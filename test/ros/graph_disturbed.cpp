// A run in which partners are killed and answers are forged: it equals the run that was left alone. While a
// partner is away simulated time stands still, and the diagnostics say who is missing.
#include <diagnostic_msgs/DiagnosticArray.h>

#include "graph_listener.hpp"

namespace amb_rotor {
namespace {

using namespace testing;

constexpr double untouched = 1e-9;  // clearances; the answers are the same bits, the settled start is to 1e-8
constexpr int forgeries = 5;        // of each kind

/// Kills a node with SIGKILL when the run has come to a time.
struct Killing {
  std::string node;
  double time;
  int pid = 0;
  std::uint64_t step = 0;
};

TEST(Graph, DisturbedEqualsUndisturbed) {
  ros::NodeHandle nodes, own("~");
  std::vector<Killing> killings = {{"/amb_controller", 0.1}, {"/auxiliary_bearing", 0.2}};
  std::vector<std::string> alarms;
  const ros::Subscriber diagnostics = nodes.subscribe<diagnostic_msgs::DiagnosticArray>(
      "/diagnostics", 100, [&](const diagnostic_msgs::DiagnosticArray::ConstPtr& array) {
        for (const auto& status : array->status)
          if (status.level == diagnostic_msgs::DiagnosticStatus::ERROR) alarms.push_back(status.message);
      });
  ros::Publisher forger = nodes.advertise<ControlCommand>("controller/command", keep_all);
  int forged = 0;
  Listener heard(nodes);
  heard.at_step = [&](const RotorState& state) {
    for (auto& killing : killings)
      if (killing.pid == 0 && state.time >= killing.time) {
        killing.pid = processOf(killing.node);
        killing.step = state.step;
        ASSERT_GT(killing.pid, 1) << killing.node;
        ASSERT_EQ(kill(killing.pid, SIGKILL), 0);
      }
    if (state.step < 300 || state.step % 100 != 0 || forged >= forgeries || forger.getNumSubscribers() == 0)
      return;
    ++forged;
    ControlCommand forgery;
    forgery.run = state.run;
    forgery.model_hash = state.model_hash;
    forgery.controller_memory.resize(4);
    forgery.command.ax = 2.0;  // would be seen
    forgery.valid_until = state.horizon;
    const auto send = [&](std::uint64_t run, std::uint64_t hash, std::uint64_t step) {
      ControlCommand answer = forgery;
      answer.run = run;
      answer.model_hash = hash;
      answer.step = step;
      forger.publish(answer);
    };
    send(state.run, state.model_hash, state.step - 200);      // late
    send(state.run + 1, state.model_hash, state.step);        // another run's
    send(state.run, state.model_hash + 1, state.step);        // another model's
    send(state.run, state.model_hash, state.step + 1000000);  // to a step that does not exist
  };
  ASSERT_TRUE(heard.hear()) << "the run did not end; last step " << heard.status.step;
  for (const auto& killing : killings) {
    EXPECT_GT(killing.pid, 1) << killing.node << " was not killed";
    EXPECT_NE(processOf(killing.node), killing.pid);
    EXPECT_TRUE(std::any_of(alarms.begin(), alarms.end(),
                            [&](const std::string& text) {
                              return text.find("stands still") != std::string::npos &&
                                     text.find(killing.node.substr(1)) != std::string::npos;
                            }))
        << "no alarm for " << killing.node;
  }
  EXPECT_EQ(forged, forgeries);
  EXPECT_EQ(heard.status.foreign_answers, 3U * forgeries);
  EXPECT_GE(heard.status.late_answers, static_cast<std::uint64_t>(forgeries));
  EXPECT_GT(heard.status.repeated_steps, 0U);

  const Model model = modelOf(own);
  const Simulation machine = simulate(model, scenarioOf(own));
  const Recording graph = heard.recording(killings[1].step), alone = recordingOf(machine);
  ASSERT_EQ(graph.time.size(), alone.time.size());
  EXPECT_LT(firstContact(alone), alone.time.size()) << "the run has contact";
  const double difference =
      largestDifference(graph, alone, firstContact(alone), model.rig.auxiliary_bearing.clearance_m);
  std::printf(
      "largest difference until the first contact: %.3g clearances; late %llu, foreign %llu, repeated steps "
      "%llu\n",
      difference, static_cast<unsigned long long>(heard.status.late_answers),
      static_cast<unsigned long long>(heard.status.foreign_answers),
      static_cast<unsigned long long>(heard.status.repeated_steps));
  EXPECT_LT(difference, untouched);
  expectEqual(graph, alone, model.rig.auxiliary_bearing.clearance_m,
              model.rig.auxiliary_bearing.rotor_radius_m, 0.3, true);
}

}  // namespace
}  // namespace amb_rotor

int main(int argc, char** argv) {
  ::testing::InitGoogleTest(&argc, argv);
  ros::init(argc, argv, "graph_disturbed");
  return RUN_ALL_TESTS();
}
