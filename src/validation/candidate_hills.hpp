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

/// Whether a fit has an unbalance over a quarter of a turn from where it is believed: one that explains what another force does ends there.
bool isUnbalanceTurned(const FitSpace& space, const Eigen::VectorXd& nuisance);

/// A bending mode that the unbalance drives the other way: the same motion, where the unbalance is turned by half.
EffectSetting drivenTheOtherWay(EffectSetting mode);

}  // namespace amb_rotor
