// Model files: reading, every rule broken once, writing, hash.
#include <unistd.h>

#include <filesystem>

#include "amb_rotor/model/model_hash.hpp"
#include "amb_rotor/model/model_rules.hpp"
#include "amb_rotor/model/model_writer.hpp"
#include "model_test_support.hpp"

namespace amb_rotor {
namespace {

using namespace model_test;

std::vector<Fault> faultsOfModel(const std::string& text) {
  return faultsOf([&] { parseModel(text, "model.yaml", smallCatalogue()); });
}

TEST(ModelFile, readsEveryValue) {
  const Model model = validModel();
  EXPECT_EQ(model.name, "small-rig");
  EXPECT_EQ(model.rotor_model, RotorModel::rigid_beam);
  EXPECT_EQ(model.amb_model, AmbModel::linear);
  EXPECT_EQ(model.rig.rotor.mass_kg, 3.36);
  EXPECT_EQ(model.rig.planes.aux[0], -0.14);
  EXPECT_EQ(model.rig.amb.air_gap_m, 0.75e-3);
  EXPECT_EQ(model.rig.amb.stiffness_N_per_m, 0.0);
  EXPECT_EQ(model.rig.controller.delay_s, 1e-4);
  EXPECT_EQ(model.rig.auxiliary_bearing.damping_N_s_per_m, 300.0);
  ASSERT_EQ(model.rig.unbalance.size(), 1u);
  EXPECT_EQ(model.rig.unbalance[0].phase_rad, 0.3);
  EXPECT_EQ(model.uncertainty.size(), 3u);  // the one of 0 means the same as none
  EXPECT_EQ(model.uncertainty.at("sensor.offset_m"), 1e-6);
  ASSERT_EQ(model.effects.size(), 1u);
  EXPECT_EQ(model.effects[0].values, (std::vector<double>{1e-6, 0.1}));
  EXPECT_NE(model.revision.find("0123456789abcdef"), std::string::npos);
}

struct BrokenRule {
  const char* from;
  const char* to;
  const char* key;
  const char* rule;  ///< part of the rule's text
};

void PrintTo(const BrokenRule& broken, std::ostream* stream) {
  *stream << broken.from << " -> " << broken.to;
}

class ModelRule : public testing::TestWithParam<BrokenRule> {};

TEST_P(ModelRule, isNamedWithKeyAndLine) {
  const BrokenRule& broken = GetParam();
  const std::string text = replaced(validText(), broken.from, broken.to);
  const auto faults = faultsOfModel(text);
  ASSERT_EQ(faults.size(), 1u) << joined(faults);
  EXPECT_EQ(faults[0].key, broken.key);
  EXPECT_EQ(faults[0].file, "model.yaml");
  // A missing key is reported at the map that lacks it, here in the same line.
  const bool is_removed = *broken.to == '\0';
  EXPECT_EQ(faults[0].line, is_removed ? lineOf(validText(), broken.from) : lineOf(text, broken.to))
      << joined(faults);
  EXPECT_NE(faults[0].rule.find(broken.rule), std::string::npos) << faults[0].text();
}

INSTANTIATE_TEST_SUITE_P(
    Limits, ModelRule,
    testing::Values(
        BrokenRule{"mass_kg: 3.36", "mass_kg: 0.0", "rig.rotor.mass_kg", "above 0.0 kg"},
        BrokenRule{"transverse_inertia_kg_m2: 0.017", "transverse_inertia_kg_m2: -0.017",
                   "rig.rotor.transverse_inertia_kg_m2", "above 0.0 kg m2"},
        BrokenRule{"polar_inertia_kg_m2: 0.001", "polar_inertia_kg_m2: -0.1", "rig.rotor.polar_inertia_kg_m2",
                   "from 0.0 kg m2"},
        BrokenRule{"current_stiffness_N_per_A: 19.0", "current_stiffness_N_per_A: -19",
                   "rig.amb.current_stiffness_N_per_A", "above 0.0 N/A"},
        BrokenRule{"displacement_stiffness_N_per_m: 39700.0", "displacement_stiffness_N_per_m: -1",
                   "rig.amb.displacement_stiffness_N_per_m", "from 0.0 N/m"},
        BrokenRule{"bias_current_A: 2.5", "bias_current_A: 0", "rig.amb.bias_current_A", "above 0.0 A"},
        BrokenRule{"air_gap_m: 0.75e-3", "air_gap_m: 0", "rig.amb.air_gap_m", "above 0.0 m"},
        BrokenRule{"bias_flux_density_T: 0.45", "bias_flux_density_T: -1", "rig.amb.bias_flux_density_T",
                   "0.0 T"},
        BrokenRule{"bandwidth_hz: 2000.0", "bandwidth_hz: 0", "rig.amb.amplifier_bandwidth_hz",
                   "above 0.0 Hz"},
        BrokenRule{"sample_rate_hz: 10000.0", "sample_rate_hz: 0", "rig.controller.sample_rate_hz",
                   "above 0.0 Hz"},
        BrokenRule{"kp_A_per_m: 13850.0", "kp_A_per_m: -1", "rig.controller.kp_A_per_m", "from 0.0 A/m"},
        BrokenRule{"kd_A_s_per_m: 16.0", "kd_A_s_per_m: -1", "rig.controller.kd_A_s_per_m", "from 0.0 A s/m"},
        BrokenRule{"ki_A_per_m_s: 0.0", "ki_A_per_m_s: -1", "rig.controller.ki_A_per_m_s",
                   "from 0.0 A/(m s)"},
        BrokenRule{"derivative_filter_hz: 2000.0", "derivative_filter_hz: 0",
                   "rig.controller.derivative_filter_hz", "above 0.0 Hz"},
        BrokenRule{"delay_s: 1.0e-4", "delay_s: -1e-4", "rig.controller.delay_s", "from 0.0 s"},
        BrokenRule{"clearance_m: 0.3e-3", "clearance_m: 0", "rig.auxiliary_bearing.clearance_m",
                   "above 0.0 m"},
        BrokenRule{"rotor_radius_m: 0.012", "rotor_radius_m: 0", "rig.auxiliary_bearing.rotor_radius_m",
                   "above 0.0"},
        BrokenRule{"stiffness_N_per_m: 3.38e7", "stiffness_N_per_m: 0",
                   "rig.auxiliary_bearing.contact.stiffness_N_per_m", "above 0.0 N/m"},
        BrokenRule{"damping_N_s_per_m: 300.0", "damping_N_s_per_m: -3",
                   "rig.auxiliary_bearing.contact.damping_N_s_per_m", "from 0.0 N s/m"},
        BrokenRule{"friction_coefficient: 0.1", "friction_coefficient: -0.1",
                   "rig.auxiliary_bearing.friction_coefficient", "from 0.0 to 2.0 ("},
        BrokenRule{"friction_coefficient: 0.1", "friction_coefficient: 2.1",
                   "rig.auxiliary_bearing.friction_coefficient", "from 0.0 to 2.0 ("},
        BrokenRule{"moment_kg_m: 6.0e-5", "moment_kg_m: -6.0e-5", "rig.unbalance.0.moment_kg_m",
                   "from 0.0 kg m"},
        BrokenRule{"gravity_m_s2: 0.0", "gravity_m_s2: -9.81", "rig.gravity_m_s2", "from 0.0 m/s2"}));

INSTANTIATE_TEST_SUITE_P(
    Units, ModelRule,  // what is typed where a number has another unit
    testing::Values(
        BrokenRule{"amb: {a: -0.096, b: 0.096}", "amb: {a: -0.096, b: 96.0}", "rig.planes.amb.b", "from -20.0 to 20.0 m"},
        BrokenRule{"air_gap_m: 0.75e-3", "air_gap_m: 0.75", "rig.amb.air_gap_m", "at most 0.05 m"},
        BrokenRule{"rotor_radius_m: 0.012", "rotor_radius_m: 12", "rig.auxiliary_bearing.rotor_radius_m", "at most 2.0 m"},
        BrokenRule{"gravity_m_s2: 0.0", "gravity_m_s2: 9810.0", "rig.gravity_m_s2", "at most 300.0 m/s2"},
        BrokenRule{"delay_s: 1.0e-4", "delay_s: 100.0", "rig.controller.delay_s", "at most 1.0 s"},
        BrokenRule{"mass_kg: 3.36", "mass_kg: 3360.0", "rig.rotor.transverse_inertia_kg_m2", "radius of gyration"},
        BrokenRule{"transverse_inertia_kg_m2: 0.017", "transverse_inertia_kg_m2: 170.0", "rig.rotor.transverse_inertia_kg_m2",
                   "radius of gyration"},
        BrokenRule{"moment_kg_m: 6.0e-5", "moment_kg_m: 60.0", "rig.unbalance.0.moment_kg_m", "eccentricity"},
        BrokenRule{"stiffness_N_per_m: 3.38e7", "stiffness_N_per_m: 3.38e16",
                   "rig.auxiliary_bearing.contact.stiffness_N_per_m", "at most 1.0e+13 N/m"}));

INSTANTIATE_TEST_SUITE_P(
    Relations, ModelRule,
    testing::Values(BrokenRule{"polar_inertia_kg_m2: 0.001", "polar_inertia_kg_m2: 0.035",
                               "rig.rotor.polar_inertia_kg_m2", "twice the transverse inertia"},
                    BrokenRule{"amb: {a: -0.096, b: 0.096}", "amb: {a: 0.096, b: 0.096}", "rig.planes.amb.b",
                               "above plane a"},
                    BrokenRule{"sensor: {a: -0.118, b: 0.118}", "sensor: {a: 0.2, b: 0.1}",
                               "rig.planes.sensor.b", "above plane"},
                    BrokenRule{"aux: {a: -0.140, b: 0.140}", "aux: {a: 0.2, b: 0.1}", "rig.planes.aux.b",
                               "above plane a"},
                    BrokenRule{"clearance_m: 0.3e-3", "clearance_m: 0.75e-3",
                               "rig.auxiliary_bearing.clearance_m", "air gap"},
                    BrokenRule{"bias_current_A: 2.5", "bias_current_A: 5.1", "rig.amb.bias_current_A",
                               "max_current_A, 5.0 A"},
                    BrokenRule{"delay_s: 1.0e-4", "delay_s: 2.1e-3", "rig.controller.delay_s",
                               "20.0 samples, 0.002 s"},
                    BrokenRule{"rotor.mass_kg: 0.005", "rotor.mass: 0.005", "rig.uncertainty.rotor.mass",
                               "rotor.mass_kg"},
                    BrokenRule{"rotor.mass_kg: 0.005", "rotor.mass_kg: -0.005",
                               "rig.uncertainty.rotor.mass_kg", "from 0"},
                    BrokenRule{"planes.amb.a: 0.0", "planes.amb.c: 0.0", "rig.uncertainty.planes.amb.c",
                               "nearest: planes.amb.a"}));

INSTANTIATE_TEST_SUITE_P(
    Wording, ModelRule,
    testing::Values(BrokenRule{"mass_kg: 3.36", "mass_kg: .nan", "rig.rotor.mass_kg", "finite number"},
                    BrokenRule{"mass_kg: 3.36", "mass_kg: .inf", "rig.rotor.mass_kg", "finite number"},
                    BrokenRule{"mass_kg: 3.36", "mass_kg: heavy", "rig.rotor.mass_kg", "finite number"},
                    BrokenRule{"mass_kg: 3.36", "mass_kg: 3.36, mass_kg: 3.36", "rig.rotor.mass_kg",
                               "stands twice"},
                    BrokenRule{"mass_kg: 3.36, ", "", "rig.rotor.mass_kg", "missing"},
                    BrokenRule{"mount: rigid", "mount: soft", "rig.auxiliary_bearing.mount", "must be rigid"},
                    BrokenRule{"type: pid", "type: lqr", "rig.controller.type", "must be one of pid, state_space"},
                    BrokenRule{"model: linear, stiffness", "model: hertz, stiffness",
                               "rig.auxiliary_bearing.contact.model", "must be linear"},
                    BrokenRule{"gravity_m_s2: 0.0", "gravitation: 1\n  gravity_m_s2: 0.0", "rig.gravitation",
                               "gravity_m_s2"},
                    BrokenRule{"model: rigid_beam", "model: rigid_bean", "rotor.model",
                               "rigid_mass, rigid_beam, flexible"},
                    BrokenRule{"model: rigid_beam", "model: flexible, geometry: none.yaml", "rotor.geometry",
                               "no such file"},
                    BrokenRule{"model: rigid_beam", "model: rigid_beam, geometry: none.yaml",
                               "rotor.geometry", "not known"},
                    BrokenRule{"model: rigid_beam", "model: rigid_beam, reduction: {method: modal, modes: 4}",
                               "rotor.reduction", "not known"},
                    BrokenRule{"model: rigid_beam",
                               "model: flexible, geometry: " AMB_ROTOR_SOURCE_DIR "/config/thesis/rotor.yaml, reduction: {method: hankel, modes: 4}",
                               "rotor.reduction.method", "modal, craig_bampton, balanced"},
                    BrokenRule{"model: rigid_beam",
                               "model: flexible, geometry: " AMB_ROTOR_SOURCE_DIR "/config/thesis/rotor.yaml, reduction: {method: modal, modes: 1}",
                               "rotor.reduction.modes", "whole number from 2 to 64"},
                    BrokenRule{"model: rigid_beam",
                               "model: flexible, geometry: " AMB_ROTOR_SOURCE_DIR "/config/thesis/rotor.yaml, reduction: {method: craig_bampton, modes: 2.5}",
                               "rotor.reduction.modes", "whole number from 0 to 64"},
                    BrokenRule{"format: amb-model/1", "format: amb-model/2", "format", "must be amb-model/1"},
                    BrokenRule{"name: small-rig", "name:", "name", "no value"}));

INSTANTIATE_TEST_SUITE_P(
    Effects, ModelRule,
    testing::Values(
        BrokenRule{"effect: sensor_runout", "effect: sensor_runoff", "effects.0.effect",
                   "nearest: sensor_runout"},
        BrokenRule{"a_1x_m: 1.0e-6", "a_1x_m: 1.0e-3", "effects.sensor_runout.a_1x_m",
                   "from 0.0 to 1.0e-04 m"},
        BrokenRule{"a_1x_m: 1.0e-6, ", "", "effects.sensor_runout.a_1x_m", "missing"},
        BrokenRule{"a_1x_phase_rad: 0.1", "a_1x_phase_rad: 0.1, a_3x_m: 0", "effects.sensor_runout.a_3x_m",
                   "not known"},
        BrokenRule{"revision:\n",
                   "  - {effect: sensor_runout, parameters: {a_1x_m: 0, a_1x_phase_rad: 0}}\nrevision:\n",
                   "effects.sensor_runout", "stands twice"}));

TEST(ModelFile, tellsAllFaultsAtOnceInTheOrderOfTheirLines) {
  std::string text = replaced(validText(), "mass_kg: 3.36", "mass_kg: -1");
  text = replaced(text, "b: 0.118", "b: -0.118, c: 1");
  text = replaced(text, "kp_A_per_m: 13850.0", "kp_A_per_m: \"13850\"");
  text = replaced(text, "mount: rigid", "mount: soft");
  text = replaced(text, "a_1x_m: 1.0e-6", "a_1x_m: -1");
  const auto faults = faultsOfModel(text);
  const std::vector<std::string> keys = {"rig.rotor.mass_kg",           "rig.planes.sensor.c",
                                         "rig.planes.sensor.b",         "rig.controller.kp_A_per_m",
                                         "rig.auxiliary_bearing.mount", "effects.sensor_runout.a_1x_m"};
  ASSERT_EQ(faults.size(), keys.size()) << joined(faults);
  for (std::size_t i = 0; i < keys.size(); ++i) EXPECT_EQ(faults[i].key, keys[i]) << joined(faults);
  for (std::size_t i = 1; i < keys.size(); ++i) EXPECT_LE(faults[i - 1].line, faults[i].line);
  EXPECT_EQ(faults[0].text(),
            "model.yaml:4: rig.rotor.mass_kg = -1: must be above 0.0 kg (a rotor has a mass)");
}

std::string equivalentText() {
  std::string text = validText();
  const std::size_t amb = text.find("  amb:\n    model: linear");
  const std::size_t bearing = text.find("  auxiliary_bearing:");
  return text.replace(amb, bearing - amb,
                      "  amb: {model: equivalent, stiffness_N_per_m: 5.9561e5, damping_N_s_per_m: 50.0}\n");
}

TEST(ModelFile, equivalentBearingHasNoControllerAndNoCoil) {
  const Model model = parseModel(equivalentText(), "model.yaml", smallCatalogue());
  EXPECT_EQ(model.amb_model, AmbModel::equivalent);
  EXPECT_EQ(model.rig.amb.stiffness_N_per_m, 5.9561e5);
  EXPECT_EQ(model.rig.controller.sample_rate_hz, 0.0);
  const auto faults = faultsOfModel(replaced(
      replaced(equivalentText(), "damping_N_s_per_m: 50.0", "damping_N_s_per_m: -50.0, bias_current_A: 1"),
      "  gravity", "  controller: {type: pid}\n  gravity"));
  EXPECT_EQ(faults.size(), 3u) << joined(faults);
  faultOf(faults, "rig.amb.damping_N_s_per_m");
  faultOf(faults, "rig.amb.bias_current_A");
  faultOf(faults, "rig.controller");
}

TEST(ModelFile, clearanceNeedNotBeBelowAnAirGapWithoutOne) {
  const std::string text = replaced(equivalentText(), "clearance_m: 0.3e-3", "clearance_m: 10.0e-3");
  EXPECT_TRUE(faultsOfModel(text).empty());
}

TEST(ModelFile, roundTripGivesTheSameBits) {
  for (const std::string& source : {validText(), equivalentText()}) {
    Model model = parseModel(source, "model.yaml", smallCatalogue());
    model.rig.rotor.mass_kg = 3.36 / 1.1;
    model.rig.unbalance.push_back({1.0 / 3.0, 1e-7 / 3.0, -2.0 / 7.0});
    model.name = "a name: with \"signs\"";
    const std::string text = modelText(model, smallCatalogue());
    Model back = parseModel(text, "model.yaml", smallCatalogue());
    EXPECT_EQ(modelText(back, smallCatalogue()), text);
    const auto fields = modelFields(model, smallCatalogue());
    const auto back_fields = modelFields(back, smallCatalogue());
    ASSERT_EQ(fields.size(), back_fields.size());
    for (std::size_t i = 0; i < fields.size(); ++i)
      EXPECT_EQ(*fields[i].value, *back_fields[i].value) << fields[i].path;
    EXPECT_EQ(back.name, model.name);
    EXPECT_EQ(back.uncertainty, model.uncertainty);
    EXPECT_EQ(back.revision, model.revision);
  }
}

TEST(ModelFile, onlyValidModelsAreWritten) {
  Model model = validModel();
  model.rig.rotor.mass_kg = -1.0;
  EXPECT_EQ(faultsOf([&] { modelText(model, smallCatalogue()); }).size(), 1u);
}

TEST(ModelFile, geometryHoldsFromAnotherFolder) {
  namespace fs = std::filesystem;
  const fs::path folder =
      fs::path(testing::TempDir()) / ("amb_rotor_model_file_" + std::to_string(::getpid()));
  fs::create_directories(folder / "a");
  fs::create_directories(folder / "b");
  writeTextFile((folder / "a" / "shaft.yaml").string(), "x: 1\n");
  const std::string source = (folder / "a" / "model.yaml").string();
  writeTextFile(source, replaced(validText(), "model: rigid_beam",
                                 "model: flexible, geometry: shaft.yaml, reduction: {method: craig_bampton, modes: 3}"));
  const Model model = readModel(source, smallCatalogue());
  EXPECT_EQ(model.rotor_geometry, "shaft.yaml");
  const std::string target = (folder / "b" / "model.yaml").string();
  writeModel(model, smallCatalogue(), target);
  const Model moved = readModel(target, smallCatalogue());
  EXPECT_EQ(moved.rotor_geometry, "../a/shaft.yaml");
  EXPECT_EQ(moved.reduction.method, RotorReduction::Method::craig_bampton);
  EXPECT_EQ(moved.reduction.modes, 3);
  EXPECT_EQ(
      faultsOf([&] { writeModel(model, smallCatalogue(), (folder / "none" / "m.yaml").string()); }).size(),
      1u);
  fs::remove_all(folder);
}

TEST(ModelHash, fnv1aOfKnownTexts) {
  // Published test vectors of FNV-1a 64.
  EXPECT_EQ(fnv1a(""), 0xcbf29ce484222325ull);
  EXPECT_EQ(fnv1a("a"), 0xaf63dc4c8601ec8cull);
  EXPECT_EQ(fnv1a("foobar"), 0x85944171f73967e8ull);
}

TEST(ModelHash, changesWithEveryNumberOfThePhysics) {
  Model model = validModel();
  const std::string hash = modelHash(model, smallCatalogue());
  EXPECT_EQ(hash.size(), 16u);
  for (const ModelField& field : modelFields(model, smallCatalogue())) {
    const double before = *field.value;
    *field.value = before == 0.0 ? 1e-12 : before * (1.0 + 1e-12);
    EXPECT_NE(modelHash(model, smallCatalogue()), hash) << field.path;
    *field.value = before;
  }
  Model other = model;
  other.rotor_model = RotorModel::rigid_mass;
  EXPECT_NE(modelHash(other, smallCatalogue()), hash);
  other = model;
  other.effects.clear();
  EXPECT_NE(modelHash(other, smallCatalogue()), hash);
  other = model;
  other.rig.unbalance.push_back({});
  EXPECT_NE(modelHash(other, smallCatalogue()), hash);
}

TEST(ModelHash, doesNotChangeWithWhatIsNoPhysics) {
  Model model = validModel();
  model.effects.push_back({"control_delay", {1e-4}});
  const std::string hash = modelHash(model, smallCatalogue());
  model.name = "other";
  model.folder = "elsewhere";
  model.revision = "";
  model.uncertainty.clear();
  std::swap(model.effects[0], model.effects[1]);
  model.rig.gravity_m_s2 = -0.0;
  model.rig.amb.stiffness_N_per_m = 5.0;  // has no meaning for a linear bearing
  EXPECT_EQ(modelHash(model, smallCatalogue()), hash);
}

TEST(ModelRules, thereIsOneLimitForEveryField) {
  Rig<double> rig;
  rig.unbalance.resize(1);
  std::size_t index = 0;
  Rig<double>::visit(rig, [&](const char* name, double&) {
    ASSERT_LT(index, rigLimits().size());
    EXPECT_STREQ(rigLimits()[index++].path, name);
  });
  EXPECT_EQ(index, rigLimits().size());
}

}  // namespace
}  // namespace amb_rotor
