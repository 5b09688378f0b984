#pragma once
// A model that has been fitted beside the measurements of all runs: what compare() and a diagnosis show.
#include <vector>

#include "amb_rotor/validation/compare.hpp"
#include "amb_rotor/validation/fit.hpp"

namespace amb_rotor {

/// @param fitted   coordinates and covariance
/// @param local    what the fit has left of the runs' own unknowns
/// @param known    of each recording what is predicted already; no prediction, or none at all: it is evaluated
Comparison sideBySide(const std::vector<Recording>& recordings, const FitSpace& space, double offset_std_m, const FitResult& fitted,
                      std::vector<LocalState> local, const std::vector<RunResult>& known = {});

}  // namespace amb_rotor
