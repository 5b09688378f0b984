#pragma once
// Compliant mount: each auxiliary bearing, mass m [kg], rides on a tolerance ring or O-ring of stiffness k [N/m] and
// damping d [N s/m] against the stator (thesis 5.30 to 5.37 with k2, d2 as in figure 5.5):
//   m b'' = -k (b - c) - d (b' - c') + (force of the rotor on it),  c its rest position on the stator.
// State: b, b' at each end, absolute. Left out: play in the ring, tilting, hysteresis.
// Valid: deflections in which ring or O-ring is linear: below those that flatten the ring's waves.
// Source: thesis 5.30 to 5.37 with the corrections of doc/physics.md section 7.
#include "amb_rotor/effects/effect.hpp"

namespace amb_rotor::effects {

struct CompliantMount {
  static EffectSchema schema() {
    EffectSchema schema = {
        "compliant_mount", "the auxiliary bearing rides on a tolerance ring or an O-ring", "contact: rubs and drops",
        {parameter("stiffness_N_per_m", "N/m", 1e3, 1e11, 5e6, std::nan(""), "k2 of one end"),
         parameter("damping_N_s_per_m", "N s/m", 0.0, 1e6, 300.0, std::nan(""), "d2 of one end"),
         parameter("mass_kg", "kg", 1e-4, 1e3, 0.07, std::nan(""), "moving bearing of one end")},
        true};
    schema.mimic = "auxiliary_bearing.contact.stiffness_N_per_m";  // a contact that gives way is soft, too
    schema.slow_to_predict = true;
    return schema;
  }

  template <class S>
  class Physics final : public EffectPhysics<S> {
   public:
    explicit Physics(const std::vector<S>& p) : stiffness_(p[0]), damping_(p[1]), inverse_mass_(S(1.0) / p[2]) {}
    unsigned roles() const override { return is_mount; }
    int stateSize() const override { return 8; }
    void mountPosition(int end, const S* state, Vec2<S>& position, Vec2<S>& velocity) const override {
      const S* s = state + 4 * end;
      position = {s[0], s[1]};
      velocity = {s[2], s[3]};
    }
    Vec2<S> mountRates(int end, const Vec2<S>& rest, const Vec2<S>& rest_velocity, const Vec2<S>& load,
                       const S* state, S* rate) const override {
      const S* s = state + 4 * end;
      S* r = rate + 4 * end;
      const Vec2<S> spring = {stiffness_ * (s[0] - rest.x) + damping_ * (s[2] - rest_velocity.x),
                              stiffness_ * (s[1] - rest.y) + damping_ * (s[3] - rest_velocity.y)};
      r[0] = s[2];
      r[1] = s[3];
      r[2] = (load.x - spring.x) * inverse_mass_;
      r[3] = (load.y - spring.y) * inverse_mass_;
      return spring;  // what the stator feels
    }

   private:
    S stiffness_, damping_, inverse_mass_;
  };
};

}  // namespace amb_rotor::effects
