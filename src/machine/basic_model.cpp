#include "amb_rotor/machine/basic_model.hpp"

#include <algorithm>
#include <cmath>
#include <string>

#include "amb_rotor/common/units.hpp"
#include "amb_rotor/machine/basic_lanes.hpp"

namespace amb_rotor {
namespace {

/// Largest step times contact frequency: see requiredBasicSteps.
constexpr double largest_step_angle = 0.3;

std::string number(double value) {
  std::string text = std::to_string(value);
  return text;
}

/// Steepest slope of the contact force [k1], at a penetration that bounds what a rub does: the static
/// deflection under the unbalance force at this speed, or an impact at the speed eta, the larger of both.
double steepestContact(const BasicParameters<double>& p, BasicContact contact) {
  if (contact == BasicContact::linear) return p.contact_stiffness;
  if (p.hertz_stiffness <= 0.0) return 0.0;
  // Impact at velocity w: kappa depth^2.5 2/5 = w^2/2. Slope 1.5 kappa sqrt(depth).
  const double speed = p.frequency_ratio * std::max(0.5, p.eccentricity * p.frequency_ratio);
  const double depth = std::pow(1.25 * speed * speed / p.hertz_stiffness, 0.4);
  return 1.5 * p.hertz_stiffness * std::sqrt(depth);
}

}  // namespace

BasicParameters<double> rotatedToPhaseZero(const BasicParameters<double>& p) {
  BasicParameters<double> turned = p;
  const BasicState<double> centre =
      rotated({p.misalignment_x, p.misalignment_y, 0.0, 0.0}, -p.unbalance_phase);
  turned.misalignment_x = centre.x;
  turned.misalignment_y = centre.y;
  turned.unbalance_phase = 0.0;
  return turned;
}

BasicState<double> rotated(const BasicState<double>& s, double angle) {
  if (angle == 0.0) return s;
  const double c = std::cos(angle), d = std::sin(angle);
  return {c * s.x - d * s.y, d * s.x + c * s.y, c * s.vx - d * s.vy, d * s.vx + c * s.vy};
}

int requiredBasicSteps(const BasicParameters<double>& p, BasicContact contact) {
  const double frequency = std::sqrt(p.support_stiffness + steepestContact(p, contact));
  return static_cast<int>(std::ceil(two_pi * frequency / (p.frequency_ratio * largest_step_angle)));
}

void checkBasicParameters(const BasicParameters<double>& p) {
  std::vector<Fault> faults;
  const auto require = [&](bool holds, const char* key, double value, const char* rule) {
    if (!holds) faults.push_back({"", 0, key, number(value), rule});
  };
  BasicParameters<double>::visit(p, [&](const char* key, const double& value) {
    require(std::isfinite(value), key, value, "a finite number");
  });
  require(p.frequency_ratio > 0.0, "frequency_ratio", p.frequency_ratio, "greater than 0 (dimensionless)");
  require(p.damping >= 0.0, "damping", p.damping, "at least 0 (dimensionless)");
  require(p.support_stiffness > 0.0, "support_stiffness", p.support_stiffness, "greater than 0 (over k1)");
  require(p.eccentricity >= 0.0, "eccentricity", p.eccentricity, "at least 0 (over the clearance)");
  require(p.contact_stiffness >= 0.0, "contact_stiffness", p.contact_stiffness, "at least 0 (over k1)");
  require(p.hertz_stiffness >= 0.0, "hertz_stiffness", p.hertz_stiffness, "at least 0 (dimensionless)");
  require(p.hertz_damping >= 0.0, "hertz_damping", p.hertz_damping, "at least 0 (dimensionless)");
  require(p.friction >= 0.0, "friction", p.friction, "at least 0");
  require(p.friction_sign == 1.0 || p.friction_sign == -1.0, "friction_sign", p.friction_sign, "1 or -1");
  require(p.surface_radius >= 0.0, "surface_radius", p.surface_radius, "at least 0 (over the clearance)");
  require(p.regularisation_speed > 0.0, "regularisation_speed", p.regularisation_speed, "greater than 0");
  if (!faults.empty()) throw InputError(std::move(faults));
}

void checkBasicSteps(const std::vector<BasicParameters<double>>& machines, const BasicLaneOptions& options) {
  int required = 0;
  for (const auto& machine : machines) {
    checkBasicParameters(machine);
    required = std::max(required, requiredBasicSteps(machine, options.contact));
  }
  if (options.steps_per_turn < required) {
    throw InputError(
        {{"", 0, "steps_per_turn", std::to_string(options.steps_per_turn),
          "too coarse for the contact: at least " + std::to_string(required) + " steps a turn"}});
  }
}

}  // namespace amb_rotor
