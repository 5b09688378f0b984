#pragma once
#include "amb_rotor/model/effect_schema.hpp"

namespace amb_rotor {

/// The effects that this program knows, in the order in which they act.
const EffectCatalogue& effectCatalogue();

}  // namespace amb_rotor
