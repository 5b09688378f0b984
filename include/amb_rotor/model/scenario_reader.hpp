#pragma once
// Reads and writes a scenario, format amb-scenario/1; doc/formats.md. Every key that belongs to a type is
// required, every other one is a fault.
#include <optional>
#include <string>
#include <vector>

#include "amb_rotor/common/error.hpp"
#include "amb_rotor/model/scenario.hpp"

namespace amb_rotor {

/// A recording holds at most this many samples.
constexpr double max_recorded_samples = 1e8;

/// Reads and checks a scenario. Throws InputError with every fault of the file, each with its line.
Scenario readScenario(const std::string& path);

/// The same from a text; `name` stands for the file in faults.
Scenario parseScenario(const std::string& text, const std::string& name);

/// The rules that files and messages share, as faults with dotted paths (faults.0.start_s); empty when all
/// hold. `skip_unreadable`: values that are not finite are taken as reported already.
std::vector<Fault> checkScenario(const Scenario& scenario, bool skip_unreadable = false);

/// The rules of one fault; `path` stands before the keys. For the injector, which gets them one by one.
std::vector<Fault> checkFaultEvent(const FaultEvent& event, const std::string& path,
                                   bool skip_unreadable = false);

/// The scenario as YAML text that reads back to the same bits. Throws InputError if it breaks a rule.
std::string scenarioText(const Scenario& scenario);

/// Writes it beside `path` and renames it.
void writeScenario(const Scenario& scenario, const std::string& path);

/// Names as in files.
const char* faultTypeName(FaultType type);
std::optional<FaultType> faultTypeFromName(const std::string& name);
const char* waveformName(Waveform waveform);
const char* speedTypeName(SpeedType type);

}  // namespace amb_rotor
