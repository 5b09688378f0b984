// The examples of doc/formats.md can be read as they stand.
#include "amb_rotor/model/scenario_reader.hpp"
#include "model_test_support.hpp"

namespace amb_rotor {
namespace {

using namespace model_test;

/// The first YAML example that begins with this format.
std::string example(const std::string& format) {
  const std::string text = readTextFile(std::string(AMB_ROTOR_SOURCE_DIR) + "/doc/formats.md");
  const std::string head = "```yaml\n";
  const std::size_t begin = text.find(head + "format: " + format);
  EXPECT_NE(begin, std::string::npos);
  if (begin == std::string::npos) return "";
  const std::size_t end = text.find("```", begin + head.size());
  return text.substr(begin + head.size(), end - begin - head.size());
}

TEST(ModelDocumentation, modelExampleCanBeRead) {
  EffectCatalogue catalogue(
      {{"static_load",
        "A constant force.",
        "all runs",
        {{"force_x_N", "N", -1e4, 1e4, 10.0, 0.0, ParameterRole::plain, "along x"},
         {"force_y_N", "N", -1e4, 1e4, 10.0, 0.0, ParameterRole::plain, "along y"}}}});
  const auto faults = faultsOf([&] { parseModel(example("amb-model/1"), "formats.md", catalogue); });
  EXPECT_TRUE(faults.empty()) << joined(faults);
}

TEST(ModelDocumentation, scenarioExampleCanBeRead) {
  const auto faults = faultsOf([&] { parseScenario(example("amb-scenario/1"), "formats.md"); });
  EXPECT_TRUE(faults.empty()) << joined(faults);
}

}  // namespace
}  // namespace amb_rotor
