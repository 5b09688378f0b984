// Faults by topic: a run into which they are published equals the machine with the same faults in its
// scenario.
#include "amb_rotor/model/scenario_reader.hpp"
#include "graph_listener.hpp"

namespace amb_rotor {
namespace {

using namespace testing;

FaultMessage faultOf(std::uint8_t type, double start, double ramp, double duration, double amount) {
  FaultMessage fault;
  fault.type = type;
  fault.start_mode = FaultMessage::ABSOLUTE;
  fault.start = start;
  fault.ramp = ramp;
  fault.duration = duration;
  fault.amount = amount;
  return fault;
}

std::vector<FaultMessage> goodFaults() {
  std::vector<FaultMessage> faults = {faultOf(FaultMessage::UNBALANCE_STEP, 0.2, 0.02, 0.1, 5e-5),
                                      faultOf(FaultMessage::AMB_OFF, 0.25, 0.0, 0.01, 0.0),
                                      faultOf(FaultMessage::FORCE_IMPULSE, 0.30005, 0.0, 0.003, 40.0),
                                      faultOf(FaultMessage::SENSOR_OFFSET, 0.35, 0.01, 0.05, 2e-5),
                                      faultOf(FaultMessage::SPEED_CHANGE, 0.4, 0.05, 0.0, 80.0)};
  faults[0].plane_z = 0.05;
  faults[0].phase = 1.0;
  faults[1].end = FaultMessage::END_B;  // one axis of one bearing
  faults[1].axis = FaultMessage::AXIS_Y;
  faults[2].plane_z = -0.05;
  faults[2].phase = 0.7;
  faults[3].end = FaultMessage::END_A;
  faults[3].axis = FaultMessage::AXIS_X;
  return faults;
}

TEST(Graph, FaultsByTopicEqualFaultsOfTheScenario) {
  ros::NodeHandle nodes, own("~");
  ros::Publisher publisher = nodes.advertise<FaultMessage>("fault", keep_all);
  Listener heard(nodes);
  bool sent = false;
  heard.at_step = [&](const RotorState&) {
    if (sent || publisher.getNumSubscribers() == 0) return;
    sent = true;
    for (const auto& fault : goodFaults()) publisher.publish(fault);
    FaultMessage delayed = faultOf(FaultMessage::FORCE_IMPULSE, 0.3, 0.0, 0.001, 20.0);
    delayed.start_mode = FaultMessage::DELAY;
    publisher.publish(delayed);
    publisher.publish(FaultMessage());                                              // no type
    publisher.publish(faultOf(FaultMessage::SENSOR_OFFSET, 0.3, -1.0, 0.0, 1e-5));  // a ramp below 0
  };
  ASSERT_TRUE(heard.hear()) << "the run did not end; last step " << heard.status.step;
  ASSERT_TRUE(sent);
  ASSERT_EQ(heard.injection->faults.size(), goodFaults().size() + 1);
  EXPECT_EQ(heard.injection->rejected, 2U);
  EXPECT_GT(heard.injection->faults.back().start, 0.3);  // from the step at which it came
  EXPECT_EQ(heard.injection->faults.back().start_mode, FaultMessage::ABSOLUTE);

  const Model model = modelOf(own);
  Scenario scenario = scenarioOf(own);
  const Recording quiet = recordingOf(simulate(model, scenario));
  for (const auto& fault : heard.injection->faults) scenario.faults.push_back(faultFrom(fault, 0.0));
  const Recording graph = heard.recording(), machine = recordingOf(simulate(model, scenario));
  ASSERT_EQ(graph.time.size(), machine.time.size());
  const double clearance = model.rig.auxiliary_bearing.clearance_m;
  const double difference = largestDifference(graph, machine, graph.time.size(), clearance);
  const double effect = largestDifference(quiet, machine, graph.time.size(), clearance);
  std::printf("largest difference %.3g clearances, of a motion of %.3g\n", difference, effect);
  EXPECT_LT(difference, displacement_tolerance);
  EXPECT_GT(effect, 20.0 * displacement_tolerance) << "the faults are seen";
  for (std::size_t i = 0; i < graph.angle.size(); ++i)
    ASSERT_NEAR(graph.angle[i], machine.angle[i], 1e-6) << "at " << graph.time[i] << " s";
}

}  // namespace
}  // namespace amb_rotor

int main(int argc, char** argv) {
  ::testing::InitGoogleTest(&argc, argv);
  ros::init(argc, argv, "graph_faults");
  return RUN_ALL_TESTS();
}
