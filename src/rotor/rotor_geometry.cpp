#include "amb_rotor/rotor/rotor_geometry.hpp"

#include <algorithm>
#include <cmath>
#include <sstream>
#include <utility>

namespace amb_rotor {
namespace {

constexpr double kSameLength = 1e-9;  // [m]; round-off of a sum of section lengths

std::string written(double value) {
  std::ostringstream text;
  text << value;
  return text.str();
}

class Faults {
 public:
  void require(bool holds, const std::string& key, double value, const std::string& rule) {
    if (!holds) list_.push_back({"", 0, key, written(value), rule});
  }
  void positive(const std::string& key, double value, const std::string& unit) {
    require(std::isfinite(value) && value > 0.0, key, value, "above 0 " + unit);
  }
  void notNegative(const std::string& key, double value, const std::string& unit) {
    require(std::isfinite(value) && value >= 0.0, key, value, "0 " + unit + " or above");
  }
  void material(const std::string& key, const Material& material, bool carries_load) {
    positive(key + ".density_kg_per_m3", material.density, "kg/m3");
    if (carries_load) {
      positive(key + ".youngs_modulus_Pa", material.youngs_modulus, "Pa (a section carries load)");
    } else {
      notNegative(key + ".youngs_modulus_Pa", material.youngs_modulus, "Pa");
    }
    require(material.poisson_ratio > -1.0 && material.poisson_ratio < 0.5, key + ".poisson_ratio",
            material.poisson_ratio, "above -1 and below 0.5");
  }
  std::vector<Fault> take() { return std::move(list_); }

 private:
  std::vector<Fault> list_;
};

std::string item(const char* list, std::size_t i) {
  return std::string(list) + "[" + std::to_string(i) + "]";
}

void checkSections(const RotorGeometry& geometry, Faults& faults) {
  faults.require(!geometry.sections.empty(), "sections", 0.0, "at least one section");
  for (std::size_t i = 0; i < geometry.sections.size(); ++i) {
    const ShaftSection& section = geometry.sections[i];
    const std::string key = item("sections", i);
    faults.positive(key + ".length_m", section.length, "m");
    faults.positive(key + ".outer_diameter_m", section.outer_diameter_left, "m");
    faults.positive(key + ".outer_diameter_end_m", section.outer_diameter_right, "m");
    faults.require(
        section.inner_diameter_left >= 0.0 && section.inner_diameter_left < section.outer_diameter_left,
        key + ".inner_diameter_m", section.inner_diameter_left, "from 0 m to below the outer diameter");
    faults.require(
        section.inner_diameter_right >= 0.0 && section.inner_diameter_right < section.outer_diameter_right,
        key + ".inner_diameter_end_m", section.inner_diameter_right,
        "from 0 m to below the outer diameter at that end");
    faults.require(section.shear_factor >= 0.0 && section.shear_factor <= 1.0, key + ".shear_factor",
                   section.shear_factor, "above 0 to 1; leave it out for Hutchinson's");
    faults.material(key + ".material", section.material, true);
  }
}

void checkRing(const RotorGeometry& geometry, std::size_t index, Faults& faults) {
  const ShrunkRing& ring = geometry.rings[index];
  const std::string key = item("rings", index);
  const double length = geometry.length();
  faults.require(ring.from >= -kSameLength && ring.from <= length, key + ".from_m", ring.from,
                 "on the shaft");
  faults.require(ring.to > ring.from && ring.to <= length + kSameLength, key + ".to_m", ring.to,
                 "above from_m and on the shaft, which is " + written(length) + " m long");
  faults.positive(key + ".outer_diameter_m", ring.outer_diameter, "m");
  faults.require(ring.inner_diameter > 0.0 && ring.inner_diameter < ring.outer_diameter,
                 key + ".inner_diameter_m", ring.inner_diameter, "above 0 m and below the outer diameter");
  faults.material(key + ".material", ring.material, false);
  double start = 0.0;
  for (const ShaftSection& section : geometry.sections) {
    const double end = start + section.length;
    const bool touches = ring.from < end - kSameLength && ring.to > start + kSameLength;
    const double shaft = std::max(section.outer_diameter_left, section.outer_diameter_right);
    const bool cylinder = section.outer_diameter_left == section.outer_diameter_right;
    faults.require(!touches || !cylinder || ring.inner_diameter >= shaft - kSameLength,
                   key + ".inner_diameter_m", ring.inner_diameter,
                   "not below the shaft's " + written(shaft) + " m there: the overlap would count twice");
    start = end;
  }
}

}  // namespace

double RotorGeometry::length() const {
  double sum = 0.0;
  for (const ShaftSection& section : sections) sum += section.length;
  return sum;
}

std::vector<Fault> faultsOf(const RotorGeometry& geometry) {
  Faults faults;
  const double length = geometry.length();
  // what lies where on a shaft is judged once its sections have lengths
  const bool known = std::all_of(geometry.sections.begin(), geometry.sections.end(), [](const ShaftSection& section) {
    return std::isfinite(section.length) && section.length > 0.0;
  });
  faults.positive("max_element_length_m", geometry.max_element_length, "m");
  // A slip of the unit (m for mm) would otherwise ask for gigabytes of matrices.
  faults.require(!known || !(geometry.max_element_length > 0.0) || length / geometry.max_element_length <= 2000.0,
                 "max_element_length_m", geometry.max_element_length, "at most 2000 elements a rotor");
  checkSections(geometry, faults);
  for (std::size_t i = 0; known && i < geometry.rings.size(); ++i) checkRing(geometry, i, faults);
  for (std::size_t i = 0; i < geometry.discs.size(); ++i) {
    const Disc& disc = geometry.discs[i];
    const std::string key = item("discs", i);
    faults.require(disc.at >= 0.0 && (!known || disc.at <= length + kSameLength), key + ".at_m", disc.at,
                   "on the shaft, which is " + written(length) + " m long");
    faults.positive(key + ".mass_kg", disc.mass, "kg");
    faults.notNegative(key + ".polar_inertia_kg_m2", disc.polar_inertia, "kg m2");
    faults.notNegative(key + ".transverse_inertia_kg_m2", disc.transverse_inertia, "kg m2");
    // Ip = It + It' - 2 int z^2 dm for a body of revolution: the triangle inequality of the inertias.
    faults.require(disc.polar_inertia <= 2.0 * disc.transverse_inertia * (1.0 + 1e-9),
                   key + ".polar_inertia_kg_m2", disc.polar_inertia,
                   "at most twice the transverse inertia (kg m2)");
  }
  faults.notNegative("damping.mass_proportional_per_s", geometry.damping.mass_proportional, "1/s");
  faults.notNegative("damping.stiffness_proportional_s", geometry.damping.stiffness_proportional, "s");
  for (std::size_t i = 0; i < geometry.damping.modal_ratios.size(); ++i) {
    const double ratio = geometry.damping.modal_ratios[i];
    faults.require(ratio >= 0.0 && ratio < 1.0, item("damping.modal_ratios", i), ratio, "from 0 to below 1");
  }
  return faults.take();
}

}  // namespace amb_rotor
