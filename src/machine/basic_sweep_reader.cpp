#include <algorithm>
#include <cmath>

#include "amb_rotor/machine/basic_sweep.hpp"
#include "amb_rotor/model/yaml_document.hpp"

namespace amb_rotor {
namespace {

constexpr std::size_t most_points = 100000000;

/// Parameters that the chosen laws do not use: naming one is a fault, so that nobody believes it counts.
std::vector<std::string> unused(const BasicLaneOptions& run) {
  std::vector<std::string> names;
  if (run.contact == BasicContact::linear) names = {"hertz_stiffness", "hertz_damping"};
  if (run.contact == BasicContact::hertz) names = {"contact_stiffness"};
  if (run.friction == BasicFriction::spin)
    names.insert(names.end(), {"surface_radius", "regularisation_speed"});
  return names;
}

bool contains(const std::vector<std::string>& names, const std::string& word) {
  return std::find(names.begin(), names.end(), word) != names.end();
}

int wholeNumber(YamlMap& map, const std::string& key, int least) {
  const double value = map.number(key);
  if (std::isnan(value)) return least;
  if (value != std::floor(value) || value < least || value > 1e9) {
    map.fault(key, "must be a whole number of at least " + std::to_string(least));
    return least;
  }
  return static_cast<int>(value);
}

/// The values of one axis: `values: [...]`, or from, to and step or count.
SweptParameter readAxis(YamlMap map, const std::vector<std::string>& names) {
  SweptParameter axis;
  axis.parameter = map.text("parameter");
  if (!axis.parameter.empty() && !contains(names, axis.parameter)) {
    map.fault("parameter",
              "is no parameter that these laws use; nearest: " + nearestWord(axis.parameter, names));
  }
  if (map.has("values")) {
    axis.values = map.numbers("values");
    if (map.valid() && axis.values.empty()) map.fault("values", "at least one value");
  } else {
    const double from = map.number("from"), to = map.number("to");
    double count = 0.0;
    if (map.has("step")) {
      const double step = map.number("step");
      if (!(step * (to - from) > 0.0)) {
        if (std::isfinite(step * (to - from))) map.fault("step", "must lead from `from` to `to`");
      } else {
        // A last step that ends a rounding error behind `to` counts.
        count = std::floor((to - from) / step * (1.0 + 1e-12)) + 1.0;
        for (double i = 0.0; i < std::min(count, 1e7); ++i) axis.values.push_back(from + i * step);
      }
    } else {
      count = wholeNumber(map, "count", 2);
      for (double i = 0.0; i < std::min(count, 1e7); ++i)
        axis.values.push_back(from + (to - from) * i / (count - 1.0));
    }
    if (count > 1e7) map.fault(map.has("step") ? "step" : "count", "at most 10 million values");
  }
  map.finish();
  return axis;
}

BasicState<double> readState(YamlMap map) {
  BasicState<double> state{map.number("x"), map.number("y"), map.number("vx"), map.number("vy")};
  map.finish();
  return state;
}

ContinuationRequest readContinuation(YamlMap map, const std::vector<std::string>& names) {
  ContinuationRequest request;
  request.given = true;
  request.parameter = map.text("parameter");
  if (!request.parameter.empty() && !contains(names, request.parameter)) {
    map.fault("parameter",
              "is no parameter that these laws use; nearest: " + nearestWord(request.parameter, names));
  }
  request.from = map.number("from");
  request.to = map.number("to");
  request.first_step = map.number("step");
  if (request.first_step <= 0.0) map.fault("step", "greater than 0");
  if (request.to <= request.from) map.fault("to", "greater than `from`");
  int index = 0;
  for (const YamlNode& item : map.list("starts")) {
    YamlMap start(&item, map.pathOf("starts." + std::to_string(index++)), map.faults());
    ContinuationRequest::Start s;
    s.at = start.number("at");
    s.turns = wholeNumber(start, "turns", 1);
    s.x = start.number("x");
    s.y = start.number("y");
    s.vx = start.number("vx");
    s.vy = start.number("vy");
    start.finish();
    request.starts.push_back(s);
  }
  if (map.valid() && request.starts.empty()) map.fault("starts", "at least one start");
  map.finish();
  return request;
}

}  // namespace

BasicSweep readBasicSweep(const std::string& path) {
  FaultList faults(path);
  const YamlNode document = parseYaml(readTextFile(path), faults);
  YamlMap root(&document, "", faults);
  requireFormat(root, "amb-sweep/1");
  BasicSweep sweep;
  sweep.name = root.text("name");
  sweep.title = root.text("title");
  sweep.source = root.text("source");
  root.choice("machine", {"basic"});
  sweep.run.contact =
      root.choice("contact", {"linear", "hertz"}) == 1 ? BasicContact::hertz : BasicContact::linear;
  sweep.run.friction =
      root.choice("friction_law", {"spin", "sliding"}) == 1 ? BasicFriction::sliding : BasicFriction::spin;

  std::vector<std::string> names;
  const auto idle = unused(sweep.run);
  for (const auto& name : basicParameterNames()) {
    if (!contains(idle, name)) names.push_back(name);
  }
  std::vector<std::string> swept_names;
  int index = 0;
  for (const YamlNode& item : root.list("swept")) {
    sweep.swept.push_back(readAxis({&item, "swept." + std::to_string(index++), faults}, names));
    swept_names.push_back(sweep.swept.back().parameter);
  }
  if (root.valid() && (sweep.swept.empty() || sweep.swept.size() > 2)) root.fault("swept", "one or two axes");
  if (sweep.swept.size() == 2 && swept_names[0] == swept_names[1])
    root.fault("swept", "two different parameters");

  YamlMap parameters = root.map("parameters");
  for (const auto& name : names) {
    if (name == clearance_name && !parameters.has(name)) continue;  // all lengths are over it: 1
    if (!contains(swept_names, name) || parameters.has(name)) {
      if (contains(swept_names, name)) parameters.fault(name, "is swept; a fixed value has no meaning");
      sweep.parameters.emplace_back(name, parameters.number(name));
    }
  }
  parameters.finish();
  sweep.initial = {readState(root.map("initial"))};

  YamlMap run = root.map("run");
  const int turns = wholeNumber(run, "turns", 2);
  sweep.run.turns_kept = wholeNumber(run, "kept_turns", 2);
  sweep.run.steps_per_turn = wholeNumber(run, "steps_per_turn", 4);
  if (sweep.run.turns_kept > turns) run.fault("kept_turns", "at most `turns`");
  sweep.run.turns_skipped = turns - sweep.run.turns_kept;
  run.finish();
  if (root.has("continuation")) sweep.continuation = readContinuation(root.map("continuation"), names);
  root.finish();
  if (sweep.size() > most_points) root.fault("swept", "at most 1e8 points");
  faults.throwIfAny();

  // Ranges and the step: at the corners and along the axes, with the file's keys.
  std::size_t stride = std::max<std::size_t>(1, sweep.size() / 10000);
  std::vector<BasicParameters<double>> machines;
  try {
    for (std::size_t i = 0; i < sweep.size(); i += stride) machines.push_back(sweep.machineAt(i));
    machines.push_back(sweep.machineAt(sweep.size() - 1));
    checkBasicSteps(machines, sweep.run);
  } catch (const InputError& error) {
    std::vector<Fault> found = error.faults();
    for (Fault& fault : found) {
      fault.key = (fault.key == "steps_per_turn" ? "run." : "parameters.") + fault.key;
      fault.file = path;
      fault.line = faults.lineOf(fault.key);
    }
    throw InputError(std::move(found));
  }
  return sweep;
}

}  // namespace amb_rotor
