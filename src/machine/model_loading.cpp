#include "amb_rotor/machine/model_loading.hpp"

#include <algorithm>
#include <cmath>
#include <filesystem>

#include "amb_rotor/common/units.hpp"
#include "amb_rotor/effects/catalogue.hpp"
#include "amb_rotor/machine/assembly.hpp"
#include "amb_rotor/model/model_reader.hpp"
#include "amb_rotor/model/model_rules.hpp"
#include "amb_rotor/model/yaml_document.hpp"
#include "amb_rotor/rotor/flexible_rotor.hpp"
#include "amb_rotor/rotor/reduction.hpp"
#include "amb_rotor/rotor/rotor_geometry.hpp"

namespace amb_rotor {
namespace {

constexpr double same_plane_m = 1e-6;

/// Throws faults in what the model says, with its file and lines where it has them.
[[noreturn]] void throwOf(const Model& model, const std::vector<Fault>& faults) {
  throw InputError(model.source != nullptr ? model.source->located(faults) : faults);
}

ReducedRotor reducedFor(const Model& model, const FlexibleRotor& rotor) {
  using Method = RotorReduction::Method;
  if (model.reduction.method == Method::by_frequency) return allModes(rotor);
  try {
    if (model.reduction.method == Method::modal) return reduceModal(rotor, model.reduction.modes);
    if (model.reduction.method == Method::balanced) return reduceBalanced(rotor, keptPlanes(model), model.reduction.modes);
    return reduceCraigBampton(rotor, keptPlanes(model), model.reduction.modes);
  } catch (const InputError& error) {
    std::vector<Fault> faults = error.faults();
    for (Fault& fault : faults)
      fault.key = fault.key == "planes" ? "rig.planes" : fault.key == "damping" ? "rotor.geometry: damping" : "rotor.reduction.modes";
    throwOf(model, faults);
  }
}

}  // namespace

std::vector<double> keptPlanes(const Model& model) {
  std::vector<double> planes;
  for (const auto* pair : {model.rig.planes.amb, model.rig.planes.sensor, model.rig.planes.aux})
    for (int end = 0; end < 2; ++end) planes.push_back(pair[end]);
  std::sort(planes.begin(), planes.end());
  planes.erase(std::unique(planes.begin(), planes.end(), [](double a, double b) { return b - a < same_plane_m; }),
               planes.end());
  return planes;
}

void fillFlexibleModes(Model& model, double highest_hz) {
  if (model.rotor_model != RotorModel::flexible || !model.flexible.mass.empty()) return;
  const auto path = std::filesystem::path(model.folder) / model.rotor_geometry;
  const RotorGeometry geometry = loadRotorGeometry(path.string());
  const FlexibleRotor rotor(geometry);
  const ReducedRotor reduced = reducedFor(model, rotor);
  const double mass = reduced.inertia.mass, tilt = reduced.inertia.transverse;
  int n = reduced.modes;
  if (model.reduction.method == RotorReduction::Method::by_frequency) {
    n = 0;
    while (n < reduced.modes && n < max_modes - 1 &&
           std::sqrt(std::max(0.0, reduced.stiffness[n])) <= radPerSecond(highest_hz))
      ++n;
  }
  FlexibleModes& modes = model.flexible;
  std::vector<double> scale;
  for (int k = 0; k < n; ++k) {
    const double own = k == 1 ? tilt : mass;
    scale.push_back(std::sqrt(own));
    modes.mass.push_back(own);
    modes.stiffness.push_back(k < 2 ? 0.0 : own * reduced.stiffness[k]);
    modes.damping.push_back(own * (k < 2 ? geometry.damping.mass_proportional : reduced.damping[k]));
  }
  for (int k = 0; k < n; ++k)
    for (int l = 0; l < n; ++l) modes.gyroscopic.push_back(scale[k] * scale[l] * reduced.gyroscopic(k, l));
  const std::vector<double>& nodes = reduced.grid.z;
  const std::size_t rows = FlexibleModes::rows_an_element;
  for (std::size_t i = 0; i <= rows * (nodes.size() - 1); ++i) {
    const std::size_t left = i / rows, inside = i % rows;
    const double length = inside > 0 ? nodes[left + 1] - nodes[left] : 0.0;
    const double z = nodes[left] + length * static_cast<double>(inside) / static_cast<double>(rows);
    modes.z_m.push_back(z);
    const auto shape = reduced.shape(z);
    for (int k = 0; k < n; ++k) modes.shape.push_back(scale[k] * shape[k]);
  }
  std::vector<Fault> faults = checkShaft(model, effectCatalogue());
  for (Fault& fault : faults) fault.rule += "; geometry: " + path.string();
  if (!faults.empty()) throwOf(model, faults);
}

Model loadModel(const std::string& path) {
  Model model = readModel(path, effectCatalogue());
  fillFlexibleModes(model);
  return model;
}

}  // namespace amb_rotor
