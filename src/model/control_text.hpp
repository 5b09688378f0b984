#pragma once
// Reading, writing and checking what a model file says of its control beyond the PID of the rig block
// (model/control_options.hpp).
#include <string>
#include <vector>

#include "amb_rotor/model/model.hpp"
#include "amb_rotor/model/yaml_document.hpp"

namespace amb_rotor {

/// The keys of `controller` beside type, sample rate, delay and PID gains; the type is read already.
void readControlOptions(YamlMap& controller, Model& model);
/// The optional block `signal_chain` of the rig.
void readSignalChain(YamlMap& rig, Model& model);
/// The optional block `coil` of `amb`.
void readCoil(YamlMap& amb, Model& model);

std::string controlText(const Model& model);
std::string signalChainText(const Model& model);
std::string coilText(const Model& model);

/// "name: value", as in every block of a model file.
inline std::string pairText(const char* name, double value) {
  return std::string(name) + ": " + numberText(value);
}

void checkOptions(const Model& model, bool skip_unreadable, std::vector<Fault>& faults);

}  // namespace amb_rotor
