#include "amb_rotor/machine/basic_dry_whirl.hpp"

#include <limits>

namespace amb_rotor {
namespace {

bool exists(const BasicParameters<double>& p, double w) {
  return w * w > p.support_stiffness && w * w < p.support_stiffness + p.contact_stiffness;
}

}  // namespace

double dryWhirlRadius(const BasicParameters<double>& p, double w) {
  if (!exists(p, w)) return std::numeric_limits<double>::quiet_NaN();
  return p.contact_stiffness / (p.contact_stiffness + p.support_stiffness - w * w);
}

double dryWhirlFriction(const BasicParameters<double>& p, double w) {
  if (!exists(p, w)) return std::numeric_limits<double>::quiet_NaN();
  return p.damping * w / (w * w - p.support_stiffness);
}

BasicState<double> dryWhirlState(const BasicParameters<double>& p, double w) {
  const double radius = dryWhirlRadius(p, w);
  return {radius, 0.0, 0.0, -w * radius};
}

}  // namespace amb_rotor
