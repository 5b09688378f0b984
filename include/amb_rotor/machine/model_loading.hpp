#pragma once
// A model file made ready to run: where its rotor is flexible, the modes of its geometry are filled in.
#include <string>
#include <vector>

#include "amb_rotor/model/model.hpp"

namespace amb_rotor {

/// Bending modes up to this frequency take part in a run [Hz]; above it they only cost steps. Far above the AMB's
/// bandwidth and the band of a contact (a few kHz). All modes of a rotor: fillFlexibleModes with a higher limit.
constexpr double highest_mode_hz = 1.0e4;

/// Reads a model file with the effects of this program. @throw InputError: all faults at once, of the geometry too
Model loadModel(const std::string& path);

/// Fills Model::flexible from the geometry file; nothing where the rotor is not flexible or its modes are there.
/// Modes are scaled so that the first has the rotor's mass and shape 1, the second its transverse inertia and shape z
/// (so that the coordinates of a rigid beam keep their meaning), the bending modes the rotor's mass.
/// @throw InputError  geometry unreadable, or its mass differs from rotor.mass_kg by more than 1 %
void fillFlexibleModes(Model& model, double highest_hz = highest_mode_hz);

/// Planes of magnetic bearings, sensors and auxiliary bearings, each once [m from the centre of gravity]: what a reduction
/// keeps or balances for.
std::vector<double> keptPlanes(const Model& model);

}  // namespace amb_rotor
