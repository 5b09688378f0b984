#pragma once
// Other places where an effect that a fit has found may do better: see candidate_hills.cpp.
#include <vector>

#include "candidates.hpp"

namespace amb_rotor {

/// An effect through contact with values far from those given that act alike at the slips of the runs' starting speeds; none where nothing
/// is known of such.
std::vector<EffectSetting> actingAlike(const EffectSetting& effect, const Model& belief, const std::vector<Recording>& recordings);

/// Whether two of them are next to the same.
bool actsInOnePlace(const EffectSetting& one, const EffectSetting& other);

}  // namespace amb_rotor
