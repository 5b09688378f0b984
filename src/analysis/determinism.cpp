#include "amb_rotor/analysis/determinism.hpp"

#include <algorithm>
#include <cmath>
#include <complex>
#include <limits>

#include "argument.hpp"

namespace amb_rotor {

double zeroOneTest(const std::vector<double>& series) {
  constexpr double none = std::numeric_limits<double>::quiet_NaN();
  const std::size_t n = series.size(), cut = n / 10;
  if (n < 30) return none;
  double mean = 0.0, variance = 0.0;
  for (double value : series) mean += value / static_cast<double>(n);
  for (double value : series) variance += (value - mean) * (value - mean) / static_cast<double>(n);
  if (!(variance > 0.0)) return none;

  constexpr int angles = 100;
  std::vector<double> correlations;
  for (int a = 0; a < angles; ++a) {
    // Golden-ratio sequence in (pi/5, 4 pi/5): evenly spread, hits no simple resonance twice, repeatable.
    const double place = std::fmod(0.5 + a * 0.6180339887498949, 1.0);
    const double c = M_PI * (0.2 + 0.6 * place);
    std::vector<std::complex<double>> path(n + 1, 0.0);
    for (std::size_t j = 0; j < n; ++j) {
      path[j + 1] = path[j] + (series[j] - mean) * std::polar(1.0, static_cast<double>(j + 1) * c);
    }
    double mean_d = 0.0;
    std::vector<double> displacement(cut);
    for (std::size_t k = 1; k <= cut; ++k) {
      double sum = 0.0;
      for (std::size_t j = 0; j + cut <= n; ++j) sum += std::norm(path[j + k] - path[j]);
      displacement[k - 1] = sum / static_cast<double>(n - cut + 1);
      mean_d += displacement[k - 1] / static_cast<double>(cut);
    }
    const double mean_k = 0.5 * (static_cast<double>(cut) + 1.0);
    double cross = 0.0, square_d = 0.0, square_k = 0.0;
    for (std::size_t k = 1; k <= cut; ++k) {
      const double dk = static_cast<double>(k) - mean_k, dd = displacement[k - 1] - mean_d;
      cross += dk * dd;
      square_d += dd * dd;
      square_k += dk * dk;
    }
    correlations.push_back(square_d > 0.0 ? cross / std::sqrt(square_d * square_k) : 0.0);
  }
  std::nth_element(correlations.begin(), correlations.begin() + angles / 2, correlations.end());
  return correlations[angles / 2];
}

double forecastRatio(const Eigen::MatrixXd& points, int depth) {
  requireArgument(depth >= 1, "depth", depth, "must be at least 1");
  const Eigen::Index n = points.cols() - depth;  // states with a successor
  if (n < 10) return std::numeric_limits<double>::quiet_NaN();
  double error = 0.0;
  for (Eigen::Index i = 0; i < n; ++i) {
    double best = std::numeric_limits<double>::infinity();
    Eigen::Index neighbour = i;
    for (Eigen::Index j = 0; j < n; ++j) {
      if (j == i) continue;
      double square = 0.0;
      for (Eigen::Index k = 0; k < depth; ++k)
        square += (points.col(i + k) - points.col(j + k)).squaredNorm();
      if (square < best) {
        best = square;
        neighbour = j;
      }
    }
    error += (points.col(i + depth) - points.col(neighbour + depth)).squaredNorm();
  }
  error /= static_cast<double>(n);
  // Two independent points differ by twice the variance in the mean.
  const Eigen::VectorXd mean = points.rowwise().mean();
  const double spread = 2.0 * (points.colwise() - mean).squaredNorm() / static_cast<double>(points.cols());
  return spread > 0.0 ? std::sqrt(error / spread) : std::numeric_limits<double>::quiet_NaN();
}

}  // namespace amb_rotor
