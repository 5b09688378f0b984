#pragma once
// Is a residual white? Autocorrelation, Ljung-Box test, block bootstrap over turns.
//
// Autocorrelation at lag k: r_k = sum_(t) (u_t - m)(u_(t+k) - m) / sum (u_t - m)^2, m the mean (biased form,
// |r_k| <= 1).
// Ljung-Box: Q = n (n + 2) sum_(k=1..h) r_k^2 / (n - k); for white u chi-squared with h - p degrees of
// freedom, p the parameters fitted to the same record. p_value = P(chi2 > Q): small means not white. Block
// bootstrap: whole blocks (turns of the shaft) drawn with replacement, the statistic of each draw; what
// repeats with the turn stays inside a block, so that its correlation does not shrink the interval falsely.
//
// Units: any. Sources: Ljung and Box, Biometrika 65 (1978); Kuensch, Ann. Stat. 17 (1989).
// Valid: n well above h (n > 5 h); blocks nearly independent of one another.
// Left out: heteroscedastic residuals (Q rejects too often there).
#include <cstddef>
#include <cstdint>
#include <functional>
#include <vector>

namespace amb_rotor {

/// r_0 .. r_max_lag; empty for a constant or too short record.
/// @throw InputError: a value that is not finite.
std::vector<double> autocorrelation(const std::vector<double>& values, std::size_t max_lag);

struct LjungBox {
  bool valid = false;  ///< false: constant, too short or no degree of freedom left
  double statistic = 0.0;
  std::size_t degrees_of_freedom = 0;
  double p_value = 1.0;
};

LjungBox ljungBoxTest(const std::vector<double>& values, std::size_t lags, std::size_t fitted_parameters = 0);

/// P(chi-squared with the degrees of freedom > value).
double chiSquaredExceedance(double value, double degrees_of_freedom);

struct BootstrapOptions {
  std::size_t replicates = 1000;
  double confidence = 0.95;  ///< of the interval, in (0, 1)
  std::uint64_t seed = 1;
};

struct BootstrapResult {
  double value = 0.0;  ///< statistic of the data as they are
  double mean = 0.0;   ///< of the replicates
  double standard_error = 0.0;
  double low = 0.0;  ///< percentile interval
  double high = 0.0;
};

/// @param blocks values of each block (turn). @param statistic of all values of a draw, joined.
/// The draw is the same on every machine for one seed.
/// @throw InputError: fewer than two blocks, no replicates, confidence outside (0, 1).
BootstrapResult blockBootstrap(const std::vector<std::vector<double>>& blocks,
                               const std::function<double(const std::vector<double>&)>& statistic,
                               const BootstrapOptions& options = {});

/// Values cut into whole turns of the shaft; the incomplete turns at the ends are left out.
/// @throw InputError: lengths differ.
std::vector<std::vector<double>> turnBlocks(const std::vector<double>& angle,
                                            const std::vector<double>& values);

}  // namespace amb_rotor
