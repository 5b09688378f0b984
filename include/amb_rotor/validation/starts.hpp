#pragma once
// Where the fit of an effect begins. Effects that vanish at a neutral value start there; the others at several plausible
// places, of which the fit keeps the best.
#include <vector>

#include "amb_rotor/model/effect_schema.hpp"
#include "amb_rotor/validation/recording.hpp"

namespace amb_rotor {

/// What a model without an effect has taken for the contact. 0: not known.
struct SeenContact {
  double stiffness_N_per_m = 0.0;     ///< far below the believed one, a mount starts in series with it
  double friction_coefficient = 0.0;  ///< far below the believed one, a friction that falls with the slip starts with it at speed
};

/// Starting parameter sets of an effect for a rig, each in the order of the schema. Empty: it cannot be in this rig
/// (reason: why).
std::vector<std::vector<double>> startingValues(const std::string& effect, const Model& belief,
                                                const std::vector<Recording>& recordings, std::string& reason,
                                                const SeenContact& seen = {});

/// Starting parameter sets of an effect of one's own: where it does nothing (its sizes then follow from the residual in
/// the first step of a fit), at several places of the range of each number that has no such value (a width, an exponent, a
/// phase), and at what its file calls typical, with both signs where the limits allow them.
std::vector<std::vector<double>> startsOfOwnEffect(const EffectSchema& schema);

/// The shape of a rotor's first bending mode, were it a uniform beam a little longer than between its auxiliary bearings: 1.4 at
/// the ends, below 0 in the middle; at the planes of shaft_flexibility, in the order of its parameters.
std::vector<double> shapesOfBeam(const Model& belief);

/// Whether the number of the rig that stands in for an effect (EffectSchema::mimic) tells its size, from which no small steps lead
/// there: a stator that moves, of mass M, lets a rotor of mass m move against it, far above its resonance, as if that had the mass
/// mu = m M/(m + M).
bool isSizedByWhatStoodIn(const std::string& effect);

/// Such an effect at that size.
/// @param believed, stood  that number as believed, and as a model without the effect has taken it, which is less
void sizeByWhatStoodIn(EffectSetting& effect, double believed, double stood);

/// Whether an effect's starts lie side by side along one parameter, rising, as in a scan.
bool startsAreAScan(const std::string& effect);

/// The share of an effect's size that a start can be scaled to, next to the one wanted: a bending mode's shape, by which a
/// force goes in and its motion comes out, is near 1, so that its share lies between 0.01 and 4.
double usableShare(const std::string& effect, double share);

/// An effect of a share a of its size, within its limits: amplitudes by a; what is neutral at its upper limit (a stator's
/// mass) by 1/a, a knee of the iron, whose effect goes by its fourth power, by a^(-1/4); the shape of a bending mode by the
/// root of the usable share.
void scaleStart(EffectSetting& effect, double share);

/// Narrows a parameter's range to what is physical on this rig, e.g. a mount that is lighter than the rotor. A soft or
/// stuck mount would otherwise stand wherever a window through contact likes it best.
void narrowToRig(const std::string& effect, const std::string& parameter, const Model& belief, double& lower,
                 double& upper);

/// A change of a parameter that counts: its typical value; of spin_drag's decay and torque what turns the shaft (at 400 rad/s)
/// back by 1 rad in the first second. Differences are taken over shares of it (validation/fit.hpp).
double scaleOnRig(const std::string& effect, const ParameterSchema& parameter, const Model& belief);

}  // namespace amb_rotor
