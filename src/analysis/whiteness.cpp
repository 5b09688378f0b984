#include "amb_rotor/analysis/whiteness.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <random>
#include <unsupported/Eigen/SpecialFunctions>

#include "argument.hpp"

namespace amb_rotor {

std::vector<double> autocorrelation(const std::vector<double>& values, std::size_t max_lag) {
  const std::size_t n = values.size();
  if (n < 2 || max_lag >= n) return {};
  double mean = 0.0;
  for (double value : values) {
    requireArgument(std::isfinite(value), "values", value, "must be finite");
    mean += value / static_cast<double>(n);
  }
  double scale = 0.0, largest = 0.0;
  for (double value : values) {
    scale += (value - mean) * (value - mean);
    largest = std::max(largest, std::fabs(value));
  }
  // A constant record differs from its computed mean by round-off only.
  const double round_off = 1e-14 * largest;
  if (scale <= static_cast<double>(n) * round_off * round_off) return {};
  std::vector<double> result(max_lag + 1, 0.0);
  for (std::size_t lag = 0; lag <= max_lag; ++lag) {
    double sum = 0.0;
    for (std::size_t i = 0; i + lag < n; ++i) sum += (values[i] - mean) * (values[i + lag] - mean);
    result[lag] = sum / scale;
  }
  return result;
}

double chiSquaredExceedance(double value, double degrees_of_freedom) {
  requireArgument(degrees_of_freedom > 0.0, "degrees_of_freedom", degrees_of_freedom, "must be above 0");
  if (!(value > 0.0)) return 1.0;
  return Eigen::numext::igammac(0.5 * degrees_of_freedom, 0.5 * value);
}

LjungBox ljungBoxTest(const std::vector<double>& values, std::size_t lags, std::size_t fitted_parameters) {
  LjungBox test;
  if (lags <= fitted_parameters) return test;
  const std::vector<double> r = autocorrelation(values, lags);
  if (r.empty()) return test;
  const double n = static_cast<double>(values.size());
  double sum = 0.0;
  for (std::size_t k = 1; k <= lags; ++k) sum += r[k] * r[k] / (n - static_cast<double>(k));
  test.valid = true;
  test.statistic = n * (n + 2.0) * sum;
  test.degrees_of_freedom = lags - fitted_parameters;
  test.p_value = chiSquaredExceedance(test.statistic, static_cast<double>(test.degrees_of_freedom));
  return test;
}

BootstrapResult blockBootstrap(const std::vector<std::vector<double>>& blocks,
                               const std::function<double(const std::vector<double>&)>& statistic,
                               const BootstrapOptions& options) {
  requireArgument(blocks.size() >= 2, "blocks", static_cast<double>(blocks.size()), "must be at least 2");
  requireArgument(options.replicates >= 1, "replicates", static_cast<double>(options.replicates),
                  "must be at least 1");
  requireArgument(options.confidence > 0.0 && options.confidence < 1.0, "confidence", options.confidence,
                  "must be in (0, 1)");
  std::vector<double> joined;
  for (const auto& block : blocks) joined.insert(joined.end(), block.begin(), block.end());
  BootstrapResult result;
  result.value = statistic(joined);

  // mt19937_64 is the same everywhere, the standard's distributions are not: the index is drawn by hand
  // (modulo; its bias, blocks / 2^64, is nothing).
  std::mt19937_64 generator(options.seed);
  std::vector<double> replicates;
  replicates.reserve(options.replicates);
  for (std::size_t i = 0; i < options.replicates; ++i) {
    joined.clear();
    for (std::size_t b = 0; b < blocks.size(); ++b) {
      const auto& block = blocks[generator() % blocks.size()];
      joined.insert(joined.end(), block.begin(), block.end());
    }
    replicates.push_back(statistic(joined));
  }
  const double count = static_cast<double>(replicates.size());
  result.mean = std::accumulate(replicates.begin(), replicates.end(), 0.0) / count;
  double squares = 0.0;
  for (double value : replicates) squares += (value - result.mean) * (value - result.mean);
  result.standard_error = count > 1.0 ? std::sqrt(squares / (count - 1.0)) : 0.0;
  std::sort(replicates.begin(), replicates.end());
  const auto quantile = [&replicates, count](double share) {
    const double place = share * (count - 1.0);
    const auto below = static_cast<std::size_t>(place);
    const std::size_t above = std::min(below + 1, replicates.size() - 1);
    return replicates[below] + (place - static_cast<double>(below)) * (replicates[above] - replicates[below]);
  };
  result.low = quantile(0.5 * (1.0 - options.confidence));
  result.high = quantile(0.5 * (1.0 + options.confidence));
  return result;
}

std::vector<std::vector<double>> turnBlocks(const std::vector<double>& angle,
                                            const std::vector<double>& values) {
  requireSameLength(angle, values, "values");
  std::vector<std::vector<double>> blocks;
  if (angle.size() < 2) return blocks;
  // The first turn began before the record, unless its first sample is within a step of the turn's start.
  const double step = (angle.back() - angle.front()) / static_cast<double>(angle.size() - 1);
  bool whole = angle.front() - 2.0 * M_PI * std::floor(angle.front() / (2.0 * M_PI)) < step;
  long turn = 0;
  std::vector<double> block;
  for (std::size_t i = 0; i < angle.size(); ++i) {
    const long now = std::lround(std::floor(angle[i] / (2.0 * M_PI)));
    if (i > 0 && now != turn) {
      if (whole) blocks.push_back(block);
      block.clear();
      whole = true;
    }
    turn = now;
    block.push_back(values[i]);
  }
  return blocks;
}

}  // namespace amb_rotor
