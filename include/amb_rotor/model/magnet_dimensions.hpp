#pragma once
// Current and displacement stiffness of a magnetic bearing from what its magnets are made of: how a model file may write
// `amb` (doc/formats.md). One magnet is a horseshoe: two poles, its windings in series, the gap crossed twice (thesis
// figure 3.8); an axis has two of them that face each other.
//
//   one magnet   F(i, g) = N^2 mu0 A i^2/(4 g^2) cos f,   B(i, g) = mu0 N i/(2 g)                        (3.16)
//   an axis      F = F(i0 + i, s0 - x) - F(i0 - i, s0 + x)                                               (3.18)
//   its slopes at the centre:  Ki = N^2 mu0 A i0/s0^2 cos f,  Ks = N^2 mu0 A i0^2/s0^3 cos f = Ki i0/s0  (3.20)
//
// N windings of a magnet, A [m2] area of one pole, f [rad] force angle: of a pole's axis against the axis of the force
// (22.5 degrees in an eight-pole bearing; table 4.1), i0 [A] bias, s0 [m] air gap, B [T] flux density in the gap. Each
// pole pulls along its own axis by B^2 A/(2 mu0); along the axis of the force counts cos f of it. The thesis's (3.16) to
// (3.20) are without cos f. Where x is not small against s0, (3.18) is the effect magnetic_nonlinearity.
// Source: thesis 3.16 to 3.20; Schweitzer and Maslen (eds.), Magnetic Bearings, Springer 2009.
// Valid far below saturation. Left out: reluctance of the iron, leakage and fringing (each of them lowers the force), the
// gap's change by cos f x under a pole that stands at the force angle, coupling of the axes.
#include "amb_rotor/model/yaml_document.hpp"

namespace amb_rotor {

struct MagnetDimensions {
  double windings, pole_area_m2, force_angle_rad;

  double pull(double current, double gap) const;         ///< of one magnet, along the axis [N]
  double fluxDensity(double current, double gap) const;  ///< in its gap [T]
  /// Of an axis, control current i and displacement x [N].
  double force(double bias, double air_gap, double current, double position) const;
  double currentStiffness(double bias, double air_gap) const;       ///< Ki [N/A]
  double displacementStiffness(double bias, double air_gap) const;  ///< Ks [N/m]
};

/// The block `magnet` of `amb`. Faults go to its list.
MagnetDimensions readMagnetDimensions(YamlMap& amb);

}  // namespace amb_rotor
