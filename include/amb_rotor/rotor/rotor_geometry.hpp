#pragma once
// Geometry of a rotor: what a person writes down (rotor.yaml), before it becomes matrices.
//
// A shaft is a row of load-carrying sections from the left end to the right one, without gaps. Rings are
// shrunk onto it (laminations, sleeves, thrust discs); with a modulus of 0 they carry mass only. Discs are
// lumped: mass and inertias at one point. Positions are measured from the left end, in metres; the rotor
// itself (flexible_rotor.hpp) measures from the centre of gravity.
//
// File format amb-rotor-geometry/1 (units are in the keys; * marks what may be left out):
//   format, name*, theory (euler_bernoulli | timoshenko), max_element_length_m
//   materials: {<name>: {density_kg_per_m3, youngs_modulus_Pa, poisson_ratio}}
//   sections:  [{length_m, outer_diameter_m, outer_diameter_end_m*, inner_diameter_m*, inner_diameter_end_m*,
//               material, shear_factor*}]
//   rings*:    [{from_m, to_m, inner_diameter_m, outer_diameter_m, material}]
//   discs*:    [{at_m, mass_kg, polar_inertia_kg_m2, transverse_inertia_kg_m2}]
//   damping*:  {mass_proportional_per_s*, stiffness_proportional_s*, modal_ratios*: [..]}
// Valid: bodies of revolution; sections that carry the load over their whole length.
// Source: thesis 3.1.2 (a shaft of beam elements, proportional damping) and table 4.1; the format is this project's.
// Left out: keyways and cracks (shaft_crack), shrink fits that slip, balance holes.
// Errors: loadRotorGeometry and validate throw InputError with all faults at once; unknown, missing and
// duplicate keys are faults.

#include <string>
#include <vector>

#include "amb_rotor/common/error.hpp"
#include "amb_rotor/rotor/shaft_element.hpp"

namespace amb_rotor {

struct ShaftSection {
  double length = 0.0;                ///< [m]
  double outer_diameter_left = 0.0;   ///< [m]
  double outer_diameter_right = 0.0;  ///< [m]; not as on the left: a cone
  double inner_diameter_left = 0.0;   ///< [m]
  double inner_diameter_right = 0.0;  ///< [m]
  Material material;
  double shear_factor = 0.0;  ///< [-]; 0: Hutchinson's
};

struct ShrunkRing {
  double from = 0.0;            ///< [m] from the left end
  double to = 0.0;              ///< [m] from the left end
  double inner_diameter = 0.0;  ///< [m], not below the shaft's outer one
  double outer_diameter = 0.0;  ///< [m]
  Material material;
};

struct Disc {
  double at = 0.0;                  ///< [m] from the left end
  double mass = 0.0;                ///< [kg]
  double polar_inertia = 0.0;       ///< [kg m2]
  double transverse_inertia = 0.0;  ///< [kg m2], about the disc's own diameter
};

/// Damping of the shaft in the inertial frame: D = a M + b K + sum of 2 zeta w in each bending mode.
struct ShaftDamping {
  double mass_proportional = 0.0;       ///< a [1/s]; acts on the rigid motions too
  double stiffness_proportional = 0.0;  ///< b [s]
  std::vector<double> modal_ratios;  ///< zeta of bending modes 1, 2, ..; the last holds for all higher ones
};

struct RotorGeometry {
  std::string name;
  BeamTheory theory = BeamTheory::timoshenko;
  bool rotary_inertia = true;       ///< of the shaft; false for the thesis's 3.13
  bool gyroscopic = true;           ///< of the shaft; discs and rings as given
  double max_element_length = 0.0;  ///< [m]; sections are split to at most this
  std::vector<ShaftSection> sections;
  std::vector<ShrunkRing> rings;
  std::vector<Disc> discs;
  ShaftDamping damping;

  double length() const;
};

/// All physical faults; file and lines are left empty.
std::vector<Fault> faultsOf(const RotorGeometry& geometry);

RotorGeometry loadRotorGeometry(const std::string& path);

}  // namespace amb_rotor
