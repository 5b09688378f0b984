#include "amb_rotor/model/model_hash.hpp"

#include <algorithm>

#include "amb_rotor/model/effect_file.hpp"
#include "amb_rotor/model/model_rules.hpp"
#include "amb_rotor/model/model_writer.hpp"
#include "amb_rotor/model/yaml_document.hpp"

namespace amb_rotor {
namespace {

std::string lineText(const std::string& path, double value) {
  return path + "=" + numberText(value + 0.0) + "\n";  // + 0.0 turns -0 into 0
}

std::string listText(const std::string& path, const std::vector<double>& values) {
  std::string text;
  for (std::size_t i = 0; i < values.size(); ++i) text += lineText(path + "." + std::to_string(i), values[i]);
  return text;
}

}  // namespace

std::uint64_t fnv1a(const std::string& text) {
  constexpr std::uint64_t offset_basis = 14695981039346656037ull;
  constexpr std::uint64_t prime = 1099511628211ull;
  std::uint64_t hash = offset_basis;
  for (const char c : text) hash = (hash ^ static_cast<unsigned char>(c)) * prime;
  return hash;
}

std::string canonicalText(const Model& model, const EffectCatalogue& catalogue) {
  Model sorted = model;
  std::sort(sorted.effects.begin(), sorted.effects.end(),
            [](const EffectSetting& a, const EffectSetting& b) { return a.id < b.id; });
  std::string text = std::string("rotor.model=") + rotorModelName(model.rotor_model) +
                     "\namb.model=" + ambModelName(model.amb_model) + "\n";
  // Only where it is not the usual one: hashes of older files stay what they are.
  if (model.friction_law == FrictionLaw::set_valued) text += "friction_law=set_valued\n";
  for (const ModelField& field : modelFields(sorted, catalogue)) text += lineText(field.path, *field.value);
  text += optionChoices(sorted);
  for (const EffectSetting& effect : sorted.effects) {
    text += "effect=" + effect.id + "\n";
    const EffectSchema* schema = catalogue.find(effect.id);
    if (schema != nullptr && schema->law != nullptr) text += "law=" + schema->law->physics + "\n";
  }
  const FlexibleModes& modes = model.flexible;
  if (modes.mass.empty()) {
    if (!model.rotor_geometry.empty()) text += "rotor.geometry=" + model.rotor_geometry + "\n";
    return text + reductionText(model.reduction);
  }
  return text + listText("flexible.mass", modes.mass) + listText("flexible.stiffness", modes.stiffness) +
         listText("flexible.damping", modes.damping) + listText("flexible.gyroscopic", modes.gyroscopic) +
         listText("flexible.z_m", modes.z_m) + listText("flexible.shape", modes.shape);
}

std::string modelHash(const Model& model, const EffectCatalogue& catalogue) {
  static const char* digits = "0123456789abcdef";
  std::uint64_t hash = fnv1a(canonicalText(model, catalogue));
  std::string text(16, '0');
  for (std::size_t i = text.size(); i-- > 0; hash >>= 4) text[i] = digits[hash & 15];
  return text;
}

}  // namespace amb_rotor
