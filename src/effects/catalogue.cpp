#include "amb_rotor/effects/catalogue.hpp"

#include "amb_rotor/effects/all.hpp"

namespace amb_rotor {

EffectCatalogue& effectCatalogue() {
  static EffectCatalogue catalogue([] {
    std::vector<EffectSchema> schemas;
    effects::forEachEffect([&](auto* effect) {
      schemas.push_back(std::remove_pointer_t<decltype(effect)>::schema());
    });
    return schemas;
  }());
  return catalogue;
}

bool needsContact(const std::string& effect) {
  const EffectSchema* schema = effectCatalogue().find(effect);
  return schema != nullptr && schema->needs_contact;
}

std::shared_ptr<const EffectLaw> effectLaw(const std::string& id) {
  const EffectSchema* schema = effectCatalogue().find(id);
  return schema != nullptr ? schema->law : nullptr;
}

}  // namespace amb_rotor
