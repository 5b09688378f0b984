#pragma once
// A number in a sentence.
#include <cstdio>
#include <string>

namespace amb_rotor {

/// As printf writes it; 63 characters at most.
inline std::string text(const char* format, double value) {
  char out[64];
  std::snprintf(out, sizeof out, format, value);
  return out;
}

}  // namespace amb_rotor
