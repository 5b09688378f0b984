// Effect files: what they hold, every fault at once with its line, and models that bring their effects along.
#include <unistd.h>

#include <cmath>
#include <filesystem>

#include "amb_rotor/effects/law_effect.hpp"
#include "amb_rotor/model/effect_file.hpp"
#include "amb_rotor/model/model_hash.hpp"
#include "amb_rotor/model/model_writer.hpp"
#include "model_test_support.hpp"

namespace amb_rotor {
namespace {

using namespace model_test;

const std::string cubic = R"yaml(format: amb-effect/1
effect: cubic_spring
summary: "a spring that grows with the cube"
excited_by: "large and small amplitudes"
place: magnetic_bearings
parameters:
  - {name: cube_N_per_m3, unit: "N/m3", lower: -1.0e15, upper: 1.0e15, typical: -1.0e12, neutral: 0.0, meaning: "per |p|^2 p"}
where:
  square: "x^2 + y^2"
law:
  force_x_N: "cube_N_per_m3 * square * x"
  force_y_N: "cube_N_per_m3 * square * y"
)yaml";

EffectSchema parsed(const std::string& text) {
  FaultList faults("effect.yaml");
  const YamlNode document = parseYaml(text, faults);
  YamlMap root(&document, "", faults);
  const EffectSchema schema = readEffect(root, document);
  faults.throwIfAny();
  return schema;
}

TEST(EffectFileTest, IsTheClosedFormForDoubleAndLanes) {
  const EffectSchema schema = parsed(cubic);
  EXPECT_EQ(schema.id, "cubic_spring");
  ASSERT_EQ(schema.parameters.size(), 1u);
  EXPECT_EQ(schema.parameters[0].unit, "N/m3");
  EXPECT_EQ(schema.parameters[0].neutral, 0.0);
  using Pack = Lanes<xsimd::default_arch>;
  const Rig<double> rig;
  const Rig<Pack> pack_rig;
  const double c = -2e12;
  const effects::LawPhysics<double> physics(schema.law, {c});
  const effects::LawPhysics<Pack> lanes(schema.law, {Pack(c)});
  EXPECT_EQ(physics.roles(), static_cast<unsigned>(acts_on_bearing_force));
  for (double x : {-8e-5, 0.0, 3e-5})
    for (double y : {-5e-5, 2e-5}) {
      const double factor = c * (x * x + y * y);
      const Shaft<double> shaft;
      Vec2<double> force{1.0, 2.0};  // it adds
      physics.bearingForce({&rig, &shaft, 1, {x, y}, {}, {}}, force);
      // a product of four factors: a few roundings
      EXPECT_NEAR(force.x, 1.0 + factor * x, 1e-15 + 1e-14 * std::fabs(factor * x));
      EXPECT_NEAR(force.y, 2.0 + factor * y, 1e-15 + 1e-14 * std::fabs(factor * y));
      const Shaft<Pack> pack_shaft;
      Vec2<Pack> pack;
      lanes.bearingForce({&pack_rig, &pack_shaft, 1, {Pack(x), Pack(y)}, {}, {}}, pack);
      EXPECT_NEAR(laneValue(pack.x, Pack::size - 1), factor * x, 1e-14 * std::fabs(factor * x));
    }
}

TEST(EffectFileTest, EveryQuantityReachesTheFormulas) {
  const EffectSchema schema = parsed(R"yaml(format: amb-effect/1
effect: everything
summary: "all quantities"
excited_by: "all"
place: magnetic_bearings
parameters:
  - {name: k, unit: "1", lower: 0.0, upper: 2.0, typical: 1.0, meaning: "factor"}
law:
  force_x_N: "k * (x + 10*y + 100*vx + 1000*vy + 1e4*ix)"
  force_y_N: "iy + 10*angle + 100*speed + 1000*time + 1e4*end"
)yaml");
  Shaft<double> shaft = Shaft<double>::at(2.0, 3.0, 0.0);
  shaft.time = 4.0;
  const Rig<double> rig;
  Vec2<double> force;
  effects::LawPhysics<double>(schema.law, {1.0}).bearingForce({&rig, &shaft, 1, {1, 2}, {3, 4}, {5, 6}}, force);
  EXPECT_EQ(force.x, 1.0 + 20.0 + 300.0 + 4000.0 + 5e4);
  EXPECT_EQ(force.y, 6.0 + 20.0 + 300.0 + 4000.0 + 1e4);
  EXPECT_TRUE(std::isnan(schema.parameters[0].neutral)) << "optional: never";
}

TEST(EffectFileTest, AllFaultsAtOnceWithTheirLines) {
  const std::string text = R"yaml(format: amb-effect/1
effect: 2fast
summary: "x"
excited_by: "y"
place: sensors
parameters:
  - {name: gain, unit: "1", lower: 1.0, upper: -1.0, typical: 0.0, meaning: "a"}
  - {name: sin, unit: "1", lower: 0.0, upper: 1.0, typical: 3.0, role: phase, meaning: "b"}
where:
  again: "gain * vx"
law:
  signal_x_m: "gain * (x + )"
  force_y_N: "0"
)yaml";
  const auto faults = faultsOf([&] { parsed(text); });
  const auto expect = [&](int line, const std::string& key, const std::string& rule) {
    for (const Fault& fault : faults)
      if (fault.line == line && fault.key == key && fault.rule.find(rule) != std::string::npos) return;
    ADD_FAILURE() << line << " " << key << ": " << rule << "\n" << joined(faults);
  };
  expect(2, "effect", "does not begin with a digit");
  expect(7, "parameters.0.upper", "above lower");
  expect(8, "parameters.1.name", "formulas' own");
  expect(8, "parameters.1.typical", "from lower to upper");
  expect(8, "parameters.1.role", "behind its amplitude");
  expect(10, "where.again", "column 8: 'vx' is not known here");
  expect(12, "law.signal_x_m", "column 13: a value is missing before ')'");
  expect(13, "law.force_y_N", "not known here");
  expect(12, "law.signal_y_m", "missing");
  EXPECT_EQ(faults.size(), 9u) << joined(faults);
}

TEST(EffectFileTest, AParameterThatNothingReadsIsAFault) {
  const auto faults = faultsOf([&] { parsed(replaced(cubic, "cube_N_per_m3 * square * x", "square * x * 0")); });
  EXPECT_TRUE(faults.empty()) << "the other formula reads it";
  std::string text = replaced(cubic, "cube_N_per_m3 * square * x", "square * x");
  text = replaced(text, "cube_N_per_m3 * square * y", "square * y");
  const auto both = faultsOf([&] { parsed(text); });
  ASSERT_EQ(both.size(), 1u);
  EXPECT_NE(both[0].rule.find("no formula reads"), std::string::npos);
}

/// The valid model with one more effect entry.
std::string withEntry(const std::string& entry) {
  const std::string text = validText();
  const std::size_t at = text.find("\neffects:");
  EXPECT_NE(at, std::string::npos);
  const std::size_t line = text.find('\n', at + 1);
  return text.substr(0, line + 1) + entry + text.substr(line + 1);
}

TEST(EffectFileTest, AModelBringsItsEffectAlong) {
  const auto folder = std::filesystem::path(testing::TempDir()) / ("amb_rotor_effect_" + std::to_string(::getpid()));
  std::filesystem::create_directories(folder);
  writeTextFile((folder / "cubic.yaml").string(), cubic);
  const std::string entry = "  - {effect: cubic_spring, file: cubic.yaml, parameters: {cube_N_per_m3: -3.0e12}}\n";
  EffectCatalogue catalogue(smallCatalogue().all());
  const std::size_t before = catalogue.all().size();
  const Model model = parseModel(withEntry(entry), (folder / "model.yaml").string(), catalogue);
  EXPECT_EQ(catalogue.all().size(), before + 1);
  // what is written holds the definition and needs no file; it reads back to the same physics in another program
  const std::string text = modelText(model, catalogue);
  std::filesystem::remove_all(folder);
  EffectCatalogue other(smallCatalogue().all());
  const Model again = parseModel(text, "elsewhere.yaml", other);
  ASSERT_NE(other.find("cubic_spring"), nullptr);
  EXPECT_EQ(modelText(again, other), text);
  EXPECT_EQ(modelHash(again, other), modelHash(model, catalogue));
  // another formula is another physics, and cannot have the same name in one program
  const std::string changed = replaced(text, "cube_N_per_m3 * square * x", "2 * cube_N_per_m3 * square * x");
  EffectCatalogue third(smallCatalogue().all());
  EXPECT_NE(modelHash(parseModel(changed, "m.yaml", third), third), modelHash(model, catalogue));
  const auto faults = faultsOf([&] { parseModel(changed, "m.yaml", other); });
  ASSERT_EQ(faults.size(), 1u) << joined(faults);
  EXPECT_NE(faults[0].rule.find("another effect of this name"), std::string::npos);
}

TEST(EffectFileTest, AMissingFileAndAForeignNameAreFaults) {
  EffectCatalogue catalogue(smallCatalogue().all());
  const std::string missing = "  - {effect: cubic_spring, file: nowhere.yaml, parameters: {cube_N_per_m3: 0.0}}\n";
  EXPECT_FALSE(faultsOf([&] { parseModel(withEntry(missing), "model.yaml", catalogue); }).empty());
  EXPECT_EQ(catalogue.find("cubic_spring"), nullptr);
}

}  // namespace
}  // namespace amb_rotor
