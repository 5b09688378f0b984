#include "amb_rotor/model/overrides.hpp"

#include <algorithm>

#include "amb_rotor/model/model_rules.hpp"
#include "amb_rotor/model/yaml_document.hpp"

namespace amb_rotor {
namespace {

/// Why there is no such number, and which one may be meant.
std::string unknownRule(Model& model, const std::string& path, const EffectCatalogue& catalogue) {
  std::vector<std::string> paths;
  for (const ModelField& field : modelFields(model, catalogue)) paths.push_back(field.path);
  paths.push_back("rotor.model");
  const std::string nearest = "; nearest: " + nearestWord(path, paths);
  const std::string head = "effects.";
  if (path.compare(0, head.size(), head) == 0) {
    const std::string id = path.substr(head.size(), path.find('.', head.size()) - head.size());
    const bool present = std::any_of(model.effects.begin(), model.effects.end(),
                                     [&](const EffectSetting& effect) { return effect.id == id; });
    if (!present && catalogue.find(id) != nullptr)
      return "the effect " + id + " is not in this model; add it under effects: first";
  }
  return "this model has no such number" + nearest;
}

double* findField(Model& model, const std::string& path, const EffectCatalogue& catalogue) {
  for (const ModelField& field : modelFields(model, catalogue))
    if (field.path == path) return field.value;
  return nullptr;
}

void apply(Model& model, const std::string& text, const EffectCatalogue& catalogue,
           std::vector<Fault>& faults) {
  const std::size_t equals = text.find('=');
  if (equals == std::string::npos || equals == 0) {
    faults.push_back({"", 0, "", text, "must be path=value"});
    return;
  }
  const std::string path = text.substr(0, equals);
  const std::string value = text.substr(equals + 1);
  if (path == "rotor.model") {
    if (model.rotor_model != RotorModel::flexible && (value == "rigid_mass" || value == "rigid_beam")) {
      model.rotor_model = value == "rigid_mass" ? RotorModel::rigid_mass : RotorModel::rigid_beam;
    } else {
      faults.push_back({"", 0, path, value, "a rigid rotor may become rigid_mass or rigid_beam"});
    }
    return;
  }
  double* field = findField(model, path, catalogue);
  const auto number = parseNumber(value);
  if (field == nullptr) {
    faults.push_back({"", 0, path, value, unknownRule(model, path, catalogue)});
  } else if (!number) {
    faults.push_back({"", 0, path, value, "must be a finite number"});
  } else {
    *field = *number;
  }
}

}  // namespace

void applyOverrides(Model& model, const std::vector<std::string>& overrides,
                    const EffectCatalogue& catalogue) {
  Model changed = model;
  std::vector<Fault> faults;
  for (const std::string& text : overrides) apply(changed, text, catalogue, faults);
  const std::vector<Fault> broken = checkModel(changed, catalogue);
  faults.insert(faults.end(), broken.begin(), broken.end());
  if (!faults.empty()) throw InputError(faults);
  if (model.source != nullptr && !overrides.empty()) {
    const auto source = std::make_shared<FaultList>(*model.source);
    for (const std::string& text : overrides) source->forget(text.substr(0, text.find('=')));
    changed.source = source;
  }
  model = std::move(changed);
}

void applyOverride(Model& model, const std::string& override_text, const EffectCatalogue& catalogue) {
  applyOverrides(model, {override_text}, catalogue);
}

double* requireField(Model& model, const std::string& path, const EffectCatalogue& catalogue) {
  double* field = findField(model, path, catalogue);
  if (field == nullptr) throw InputError({{"", 0, path, "", unknownRule(model, path, catalogue)}});
  return field;
}

}  // namespace amb_rotor
