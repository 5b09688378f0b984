#pragma once
// Two numbers that tell regular, chaotic and random series of states apart.
//
// 0-1 test: p_n + i q_n = sum_(j<n) (u_j - mean) exp(i j c); its mean square displacement grows linearly for
// chaos (and
//   noise) and stays bounded for regular motion. K is the correlation of the displacement with n, the
//   median over 100 values of c: about 0 regular, about 1 chaotic or random.
// Forecast ratio: error of predicting each state's successor by the successor of its nearest neighbour, over
//   the error of predicting it by a random other state: about 0 deterministic, about 1 random.
// Together: K near 1 with a small ratio is deterministic chaos; K near 1 with a ratio near 1 is noise.
//
// Units: none. Valid: at least some 120 states, better 300 to 1000; slow drift removed.
// Sources: Gottwald and Melbourne, SIAM J. Appl. Dyn. Syst. 8 (2009) 129; Farmer and Sidorowich, PRL 59
// (1987). Left out: chaos of dimension so high that the points do not come near one another looks random.
#include <Eigen/Core>
#include <vector>

namespace amb_rotor {

/// K of the 0-1 test, NaN for fewer than 30 values or a constant series.
double zeroOneTest(const std::vector<double>& series);

/// Forecast ratio of points (one a column), NaN for fewer than 10 points or equal points.
/// @param depth consecutive points that make a state when neighbours are sought: above 1 where a point alone
/// is a projection of the state. The error is that of the next point alone.
/// @throw InputError: depth below 1.
double forecastRatio(const Eigen::MatrixXd& points, int depth = 1);

}  // namespace amb_rotor
