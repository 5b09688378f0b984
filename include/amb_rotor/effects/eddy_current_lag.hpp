#pragma once
// Eddy-current lag: between the current channel and the current that makes the force lies a half-order roll-off
//   H(s) = 1/(1 + sqrt(s/w)),  w = 2 pi corner_hz
// (flux diffusion into solid or laminated iron). Its diffusive form is exact,
//   H(s) = integral m(u) u w/(s + u w) du/u,  m(u) = sqrt(u)/(pi (1 + u)),
// a sum of first-order lags without end. Here it is one of twelve: eleven rates that are even in ln r from 0.2 Hz to
// 30 kHz, with the weights by which 1 - H is met best from 2 to 4000 Hz, in least squares over sqrt(frequency), and the
// rest, which does not lag; their sum is 1, exact at rest. The effect is 1 - H, which far below the corner is the small
// sqrt(s/w): so the rates lie where rotors move, whatever the corner, and from 2 to 4000 Hz the error is below 0.14 % of
// 1 - H (checked by a test). From corners of 30 Hz on all weights are positive: nothing overshoots. The lags are
// propagated exactly behind the amplifier.
// Left out: eddy currents from the rotor's spin (drag), frequency-dependent Ks.
// Valid: changes that are small against the bias flux (linear iron), 2 to 4000 Hz.
// Source: half order as in: Analytic model for a nonlaminated cylindrical magnetic actuator including eddy currents.
#include <array>

#include "amb_rotor/effects/effect.hpp"

namespace amb_rotor::effects {

struct EddyCurrentLag {
  static constexpr int nodes = 12;

  static EffectSchema schema() {
    return {"eddy_current_lag", "the force lags the current with a half-order roll-off",
            "chirp or step: displacement against current",
            {parameter("corner_hz", "Hz", 1.0, 1e7, 3000.0, 1e7, "corner of the half-order lag")},
            false, false, "amb.current_stiffness_N_per_A"};
  }

  struct Lag {
    double weight, rate;  ///< share of the current, 1/s
  };
  /// The lags of a corner [rad/s], slowest first; their weights are smooth in the corner.
  static std::array<Lag, nodes> rule(double corner);

  template <class S>
  class Physics final : public EffectPhysics<S> {
   public:
    explicit Physics(const std::vector<S>& p) : omega_(S(two_pi) * p[0]) {}
    unsigned roles() const override { return acts_on_force_current; }
    void relaxation(std::vector<S>& weights, std::vector<S>& rates) const override {
      weights.resize(nodes, S(0.0));
      rates.resize(nodes, S(0.0));
      for (std::size_t l = 0; l < ScalarTraits<S>::lanes; ++l) {
        const auto lags = rule(laneValue(omega_, l));
        for (int k = 0; k < nodes; ++k) {
          setLane(weights[k], l, lags[k].weight);
          setLane(rates[k], l, lags[k].rate);
        }
      }
    }

   private:
    S omega_;
  };
};

}  // namespace amb_rotor::effects
