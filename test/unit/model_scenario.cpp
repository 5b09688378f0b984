// Scenario files: reading, broken rules, round trip.
#include "amb_rotor/model/scenario_reader.hpp"
#include "model_test_support.hpp"

namespace amb_rotor {
namespace {

using namespace model_test;

std::string scenarioFile() { return dataFolder() + "/model_scenario/scenario.yaml"; }

std::vector<Fault> faultsOfScenario(const std::string& text) {
  return faultsOf([&] { parseScenario(text, "scenario.yaml"); });
}

TEST(ModelScenario, readsEveryType) {
  const Scenario scenario = readScenario(scenarioFile());
  EXPECT_EQ(scenario.name, "everything");
  EXPECT_EQ(scenario.speed.type, SpeedType::ramp);
  EXPECT_EQ(scenario.speed.end_hz, 120.0);
  ASSERT_EQ(scenario.excitations.size(), 4u);
  EXPECT_EQ(scenario.excitations[0].kind, Excitation::Kind::current);
  EXPECT_EQ(scenario.excitations[0].end, 1);
  EXPECT_EQ(scenario.excitations[0].axis, 1);
  EXPECT_EQ(scenario.excitations[0].end_hz, 500.0);
  EXPECT_EQ(scenario.excitations[3].waveform, Waveform::sine);
  EXPECT_EQ(scenario.excitations[3].start_hz, 75.0);
  ASSERT_EQ(scenario.faults.size(), 7u);
  for (std::size_t i = 0; i < 7; ++i) EXPECT_EQ(scenario.faults[i].type, static_cast<FaultType>(i));
  EXPECT_EQ(scenario.faults[0].amount, 2e-4);
  EXPECT_EQ(scenario.faults[1].end, -1);
  EXPECT_EQ(scenario.faults[2].axis, 0);
  EXPECT_EQ(scenario.faults[4].phase_rad, 1.57);
  EXPECT_EQ(scenario.faults[6].amount, 60.0);
  EXPECT_FALSE(scenario.start_settled);
  EXPECT_EQ(scenario.initial_displacement_m.size(), 4u);
}

TEST(ModelScenario, roundTripGivesTheSameText) {
  const std::string once = scenarioText(readScenario(scenarioFile()));
  EXPECT_EQ(scenarioText(parseScenario(once, "again.yaml")), once);
  for (const char* speed :
       {"{type: constant, start_hz: 10, initial_angle_rad: 0}",
        "{type: decay, start_hz: 10, initial_angle_rad: 0, start_s: 0.1, decay_factor_per_s: 2}",
        "{type: free, start_hz: 10, initial_angle_rad: 0.5}"}) {
    const std::string text =
        std::string("format: amb-scenario/1\nname: s\nduration_s: 1\nrecord_rate_hz: 1e4\nspeed: ") + speed +
        "\nexcitations: []\nfaults: []\nstart: settled\n";
    const std::string written = scenarioText(parseScenario(text, "s.yaml"));
    EXPECT_EQ(scenarioText(parseScenario(written, "s.yaml")), written);
  }
}

TEST(ModelScenario, namesOfFaultTypes) {
  EXPECT_EQ(faultTypeFromName("amb_off"), FaultType::amb_off);
  EXPECT_STREQ(faultTypeName(FaultType::speed_change), "speed_change");
  EXPECT_FALSE(faultTypeFromName("amb"));
}

struct ScenarioChange {
  const char* from;
  const char* to;
  const char* key;
};

void PrintTo(const ScenarioChange& change, std::ostream* stream) {
  *stream << change.from << " -> " << change.to;
}

class ScenarioRule : public testing::TestWithParam<ScenarioChange> {};

TEST_P(ScenarioRule, isNamedWithKeyAndLine) {
  const std::string text = replaced(readTextFile(scenarioFile()), GetParam().from, GetParam().to);
  const auto faults = faultsOfScenario(text);
  ASSERT_EQ(faults.size(), 1u) << joined(faults);
  EXPECT_EQ(faults[0].key, GetParam().key);
  // A missing key is reported at the map that lacks it, here in the same line.
  const bool is_removed = *GetParam().to == '\0';
  EXPECT_EQ(faults[0].line,
            is_removed ? lineOf(readTextFile(scenarioFile()), GetParam().from) : lineOf(text, GetParam().to));
}

INSTANTIATE_TEST_SUITE_P(
    All, ScenarioRule,
    testing::Values(
        ScenarioChange{"record_rate_hz: 10000.0", "record_rate_hz: 0", "record_rate_hz"},
        ScenarioChange{"record_rate_hz: 10000.0", "record_rate_hz: 1e9", "record_rate_hz"},
        ScenarioChange{"start_hz: 20.0, end_hz: 120.0", "start_hz: -20.0, end_hz: 120.0", "speed.start_hz"},
        ScenarioChange{"end_hz: 120.0, duration_s: 0.5", "end_hz: 120.0, duration_s: 0", "speed.duration_s"},
        ScenarioChange{"end_hz: 120.0, ", "", "speed.end_hz"},
        ScenarioChange{"type: ramp,", "type: ramp, decay_factor_per_s: 1,", "speed.decay_factor_per_s"},
        ScenarioChange{"type: ramp,", "type: rump,", "speed.type"},
        ScenarioChange{"end: b, axis: y, amplitude_A", "end: both, axis: y, amplitude_A",
                       "excitations.0.end"},
        ScenarioChange{"end_hz: 500.0", "end_hz: 5.0", "excitations.0.end_hz"},
        ScenarioChange{"waveform: impulse", "waveform: bang", "excitations.2.waveform"},
        ScenarioChange{"frequency_hz: 75.0", "frequency_hz: 0", "excitations.3.frequency_hz"},
        ScenarioChange{"amplitude_N: 4.0", "amplitude_N: .nan", "excitations.1.amplitude_N"},
        ScenarioChange{"moment_kg_m: 2.0e-4", "moment_kg_m: -2.0e-4", "faults.0.moment_kg_m"},
        ScenarioChange{"ramp_s: 0.01", "ramp_s: 0.3", "faults.0.ramp_s"},
        ScenarioChange{"type: amb_on, start_s: 0.4", "type: amb_on, start_s: 4", "faults.2.start_s"},
        ScenarioChange{"type: amb_on, start_s: 0.4", "type: amb_one, start_s: 0.4", "faults.2.type"},
        ScenarioChange{"offset_m: 1.0e-5", "offset_m: 1.0e-5, force_N: 1", "faults.5.force_N"},
        ScenarioChange{"speed_hz: 60.0", "speed_hz: -60.0", "faults.6.speed_hz"},
        ScenarioChange{"velocity: [0, 0, 0, 0]", "velocity: [0, 0]", "start.velocity"},
        ScenarioChange{"displacement: [1.0e-5, 0, 0, 0]", "displacement: [1.0e-5, 0, 0, x]",
                       "start.displacement.3"}));

INSTANTIATE_TEST_SUITE_P(
    Units, ScenarioRule,  // what is typed where a number has another unit
    testing::Values(ScenarioChange{"end_hz: 120.0, duration_s: 0.5", "end_hz: 60000.0, duration_s: 0.5", "speed.end_hz"},
                    ScenarioChange{"speed_hz: 60.0", "speed_hz: 36000.0", "faults.6.speed_hz"},
                    ScenarioChange{"frequency_hz: 75.0", "frequency_hz: 75.0e6", "excitations.3.frequency_hz"},
                    ScenarioChange{"offset_m: 1.0e-5", "offset_m: -10.0", "faults.5.offset_m"},
                    ScenarioChange{"moment_kg_m: 2.0e-4", "moment_kg_m: 200.0", "faults.0.moment_kg_m"},
                    ScenarioChange{"amplitude_N: 4.0", "amplitude_N: -4.0e8", "excitations.1.amplitude_N"},
                    ScenarioChange{"displacement: [1.0e-5, 0, 0, 0]", "displacement: [0.1, 0, 0, 0]", "start.displacement.0"},
                    ScenarioChange{"displacement: [1.0e-5, 0, 0, 0]", "displacement: [1.0e-5, 0, 0, 1.0]", "start.displacement.3"},
                    ScenarioChange{"velocity: [0, 0, 0, 0]", "velocity: [0, 500, 0, 0]", "start.velocity.1"}));

TEST(ModelScenario, tellsAllFaultsAtOnce) {
  const auto faults = faultsOfScenario(
      "format: amb-scenario/1\nname: s\nduration_s: -1\nspeed: {type: constant}\nexcitations: {}\n"
      "faults: [{type: amb_off}]\nstart: now\nextra: 1\n");
  for (const char* key :
       {"duration_s", "record_rate_hz", "speed.start_hz", "speed.initial_angle_rad", "excitations",
        "faults.0.end", "faults.0.axis", "faults.0.start_s", "faults.0.duration_s", "start", "extra"})
    faultOf(faults, key);
  EXPECT_EQ(faults.size(), 11u) << joined(faults);
}

}  // namespace
}  // namespace amb_rotor
