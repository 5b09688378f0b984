#pragma once
// What small forces at the magnetic bearings, or at another plane, do to a run's channels when they are taken along the measured path.
//
// The channels show where the rotor was, so a force F(p, v, i, angle, time) that acted on it is known up to its
// coefficient, however much it bent the path: what it did is linear in the coefficient, while a prediction with the force
// in the model goes another way as soon as the coefficient is wrong. p and v [m, m/s] at the magnets are a parabola through
// nine instants of the displacements about each, rotor taken as straight between the sensors; i [A] is the measured current.
// F enters the loop as the current F/Ki behind the amplifier: as excitation ahead of its lag, held from instant to instant.
// A force at another plane of the rotor enters as the two at the bearings that move a rigid rotor as it does.
// Left out: how the run began (the force sets in at t = 0), Ki's own dependence on gap and current, noise of p, v and i.
#include <vector>

#include "amb_rotor/effects/effect.hpp"
#include "amb_rotor/validation/start_screen.hpp"

namespace amb_rotor {

/// Changes of the predicted channels by each of the forces, samples * predicted_channels; empty where a sensor is missing, the
/// magnetic bearings are not linear ones behind an amplifier's lag, or a prediction did not stay finite.
/// @param model   that of the run's prediction
/// @param forces  effects that add to the bearings' force or push the rotor at a plane; their size must leave the currents within
///                their limit
std::vector<std::vector<double>> responsesAlongPath(const ReferenceRun& run, const Model& model,
                                                    const std::vector<EffectSetting>& forces);

}  // namespace amb_rotor
