#pragma once
#include <memory>
#include <string>

#include "amb_rotor/model/effect_schema.hpp"

namespace amb_rotor {

/// The effects that this program knows, in the order in which they act; those of files that were read come last.
EffectCatalogue& effectCatalogue();

/// Whether an effect cannot be seen without contact; an unknown one: no.
bool needsContact(const std::string& effect);

/// The law of an effect that a file defined; null: there is none of this name.
std::shared_ptr<const EffectLaw> effectLaw(const std::string& id);

}  // namespace amb_rotor
