#include "amb_rotor/validation/dataset.hpp"

#include <algorithm>
#include <cmath>
#include <filesystem>

#include "amb_rotor/common/units.hpp"
#include "amb_rotor/model/model_reader.hpp"
#include "amb_rotor/model/model_rules.hpp"
#include "amb_rotor/validation/table.hpp"

namespace amb_rotor {
namespace {

namespace fs = std::filesystem;

const std::vector<std::string> meaning_names = {"displacement", "control current", "excitation current",
                                                "one pulse a turn"};
const std::vector<std::string> kind_names = {"step",       "chirp", "steady", "run_up",
                                             "coast_down", "rub",   "drop"};

bool measures(const std::string& unit, ChannelMeaning meaning) {
  const std::vector<std::string> lengths = {"m", "mm", "um"};
  const std::vector<std::string> currents = {"A", "mA"};
  const auto& units = meaning == ChannelMeaning::displacement ? lengths : currents;
  return std::find(units.begin(), units.end(), unit) != units.end();
}

/// noise_rms_UNIT or resolution_UNIT, in SI; its unit may be another than the column's.
double readAmount(YamlMap& entry, const std::string& quantity, ChannelMeaning meaning) {
  for (const std::string& key : entry.keys()) {
    const NameWithUnit name = splitUnit(key);
    if (name.quantity != quantity) continue;
    double value = entry.number(key);
    if (std::isfinite(value) && value < 0.0) entry.fault(key, "must be from 0");
    if (measures(name.unit, meaning)) return value * *unitFactor(name.unit);
    entry.fault(key, "the unit " + name.unit + " is not one of a " + channelMeaningName(meaning));
    return value;
  }
  const std::string unit = meaning == ChannelMeaning::displacement ? "um" : "A";
  entry.number(quantity + "_" + unit);  // reports that it is missing
  return std::nan("");
}

void readSensor(YamlMap& entry, Channel& channel) {
  channel.end = entry.choice("plane", {"a", "b"});
  channel.axis = entry.choice("axis", {"x", "y"});
  const std::string unit = splitUnit(channel.name).unit;
  if (measures(unit, channel.meaning)) {
    channel.unit_factor = *unitFactor(unit);
  } else {
    entry.faults().add(
        entry.line(), entry.path(), "",
        "the name must end with the unit of a " + std::string(channelMeaningName(channel.meaning)) +
            (channel.meaning == ChannelMeaning::displacement ? ", _m, _mm or _um" : ", _A or _mA"));
  }
  if (channel.meaning == ChannelMeaning::excitation_current) return;
  channel.noise_rms = readAmount(entry, "noise_rms", channel.meaning);
  channel.resolution = readAmount(entry, "resolution", channel.meaning);
  if (channel.noise() == 0.0)
    entry.fault("noise_rms", "noise and resolution must not both be 0: residuals are divided by them");
}

void readChannels(YamlMap channels, Dataset& dataset) {
  FaultList& faults = channels.faults();
  for (const std::string& name : channels.keys()) {
    YamlMap entry = channels.map(name);
    Channel channel;
    channel.name = name;
    const int meaning = entry.choice("meaning", meaning_names);
    if (meaning < 0) continue;
    channel.meaning = static_cast<ChannelMeaning>(meaning);
    if (channel.meaning == ChannelMeaning::tacho) {
      channel.threshold = entry.number("threshold");
    } else {
      readSensor(entry, channel);
    }
    entry.finish();
    if (channel.end < 0 || channel.axis < 0) continue;
    const Channel* twin = dataset.findChannel(channel.meaning, channel.index());
    if (twin != nullptr) faults.add(entry.line(), entry.path(), "", "measures the same as " + twin->name);
    dataset.channels.push_back(channel);
  }
  if (!channels.valid()) return;
  for (const ChannelMeaning meaning : {ChannelMeaning::displacement, ChannelMeaning::control_current})
    for (const Channel& channel : dataset.channels)
      if (channel.meaning == meaning) return;
  faults.add(channels.line(), channels.path(), "", "there is neither a displacement nor a control current");
}

constexpr double most_turns_hz = 2e4;

void readSpeed(YamlMap speed, const Dataset& dataset, Run& run) {
  const int type = speed.choice("type", {"constant", "tacho"});
  if (type < 0) return;
  run.speed_from_tacho = type == 1;
  if (run.speed_from_tacho) {
    if (dataset.findChannel(ChannelMeaning::tacho) == nullptr)
      speed.fault("type", "there is no channel with one pulse a turn");
  } else {
    run.speed_hz = speed.number("hz");
    if (run.speed_hz < 0.0) speed.fault("hz", "must be from 0 Hz: the spin is positive about z");
    if (run.speed_hz > most_turns_hz)
      speed.fault("hz", "must be at most " + numberText(most_turns_hz) + " Hz, as in a scenario (is it in turns a second?)");
  }
  speed.finish();
}

void readEvents(YamlMap& owner, Run& run) {
  if (!owner.has("events")) return;
  std::size_t index = 0;
  for (const YamlNode& item : owner.list("events")) {
    YamlMap entry(&item, owner.pathOf("events") + "." + std::to_string(index++), owner.faults());
    RunEvent event;
    event.time_s = entry.number("time_s");
    event.amb_on = entry.choice("type", {"amb_off", "amb_on"}) == 1;
    entry.finish();
    if (event.time_s < 0.0) entry.fault("time_s", "must be from 0 s");
    if (!run.events.empty() && event.time_s < run.events.back().time_s)
      entry.fault("time_s", "events must stand in the order of their times");
    run.events.push_back(event);
  }
}

Run readRunEntry(YamlMap& entry, const Dataset& dataset, std::vector<RunHead>& heads) {
  Run run;
  const RunHead head = readRunHead(entry, dataset.folder, heads);
  run.id = head.id;
  run.file = head.file;
  run.use = head.use;
  run.kind = static_cast<RunKind>(std::max(0, entry.choice("kind", kind_names)));
  run.sample_rate_hz = entry.number("sample_rate_hz");
  if (run.sample_rate_hz <= 0.0) entry.fault("sample_rate_hz", "must be above 0 Hz");
  readSpeed(entry.map("speed"), dataset, run);
  readEvents(entry, run);
  if (entry.has("unbalance")) {
    run.unbalance = readUnbalance(entry, "unbalance");
    for (std::size_t i = 0; i < run.unbalance.size(); ++i) {
      const std::string path = entry.pathOf("unbalance") + "." + std::to_string(i) + ".moment_kg_m";
      if (run.unbalance[i].moment_kg_m < 0.0)
        entry.faults().addRules({{"", 0, path, "", rigLimit("unbalance.moment_kg_m").text()}});
    }
  }
  entry.finish();
  return run;
}

bool isOfModes(const YamlNode& document) {
  const YamlNode* kind = document.find("kind");
  return kind != nullptr && kind->kind == YamlNode::Kind::scalar && kind->text == "modes";
}

}  // namespace

double Channel::noise() const { return std::sqrt(noise_rms * noise_rms + resolution * resolution / 12.0); }

const Run* Dataset::findRun(const std::string& id) const {
  const auto found = std::find_if(runs.begin(), runs.end(), [&](const Run& run) { return run.id == id; });
  return found == runs.end() ? nullptr : &*found;
}

const Channel* Dataset::findChannel(ChannelMeaning meaning, int index) const {
  const auto found = std::find_if(channels.begin(), channels.end(), [&](const Channel& channel) {
    return channel.meaning == meaning && (meaning == ChannelMeaning::tacho || channel.index() == index);
  });
  return found == channels.end() ? nullptr : &*found;
}

const char* runKindName(RunKind kind) { return kind_names[static_cast<std::size_t>(kind)].c_str(); }
const char* channelMeaningName(ChannelMeaning meaning) {
  return meaning_names[static_cast<std::size_t>(meaning)].c_str();
}

std::string datasetFile(const std::string& folder) {
  const fs::path path(folder);
  return path.filename() == "dataset.yaml" ? folder : (path / "dataset.yaml").string();
}

bool isModesDataset(const std::string& folder) {
  FaultList faults(datasetFile(folder));
  return isOfModes(parseYaml(readTextFile(faults.file()), faults));
}

Model readDatasetHead(YamlMap& root) {
  requireFormat(root, "amb-dataset/1");
  Model belief;
  belief.name = root.text("name");
  belief.folder = fs::path(root.faults().file()).parent_path().string();
  YamlMap rig = root.map("rig");
  if (rig.valid()) {
    readRig(rig, belief);
    root.faults().addRules(checkRig(belief, true));
  }
  return belief;
}

RunHead readRunHead(YamlMap& run, const std::string& folder, std::vector<RunHead>& before) {
  RunHead head;
  head.id = run.text("id");
  if (!head.id.empty() &&
      std::any_of(before.begin(), before.end(), [&](const RunHead& other) { return other.id == head.id; }))
    run.fault("id", "another run has this id");
  head.file = run.text("file");
  std::error_code ignored;
  if (!head.file.empty() && fs::path(head.file).is_absolute()) {
    run.fault("file", "must be relative to the data set's folder");
  } else if (!head.file.empty() && !fs::exists(fs::path(folder) / head.file, ignored)) {
    run.fault("file", "there is no such file in the data set's folder");
  } else if (!head.file.empty()) {
    for (const RunHead& other : before)
      if (!other.file.empty() && fs::equivalent(fs::path(folder) / head.file, fs::path(folder) / other.file, ignored))
        run.fault("file", "is the file of run " + other.id + " too: one measurement would count twice");
  }
  head.use = run.choice("use", {"fit", "validate"}) == 1 ? RunUse::validate : RunUse::fit;
  before.push_back(head);
  return head;
}

Dataset readDataset(const std::string& folder) {
  FaultList faults(datasetFile(folder));
  const YamlNode document = parseYaml(readTextFile(faults.file()), faults);
  YamlMap root(&document, "", faults);
  if (isOfModes(document)) {
    root.fault("kind", "a data set of modes holds no recordings in time");
    faults.throwIfAny();
  }
  Dataset dataset;
  dataset.folder = fs::path(faults.file()).parent_path().string();
  dataset.belief = readDatasetHead(root);
  dataset.name = dataset.belief.name;
  readChannels(root.map("channels"), dataset);
  const std::vector<YamlNode> runs = root.list("runs");
  if (runs.empty() && root.has("runs")) root.fault("runs", "there is no run");
  std::vector<RunHead> heads;
  for (std::size_t i = 0; i < runs.size(); ++i) {
    YamlMap entry(&runs[i], "runs." + std::to_string(i), faults);
    if (entry.valid()) dataset.runs.push_back(readRunEntry(entry, dataset, heads));
  }
  root.finish();
  faults.throwIfAny();
  dataset.belief.source = std::make_shared<FaultList>(faults);
  return dataset;
}

Model trustedAs(Model model, const Dataset& dataset) {
  if (model.uncertainty.empty()) model.uncertainty = dataset.belief.uncertainty;
  return model;
}

}  // namespace amb_rotor
