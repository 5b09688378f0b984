#pragma once
// Writes a model as amb-model/1. Reading it back gives the same bits: numbers are written as the
// shortest text that does (numberText).
#include <string>

#include "amb_rotor/model/effect_schema.hpp"
#include "amb_rotor/model/model.hpp"

namespace amb_rotor {

/// As a model file names it; not for by_frequency.
const char* reductionName(RotorReduction::Method method);
/// The lines of `rotor.reduction`; empty where it is by frequency.
std::string reductionText(const RotorReduction& reduction);

/// The model as YAML text. The geometry's path is written as it stands in the model.
/// Throws InputError for a model that breaks a rule: what is written can always be read.
std::string modelText(const Model& model, const EffectCatalogue& catalogue);

/// Writes the text beside `path` and renames it. A relative geometry path is rewritten to hold from the
/// new folder. Throws InputError if the file cannot be written.
void writeModel(const Model& model, const EffectCatalogue& catalogue, const std::string& path);

/// Writes a text file beside `path` and renames it, so that it is there whole or not at all.
void writeTextFile(const std::string& path, const std::string& text);

/// The name of a model choice as in files.
const char* rotorModelName(RotorModel model);
const char* ambModelName(AmbModel model);

}  // namespace amb_rotor
