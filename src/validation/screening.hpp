#pragma once
// One step of a diagnosis: every candidate beside the model as it stands, fitted and judged.
#include <functional>
#include <string>
#include <vector>

#include "candidates.hpp"

namespace amb_rotor {

/// What candidates are beside.
struct Standing {
  const Settings& adopted;
  const References& references;
  const CandidateErrors& errors;  ///< on the runs to validate
};

struct Screening {
  std::vector<Trial> trials;    ///< the most evidence first
  bool contact_waited = false;  ///< candidates through contact were not looked at, for one beyond doubt without
};

/// @param names             in the order in which they are looked at; what comes late and can no longer lead costs less
/// @param contact_may_wait  whether candidates through contact wait for one that is beyond doubt without
/// @param progress          a share of the step, and what is looked at
Screening screen(const Candidates& candidates, const std::vector<std::string>& names, const Standing& standing,
                 bool contact_may_wait, const std::function<void(double, const std::string&)>& progress);

}  // namespace amb_rotor
