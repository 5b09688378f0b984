#include "amb_rotor/common/error.hpp"

#include <utility>

namespace amb_rotor {
namespace {

std::string joined(const std::vector<Fault>& faults) {
  std::string text;
  for (const Fault& fault : faults) {
    if (!text.empty()) text += '\n';
    text += fault.text();
  }
  return text.empty() ? "bad input" : text;
}

}  // namespace

std::string Fault::text() const {
  std::string text;
  if (!file.empty()) text += file + ":";
  if (line > 0) text += std::to_string(line) + ":";
  if (!text.empty()) text += " ";
  if (!key.empty()) text += key;
  if (!value.empty()) text += " = " + value;
  if (!key.empty() || !value.empty()) text += ": ";
  return text + rule;
}

InputError::InputError(std::vector<Fault> faults)
    : std::runtime_error(joined(faults)), faults_(std::move(faults)) {}

void invariantFailed(const char* expression, const char* file, int line, const std::string& detail) {
  throw InvariantError(std::string(file) + ":" + std::to_string(line) + ": " + expression +
                       " does not hold: " + detail);
}

}  // namespace amb_rotor
