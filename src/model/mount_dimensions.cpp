#include "amb_rotor/model/mount_dimensions.hpp"

#include <cmath>

#include "amb_rotor/common/units.hpp"

namespace amb_rotor {
namespace {

/// A number with limits, which the file must have.
double positive(YamlMap& map, const std::string& key, double most, const std::string& rule) {
  const double value = map.number(key);
  if (std::isfinite(value) && !(value > 0.0 && value <= most)) map.fault(key, rule);
  return value;
}

double lossOf(YamlMap& map, double stiffness) {
  const double factor = map.number("loss_factor");
  if (factor < 0.0) map.fault("loss_factor", "must be from 0 (a mount gives no energy)");
  return kelvinVoigtDamping(stiffness, factor,
                            positive(map, "loss_frequency_hz", INFINITY, "must be above 0 Hz"));
}

double modulusOf(YamlMap& map) { return positive(map, "youngs_modulus_Pa", INFINITY, "must be above 0 Pa"); }

double lengthOf(YamlMap& map, const char* key) { return positive(map, key, INFINITY, "must be above 0 m"); }

}  // namespace

double ToleranceRing::waveStiffness() const {
  return 4.8 * youngs_modulus_Pa * width_m * std::pow(thickness_m / wave_pitch_m, 3);
}

double ORing::stiffness() const {
  return count * 0.5 * pi * mean_diameter_m * youngs_modulus_Pa *
         (1.875 * std::sqrt(squeeze) + 300.0 * std::pow(squeeze, 5));
}

double kelvinVoigtDamping(double stiffness, double loss_factor, double frequency_hz) {
  return loss_factor * stiffness / (two_pi * frequency_hz);
}

bool hasMountDimensions(YamlMap& entry) {
  const bool ring = entry.has("tolerance_ring"), o_ring = entry.has("o_ring");
  return ring || o_ring;
}

std::vector<double> readMountDimensions(YamlMap& entry) {
  double stiffness = 0.0, damping = 0.0;
  const std::size_t faults_before = entry.faults().faults().size();
  if (entry.has("tolerance_ring") && entry.has("o_ring"))
    entry.fault("o_ring", "the mount is a tolerance ring already; it may be one of the two");
  if (entry.has("tolerance_ring")) {
    YamlMap map = entry.map("tolerance_ring");
    ToleranceRing ring;
    ring.youngs_modulus_Pa = modulusOf(map);
    ring.width_m = lengthOf(map, "width_m");
    ring.thickness_m = lengthOf(map, "thickness_m");
    ring.wave_pitch_m = lengthOf(map, "wave_pitch_m");
    ring.share =
        positive(map, "ring_share", 1e3, "must be above 0 (stiffness of the ring over that of one wave)");
    if (ring.thickness_m >= ring.wave_pitch_m)
      map.fault("thickness_m", "must be below the wave pitch (a thin strip)");
    stiffness = ring.stiffness();
    damping = lossOf(map, stiffness);
    map.finish();
  } else {
    YamlMap map = entry.map("o_ring");
    ORing ring;
    ring.youngs_modulus_Pa = modulusOf(map);
    ring.mean_diameter_m = lengthOf(map, "mean_diameter_m");
    ring.cord_diameter_m = lengthOf(map, "cord_diameter_m");
    ring.squeeze = positive(map, "squeeze", 0.4, "must be above 0 to 0.4 (share of the cord's diameter)");
    ring.count = positive(map, "count", 1e3, "must be above 0");
    if (ring.cord_diameter_m >= ring.mean_diameter_m)
      map.fault("cord_diameter_m", "must be below the mean diameter");
    stiffness = ring.stiffness();
    damping = lossOf(map, stiffness);
    map.finish();
  }
  // of dimensions that are refused nothing follows that could be refused, too
  if (entry.faults().faults().size() != faults_before) stiffness = damping = std::nan("");
  return {stiffness, damping, entry.number("mass_kg")};
}

}  // namespace amb_rotor
