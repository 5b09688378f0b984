#pragma once
// A force law by its terms at each magnetic bearing, while it is on: what the diagnosis proposes where no physical effect of
// the catalogue explains a residual. A hypothesis, not a mechanism; terms, symbols and signs: effects/law_terms.hpp.
// Left out: forces elsewhere (force_law_at_plane), and what law_terms leaves out.
// Valid: where it was fitted, as far as the runs went. Source: a fit, no mechanism.
#include <cmath>

#include "amb_rotor/effects/law_terms.hpp"

namespace amb_rotor::effects {

struct ForceLaw : LawTerms {
  static constexpr const char* id = "force_law";

  static EffectSchema schema() {
    EffectSchema s{id,
                   "a force by its terms in position, velocity, speed, angle, current and time: a hypothesis",
                   "whatever moves the quantities of its terms",
                   {},
                   false};
    addRows(term_count, s.parameters);
    s.parameters.push_back(parameter("step_width_A", "A", 1e-3, 10.0, 0.05, std::nan(""), "w, over which a step of the current is rounded off"));
    s.only_by_name = true;
    return s;
  }

  template <class S>
  class Physics final : public EffectPhysics<S> {
   public:
    explicit Physics(const std::vector<S>& p) : sum_(p, term_count, p[term_count + 1]) {}
    unsigned roles() const override { return acts_on_bearing_force; }
    void bearingForce(const BearingSite<S>& site, Vec2<S>& force) const override {
      force += sum_.at(*site.shaft, site.position, site.velocity, site.current, site.end);
    }

   private:
    Sum<S> sum_;
  };
};

}  // namespace amb_rotor::effects
