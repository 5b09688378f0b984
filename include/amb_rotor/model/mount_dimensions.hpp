#pragma once
// Stiffness and damping of a compliant mount from what it is made of: how a model file may write `compliant_mount`
// (doc/formats.md). One end of the machine, radial.
//
// Tolerance ring (thesis 3.31, table 3.2), a corrugated strip of spring steel between bearing and housing:
//   K_wave = 4.8 E W (t/p)^3,   k2 = share K_wave
//   E [Pa], W width, t thickness, p wave pitch [m]; share: of the ring against one wave. The thesis prints
//   k2 = (1 - 1/3) K_wave, its table 3.2 has k2 = K_wave/3 (1.97e6 of 5.90e6 N/m): 1/3 is what its numbers follow from.
//   (3.31 as printed has E in kN/mm2 and gives kN/mm.) Valid before a wave is flat; left out: the stiffness of waves that
//   are pressed in beforehand, sliding of the waves.
// O-ring, n cords of diameter d [m] with mean diameter D [m], squeezed by the share c of d when mounted:
//   force on a length l of a cord:  F = E d l (1.25 c^1.5 + 50 c^6)   (empirical, goes by Lindley's name; original not seen)
//   slope dF/d(c d) = E l (1.875 c^0.5 + 300 c^5); radial displacement u presses the cord at the angle f by u cos f:
//   k2 = n pi D/2  E (1.875 c^0.5 + 300 c^5)
//   E: dynamic modulus of the elastomer [Pa] in the band of use. Valid: c to 0.4, displacements far below c d. Left out:
//   stiffening with amplitude and by the groove's walls.
// Damping of either, Kelvin-Voigt: the loss factor eta [-] at the frequency f [Hz] that is stated, d2 = eta k2/(2 pi f).
// A loss that is steady over frequency is the effect fractional_mount.
#include "amb_rotor/model/yaml_document.hpp"

namespace amb_rotor {

struct ToleranceRing {
  double youngs_modulus_Pa, width_m, thickness_m, wave_pitch_m, share;
  double waveStiffness() const;  ///< [N/m]
  double stiffness() const { return share * waveStiffness(); }
};

struct ORing {
  double youngs_modulus_Pa, mean_diameter_m, cord_diameter_m, squeeze, count;
  double stiffness() const;  ///< [N/m]
};

/// d2 [N s/m] of a loss factor at a frequency [Hz].
double kelvinVoigtDamping(double stiffness, double loss_factor, double frequency_hz);

/// Whether an entry of `effects:` describes its mount by dimensions.
bool hasMountDimensions(YamlMap& entry);
/// Stiffness, damping, mass of such an entry, in the order of compliant_mount's schema. Faults go to its list.
std::vector<double> readMountDimensions(YamlMap& entry);

}  // namespace amb_rotor
