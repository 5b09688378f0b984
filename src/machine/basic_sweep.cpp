#include "amb_rotor/machine/basic_sweep.hpp"

#include <algorithm>
#include <cmath>

#include "amb_rotor/common/check.hpp"
#include "amb_rotor/common/units.hpp"

namespace amb_rotor {
namespace {

const char* const misalignment = "misalignment";
const char* const misalignment_angle = "misalignment_angle_deg";
const char* const phase = "unbalance_phase_deg";

double radians(double degrees) { return degrees * pi / 180.0; }

}  // namespace

const char* const clearance_name = "clearance";

double clearanceOf(const NamedValues& values) {
  double clearance = 1.0;
  for (const auto& [key, value] : values) {
    if (key == clearance_name) clearance = value;
  }
  if (!(clearance > 0.0) || !std::isfinite(clearance)) {
    throw InputError(
        {{"", 0, clearance_name, std::to_string(clearance), "greater than 0 (over the file's)"}});
  }
  return clearance;
}

std::vector<std::string> basicParameterNames() {
  std::vector<std::string> names;
  const BasicParameters<double> p;
  BasicParameters<double>::visit(p, [&](const std::string& field, const double&) {
    if (field != "misalignment_x" && field != "misalignment_y" && field != "unbalance_phase") {
      names.push_back(field);
    }
  });
  names.insert(names.end(), {misalignment, misalignment_angle, phase, clearance_name});
  return names;
}

BasicParameters<double> basicParametersFrom(const NamedValues& values) {
  BasicParameters<double> p;
  const auto known = basicParameterNames();
  double distance = 0.0, angle_deg = 0.0;
  for (const auto& [key, value] : values) {
    if (std::find(known.begin(), known.end(), key) == known.end()) {
      throw InputError({{"", 0, key, "", "is no parameter of the basic model"}});
    }
    if (key == misalignment) distance = value;
    if (key == misalignment_angle) angle_deg = value;
    if (key == phase) p.unbalance_phase = radians(value);
    BasicParameters<double>::visit(p,
                                   [&, &key = key, &value = value](const std::string& field, double& target) {
                                     if (field == key) target = value;
                                   });
  }
  const double c = clearanceOf(values);
  p.misalignment_x = distance * std::cos(radians(angle_deg)) / c;
  p.misalignment_y = distance * std::sin(radians(angle_deg)) / c;
  p.eccentricity /= c;
  p.surface_radius /= c;
  p.regularisation_speed /= c;
  p.hertz_stiffness *= std::sqrt(c);
  p.hertz_damping *= c;
  return p;
}

BasicState<double> overOwnClearance(const BasicState<double>& state, const NamedValues& values) {
  const double c = clearanceOf(values);
  return {state.x / c, state.y / c, state.vx / c, state.vy / c};
}

std::size_t BasicSweep::size() const {
  std::size_t points = 1;
  for (const auto& axis : swept) points *= axis.values.size();
  return points;
}

std::vector<double> BasicSweep::valuesAt(std::size_t point) const {
  std::vector<double> values(swept.size());
  for (std::size_t axis = swept.size(); axis-- > 0;) {
    values[axis] = swept[axis].values[point % swept[axis].values.size()];
    point /= swept[axis].values.size();
  }
  return values;
}

NamedValues BasicSweep::namedAt(std::size_t point) const {
  NamedValues all = parameters;
  const auto values = valuesAt(point);
  for (std::size_t axis = 0; axis < swept.size(); ++axis)
    all.emplace_back(swept[axis].parameter, values[axis]);
  return all;
}

BasicParameters<double> BasicSweep::machineAt(std::size_t point) const {
  return basicParametersFrom(namedAt(point));
}

BasicState<double> BasicSweep::initialAt(std::size_t point) const {
  return overOwnClearance(initial.front(), namedAt(point));
}

BasicSweepPart runBasicSweep(const BasicSweep& sweep, std::size_t first, std::size_t count) {
  AMB_ROTOR_CHECK(first + count <= sweep.size() && count > 0, "points outside the grid");
  std::vector<BasicParameters<double>> machines;
  std::vector<BasicState<double>> initial;
  machines.reserve(count);
  initial.reserve(count);
  for (std::size_t i = 0; i < count; ++i) {
    machines.push_back(sweep.machineAt(first + i));
    initial.push_back(sweep.initialAt(first + i));
  }
  BasicLaneOptions options = sweep.run;
  options.lyapunov = true;
  BasicSweepPart part;
  part.lanes = runBasicLanes(machines, initial, options);
  part.motions = basicMotions(part.lanes, sweep.regime);
  return part;
}

double exponentPerTime(double per_turn, double frequency_ratio) {
  return per_turn * frequency_ratio / two_pi;
}

}  // namespace amb_rotor
