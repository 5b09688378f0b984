#include "amb_rotor/common/units.hpp"

#include <map>

namespace amb_rotor {

std::optional<double> unitFactor(const std::string& unit) {
  static const std::map<std::string, double> factors = {
      {"m", 1.0},    {"mm", 1e-3}, {"um", 1e-6},        {"A", 1.0},   {"mA", 1e-3},
      {"N", 1.0},    {"V", 1.0},   {"s", 1.0},          {"ms", 1e-3}, {"us", 1e-6},
      {"Hz", 1.0},   {"rad", 1.0}, {"rpm", 1.0 / 60.0}, {"deg", pi / 180.0}};
  const auto found = factors.find(unit);
  if (found == factors.end()) return std::nullopt;
  return found->second;
}

}  // namespace amb_rotor
