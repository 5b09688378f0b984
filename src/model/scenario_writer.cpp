#include "amb_rotor/model/model_writer.hpp"
#include "amb_rotor/model/scenario_reader.hpp"
#include "amb_rotor/model/yaml_document.hpp"
#include "scenario_fields.hpp"

namespace amb_rotor {
namespace {

using namespace scenario_fields;

template <class Owner>
std::string keysText(const std::vector<Key<Owner>>& keys, const Owner& owner) {
  std::string text;
  for (const auto& key : keys) text += std::string(", ") + key.name + ": " + numberText(owner.*key.member);
  return text;
}

std::string addressText(int end, int axis) {
  const char* ends[] = {"both", "a", "b"};
  const char* axes[] = {"both", "x", "y"};
  return std::string(", end: ") + ends[end + 1] + ", axis: " + axes[axis + 1];
}

std::string listText(const std::vector<double>& values) {
  std::string text;
  for (const double value : values) text += (text.empty() ? "" : ", ") + numberText(value);
  return "[" + text + "]";
}

std::string excitationText(const Excitation& excitation) {
  const bool is_force = excitation.kind == Excitation::Kind::force;
  return std::string("  - {type: ") + (is_force ? "force" : "current") +
         ", waveform: " + waveformName(excitation.waveform) +
         (is_force ? "" : addressText(excitation.end, excitation.axis)) +
         keysText(keysOf(excitation), excitation) + "}\n";
}

std::string faultText(const FaultEvent& event) {
  const bool addressed = addressOf(event.type) == Address::several;
  return std::string("  - {type: ") + faultTypeName(event.type) +
         (addressed ? addressText(event.end, event.axis) : "") + keysText(keysOf(event.type), event) + "}\n";
}

}  // namespace

std::string scenarioText(const Scenario& scenario) {
  const std::vector<Fault> faults = checkScenario(scenario);
  if (!faults.empty()) throw InputError(faults);
  std::string text = "format: amb-scenario/1\nname: " + quotedText(scenario.name) +
                     "\nduration_s: " + numberText(scenario.duration_s) +
                     "\nrecord_rate_hz: " + numberText(scenario.record_rate_hz) +
                     "\nspeed: {type: " + speedTypeName(scenario.speed.type) +
                     keysText(keysOf(scenario.speed.type), scenario.speed) + "}\n";
  text += scenario.excitations.empty() ? "excitations: []\n" : "excitations:\n";
  for (const Excitation& excitation : scenario.excitations) text += excitationText(excitation);
  text += scenario.faults.empty() ? "faults: []\n" : "faults:\n";
  for (const FaultEvent& event : scenario.faults) text += faultText(event);
  if (scenario.start_settled) return text + "start: settled\n";
  return text + "start:\n  displacement: " + listText(scenario.initial_displacement_m) +
         "\n  velocity: " + listText(scenario.initial_velocity_m_s) + "\n";
}

void writeScenario(const Scenario& scenario, const std::string& path) {
  writeTextFile(path, scenarioText(scenario));
}

}  // namespace amb_rotor
