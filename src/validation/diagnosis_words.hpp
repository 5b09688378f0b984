#pragma once
// A diagnosis in words.
#include <string>
#include <vector>

#include "amb_rotor/validation/ranking.hpp"
#include "candidates.hpp"

namespace amb_rotor {

/// The finding, readable in one look.
std::vector<std::string> sentencesOf(const Diagnosis& diagnosis);

/// What a model that leaves nothing has asked of the belief: one sentence for each nuisance that is farther from it than chance
/// takes it, and so may stand for an effect that these runs do not tell from it.
std::vector<std::string> strainsOf(const Trial& standing);

/// From which distance to its neutral value on a candidate would have been seen: of each parameter
///   sqrt(2 E + n ln N) standard deviations
/// with E the least evidence for an adoption, n the candidate's parameters and N the samples. Phases, and what is neutral
/// nowhere, are left out; empty where nothing is known.
std::string powerOf(const Trial& trial, double least_evidence);

/// Of an error, through contact or without, that the runs to fit leave open.
std::string leftOpenInWords(const LeftOpen& open, Through through, const CandidateErrors& errors);

/// What to say where nothing is wrong without contact: that is where laws are sought.
Unexplained inContactOnly();

}  // namespace amb_rotor
