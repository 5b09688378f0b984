#pragma once
// Starts of a bending mode with shapes that the runs without contact ask for, beside those of a uniform beam: a rotor with a disc,
// or sensors on a stub, has its nodes elsewhere, and a fit that begins with the wrong sign at one plane ends beside the right one.
//
// To first order the mode's motion is c_ij R_ij, summed over sensors i and inputs j (the magnetic bearings, the unbalance), where R_ij
// is what a small product of the two shapes changes and c_ij = s_i p_j. With the squares S of these six directions and their
// products a with the residual, freed of the nuisance (amb_rotor/validation/start_screen.hpp), s and p are those that
// maximise  a'c - c'S c/2,  found by solving for one while the other stands. Sensors and magnets are taken to move about as much;
// at an auxiliary bearing the mean of its neighbours stands. Left out: that the mode meets the displacement stiffness.
#include <optional>

#include "candidates.hpp"

namespace amb_rotor {

/// The rank-one matrix s p' [2 x 3], row by row in c, that maximises a'c - c'S c/2 nearly.
Eigen::Matrix<double, 2, 3> likeliestProducts(const Eigen::MatrixXd& squares, const Eigen::VectorXd& along);

/// Whether an effect is a bending mode.
bool hasShapes(const std::string& effect);

/// Runs without contact tell the products of the shapes at the sensors with those at the magnetic bearings and at the unbalance, and little
/// of how a product is shared. The mode of the same products whose shapes come nearest to one curve a + b z + c z^2 along the shaft, with
/// those at the auxiliary bearings on it; none where no factor of the same sign does.
std::optional<EffectSetting> smoothMode(const Model& belief, const EffectSetting& mode);

/// Appends to the starts of a bending mode as many with the shapes seen at their frequencies; other effects' stay as they are.
void addSeenShapes(const Model& belief, const Eigen::VectorXd& nuisance, const References& references, std::vector<Settings>& starts);

}  // namespace amb_rotor
