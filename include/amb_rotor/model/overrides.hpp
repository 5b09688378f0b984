#pragma once
// `--set path=value`: changes a number of a model that was read.
//
// Paths: rig.rotor.mass_kg, rig.unbalance.0.moment_kg_m, effects.sensor_runout.a_1x_m (the effect must be
// in the model), and rotor.model=rigid_mass|rigid_beam.
#include <string>
#include <vector>

#include "amb_rotor/model/effect_schema.hpp"
#include "amb_rotor/model/model.hpp"

namespace amb_rotor {

/// Applies all "path=value" texts, then checks the rules of the model. Throws InputError with all faults
/// (unknown path with the nearest known one, value that is no number, broken rule); the model is then
/// unchanged.
void applyOverrides(Model& model, const std::vector<std::string>& overrides,
                    const EffectCatalogue& catalogue);

/// One of them.
void applyOverride(Model& model, const std::string& override_text, const EffectCatalogue& catalogue);

/// The number at `path` of the model; throws InputError, with the nearest known path, where there is none.
/// The pointer holds until the model's lists change.
double* requireField(Model& model, const std::string& path, const EffectCatalogue& catalogue);

}  // namespace amb_rotor
