#pragma once
// When no effect of the catalogue explains a residual: which quantities does the missing force depend on, and in what
// shape. A hypothesis, not a finding.
#include "amb_rotor/validation/diagnosis.hpp"
#include "amb_rotor/validation/fit.hpp"

namespace amb_rotor {

/// How far a search goes: `plain` looks for one term alone, or a few of one set of quantities, that explain all and that
/// no effect of the catalogue has, and leaves the terms empty where there are none.
enum class LawEffort { plain, whole };

Unexplained searchUnexplained(const std::vector<Recording>& recordings, const FitSpace& space, const Eigen::VectorXd& x,
                              const std::vector<LocalState>& local, double offset_std_m,
                              LawEffort effort = LawEffort::whole);

}  // namespace amb_rotor
