#include "amb_rotor/effects/catalogue.hpp"

#include "amb_rotor/effects/all.hpp"

namespace amb_rotor {

const EffectCatalogue& effectCatalogue() {
  static const EffectCatalogue catalogue([] {
    std::vector<EffectSchema> schemas;
    effects::forEachEffect([&](auto* effect) {
      schemas.push_back(std::remove_pointer_t<decltype(effect)>::schema());
    });
    return schemas;
  }());
  return catalogue;
}

}  // namespace amb_rotor
