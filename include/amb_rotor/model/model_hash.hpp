#pragma once
// A number that names the physics of a model: recordings, sweeps and diagnoses carry it, so that it
// can be seen whether they belong to the same machine.
#include <cstdint>
#include <string>

#include "amb_rotor/model/effect_schema.hpp"
#include "amb_rotor/model/model.hpp"

namespace amb_rotor {

/// FNV-1a, 64 bits. Against accidents, not against forgers.
std::uint64_t fnv1a(const std::string& text);

/// What the hash is taken of: every number that has a meaning for the model, as path=shortest text, one a
/// line; effects by name (the order of the list has no meaning). Without name, folder, revision and
/// uncertainty. -0 counts as 0. A flexible rotor enters by its modes where they are filled in, else by
/// the path of its geometry: fill them in first.
std::string canonicalText(const Model& model, const EffectCatalogue& catalogue);

/// fnv1a of canonicalText as 16 hexadecimal digits.
std::string modelHash(const Model& model, const EffectCatalogue& catalogue);

}  // namespace amb_rotor
