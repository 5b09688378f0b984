#include "amb_rotor/rotor/shaft_element.hpp"

#include <array>
#include <cmath>
#include <string>
#include <utility>

#include "amb_rotor/common/error.hpp"

namespace amb_rotor {
namespace {

constexpr double kPi = 3.14159265358979323846;

struct GaussPoint {
  double xi;
  double weight;
};

/// Five points on (0, 1): exact to degree 9; the highest is 8, a cone's area times a squared cubic.
const std::array<GaussPoint, 5>& gaussPoints() {
  static const std::array<GaussPoint, 5> points = [] {
    const double inner = std::sqrt(5.0 - 2.0 * std::sqrt(10.0 / 7.0)) / 3.0;
    const double outer = std::sqrt(5.0 + 2.0 * std::sqrt(10.0 / 7.0)) / 3.0;
    const double w_inner = (322.0 + 13.0 * std::sqrt(70.0)) / 900.0;
    const double w_outer = (322.0 - 13.0 * std::sqrt(70.0)) / 900.0;
    return std::array<GaussPoint, 5>{{{0.5 * (1.0 - outer), 0.5 * w_outer},
                                      {0.5 * (1.0 - inner), 0.5 * w_inner},
                                      {0.5, 64.0 / 225.0},
                                      {0.5 * (1.0 + inner), 0.5 * w_inner},
                                      {0.5 * (1.0 + outer), 0.5 * w_outer}}};
  }();
  return points;
}

double between(double left, double right, double xi) { return left + (right - left) * xi; }

void check(const ShaftElement& element) {
  std::vector<Fault> faults;
  const auto require = [&faults](bool holds, const std::string& key, double value, const char* rule) {
    if (!holds) faults.push_back({"", 0, key, std::to_string(value), rule});
  };
  require(element.length > 0.0 && std::isfinite(element.length), "length", element.length, "above 0 m");
  require(!element.layers.empty(), "layers", 0.0, "at least one layer");
  bool elastic = false;
  for (std::size_t i = 0; i < element.layers.size(); ++i) {
    const ShaftLayer& layer = element.layers[i];
    const Material& material = layer.material;
    const std::string key = "layers[" + std::to_string(i) + "].";
    const auto ring = [&](double outer, double inner, const char* side) {
      require(outer > 0.0 && std::isfinite(outer), key + "outer_diameter_" + side, outer, "above 0 m");
      require(inner >= 0.0 && inner < outer, key + "inner_diameter_" + side, inner,
              "from 0 m to below the outer diameter");
    };
    ring(layer.outer_diameter_left, layer.inner_diameter_left, "left");
    ring(layer.outer_diameter_right, layer.inner_diameter_right, "right");
    require(material.density > 0.0 && std::isfinite(material.density), key + "density", material.density,
            "above 0 kg/m3");
    require(material.youngs_modulus >= 0.0 && std::isfinite(material.youngs_modulus), key + "youngs_modulus",
            material.youngs_modulus, "0 Pa or above");
    require(material.poisson_ratio > -1.0 && material.poisson_ratio < 0.5, key + "poisson_ratio",
            material.poisson_ratio, "above -1 and below 0.5");
    require(layer.shear_factor >= 0.0 && layer.shear_factor <= 1.0, key + "shear_factor", layer.shear_factor,
            "0 (Hutchinson) to 1");
    elastic = elastic || material.youngs_modulus > 0.0;
  }
  require(elastic, "layers", 0.0, "at least one layer with a modulus above 0 Pa");
  if (!faults.empty()) throw InputError(std::move(faults));
}

}  // namespace

double hutchinsonShearFactor(double diameter_ratio, double poisson_ratio) {
  const double r2 = diameter_ratio * diameter_ratio;
  const double r4 = r2 * r2;
  const double nu = poisson_ratio;
  const double denominator = 7.0 + 34.0 * r2 + 7.0 * r4 + nu * (12.0 + 48.0 * r2 + 12.0 * r4) +
                             nu * nu * (4.0 + 16.0 * r2 + 4.0 * r4);
  return 6.0 * (1.0 + r2) * (1.0 + r2) * (1.0 + nu) * (1.0 + nu) / denominator;
}

double cowperShearFactor(double poisson_ratio) {
  return 6.0 * (1.0 + poisson_ratio) / (7.0 + 6.0 * poisson_ratio);
}

ShaftElement cylinder(double length, double outer_diameter, double inner_diameter, const Material& material,
                      BeamTheory theory) {
  ShaftElement element;
  element.length = length;
  element.layers.push_back({outer_diameter, outer_diameter, inner_diameter, inner_diameter, material, 0.0});
  element.theory = theory;
  return element;
}

SectionProperties sectionAt(const ShaftElement& element, double xi) {
  SectionProperties section;
  for (const ShaftLayer& layer : element.layers) {
    const double outer = between(layer.outer_diameter_left, layer.outer_diameter_right, xi);
    const double inner = between(layer.inner_diameter_left, layer.inner_diameter_right, xi);
    const double area = 0.25 * kPi * (outer * outer - inner * inner);
    const double second_moment = kPi / 64.0 * (std::pow(outer, 4) - std::pow(inner, 4));
    const double factor = layer.shear_factor > 0.0
                              ? layer.shear_factor
                              : hutchinsonShearFactor(inner / outer, layer.material.poisson_ratio);
    section.mass_per_length += layer.material.density * area;
    section.inertia_per_length += layer.material.density * second_moment;
    section.bending_stiffness += layer.material.youngs_modulus * second_moment;
    section.shear_stiffness += factor * layer.material.shearModulus() * area;
  }
  return section;
}

ShapeValues shapeValues(double xi, double length, double shear_parameter) {
  const double phi = shear_parameter;
  const double xi2 = xi * xi;
  const double xi3 = xi2 * xi;
  ShapeValues shape;
  shape.displacement << 1.0 + phi * (1.0 - xi) - 3.0 * xi2 + 2.0 * xi3,
      length * (xi - 2.0 * xi2 + xi3 + 0.5 * phi * (xi - xi2)), 3.0 * xi2 - 2.0 * xi3 + phi * xi,
      length * (-xi2 + xi3 - 0.5 * phi * (xi - xi2));
  shape.rotation << 6.0 * (xi2 - xi) / length, 1.0 - 4.0 * xi + 3.0 * xi2 + phi * (1.0 - xi),
      6.0 * (xi - xi2) / length, 3.0 * xi2 - 2.0 * xi + phi * xi;
  shape.displacement /= 1.0 + phi;
  shape.rotation /= 1.0 + phi;
  return shape;
}

ElementMatrices elementMatrices(const ShaftElement& element) {
  check(element);
  const double l = element.length;
  ElementMatrices result;
  if (element.theory == BeamTheory::timoshenko) {
    double bending = 0.0;
    double shear = 0.0;
    for (const GaussPoint& point : gaussPoints()) {
      const SectionProperties section = sectionAt(element, point.xi);
      bending += point.weight * section.bending_stiffness;
      shear += point.weight * section.shear_stiffness;
    }
    result.shear_parameter = 12.0 * bending / (shear * l * l);
  }
  const double phi = result.shear_parameter;
  // dw/dz - psi is constant along these shapes.
  Eigen::Vector4d shear_strain(-1.0 / l, -0.5, 1.0 / l, -0.5);
  shear_strain *= phi / (1.0 + phi);
  for (const GaussPoint& point : gaussPoints()) {
    const SectionProperties section = sectionAt(element, point.xi);
    const ShapeValues shape = shapeValues(point.xi, l, phi);
    Eigen::Vector4d curvature;
    curvature << 6.0 * (2.0 * point.xi - 1.0) / l, 6.0 * point.xi - 4.0 - phi,
        6.0 * (1.0 - 2.0 * point.xi) / l, 6.0 * point.xi - 2.0 + phi;
    curvature /= l * (1.0 + phi);
    const double dz = point.weight * l;
    const Eigen::Matrix4d rotary =
        dz * section.inertia_per_length * shape.rotation * shape.rotation.transpose();
    result.mass += dz * section.mass_per_length * shape.displacement * shape.displacement.transpose();
    if (element.rotary_inertia) result.mass += rotary;
    if (element.gyroscopic) result.gyroscopic += 2.0 * rotary;
    result.stiffness += dz * section.bending_stiffness * curvature * curvature.transpose();
    if (phi > 0.0) {
      result.stiffness += dz * section.shear_stiffness * shear_strain * shear_strain.transpose();
    }
  }
  return result;
}

}  // namespace amb_rotor
