// Remarks: numbers of an unusual size are told with their line, usual ones are not.
#include "amb_rotor/model/overrides.hpp"
#include "amb_rotor/model/remarks.hpp"
#include "amb_rotor/model/scenario_reader.hpp"
#include "model_test_support.hpp"

namespace amb_rotor {
namespace {

using namespace model_test;

std::vector<Fault> remarksOnText(const std::string& from, const std::string& to) {
  return remarksOn(parseModel(replaced(validText(), from, to), "model.yaml", smallCatalogue()));
}

std::string scenarioText(const std::string& from, const std::string& to) {
  return replaced(readTextFile(dataFolder() + "/model_scenario/scenario.yaml"), from, to);
}

TEST(ModelRemarks, AUsualModelAndScenarioHaveNone) {
  EXPECT_TRUE(remarksOn(validModel()).empty()) << joined(remarksOn(validModel()));
  const Scenario scenario = readScenario(dataFolder() + "/model_scenario/scenario.yaml");
  EXPECT_TRUE(remarksOn(scenario).empty()) << joined(remarksOn(scenario));
  EXPECT_TRUE(remarksOn(validModel(), scenario).empty());
}

TEST(ModelRemarks, ANumberOfAnotherUnitIsToldWithItsLine) {
  struct Case {
    const char *from, *to, *key, *word;
  };
  for (const Case& one : std::vector<Case>{
           {"stiffness_N_per_m: 3.38e7", "stiffness_N_per_m: 33.8", "rig.auxiliary_bearing.contact.stiffness_N_per_m", "33.8 N/um"},
           {"displacement_stiffness_N_per_m: 39700.0", "displacement_stiffness_N_per_m: 39.7",
            "rig.amb.displacement_stiffness_N_per_m", "39.7 N/mm"},
           {"clearance_m: 0.3e-3", "clearance_m: 0.3e-6", "rig.auxiliary_bearing.clearance_m", "0.3 mm"},
           {"phase_rad: 0.", "phase_rad: 90.", "rig.unbalance.0.phase_rad", "degrees"},
           {"moment_kg_m: 6.0e-5", "moment_kg_m: 6.0e-3", "rig.unbalance.0.moment_kg_m", "eccentricity"}}) {
    const auto remarks = remarksOnText(one.from, one.to);
    const Fault remark = faultOf(remarks, one.key);
    EXPECT_EQ(remark.file, "model.yaml");
    EXPECT_EQ(remark.line, lineOf(replaced(validText(), one.from, one.to), one.to)) << remark.text();
    EXPECT_NE(remark.rule.find(one.word), std::string::npos) << remark.text();
  }
}

TEST(ModelRemarks, AWeightThatTheMagnetsDoNotCarryIsTold) {
  // Ki 19 N/A times the 2.5 A that are left, at both ends: 95 N, 9.68 kg
  Model model = validModel();
  model.rig.gravity_m_s2 = 9.81;
  model.rig.rotor.mass_kg = 9.6;
  EXPECT_TRUE(remarksOn(model).empty()) << joined(remarksOn(model));
  model.rig.rotor.mass_kg = 9.8;
  EXPECT_NE(faultOf(remarksOn(model), "rig.rotor.mass_kg").rule.find("95.0 N"), std::string::npos);
}

TEST(ModelRemarks, AStiffnessFarFromWhatBiasAndGapGiveIsTold) {
  Model model = validModel();
  const double expected = 19.0 * 2.5 / 0.75e-3;
  auto& ks = model.rig.amb.displacement_stiffness_N_per_m;
  for (const double factor : {1.0 / 29.0, 29.0}) {
    ks = factor * expected;
    EXPECT_TRUE(remarksOn(model).empty()) << joined(remarksOn(model));
  }
  for (const double factor : {1.0 / 31.0, 31.0}) {
    ks = factor * expected;
    EXPECT_NE(faultOf(remarksOn(model), "rig.amb.displacement_stiffness_N_per_m").rule.find("Ki i0/s0"), std::string::npos);
  }
}

TEST(ModelRemarks, AnOverrideIsNotTheFilesLine) {
  Model model = validModel();
  applyOverride(model, "rig.auxiliary_bearing.contact.stiffness_N_per_m=33.8", smallCatalogue());
  const Fault remark = faultOf(remarksOn(model), "rig.auxiliary_bearing.contact.stiffness_N_per_m");
  EXPECT_EQ(remark.file, "");
  EXPECT_EQ(remark.line, 0);
  EXPECT_EQ(remark.value, "33.8");
}

TEST(ModelRemarks, ASpeedInTurnsAMinuteIsTold) {
  const std::string text = scenarioText("end_hz: 120.0, duration_s: 0.5", "end_hz: 6000.0, duration_s: 0.5");
  const Scenario scenario = parseScenario(text, "scenario.yaml");
  const Fault remark = faultOf(remarksOn(scenario), "speed.end_hz");
  EXPECT_EQ(remark.line, lineOf(text, "end_hz: 6000.0"));
  EXPECT_NE(remark.rule.find("turns a minute"), std::string::npos);
  // and the controller, 10 kHz, does not see it
  EXPECT_NE(faultOf(remarksOn(validModel(), scenario), "speed.end_hz").rule.find("5000.0 Hz"), std::string::npos);
}

TEST(ModelRemarks, AnglesInDegreesAreTold) {
  const Scenario scenario = parseScenario(scenarioText("direction_rad: 1.57", "direction_rad: 90.0"), "scenario.yaml");
  EXPECT_EQ(remarksOn(scenario).size(), 1u);
}

}  // namespace
}  // namespace amb_rotor
