#pragma once
// What a diagnosis proposes to do about its confounded pairs.
#include "candidates.hpp"

namespace amb_rotor {

/// Fills the experiments that part the effect chosen from those confounded with it, and the candidates'
/// sentences. Of a model that breaks a rule of models as fitted, which nobody can run, only a remark says so.
void proposeExperiments(const Candidates& candidates, const std::vector<Trial>& trials,
                        const std::string& chosen, Diagnosis& out);

}  // namespace amb_rotor
