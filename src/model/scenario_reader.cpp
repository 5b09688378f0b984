#include "amb_rotor/model/scenario_reader.hpp"

#include <algorithm>

#include "amb_rotor/model/model_writer.hpp"
#include "amb_rotor/model/yaml_document.hpp"
#include "scenario_fields.hpp"

namespace amb_rotor {
namespace {

using namespace scenario_fields;

template <class Owner>
void readKeys(YamlMap& map, const std::vector<Key<Owner>>& keys, Owner& owner) {
  for (const auto& key : keys) owner.*key.member = map.number(key.name);
}

void readAddress(YamlMap& map, Address address, int& end, int& axis) {
  if (address == Address::none) return;
  std::vector<std::string> ends = {"a", "b"};
  std::vector<std::string> axes = {"x", "y"};
  if (address == Address::several) {
    ends.push_back("both");
    axes.push_back("both");
  }
  const int found_end = map.choice("end", ends);
  const int found_axis = map.choice("axis", axes);
  end = found_end == 2 ? -1 : std::max(0, found_end);
  axis = found_axis == 2 ? -1 : std::max(0, found_axis);
}

void readSpeed(YamlMap map, SpeedLaw& speed) {
  const int type = map.choice("type", speed_names);
  if (type < 0) return;
  speed.type = static_cast<SpeedType>(type);
  readKeys(map, keysOf(speed.type), speed);
  map.finish();
}

void readExcitation(YamlMap map, Scenario& scenario) {
  const int kind = map.choice("type", {"force", "current"});
  const int waveform = map.choice("waveform", waveform_names);
  Excitation excitation;
  if (kind >= 0 && waveform >= 0) {
    excitation.kind = kind == 0 ? Excitation::Kind::force : Excitation::Kind::current;
    excitation.waveform = static_cast<Waveform>(waveform);
    readAddress(map, kind == 0 ? Address::none : Address::one, excitation.end, excitation.axis);
    readKeys(map, keysOf(excitation), excitation);
    map.finish();
  }
  scenario.excitations.push_back(excitation);
}

void readFault(YamlMap map, Scenario& scenario) {
  const int type = map.choice("type", fault_names);
  FaultEvent event;
  if (type >= 0) {
    event.type = static_cast<FaultType>(type);
    readAddress(map, addressOf(event.type), event.end, event.axis);
    readKeys(map, keysOf(event.type), event);
    map.finish();
  }
  scenario.faults.push_back(event);
}

void readStart(YamlMap& root, Scenario& scenario) {
  const YamlNode* start = root.take("start", true);
  if (start == nullptr) return;
  scenario.start_settled = start->kind != YamlNode::Kind::map;
  if (scenario.start_settled) {
    if (start->text != "settled")
      root.fault("start", "must be settled, or a map with the lists displacement and velocity");
    return;
  }
  YamlMap map(start, "start", root.faults());
  scenario.initial_displacement_m = map.numbers("displacement");
  scenario.initial_velocity_m_s = map.numbers("velocity");
  map.finish();
}

}  // namespace

const char* faultTypeName(FaultType type) { return fault_names[static_cast<std::size_t>(type)].c_str(); }
const char* waveformName(Waveform waveform) {
  return waveform_names[static_cast<std::size_t>(waveform)].c_str();
}
const char* speedTypeName(SpeedType type) { return speed_names[static_cast<std::size_t>(type)].c_str(); }

std::optional<FaultType> faultTypeFromName(const std::string& name) {
  const auto found = std::find(fault_names.begin(), fault_names.end(), name);
  if (found == fault_names.end()) return std::nullopt;
  return static_cast<FaultType>(found - fault_names.begin());
}

Scenario parseScenario(const std::string& text, const std::string& name) {
  FaultList faults(name);
  const YamlNode document = parseYaml(text, faults);
  YamlMap root(&document, "", faults);
  requireFormat(root, "amb-scenario/1");
  Scenario scenario;
  scenario.name = root.text("name");
  scenario.duration_s = root.number("duration_s");
  scenario.record_rate_hz = root.number("record_rate_hz");
  readSpeed(root.map("speed"), scenario.speed);
  for (const YamlNode& item : root.list("excitations"))
    readExcitation({&item, "excitations." + std::to_string(scenario.excitations.size()), faults}, scenario);
  for (const YamlNode& item : root.list("faults"))
    readFault({&item, "faults." + std::to_string(scenario.faults.size()), faults}, scenario);
  readStart(root, scenario);
  root.finish();
  faults.addRules(checkScenario(scenario, true));
  faults.throwIfAny();
  scenario.source = std::make_shared<FaultList>(faults);
  return scenario;
}

Scenario readScenario(const std::string& path) { return parseScenario(readTextFile(path), path); }

}  // namespace amb_rotor
