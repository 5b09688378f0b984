#pragma once
// Reads a model file, format amb-model/1; doc/formats.md.
#include <string>
#include <vector>

#include "amb_rotor/model/effect_schema.hpp"
#include "amb_rotor/model/model.hpp"
#include "amb_rotor/model/yaml_document.hpp"

namespace amb_rotor {

/// Reads and checks a model. Throws InputError with every fault of the file, each with its line. Effects that the model
/// defines (file:, definition:) join the catalogue.
Model readModel(const std::string& path, EffectCatalogue& catalogue);

/// The same from a text; `name` stands for the file in faults, and its folder is the model's.
Model parseModel(const std::string& text, const std::string& name, EffectCatalogue& catalogue);

/// The rig block that model files and data sets share: fills rig, amb_model and uncertainty of `model`.
/// An uncertainty of 0 (known exactly) is left out, which means the same. Faults go to the map's list;
/// limits are not checked here (checkRig).
void readRig(YamlMap& rig, Model& model);

/// A list of unbalances, in a rig or in a run of a data set.
std::vector<Unbalance<double>> readUnbalance(YamlMap& owner, const std::string& key);

}  // namespace amb_rotor
