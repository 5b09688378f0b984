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
  References& references;  ///< through contact they are made when they are asked for
  const CandidateErrors& errors;  ///< on the runs to validate
  bool ranked;                    ///< all candidates have been valued once: what is far behind is not looked at again
  bool stand_in;                  ///< what is adopted leaves more than a right effect would
};

struct Screening {
  std::vector<Trial> trials;    ///< the most evidence first
  std::string explains_contact;  ///< effect that was looked at without contact and takes most of what is off there; empty: none
  bool contact_waited = false;  ///< candidates through contact were not looked at, see Leaders::waits()
  bool none_near = false;       ///< beside a stand-in no look without contact takes much: none was followed, nor judged
};

/// Whether an effect that was looked at without contact is what is off through it. One that shows nowhere else bends to whatever is
/// missing there: a foundation's mode took all but 0.2 of 13 that a ring had left.
/// @param without_contact  its evidence there
bool isBelieved(const ExplainedContact& explained, double without_contact);

/// Whether a candidate through contact is looked at from where the best of its starts stands.
/// @param level    what it leaves there, over what the reference leaves
/// @param nearest  the same of the candidate that was looked at first
/// @param settled  that one leaves nothing after its look. Another is then looked at only where it stands at half, or as near as that one
///                 did: beside a reference far off a look that leaves little of it may still be far from the noise
bool isInSight(double level, double nearest, bool settled);

/// Those that take long to predict come last, when it is known whether they may still lead, and before them those through contact.
void slowLast(std::vector<std::string>& names);

/// By the evidence that they had, those that take long still last: what stood out alone is the likeliest beside another.
std::vector<std::string> likeliestFirst(std::vector<std::string> names, const std::vector<Trial>& trials);

/// Those that come within reach of the best, in the order given: two iterations do not tell which of them it is, and what takes long
/// stays last, there by its evidence, of which a ring must have twice as much as the next to come first: the second of two such is hardly
/// waited for. Then the others, by their evidence: what takes long and may be it does not wait for those that cannot.
std::vector<std::string> contendersFirst(std::vector<std::string> names, const std::vector<Trial>& trials);

/// @param names             those without contact are looked at first, by what they promise (foreseen.hpp), then the others, in an order
///                          into which short looks may bring them; what comes late and can no longer lead costs less
/// @param contact_may_wait  whether candidates through contact are left out where Leaders::waits() says so
/// @param progress          a share of the step, and what is looked at
Screening screen(Candidates& candidates, const std::vector<std::string>& names, const Standing& standing,
                 bool contact_may_wait, const std::function<void(double, const std::string&)>& progress);

}  // namespace amb_rotor
