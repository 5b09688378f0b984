#include "amb_rotor/validation/modes_dataset.hpp"

#include <algorithm>
#include <filesystem>

#include "amb_rotor/model/model_rules.hpp"
#include "amb_rotor/model/overrides.hpp"
#include "amb_rotor/validation/table.hpp"

namespace amb_rotor {
namespace {

constexpr double most_modes = 100.0;

std::string frequencyColumn(std::size_t mode) { return "frequency_" + std::to_string(mode + 1) + "_hz"; }
std::string stdColumn(std::size_t mode) { return "frequency_" + std::to_string(mode + 1) + "_std_hz"; }

/// Fields of the rig that may be set beside the belief: not the unbalances, of which there are many.
std::vector<std::string> conditionNames(const Model& model) {
  std::vector<std::string> names;
  for (const FieldLimit& limit : rigLimits()) {
    const std::string path = limit.path;
    if (rigFieldApplies(path, model) && path.compare(0, 10, "unbalance.") != 0) names.push_back(path);
  }
  return names;
}

void readConditions(YamlMap& modes, ModesDataset& dataset) {
  const auto known = conditionNames(dataset.belief);
  for (const YamlNode& item : modes.list("conditions")) {
    const std::string path = modes.pathOf("conditions") + "." + std::to_string(dataset.conditions.size());
    if (std::find(known.begin(), known.end(), item.text) == known.end()) {
      modes.faults().add(item.line, path, item.text,
                         "no number of this rig has this name; nearest: " + nearestWord(item.text, known));
    } else if (std::count(dataset.conditions.begin(), dataset.conditions.end(), item.text) > 0) {
      modes.faults().add(item.line, path, item.text, "the condition stands twice");
    }
    dataset.conditions.push_back(item.text);
  }
}

void readModesBlock(YamlMap modes, ModesDataset& dataset) {
  readConditions(modes, dataset);
  const double count = modes.number("count");
  if (count >= 1.0 && count <= most_modes && count == static_cast<double>(static_cast<int>(count))) {
    dataset.mode_count = static_cast<std::size_t>(count);
  } else if (count == count) {
    modes.fault("count", "must be a whole number from 1 to " + std::to_string(static_cast<int>(most_modes)));
  }
  modes.finish();
}

void checkColumns(const NumericTable& table, const ModesDataset& dataset, FaultList& faults) {
  std::vector<std::string> names = dataset.conditions;
  for (std::size_t mode = 0; mode < dataset.mode_count; ++mode) {
    names.push_back(frequencyColumn(mode));
    names.push_back(stdColumn(mode));
  }
  for (const std::string& name : names)
    if (table.indexOf(name) < 0) faults.add(1, name, "", "the column is missing");
  names.push_back("speed_hz");
  for (const std::string& name : table.columns)
    if (std::find(names.begin(), names.end(), name) == names.end())
      faults.add(1, name, "", "the column is not known here; nearest: " + nearestWord(name, names));
}

/// One row; its faults with the line.
ModesPoint readPoint(const NumericTable& table, std::size_t row, const ModesDataset& dataset,
                     FaultList& faults) {
  const int line = NumericTable::lineOf(row);
  const auto cell = [&](const std::string& column) {
    return table.values[static_cast<std::size_t>(table.indexOf(column))][row];
  };
  ModesPoint point;
  for (const std::string& name : dataset.conditions) {
    point.condition.push_back(cell(name));
    const FieldLimit& limit = rigLimit(name);
    if (!limit.holds(point.condition.back()))
      faults.add(line, name, numberText(point.condition.back()), limit.text());
  }
  if (table.indexOf("speed_hz") >= 0) point.speed_hz = cell("speed_hz");
  if (point.speed_hz < 0.0) faults.add(line, "speed_hz", numberText(point.speed_hz), "must be from 0 Hz");
  double below = 0.0;
  for (std::size_t mode = 0; mode < dataset.mode_count; ++mode) {
    const double frequency = cell(frequencyColumn(mode));
    const double std = cell(stdColumn(mode));
    if (frequency <= below)
      faults.add(
          line, frequencyColumn(mode), numberText(frequency),
          mode == 0 ? "must be above 0 Hz" : "must be above the mode before, " + numberText(below) + " Hz");
    if (std <= 0.0)
      faults.add(line, stdColumn(mode), numberText(std), "must be above 0 Hz: errors are divided by it");
    below = frequency;
    point.frequency_hz.push_back(frequency);
    point.std_hz.push_back(std);
  }
  return point;
}

void readModesTable(const RunHead& run, ModesDataset& dataset, FaultList& all) {
  FaultList faults((std::filesystem::path(dataset.folder) / run.file).string());
  const NumericTable table = readTable(faults.file(), faults);
  if (!table.columns.empty()) checkColumns(table, dataset, faults);
  if (faults.empty()) {
    for (std::size_t row = 0; row < table.rows(); ++row) {
      ModesPoint point = readPoint(table, row, dataset, faults);
      point.run = run.id;
      point.use = run.use;
      dataset.points.push_back(std::move(point));
    }
  }
  all.append(faults.faults());
}

}  // namespace

ModesDataset readModesDataset(const std::string& folder) {
  FaultList faults(datasetFile(folder));
  const YamlNode document = parseYaml(readTextFile(faults.file()), faults);
  YamlMap root(&document, "", faults);
  ModesDataset dataset;
  dataset.folder = std::filesystem::path(faults.file()).parent_path().string();
  dataset.belief = readDatasetHead(root);
  dataset.name = dataset.belief.name;
  root.choice("kind", {"modes"});
  readModesBlock(root.map("modes"), dataset);
  std::vector<RunHead> heads;
  const std::vector<YamlNode> runs = root.list("runs");
  if (runs.empty() && root.has("runs")) root.fault("runs", "there is no run");
  for (std::size_t i = 0; i < runs.size(); ++i) {
    YamlMap entry(&runs[i], "runs." + std::to_string(i), faults);
    if (!entry.valid()) continue;
    readRunHead(entry, dataset.folder, heads);
    entry.choice("kind", {"modes"});
    entry.finish();
  }
  root.finish();
  // The tables can only be judged by a description that is right.
  faults.throwIfAny();
  dataset.belief.source = std::make_shared<FaultList>(faults);
  for (const RunHead& head : heads) readModesTable(head, dataset, faults);
  faults.throwIfAny();
  return dataset;
}

Model modelAt(const Model& model, const ModesDataset& dataset, const ModesPoint& point) {
  Model changed = model;
  changed.source.reset();  // the conditions are no longer the file's
  const EffectCatalogue none({});
  for (std::size_t i = 0; i < dataset.conditions.size(); ++i)
    *requireField(changed, "rig." + dataset.conditions[i], none) = point.condition.at(i);
  return changed;
}

}  // namespace amb_rotor
