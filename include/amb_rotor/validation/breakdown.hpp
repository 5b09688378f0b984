#pragma once
// Where a model fails: error by run, channel, regime, speed and harmonic, and the worst cell in a sentence.
#include "amb_rotor/validation/compare.hpp"

namespace amb_rotor {

/// @param which  runs to count (indices into both lists)
ErrorBreakdown breakDown(const std::vector<Recording>& recordings, const std::vector<PredictedRun>& runs,
                         const std::vector<int>& which);

}  // namespace amb_rotor
