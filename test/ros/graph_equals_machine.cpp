// The launched graph against the machine in process: listens to a run from its first step, then simulates the
// same model and scenario. Parameters: `contact` (whether the rotor touches), `settled_from` [s].
#include "graph_listener.hpp"

namespace amb_rotor {
namespace {

using namespace testing;

TEST(Graph, EqualsMachine) {
  ros::NodeHandle nodes, own("~");
  const Listener heard(nodes);
  ASSERT_TRUE(heard.hear()) << "the run did not end; last step " << heard.status.step;
  const Model model = modelOf(own);
  const Simulation machine = simulate(model, scenarioOf(own));
  ASSERT_EQ(machine.outcome.status, RunStatus::ok) << machine.outcome.reason;
  std::printf("%llu steps, %.0f us a step\n", static_cast<unsigned long long>(heard.status.step),
              1e6 * heard.status.wall_time / static_cast<double>(heard.status.step));
  expectEqual(heard.recording(), recordingOf(machine), model.rig.auxiliary_bearing.clearance_m,
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
