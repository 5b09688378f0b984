#include "amb_rotor/model/effect_schema.hpp"

#include <algorithm>
#include <mutex>

#include "amb_rotor/model/effect_file.hpp"

namespace amb_rotor {

EffectCatalogue::EffectCatalogue(std::vector<EffectSchema> schemas) : schemas_(schemas.begin(), schemas.end()) {}

std::vector<EffectSchema> EffectCatalogue::all() const {
  const std::shared_lock<std::shared_mutex> lock(mutex_);
  return {schemas_.begin(), schemas_.end()};
}

const EffectSchema* EffectCatalogue::find(const std::string& id) const {
  const std::shared_lock<std::shared_mutex> lock(mutex_);
  const auto found =
      std::find_if(schemas_.begin(), schemas_.end(), [&](const EffectSchema& schema) { return schema.id == id; });
  return found == schemas_.end() ? nullptr : &*found;
}

const EffectSchema* EffectCatalogue::add(const EffectSchema& schema) {
  const std::unique_lock<std::shared_mutex> lock(mutex_);
  for (const EffectSchema& known : schemas_) {
    if (known.id != schema.id) continue;
    const bool same = known.law != nullptr && schema.law != nullptr && known.law->definition == schema.law->definition;
    return same ? &known : nullptr;
  }
  schemas_.push_back(schema);
  return &schemas_.back();
}

}  // namespace amb_rotor
