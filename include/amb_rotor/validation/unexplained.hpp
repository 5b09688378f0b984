#pragma once
// When no effect of the catalogue explains a residual: which quantities does the missing force depend on, and in what
// shape. A hypothesis, not a finding.
#include <memory>

#include "amb_rotor/validation/diagnosis.hpp"
#include "amb_rotor/validation/fit.hpp"

namespace amb_rotor {

/// How far a search goes: `plain` looks for one term alone, or a few of one set of quantities, that explain all and that
/// no effect of the catalogue has, and leaves the terms empty where there are none; `foreseen` fits it only where the forces
/// along the measured path tell of one set of quantities.
enum class LawEffort { foreseen, plain, whole };

/// A search for a law beside a model as it stands. What one question has found is not sought again for the next.
class UnexplainedSearch {
 public:
  /// @param recordings  outlive the search
  /// @param x, local    the model as it stands, in `space`
  UnexplainedSearch(const std::vector<Recording>& recordings, const FitSpace& space, const Eigen::VectorXd& x,
                    const std::vector<LocalState>& local, double offset_std_m);
  UnexplainedSearch(UnexplainedSearch&&) noexcept;
  UnexplainedSearch& operator=(UnexplainedSearch&&) noexcept;
  ~UnexplainedSearch();
  Unexplained law(LawEffort effort = LawEffort::whole);

 private:
  struct Parts;
  std::unique_ptr<Parts> parts_;  ///< null: no run without contact to look at
};

}  // namespace amb_rotor
