#include "amb_rotor/model/magnet_dimensions.hpp"

#include <cmath>

#include "amb_rotor/common/units.hpp"

namespace amb_rotor {
namespace {

constexpr double permeability = 4e-7 * pi;  // of the vacuum [V s/(A m)]

}  // namespace

double MagnetDimensions::fluxDensity(double current, double gap) const {
  return permeability * windings * current / (2.0 * gap);
}

double MagnetDimensions::pull(double current, double gap) const {
  const double b = fluxDensity(current, gap);
  return b * b * pole_area_m2 / permeability * std::cos(force_angle_rad);
}

double MagnetDimensions::force(double bias, double air_gap, double current, double position) const {
  return pull(bias + current, air_gap - position) - pull(bias - current, air_gap + position);
}

double MagnetDimensions::currentStiffness(double bias, double air_gap) const {
  return windings * windings * permeability * pole_area_m2 * bias / (air_gap * air_gap) * std::cos(force_angle_rad);
}

double MagnetDimensions::displacementStiffness(double bias, double air_gap) const {
  return currentStiffness(bias, air_gap) * bias / air_gap;
}

MagnetDimensions readMagnetDimensions(YamlMap& amb) {
  YamlMap map = amb.map("magnet");
  MagnetDimensions magnet{};
  magnet.windings = map.number("windings");
  if (magnet.windings <= 0.0) map.fault("windings", "must be above 0 (of one magnet, both poles)");
  magnet.pole_area_m2 = map.number("pole_area_m2");
  if (magnet.pole_area_m2 <= 0.0) map.fault("pole_area_m2", "must be above 0 m2");
  magnet.force_angle_rad = map.number("force_angle_rad");
  if (magnet.force_angle_rad < 0.0 || magnet.force_angle_rad > 0.25 * pi)
    map.fault("force_angle_rad", "must be from 0 to " + numberText(0.25 * pi) +
                                     " rad (a pole farther round belongs to the other axis)");
  map.finish();
  return magnet;
}

}  // namespace amb_rotor
