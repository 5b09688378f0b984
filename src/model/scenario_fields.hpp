#pragma once
// Which keys belong to which type in a scenario file, where they live, and their limits: the one list for
// the reader, the writer and the rules.
#include <limits>
#include <string>
#include <vector>

#include "amb_rotor/model/scenario.hpp"

namespace amb_rotor::scenario_fields {

enum class Limit { any, from_zero, above_zero };

template <class Owner>
struct Key {
  const char* name;  ///< with its unit
  double Owner::*member;
  Limit limit;
  double most = std::numeric_limits<double>::infinity();  ///< its size is at most that
  const char* reason = "";                                ///< of this
};

/// For what an entry acts on, beside its numbers.
enum class Address {
  none,
  one,     ///< end: a | b, axis: x | y
  several  ///< end: a | b | both, axis: x | y | both
};

extern const std::vector<std::string> speed_names;
extern const std::vector<std::string> waveform_names;
extern const std::vector<std::string> fault_names;

std::vector<Key<SpeedLaw>> keysOf(SpeedType type);
std::vector<Key<Excitation>> keysOf(const Excitation& excitation);
std::vector<Key<FaultEvent>> keysOf(FaultType type);
Address addressOf(FaultType type);

}  // namespace amb_rotor::scenario_fields
