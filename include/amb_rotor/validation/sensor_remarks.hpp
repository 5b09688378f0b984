#pragma once
// What a recording's channels say against themselves, each on its own and against the tacho. Remarks, not
// faults, as those of validation/plausibility.hpp.
//
//   dead       one value throughout, though the stated noise is not below half a step of the resolution
//   stuck      one value for 5 % of the run, or more; clipped: the largest or smallest value, 20 times or more, and more
//              than half as often as all others within one noise of it
//   beyond     a displacement above the air gap, in a run without contact
//   noise      the quietest twentieth of the run scatters by more than twice, or less than a quarter of, the stated noise;
//              scatter s of samples y by fourth differences, s^2 = mean((y0 - 4 y1 + 6 y2 - 4 y3 + y4)^2)/70, in which what
//              moves by less than a twentieth of the sample rate is gone
//   whirl      the first harmonic backward, three times the forward one at both ends: x and y swapped, one of them mirrored
//              at both ends, or a spin against the convention
//   standstill the tacho turns where the speed is stated as 0
// Left out: sensors that are wrong and plausible (gain, rotation, runout: effects); noise of currents, which is coloured.
#include <string>
#include <vector>

#include "amb_rotor/validation/recording.hpp"

namespace amb_rotor {

std::vector<std::string> sensorRemarks(const Recording& rec, const Dataset& dataset);
std::vector<std::string> turningRemarks(const Recording& rec);

/// All remarks on a data set, one line for those that say the same (but for their numbers) of several runs.
std::vector<std::string> remarksOn(const std::vector<Recording>& recordings);

}  // namespace amb_rotor
