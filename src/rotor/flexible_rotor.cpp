#include "amb_rotor/rotor/flexible_rotor.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "amb_rotor/common/error.hpp"
#include "amb_rotor/common/linear_algebra.hpp"

namespace amb_rotor {
namespace {

/// Nodes closer than this are one: far below any machining tolerance, far above round-off.
constexpr double kSamePlace = 1e-9;  // [m]

struct Place {
  int element;
  double xi;
  double length;
};

Place placeOf(const BeamGrid& grid, double at) {
  const std::vector<double>& z = grid.z;
  if (!(at >= z.front() - kSamePlace && at <= z.back() + kSamePlace)) {
    throw InputError({{"", 0, "z", std::to_string(at),
                       "on the rotor, from " + std::to_string(z.front()) + " m to " +
                           std::to_string(z.back()) + " m of the centre of gravity"}});
  }
  const auto above = std::upper_bound(z.begin() + 1, z.end() - 1, at);
  const int element = static_cast<int>(above - z.begin()) - 1;
  const double length = z[element + 1] - z[element];
  return {element, std::clamp((at - z[element]) / length, 0.0, 1.0), length};
}

std::vector<double> nodePositions(const RotorGeometry& geometry) {
  std::vector<double> edges{0.0};
  for (const ShaftSection& section : geometry.sections) edges.push_back(edges.back() + section.length);
  const double length = edges.back();
  for (const ShrunkRing& ring : geometry.rings) {
    edges.push_back(ring.from);
    edges.push_back(ring.to);
  }
  for (const Disc& disc : geometry.discs) edges.push_back(disc.at);
  std::sort(edges.begin(), edges.end());
  std::vector<double> nodes{0.0};
  for (double edge : edges) {
    const double start = nodes.back();
    const double gap = std::min(edge, length) - start;
    if (gap <= kSamePlace) continue;
    const int parts = std::max(1, static_cast<int>(std::ceil(gap / geometry.max_element_length - 1e-9)));
    for (int i = 1; i <= parts; ++i) nodes.push_back(start + gap * i / parts);
  }
  return nodes;
}

std::vector<ShaftElement> elementsOf(const RotorGeometry& geometry) {
  std::vector<Fault> faults = faultsOf(geometry);
  if (!faults.empty()) throw InputError(std::move(faults));
  const std::vector<double> nodes = nodePositions(geometry);
  std::vector<ShaftElement> elements;
  std::size_t section_index = 0;
  double section_start = 0.0;
  for (std::size_t i = 0; i + 1 < nodes.size(); ++i) {
    const double middle = 0.5 * (nodes[i] + nodes[i + 1]);
    while (section_index + 1 < geometry.sections.size() &&
           middle > section_start + geometry.sections[section_index].length) {
      section_start += geometry.sections[section_index++].length;
    }
    const ShaftSection& section = geometry.sections[section_index];
    const auto along = [&](double left, double right, double z) {
      return left + (right - left) * (z - section_start) / section.length;
    };
    ShaftElement element;
    element.length = nodes[i + 1] - nodes[i];
    element.theory = geometry.theory;
    element.rotary_inertia = geometry.rotary_inertia;
    element.gyroscopic = geometry.gyroscopic;
    element.layers.push_back({along(section.outer_diameter_left, section.outer_diameter_right, nodes[i]),
                              along(section.outer_diameter_left, section.outer_diameter_right, nodes[i + 1]),
                              along(section.inner_diameter_left, section.inner_diameter_right, nodes[i]),
                              along(section.inner_diameter_left, section.inner_diameter_right, nodes[i + 1]),
                              section.material, section.shear_factor});
    for (const ShrunkRing& ring : geometry.rings) {
      if (middle < ring.from || middle > ring.to) continue;
      element.layers.push_back({ring.outer_diameter, ring.outer_diameter, ring.inner_diameter,
                                ring.inner_diameter, ring.material, 0.0});
    }
    elements.push_back(std::move(element));
  }
  return elements;
}

/// Orthonormal columns that span what the rows of constraints leave free.
Eigen::MatrixXd nullSpace(const Eigen::MatrixXd& constraints) {
  return orthogonalComplement(constraints.transpose());
}

Eigen::VectorXd frequenciesOf(const Eigen::MatrixXd& stiffness, const Eigen::MatrixXd& mass) {
  return generalizedSymmetricEigenvalues(stiffness, mass).cwiseMax(0.0).cwiseSqrt();
}

}  // namespace

Eigen::VectorXd BeamGrid::displacementShape(double at) const {
  const Place place = placeOf(*this, at);
  Eigen::VectorXd shape = Eigen::VectorXd::Zero(2 * static_cast<Eigen::Index>(z.size()));
  shape.segment<4>(2 * place.element) =
      shapeValues(place.xi, place.length, shear_parameter[place.element]).displacement;
  return shape;
}

Eigen::VectorXd BeamGrid::rotationShape(double at) const {
  const Place place = placeOf(*this, at);
  Eigen::VectorXd shape = Eigen::VectorXd::Zero(2 * static_cast<Eigen::Index>(z.size()));
  shape.segment<4>(2 * place.element) =
      shapeValues(place.xi, place.length, shear_parameter[place.element]).rotation;
  return shape;
}

FlexibleRotor::FlexibleRotor(const RotorGeometry& geometry)
    : FlexibleRotor(elementsOf(geometry), geometry.discs, geometry.damping) {}

FlexibleRotor::FlexibleRotor(const std::vector<ShaftElement>& elements, const std::vector<Disc>& discs,
                             ShaftDamping damping)
    : damping_(std::move(damping)) {
  if (elements.empty()) throw InputError({{"", 0, "elements", "", "at least one element"}});
  assemble(elements, discs);
}

void FlexibleRotor::assemble(const std::vector<ShaftElement>& elements, const std::vector<Disc>& discs) {
  const Eigen::Index size = 2 * (static_cast<Eigen::Index>(elements.size()) + 1);
  mass_ = Eigen::MatrixXd::Zero(size, size);
  stiffness_ = mass_;
  gyroscopic_ = mass_;
  grid_.z.push_back(0.0);
  for (std::size_t i = 0; i < elements.size(); ++i) {
    const ElementMatrices element = elementMatrices(elements[i]);
    const Eigen::Index row = 2 * static_cast<Eigen::Index>(i);
    mass_.block<4, 4>(row, row) += element.mass;
    stiffness_.block<4, 4>(row, row) += element.stiffness;
    gyroscopic_.block<4, 4>(row, row) += element.gyroscopic;
    grid_.z.push_back(grid_.z.back() + elements[i].length);
    grid_.shear_parameter.push_back(element.shear_parameter);
  }
  for (const Disc& disc : discs) {
    const Eigen::VectorXd displacement = grid_.displacementShape(disc.at);
    const Eigen::VectorXd rotation = grid_.rotationShape(disc.at);
    mass_ += disc.mass * displacement * displacement.transpose() +
             disc.transverse_inertia * rotation * rotation.transpose();
    gyroscopic_ += disc.polar_inertia * rotation * rotation.transpose();
  }

  Eigen::VectorXd shift = Eigen::VectorXd::Zero(size);
  Eigen::VectorXd tilt = Eigen::VectorXd::Zero(size);
  for (std::size_t i = 0; i < grid_.z.size(); ++i) {
    shift(2 * i) = 1.0;
    tilt(2 * i) = grid_.z[i];
    tilt(2 * i + 1) = 1.0;
  }
  inertia_.mass = shift.dot(mass_ * shift);
  inertia_.centre_of_gravity_from_left = shift.dot(mass_ * tilt) / inertia_.mass;
  for (double& z : grid_.z) z -= inertia_.centre_of_gravity_from_left;
  tilt -= inertia_.centre_of_gravity_from_left * shift;
  inertia_.transverse = tilt.dot(mass_ * tilt);
  inertia_.polar = tilt.dot(gyroscopic_ * tilt);
}

Eigen::MatrixXd FlexibleRotor::rigidModes() const {
  Eigen::MatrixXd modes = Eigen::MatrixXd::Zero(freedoms(), 2);
  for (std::size_t i = 0; i < grid_.z.size(); ++i) {
    modes(2 * i, 0) = 1.0 / std::sqrt(inertia_.mass);
    modes(2 * i, 1) = grid_.z[i] / std::sqrt(inertia_.transverse);
    modes(2 * i + 1, 1) = 1.0 / std::sqrt(inertia_.transverse);
  }
  return modes;
}

Eigen::MatrixXd FlexibleRotor::damping() const {
  Eigen::MatrixXd result = damping_.mass_proportional * mass_ + damping_.stiffness_proportional * stiffness_;
  if (damping_.modal_ratios.empty()) return result;
  const FreeModes modes = freeModes(*this);
  const Eigen::Index bending = modes.frequency.size() - 2;
  Eigen::VectorXd modal(bending);
  for (Eigen::Index i = 0; i < bending; ++i) {
    modal(i) = 2.0 * modalRatio(damping_, static_cast<int>(i)) * modes.frequency(i + 2);
  }
  const Eigen::MatrixXd weighted = mass_ * modes.vectors.rightCols(bending);
  return result + weighted * modal.asDiagonal() * weighted.transpose();
}

Eigen::MatrixXd FlexibleRotor::stiffnessWith(const std::vector<GroundSpring>& springs) const {
  Eigen::MatrixXd result = stiffness_;
  for (const GroundSpring& spring : springs) {
    const Eigen::VectorXd shape = grid_.displacementShape(spring.z);
    result += spring.stiffness * shape * shape.transpose();
  }
  return result;
}

double modalRatio(const ShaftDamping& damping, int bending_mode) {
  if (damping.modal_ratios.empty()) return 0.0;
  const std::size_t last = damping.modal_ratios.size() - 1;
  return damping.modal_ratios[std::min(static_cast<std::size_t>(bending_mode), last)];
}

FreeModes freeModes(const FlexibleRotor& rotor) {
  const Eigen::MatrixXd rigid = rotor.rigidModes();
  // Only what is M-orthogonal to the rigid motions is left to the solver, so its two zeros, which come out as
  // round-off of the highest frequency, never mix into the modes.
  const Eigen::MatrixXd basis = nullSpace((rotor.mass() * rigid).transpose());
  const Eigen::MatrixXd stiffness = basis.transpose() * rotor.stiffness() * basis;
  const Eigen::MatrixXd mass = basis.transpose() * rotor.mass() * basis;
  const SymmetricEigen eigen = generalizedSymmetricEigen(stiffness, mass);
  FreeModes modes;
  modes.frequency = Eigen::VectorXd::Zero(rotor.freedoms());
  modes.frequency.tail(rotor.freedoms() - 2) = eigen.values.cwiseMax(0.0).cwiseSqrt();
  modes.vectors.resize(rotor.freedoms(), rotor.freedoms());
  modes.vectors << rigid, basis * eigen.vectors;
  return modes;
}

Eigen::VectorXd planarFrequencies(const FlexibleRotor& rotor, const std::vector<GroundSpring>& springs) {
  return frequenciesOf(rotor.stiffnessWith(springs), rotor.mass());
}

Eigen::VectorXd constrainedFrequencies(const FlexibleRotor& rotor, const std::vector<double>& pinned,
                                       const std::vector<double>& clamped) {
  const Eigen::Index count = static_cast<Eigen::Index>(pinned.size() + 2 * clamped.size());
  Eigen::MatrixXd constraints(count, rotor.freedoms());
  Eigen::Index row = 0;
  for (double z : pinned) constraints.row(row++) = rotor.grid().displacementShape(z).transpose();
  for (double z : clamped) {
    constraints.row(row++) = rotor.grid().displacementShape(z).transpose();
    constraints.row(row++) = rotor.grid().rotationShape(z).transpose();
  }
  if (count == 0) return freeModes(rotor).frequency;
  const Eigen::MatrixXd basis = nullSpace(constraints);
  return frequenciesOf(basis.transpose() * rotor.stiffness() * basis,
                       basis.transpose() * rotor.mass() * basis);
}

}  // namespace amb_rotor
