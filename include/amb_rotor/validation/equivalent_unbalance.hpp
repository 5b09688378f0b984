#pragma once
// Of all pairs of the rig's own unbalance n (in its plane z_n) and a second one U in a plane z that a rigid rotor cannot
// tell apart, the one that the owner's belief about n favours.
//
// Runs see the static sum S = n + U and the couple C = n z_n + U z, four numbers; unknown are five:
//   U(z) = (C - S z_n)/(z - z_n),   n(z) = S - U(z).
// Along this line a fit creeps, for the data bend it sharply and only the prior of n pulls: here it is walked in one go.
// Frame: complex numbers in the rotor, phases as in excitation/unbalance.hpp [kg m, rad, m].
// Left out: that a rotor that bends tells z itself; more unbalances of the rig's own than one.
#include <Eigen/Core>
#include <complex>
#include <vector>

#include "amb_rotor/validation/coordinates.hpp"

namespace amb_rotor {

struct BelievedUnbalance {
  double plane_z_m = 0.0;
  double moment_kg_m = 0.0, moment_std_kg_m = 0.0;
  double phase_rad = 0.0, phase_std_rad = 0.0;
};

struct UnbalancePair {
  std::complex<double> own, second;
  double second_z_m = 0.0;
};

/// @param found     as fitted
/// @param reach_m   planes looked at: from -reach to reach
/// @return the pair with the same S and C whose own unbalance is nearest to the belief; `found` where it has no couple
UnbalancePair likeliestUnbalance(const UnbalancePair& found, const BelievedUnbalance& believed, double reach_m);

/// Moves `couple_unbalance` among the effects, and the nuisance of the rig's one unbalance, to the likeliest pair. False:
/// neither is fitted here, or they stand there already.
bool moveToLikeliestUnbalance(const Model& belief, const FitSpace& space, std::vector<EffectSetting>& effects,
                              Eigen::VectorXd& nuisance);

/// One deviation of the belief about the rig's own unbalance along the line, as a change of the fit's coordinates; 0: no such pair.
Eigen::VectorXd deviationAlongEquivalents(const Model& belief, const FitSpace& space, const Eigen::VectorXd& x);

/// Widens a fit's covariance to what the belief about the rig's own unbalance leaves open along the line. Derivatives that are taken
/// by differences lend a line that is exactly flat a curvature of their own, beside which that belief is little. Beside a bending mode,
/// whose line is not flat, nothing is widened.
/// @param x  of `space`
void widenAlongEquivalents(const Model& belief, const FitSpace& space, const Eigen::VectorXd& x, Eigen::MatrixXd& covariance);

}  // namespace amb_rotor
