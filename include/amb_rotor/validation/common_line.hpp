#pragma once
// A line of fixed frequency that the residuals of all runs share, whatever the shaft does: a force that
// repeats in time.
#include <vector>

namespace amb_rotor {

/// The residual of a run: rows of channels over their noise, equally spaced.
struct ResidualRows {
  double sample_rate_hz = 0.0;
  std::vector<std::vector<double>> channels;
};

struct CommonLine {
  double frequency_hz = 0.0;  ///< 0: none
  double prominence = 0.0;  ///< power over that of the neighbouring frequencies, geometric mean over the runs
};

/// Looks from `least_hz` up to 1 kHz (or 0.4 of the sample rate). A line counts where it stands out in each
/// run.
CommonLine commonLine(const std::vector<ResidualRows>& runs, double least_hz = 4.0);

}  // namespace amb_rotor
