#pragma once
// What a diagnosis goes on from where contact is asked: a set's belief fitted without contact, and measured through it.
#include <vector>

#include "../../src/validation/candidates.hpp"
#include "made_sets.hpp"

namespace amb_rotor {

struct ThroughContact {
  const MadeSet& set;
  Candidates candidates{set.dataset.belief, set.dataset};
  Trial free = candidates.fit({}, nullptr, std::vector<LocalState>(set.recordings.size()), {Through::free, 10});
  References references = referred();

  References referred() {
    References out = candidates.referencesWithoutContact(free, free);
    candidates.referThroughContact(out);
    return out;
  }
  /// From where the belief's windows stand.
  Trial fitted(const Settings& effects, const FitEffort& effort, const QuadraticPrior* prior = nullptr) const {
    const Eigen::VectorXd own = references.contact.nuisance();
    return candidates.fit(effects, &own, references.contact.local, effort, prior);
  }
};

}  // namespace amb_rotor
