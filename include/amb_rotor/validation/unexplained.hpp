#pragma once
// When no effect of the catalogue explains a residual: which quantities does the missing force depend on, and in what
// shape. A hypothesis, not a finding.
#include "amb_rotor/validation/diagnosis.hpp"
#include "amb_rotor/validation/fit.hpp"

namespace amb_rotor {

Unexplained searchUnexplained(const std::vector<Recording>& recordings, const FitSpace& space, const Eigen::VectorXd& x,
                              const std::vector<LocalState>& local, double offset_std_m);

}  // namespace amb_rotor
