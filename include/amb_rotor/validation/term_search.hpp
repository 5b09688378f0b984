#pragma once
// Which few terms of a library explain a residual best, out of the normal equations of all of them: every
// subset of up to three is looked at, so that no first choice stands in the way of a better pair.
#include <Eigen/Core>
#include <vector>

namespace amb_rotor {

struct TermChoice {
  std::vector<int> terms;  ///< coordinates; empty: none is worth its place
  double drop = 0.0;       ///< of chi2, beyond what the base alone takes
};

/// @param h, g        normal equations of all coordinates, priors included; chi2 falls by g_S' h_S^-1 g_S
/// @param base        coordinates that are always there
/// @param library     coordinates to choose from
/// @param quantities  of each of the library: how many quantities a subset depends on is their union (as
/// bits)
/// @param least       drop of chi2 that each further term must bring
/// @param most        size of the largest subset, up to 3
/// @param tie         drop of chi2 within which subsets count as equal: the one of fewer quantities is taken
TermChoice bestTerms(const Eigen::MatrixXd& h, const Eigen::VectorXd& g, const std::vector<int>& base,
                     const std::vector<int>& library, const std::vector<unsigned>& quantities, double least,
                     double tie, int most = 3);

/// The subsets of one size, 1 to 3, that drop most, best first, `count` at most. Parameters as above.
std::vector<TermChoice> bestSubsets(const Eigen::MatrixXd& h, const Eigen::VectorXd& g, const std::vector<int>& base,
                                    const std::vector<int>& library, int size, int count);

/// Solves for the base and the chosen terms: coordinates in the order base, terms.
Eigen::VectorXd solveFor(const Eigen::MatrixXd& h, const Eigen::VectorXd& g, const std::vector<int>& chosen);

}  // namespace amb_rotor
