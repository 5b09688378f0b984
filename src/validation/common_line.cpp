#include "amb_rotor/validation/common_line.hpp"

#include <algorithm>
#include <cmath>

#include "amb_rotor/analysis/spectrum.hpp"

namespace amb_rotor {
namespace {

constexpr double grid_hz = 0.1, most_hz = 1000.0;
/// Mean prominence that makes a line, and the least in any run.
constexpr double least_prominence = 12.0, least_in_a_run = 3.0;
/// A run's own background: from and to so many of its resolutions beside a frequency.
constexpr double from_lines = 4.0, to_lines = 16.0;

/// Power over the grid, summed over the channels, each frequency over its neighbours'.
std::vector<double> prominences(const ResidualRows& run, std::size_t count) {
  const std::size_t padded = static_cast<std::size_t>(std::lround(run.sample_rate_hz / grid_hz));
  const std::size_t n = run.channels.empty() ? 0 : std::min(run.channels[0].size(), padded);
  std::vector<double> power(count, 0.0);
  if (n < 16) return power;
  const std::vector<double> window = windowValues(Window::hann, n);
  for (const auto& channel : run.channels) {
    double mean = 0.0;
    for (std::size_t i = 0; i < n; ++i) mean += channel[i] / static_cast<double>(n);
    std::vector<double> row(padded, 0.0);
    for (std::size_t i = 0; i < n; ++i) row[i] = window[i] * (channel[i] - mean);
    SpectrumOptions options;
    options.window = Window::rectangular;
    options.remove_mean = false;
    const Spectrum spectrum = amplitudeSpectrum(row, run.sample_rate_hz, options);
    for (std::size_t k = 0; k < count && k < spectrum.amplitude.size(); ++k)
      power[k] += spectrum.amplitude[k] * spectrum.amplitude[k];
  }
  const double line = run.sample_rate_hz / static_cast<double>(n) / grid_hz;  // in steps of the grid
  const long near = std::lround(from_lines * line), far = std::lround(to_lines * line);
  std::vector<double> out(count, 0.0), beside;
  const long stride = std::max<long>(1, std::lround(0.5 * line));
  for (long k = 0; k < static_cast<long>(count); ++k) {
    beside.clear();
    for (long d = near; d <= far; d += stride)
      for (const long at : {k - d, k + d})
        if (at > 0 && at < static_cast<long>(count)) beside.push_back(power[at]);
    if (beside.empty()) continue;
    const auto middle = beside.begin() + static_cast<long>(beside.size() / 2);
    std::nth_element(beside.begin(), middle, beside.end());
    out[k] = power[k] / std::max(*middle, 1e-300);
  }
  return out;
}

}  // namespace

CommonLine commonLine(const std::vector<ResidualRows>& runs, double least_hz) {
  CommonLine line;
  if (runs.size() < 2) return line;
  double top = most_hz;
  for (const auto& run : runs) top = std::min(top, 0.4 * run.sample_rate_hz);
  const std::size_t count = static_cast<std::size_t>(top / grid_hz);
  std::vector<double> sum(count, 0.0), least(count, 1e300);
  for (const auto& run : runs) {
    const std::vector<double> own = prominences(run, count);
    for (std::size_t k = 0; k < count; ++k) {
      sum[k] += std::log(std::max(own[k], 1e-6)) / static_cast<double>(runs.size());
      least[k] = std::min(least[k], own[k]);
    }
  }
  std::size_t best = 0;
  for (std::size_t k = static_cast<std::size_t>(least_hz / grid_hz); k + 1 < count; ++k)
    if (least[k] > least_in_a_run && (best == 0 || sum[k] > sum[best])) best = k;
  if (best == 0 || sum[best] < std::log(least_prominence)) return line;
  // between the steps: a parabola through the logarithms
  const double a = sum[best - 1], b = sum[best], c = sum[best + 1], bend = a - 2.0 * b + c;
  const double shift = bend < 0.0 ? std::min(std::max(0.5 * (a - c) / bend, -0.5), 0.5) : 0.0;
  line.frequency_hz = grid_hz * (static_cast<double>(best) + shift);
  line.prominence = std::exp(b);
  return line;
}

}  // namespace amb_rotor
