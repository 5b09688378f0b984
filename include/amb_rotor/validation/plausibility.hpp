#pragma once
// What a recording says against itself: displacement channels whose controller would not have made the measured currents,
// and a tacho whose clock is not that of the samples. Remarks, not faults: a fit may go on, and an effect may do the same.
//
// Each displacement channel is sent through the believed controller, its delay and the amplifier's lag, and compared with
// each measured current less the lagged excitation, both averaged over 1 ms (correlation r, gain g of the current on the
// computed one):
//   r of its own below -0.9                           a wrong sign
//   else of its own below 0.3, of another's over 0.9  the channels are swapped
//   r of its own above 0.9, g off by a factor over 3  mixed units
// What a current has beyond the computed one is the excitation of its axis behind the amplifier's lag (r, g as above):
//   r with its own excitation below -0.8              a wrong sign
//   below 0.4, of another's over 0.8, whose own is    channels are swapped
//   below 0.4 there (axes are driven alike)
//   above 0.8, g off by a factor over 3               mixed units
// A chirp or step without excitation: what drove it is not recorded. Not judged: excitation in runs with contact.
// The first harmonic of a run at constant speed without excitation keeps its phase to the tacho; where that runs away
// steadily by more than 0.3 rad, from the begin or from some time on, while its amplitude stays, the clocks drift. A tacho's speed
// that changes by more than 1e-3 is a drift too where the phase runs away by just that. Where channels are missing, the others are
// judged: pairs of a displacement and a current. Not judged: an equivalent bearing (it has no
// controller), channels that hardly move, swaps of signals that are alike (both ends of a rotor that only moves parallel).
#include <string>
#include <vector>

#include "amb_rotor/validation/recording.hpp"

namespace amb_rotor {

/// What is odd, in sentences with what to do; empty: nothing.
std::vector<std::string> channelRemarks(const Recording& rec, const Dataset& dataset);
std::vector<std::string> excitationRemarks(const Recording& rec, const Dataset& dataset);
std::vector<std::string> clockRemarks(const Recording& rec);

}  // namespace amb_rotor
