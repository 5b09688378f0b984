#pragma once
// A step of a fit that stays within lengths to which its linear model is trusted.
#include <Eigen/Core>

namespace amb_rotor {

/// The step s of (h + w D^-2) s = g with |s_k| <= D_k, w the least that does it (then s touches a D_k, from a step that reaches beyond
/// by 1e-3 of it at most); 0 where the plain step stays within. Along what hardly shows (two numbers of a friction law where all slips
/// are fast) a whole step is of no size that counts, and the share of it that is trusted would be next to none of the rest.
/// @param h        normal matrix, symmetric and positive definite
/// @param g        gradient, of its size
/// @param lengths  D, above 0; infinite: no bound
/// @return not finite where the plain step is not
/// Source: Levenberg's scaling by trusted lengths (More, The Levenberg-Marquardt algorithm, 1978).
Eigen::VectorXd trustedStep(const Eigen::MatrixXd& h, const Eigen::VectorXd& g, const Eigen::VectorXd& lengths);

}  // namespace amb_rotor
