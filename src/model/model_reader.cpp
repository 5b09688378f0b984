#include "amb_rotor/model/model_reader.hpp"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <limits>

#include "amb_rotor/model/effect_file.hpp"
#include "amb_rotor/model/magnet_dimensions.hpp"
#include "amb_rotor/model/model_rules.hpp"
#include "amb_rotor/model/mount_dimensions.hpp"
#include "control_text.hpp"

namespace amb_rotor {
namespace {

/// Of a flexible rotor; what a machine has room for, with the planes that Craig-Bampton keeps besides.
constexpr int most_kept_modes = 64;
constexpr double not_a_number = std::numeric_limits<double>::quiet_NaN();

void readPlanes(YamlMap planes, Model& model) {
  const auto pair = [&](const char* name, double(&z)[2]) {
    YamlMap plane = planes.map(name);
    z[0] = plane.number("a");
    z[1] = plane.number("b");
    plane.finish();
  };
  pair("amb", model.rig.planes.amb);
  pair("sensor", model.rig.planes.sensor);
  pair("aux", model.rig.planes.aux);
  planes.finish();
}

/// Ki, Ks and the flux density: as numbers, or from the magnets' dimensions, bias and gap.
void readStiffnesses(YamlMap& amb, Model& model) {
  auto& values = model.rig.amb;
  if (!amb.has("magnet")) {
    values.current_stiffness_N_per_A = amb.number("current_stiffness_N_per_A");
    values.displacement_stiffness_N_per_m = amb.number("displacement_stiffness_N_per_m");
    values.bias_flux_density_T = amb.optionalNumber("bias_flux_density_T").value_or(0.0);
    return;
  }
  for (const char* key : {"current_stiffness_N_per_A", "displacement_stiffness_N_per_m", "bias_flux_density_T"})
    if (amb.has(key)) amb.fault(key, "must be absent: it follows from magnet");
  const std::size_t before = amb.faults().faults().size();
  const MagnetDimensions magnet = readMagnetDimensions(amb);
  const bool sound = amb.faults().faults().size() == before;
  if (!sound || !(values.bias_current_A > 0.0 && values.air_gap_m > 0.0)) return;  // told, here or by the rules
  values.current_stiffness_N_per_A = magnet.currentStiffness(values.bias_current_A, values.air_gap_m);
  values.displacement_stiffness_N_per_m = magnet.displacementStiffness(values.bias_current_A, values.air_gap_m);
  values.bias_flux_density_T = magnet.fluxDensity(values.bias_current_A, values.air_gap_m);
}

/// False where the bearing's model is not known: then its other keys cannot be judged.
bool readAmb(YamlMap amb, Model& model) {
  auto& values = model.rig.amb;
  const int kind = amb.choice("model", {"linear", "equivalent"});
  if (kind < 0) return false;
  model.amb_model = kind == 0 ? AmbModel::linear : AmbModel::equivalent;
  if (model.amb_model == AmbModel::linear) {
    values.bias_current_A = amb.number("bias_current_A");
    values.air_gap_m = amb.number("air_gap_m");
    readStiffnesses(amb, model);
    values.amplifier_bandwidth_hz = amb.number("amplifier_bandwidth_hz");
    values.max_current_A = amb.number("max_current_A");
    readCoil(amb, model);
  } else {
    values.stiffness_N_per_m = amb.number("stiffness_N_per_m");
    values.damping_N_s_per_m = amb.number("damping_N_s_per_m");
  }
  amb.finish();
  return true;
}

void readController(YamlMap controller, Model& model) {
  auto& values = model.rig.controller;
  const int type = controller.choice("type", {"pid", "state_space"});
  values.sample_rate_hz = controller.number("sample_rate_hz");
  values.delay_s = controller.number("delay_s");
  if (type < 0) return;
  model.control.type = type == 0 ? ControllerType::pid : ControllerType::state_space;
  if (type == 0) {
    values.kp_A_per_m = controller.number("kp_A_per_m");
    values.kd_A_s_per_m = controller.number("kd_A_s_per_m");
    values.ki_A_per_m_s = controller.number("ki_A_per_m_s");
    values.derivative_filter_hz = controller.number("derivative_filter_hz");
  }
  readControlOptions(controller, model);
  controller.finish();
}

void readAuxiliaryBearing(YamlMap bearing, Model& model) {
  auto& values = model.rig.auxiliary_bearing;
  values.clearance_m = bearing.number("clearance_m");
  values.rotor_radius_m = bearing.number("rotor_radius_m");
  YamlMap contact = bearing.map("contact");
  contact.choice("model", {"linear"});  // other laws are effects
  values.stiffness_N_per_m = contact.number("stiffness_N_per_m");
  values.damping_N_s_per_m = contact.number("damping_N_s_per_m");
  contact.finish();
  values.friction_coefficient = bearing.number("friction_coefficient");
  if (bearing.has("friction_law") && bearing.choice("friction_law", {"regularised", "set_valued"}) == 1)
    model.friction_law = FrictionLaw::set_valued;
  bearing.choice("mount", {"rigid"});
  bearing.finish();
}

void readUncertainty(YamlMap uncertainty, Model& model) {
  const std::vector<std::string> known = uncertaintyNames(model);
  for (const std::string& name : uncertainty.keys()) {
    const double value = uncertainty.number(name);
    const bool exact = value == 0.0 && std::find(known.begin(), known.end(), name) != known.end();
    if (!exact) model.uncertainty[name] = value;
  }
}

void readReduction(YamlMap reduction, Model& model) {
  using Method = RotorReduction::Method;
  const int method = reduction.choice("method", {"modal", "craig_bampton", "balanced"});
  const double modes = reduction.number("modes");
  reduction.finish();
  if (method < 0 || std::isnan(modes)) return;
  constexpr Method methods[] = {Method::modal, Method::craig_bampton, Method::balanced};
  model.reduction.method = methods[method];
  const int least = methods[method] == Method::craig_bampton ? 0 : 2;
  if (modes < least || modes > most_kept_modes || modes != std::floor(modes))
    reduction.fault("modes", "must be a whole number from " + std::to_string(least) + " to " + std::to_string(most_kept_modes));
  else
    model.reduction.modes = static_cast<int>(modes);
}

void readRotor(YamlMap rotor, Model& model) {
  const int kind = rotor.choice("model", {"rigid_mass", "rigid_beam", "flexible"});
  if (kind < 0) return;
  model.rotor_model = kind == 0   ? RotorModel::rigid_mass
                      : kind == 1 ? RotorModel::rigid_beam
                                  : RotorModel::flexible;
  if (model.rotor_model == RotorModel::flexible) {
    model.rotor_geometry = rotor.text("geometry");
    const std::filesystem::path file = std::filesystem::path(model.folder) / model.rotor_geometry;
    std::error_code ignored;
    if (!model.rotor_geometry.empty() && !std::filesystem::is_regular_file(file, ignored))
      rotor.fault("geometry", "there is no such file (paths are relative to the model file)");
    if (rotor.has("reduction")) readReduction(rotor.map("reduction"), model);
  }
  rotor.finish();
}

/// The effect that an entry brings along, in a file or written out, into the catalogue.
void readDefinition(YamlMap& entry, const EffectSetting& effect, EffectCatalogue& catalogue, const Model& model) {
  const bool in_file = entry.has("file"), written_out = entry.has("definition");
  if (in_file && written_out) entry.fault("file", "the effect is defined twice: leave out file or definition");
  EffectSchema schema;
  if (written_out) {
    const YamlNode* node = entry.take("definition", true);
    if (node == nullptr) return;
    const std::size_t before = entry.faults().faults().size();
    YamlMap definition(node, entry.pathOf("definition"), entry.faults());
    schema = readEffect(definition, *node);
    if (entry.faults().faults().size() != before) return;
  } else if (in_file) {
    const std::string name = entry.text("file");
    if (name.empty()) return;
    try {
      schema = readEffectFile((std::filesystem::path(model.folder) / name).string());
    } catch (const InputError& error) {
      entry.faults().append(error.faults());
      return;
    }
  } else {
    return;
  }
  if (schema.id != effect.id)
    entry.fault("effect", "is not the effect that its definition names, " + schema.id);
  else if (catalogue.add(schema) == nullptr)
    entry.fault("effect", "another effect of this name is known already");
}

void readEffects(YamlMap& root, EffectCatalogue& catalogue, Model& model) {
  FaultList& faults = root.faults();
  std::size_t index = 0;
  for (const YamlNode& item : root.list("effects")) {
    YamlMap entry(&item, "effects." + std::to_string(index++), faults);
    EffectSetting effect;
    effect.id = entry.text("effect");
    const std::size_t before = faults.faults().size();
    readDefinition(entry, effect, catalogue, model);
    const EffectSchema* schema = catalogue.find(effect.id);
    if (effect.id == "compliant_mount" && schema != nullptr && hasMountDimensions(entry)) {
      effect.values = readMountDimensions(entry);
      entry.finish();
      faults.noteLine("effects." + effect.id, item.line);
      model.effects.push_back(std::move(effect));
      continue;
    }
    if (schema == nullptr && !effect.id.empty() && faults.faults().size() == before) {
      std::vector<std::string> ids;  // nothing else can be said of its keys
      for (const auto& known : catalogue.all()) ids.push_back(known.id);
      entry.fault("effect", "the effect is not known; nearest: " + nearestWord(effect.id, ids));
      continue;
    }
    const YamlNode* parameters = entry.take("parameters", true);
    entry.finish();
    if (schema == nullptr) continue;
    const std::string path = "effects." + effect.id;
    YamlMap values(parameters, path, faults);
    for (const ParameterSchema& parameter : schema->parameters)
      effect.values.push_back(values.number(parameter.name));
    values.finish();
    faults.noteLine(path, item.line);
    model.effects.push_back(std::move(effect));
  }
}

}  // namespace

std::vector<Unbalance<double>> readUnbalance(YamlMap& owner, const std::string& key) {
  std::vector<Unbalance<double>> entries;
  for (const YamlNode& item : owner.list(key)) {
    YamlMap entry(&item, owner.pathOf(key) + "." + std::to_string(entries.size()), owner.faults());
    Unbalance<double> unbalance{not_a_number, not_a_number, not_a_number};
    unbalance.plane_z_m = entry.number("plane_z_m");
    unbalance.moment_kg_m = entry.number("moment_kg_m");
    unbalance.phase_rad = entry.number("phase_rad");
    entry.finish();
    entries.push_back(unbalance);
  }
  return entries;
}

void readRig(YamlMap& rig, Model& model) {
  // What cannot be read stays NaN, so that no rule is checked on it.
  Rig<double>::visit(model.rig, [](const char*, double& value) { value = not_a_number; });
  YamlMap rotor = rig.map("rotor");
  model.rig.rotor.mass_kg = rotor.number("mass_kg");
  model.rig.rotor.transverse_inertia_kg_m2 = rotor.number("transverse_inertia_kg_m2");
  model.rig.rotor.polar_inertia_kg_m2 = rotor.number("polar_inertia_kg_m2");
  rotor.finish();
  readPlanes(rig.map("planes"), model);
  if (readAmb(rig.map("amb"), model)) {
    if (model.amb_model == AmbModel::linear) {
      readController(rig.map("controller"), model);
      readSignalChain(rig, model);
    } else if (rig.has("controller")) {
      rig.fault("controller", "must be absent: an equivalent bearing has no controller");
    }
  } else {
    rig.has("controller");
    rig.has("signal_chain");
  }
  readAuxiliaryBearing(rig.map("auxiliary_bearing"), model);
  model.rig.unbalance = readUnbalance(rig, "unbalance");
  model.rig.gravity_m_s2 = rig.number("gravity_m_s2");
  readUncertainty(rig.map("uncertainty"), model);
  rig.finish();
  // Fields that have no meaning for this bearing model are 0, not NaN.
  Rig<double>::visit(model.rig, [&](const char* name, double& value) {
    if (!rigFieldApplies(name, model)) value = 0.0;
  });
}

Model parseModel(const std::string& text, const std::string& name, EffectCatalogue& catalogue) {
  FaultList faults(name);
  const YamlNode document = parseYaml(text, faults);
  YamlMap root(&document, "", faults);
  requireFormat(root, "amb-model/1");
  Model model;
  model.folder = std::filesystem::path(name).parent_path().string();
  model.name = root.text("name");
  YamlMap rig = root.map("rig");
  if (rig.valid()) readRig(rig, model);
  readRotor(root.map("rotor"), model);
  readEffects(root, catalogue, model);
  if (root.has("revision")) {
    const YamlNode* revision = root.take("revision", true);
    if (revision != nullptr) model.revision = yamlText(*revision, 0);
  }
  root.finish();
  if (rig.valid()) faults.addRules(checkModel(model, catalogue, true));
  faults.throwIfAny();
  model.source = std::make_shared<FaultList>(faults);
  return model;
}

Model readModel(const std::string& path, EffectCatalogue& catalogue) {
  return parseModel(readTextFile(path), path, catalogue);
}

}  // namespace amb_rotor
