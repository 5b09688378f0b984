#pragma once
// Private to analysis/: one way to refuse a bad argument, with its name, value and rule.
#include <string>
#include <vector>

#include "amb_rotor/common/error.hpp"

namespace amb_rotor {

/// Throws InputError that names the argument when the condition does not hold.
inline void requireArgument(bool condition, const char* name, double value, const char* rule) {
  if (!condition) throw InputError({Fault{"", 0, name, std::to_string(value), rule}});
}

/// Throws InputError when two series that belong together differ in length.
inline void requireSameLength(const std::vector<double>& a, const std::vector<double>& b, const char* name) {
  requireArgument(a.size() == b.size(), name, static_cast<double>(b.size()),
                  "must have as many values as the series it belongs to");
}

}  // namespace amb_rotor
