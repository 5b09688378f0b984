#pragma once
// What no rule forbids and yet is seldom meant: numbers of an unusual size, mostly of another unit, and numbers that
// hardly belong to one machine. For people (`amb check`, `amb simulate`); nothing is refused for a remark.
//
// A remark has the form of a fault: path, value, what is odd; file and line where it was read from a file.
#include <vector>

#include "amb_rotor/common/error.hpp"
#include "amb_rotor/model/model.hpp"
#include "amb_rotor/model/scenario.hpp"

namespace amb_rotor {

/// Of a model without faults.
std::vector<Fault> remarksOn(const Model& model);
/// Of a scenario without faults.
std::vector<Fault> remarksOn(const Scenario& scenario);
/// Of both together.
std::vector<Fault> remarksOn(const Model& model, const Scenario& scenario);

}  // namespace amb_rotor
