#include "amb_rotor/model/model_writer.hpp"

#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <sstream>

#include "amb_rotor/model/effect_file.hpp"
#include "amb_rotor/model/model_rules.hpp"
#include "amb_rotor/model/yaml_document.hpp"
#include "control_text.hpp"

namespace amb_rotor {
namespace {

std::string planeText(const char* name, const double (&z)[2]) {
  return std::string("    ") + name + ": {" + pairText("a", z[0]) + ", " + pairText("b", z[1]) + "}\n";
}

/// The numbers of one block of the rig, one a line, by their names out of Rig::visit.
std::string blockText(const Model& model, const std::string& block) {
  std::string text;
  const std::string head = block + ".";
  Rig<double>::visit(model.rig, [&](const char* path, const double& value) {
    const std::string name = path;
    if (name.compare(0, head.size(), head) != 0 || !rigFieldApplies(name, model)) return;
    if (name == "amb.bias_flux_density_T" && value == 0.0) return;  // not stated
    text += "    " + pairText(path + head.size(), value) + "\n";
  });
  return text;
}

std::string rigText(const Model& model) {
  const auto& rig = model.rig;
  std::string text = "rig:\n  rotor:\n" + blockText(model, "rotor") + "  planes:\n";
  text += planeText("amb", rig.planes.amb) + planeText("sensor", rig.planes.sensor) +
          planeText("aux", rig.planes.aux);
  text += std::string("  amb:\n    model: ") + ambModelName(model.amb_model) + "\n" + blockText(model, "amb") + coilText(model);
  if (model.amb_model == AmbModel::linear)
    text += std::string("  controller:\n    type: ") +
            (model.control.type == ControllerType::pid ? "pid" : "state_space") + "\n" +
            blockText(model, "controller") + controlText(model) + signalChainText(model);
  const auto& bearing = rig.auxiliary_bearing;
  text += "  auxiliary_bearing:\n    " + pairText("clearance_m", bearing.clearance_m) + "\n    " +
          pairText("rotor_radius_m", bearing.rotor_radius_m) + "\n    contact: {model: linear, " +
          pairText("stiffness_N_per_m", bearing.stiffness_N_per_m) + ", " +
          pairText("damping_N_s_per_m", bearing.damping_N_s_per_m) + "}\n    " +
          pairText("friction_coefficient", bearing.friction_coefficient) + "\n" +
          (model.friction_law == FrictionLaw::set_valued ? "    friction_law: set_valued\n" : "") +
          "    mount: rigid\n";
  text += rig.unbalance.empty() ? "  unbalance: []\n" : "  unbalance:\n";
  for (const auto& unbalance : rig.unbalance)
    text += "    - {" + pairText("plane_z_m", unbalance.plane_z_m) + ", " +
            pairText("moment_kg_m", unbalance.moment_kg_m) + ", " +
            pairText("phase_rad", unbalance.phase_rad) + "}\n";
  text += "  " + pairText("gravity_m_s2", rig.gravity_m_s2) + "\n";
  text += model.uncertainty.empty() ? "  uncertainty: {}\n" : "  uncertainty:\n";
  for (const auto& entry : model.uncertainty)
    text += "    " + pairText(entry.first.c_str(), entry.second) + "\n";
  return text;
}

std::string effectsText(const Model& model, const EffectCatalogue& catalogue) {
  if (model.effects.empty()) return "effects: []\n";
  std::string text = "effects:\n";
  for (const EffectSetting& effect : model.effects) {
    const EffectSchema* schema = catalogue.find(effect.id);
    text += "  - effect: " + effect.id + "\n";
    if (schema->law != nullptr) {  // a model that is written holds all that it needs
      text += "    definition:\n";
      std::istringstream lines(schema->law->definition);
      for (std::string line; std::getline(lines, line);) text += "      " + line + "\n";
    }
    text += "    parameters:";
    text += effect.values.empty() ? " {}\n" : "\n";
    for (std::size_t i = 0; i < effect.values.size(); ++i)
      text += "      " + pairText(schema->parameters[i].name.c_str(), effect.values[i]) + "\n";
  }
  return text;
}

std::string revisionText(const Model& model) {
  if (model.revision.empty()) return "";
  FaultList faults("revision of " + model.name);
  YamlNode block;
  block.kind = YamlNode::Kind::map;
  block.keys = {"revision"};
  block.items = {parseYaml(model.revision, faults)};
  faults.throwIfAny();
  return yamlText(block, 0);
}

}  // namespace

const char* rotorModelName(RotorModel model) {
  switch (model) {
    case RotorModel::rigid_mass:
      return "rigid_mass";
    case RotorModel::rigid_beam:
      return "rigid_beam";
    case RotorModel::flexible:
      return "flexible";
  }
  return "";
}

const char* ambModelName(AmbModel model) { return model == AmbModel::linear ? "linear" : "equivalent"; }

const char* reductionName(RotorReduction::Method method) {
  using Method = RotorReduction::Method;
  return method == Method::modal ? "modal" : method == Method::craig_bampton ? "craig_bampton" : "balanced";
}

std::string reductionText(const RotorReduction& reduction) {
  using Method = RotorReduction::Method;
  if (reduction.method == Method::by_frequency) return "";
  return std::string("  reduction:\n    method: ") + reductionName(reduction.method) +
         "\n    modes: " + std::to_string(reduction.modes) + "\n";
}

std::string modelText(const Model& model, const EffectCatalogue& catalogue) {
  requireValid(model, catalogue);
  std::string text = "format: amb-model/1\nname: " + quotedText(model.name) + "\n" + rigText(model);
  text += std::string("rotor:\n  model: ") + rotorModelName(model.rotor_model) + "\n";
  if (!model.rotor_geometry.empty()) text += "  geometry: " + quotedText(model.rotor_geometry) + "\n";
  return text + reductionText(model.reduction) + effectsText(model, catalogue) + revisionText(model);
}

void writeModel(const Model& model, const EffectCatalogue& catalogue, const std::string& path) {
  namespace fs = std::filesystem;
  Model moved = model;
  const fs::path geometry = model.rotor_geometry;
  if (!geometry.empty() && geometry.is_relative()) {
    const fs::path target = fs::absolute(fs::path(path)).parent_path().lexically_normal();
    const fs::path source = fs::absolute(fs::path(model.folder) / geometry).lexically_normal();
    moved.rotor_geometry = source.lexically_relative(target).string();
  }
  writeTextFile(path, modelText(moved, catalogue));
}

void writeTextFile(const std::string& path, const std::string& text) {
  const std::string beside = path + ".part" + std::to_string(::getpid());
  std::error_code error;
  errno = 0;
  std::ofstream stream(beside, std::ios::binary | std::ios::trunc);
  stream << text;
  stream.close();
  if (stream) std::filesystem::rename(beside, path, error);
  if (stream && !error) return;
  const std::string reason = error ? error.message() : errno != 0 ? std::strerror(errno) : "unknown why";
  std::error_code ignored;
  std::filesystem::remove(beside, ignored);
  throw InputError({{path, 0, "", "", "the file cannot be written: " + reason}});
}

}  // namespace amb_rotor
