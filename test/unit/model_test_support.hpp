#pragma once
// What the tests of model files share: a small catalogue of effects, the valid model as a text to spoil,
// and the faults of a call.
#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "amb_rotor/common/error.hpp"
#include "amb_rotor/model/model_reader.hpp"

namespace amb_rotor::model_test {

inline EffectCatalogue& smallCatalogue() {
  static EffectCatalogue catalogue(
      {{"sensor_runout",
        "The sensor track is not round.",
        "all runs with spin",
        {{"a_1x_m", "m", 0.0, 1e-4, 1e-6, 0.0, ParameterRole::amplitude, "amplitude once a turn"},
         {"a_1x_phase_rad", "rad", -10.0, 10.0, 0.0, 0.0, ParameterRole::phase, "its phase"}}},
       {"control_delay",
        "A longer delay.",
        "chirps",
        {{"delay_s", "s", 0.0, 2e-3, 1e-4, 0.0, ParameterRole::plain, "sample to command"}}}});
  return catalogue;
}

inline const std::string& dataFolder() {
  static const std::string folder = std::string(AMB_ROTOR_SOURCE_DIR) + "/test/data";
  return folder;
}

inline std::string validText() { return readTextFile(dataFolder() + "/model_valid/model.yaml"); }

inline Model validModel() { return parseModel(validText(), "model.yaml", smallCatalogue()); }

/// The text with its first `from` replaced; the test fails where it is not in there.
inline std::string replaced(std::string text, const std::string& from, const std::string& to) {
  const std::size_t at = text.find(from);
  EXPECT_NE(at, std::string::npos) << "not in the text: " << from;
  if (at != std::string::npos) text.replace(at, from.size(), to);
  return text;
}

/// The line in which `part` first stands, 1-based.
inline int lineOf(const std::string& text, const std::string& part) {
  int line = 1;
  const std::size_t at = text.find(part);
  for (std::size_t i = 0; i < at && i < text.size(); ++i) line += text[i] == '\n';
  return line;
}

template <class F>
std::vector<Fault> faultsOf(F&& call) {
  try {
    call();
  } catch (const InputError& error) {
    return error.faults();
  }
  return {};
}

inline std::string joined(const std::vector<Fault>& faults) {
  std::string text;
  for (const Fault& fault : faults) text += fault.text() + "\n";
  return text;
}

/// The fault of a key; the test fails where there is none.
inline Fault faultOf(const std::vector<Fault>& faults, const std::string& key) {
  for (const Fault& fault : faults)
    if (fault.key == key) return fault;
  ADD_FAILURE() << "no fault of " << key << " in:\n" << joined(faults);
  return {};
}

}  // namespace amb_rotor::model_test
