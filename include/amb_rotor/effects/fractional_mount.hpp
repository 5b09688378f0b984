#pragma once
// Fractional mount: each auxiliary bearing, mass m [kg], rides on an elastomer (O-ring) whose stiffness and loss grow with
// frequency by one law, a spring beside a springpot (fractional Kelvin-Voigt):
//   K(s) = k (1 + (s T)^a),  0 < a < 1;  k [N/m] at rest, T [s], a [-];  loss factor Im K/Re K at s = i w
// It takes the place of compliant_mount; a model has one of the two. A half-integer power has a memory, which this law
// gives to a finite state by its diffusive form, exact and with positive weights only,
//   s^a = sin(pi a)/pi  integral r^(a-1) s/(s + r) dr,  r from 0 to infinity
// in steps h of ln r: each node is a Maxwell branch, force K_j (x - z_j), z_j' = r_j (x - z_j), K_j = k T^a sin(pi a)/pi
// h r_j^a. What lies below the lowest node is a spring, above the highest a dashpot; both are positive, so that the
// mount never gives energy. Band: 1 to 1000 Hz; the error of K there is below 0.4 % of |K| for a from 0.1 to 0.9 (held by
// a test; the trapezium rule's is 2 exp(-pi^2/h) of s^a, the rest comes from the ends).
// State: b, b' of each end (absolute), then the branches' z of each end in x and y, relative to the rest position.
// Left out: stiffening with amplitude (Payne), temperature, static set.
// Valid: the band above, strains in which the elastomer is linear.
// Source: Bagley and Torvik, J. Rheol. 27 (1983) 201.
#include "amb_rotor/effects/effect.hpp"

namespace amb_rotor::effects {

struct FractionalMount {
  static constexpr int branches = 10;
  static constexpr double log_step = 1.3;         ///< h
  static constexpr double lowest_rate_per_s = 0.6;   ///< r of the first branch

  static EffectSchema schema() {
    return {"fractional_mount", "the auxiliary bearing rides on an O-ring with fractional damping",
            "contact: rubs and drops",
            {parameter("stiffness_N_per_m", "N/m", 1e3, 1e11, 2e6, std::nan(""), "k of one end, at rest"),
             parameter("time_s", "s", 1e-9, 1e3, 1e-3, std::nan(""), "T: the springpot equals k at 1/T"),
             parameter("exponent", "1", 0.1, 0.9, 0.3, std::nan(""), "a", ParameterRole::fixed),
             parameter("mass_kg", "kg", 1e-4, 1e3, 0.07, std::nan(""), "moving bearing of one end")},
            true, true};
  }

  template <class S>
  class Physics final : public EffectPhysics<S> {
   public:
    explicit Physics(const std::vector<S>& p) : inverse_mass_(S(1.0) / p[3]) {
      const S a = p[2], share = power(p[1], a) * sine(S(pi) * a) * S(1.0 / pi);
      const S scale = p[0] * share;
      for (int j = 0; j < branches; ++j) {
        rate_[j] = S(rateOf(j));
        branch_[j] = scale * S(log_step) * power(rate_[j], a);
      }
      const double half = std::exp(0.5 * log_step);
      const S low(rateOf(0) / half), high(rateOf(branches - 1) * half);
      spring_ = p[0] + scale * power(low, a) / a;
      dashpot_ = scale * power(high, a - S(1.0)) / (S(1.0) - a);
    }
    unsigned roles() const override { return is_mount; }
    int stateSize() const override { return 8 + 4 * branches; }
    void mountPosition(int end, const S* state, Vec2<S>& position, Vec2<S>& velocity) const override {
      const S* s = state + 4 * end;
      position = {s[0], s[1]};
      velocity = {s[2], s[3]};
    }
    Vec2<S> mountRates(int end, const Vec2<S>& rest, const Vec2<S>& rest_velocity, const Vec2<S>& load,
                       const S* state, S* rate) const override {
      const S* s = state + 4 * end;
      S* r = rate + 4 * end;
      const S x[2] = {s[0] - rest.x, s[1] - rest.y};
      const S v[2] = {s[2] - rest_velocity.x, s[3] - rest_velocity.y};
      S force[2];
      for (int axis = 0; axis < 2; ++axis) {
        const S* z = state + 8 + (2 * end + axis) * branches;
        S* z_rate = rate + 8 + (2 * end + axis) * branches;
        force[axis] = spring_ * x[axis] + dashpot_ * v[axis];
        for (int j = 0; j < branches; ++j) {
          const S stretch = x[axis] - z[j];
          force[axis] += branch_[j] * stretch;
          z_rate[j] = rate_[j] * stretch;
        }
        r[axis] = s[2 + axis];
      }
      r[2] = (load.x - force[0]) * inverse_mass_;
      r[3] = (load.y - force[1]) * inverse_mass_;
      return {force[0], force[1]};  // what the stator feels
    }

   private:
    static double rateOf(int j) { return lowest_rate_per_s * std::exp(log_step * j); }
    /// b^e for b > 0, lane by lane: only while a machine is built.
    static S power(const S& base, const S& exponent) {
      S result(0.0);
      for (std::size_t lane = 0; lane < ScalarTraits<S>::lanes; ++lane)
        setLane(result, lane, std::pow(laneValue(base, lane), laneValue(exponent, lane)));
      return result;
    }
    static S sine(const S& angle) {
      S result(0.0);
      for (std::size_t lane = 0; lane < ScalarTraits<S>::lanes; ++lane)
        setLane(result, lane, std::sin(laneValue(angle, lane)));
      return result;
    }

    S inverse_mass_, spring_ = S(0.0), dashpot_ = S(0.0);
    S rate_[branches], branch_[branches];
  };
};

}  // namespace amb_rotor::effects
