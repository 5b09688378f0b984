#pragma once
// Eddy-current lag: between the current channel and the current that makes the force lies a half-order roll-off
//   H(s) = 1/(1 + sqrt(s/w)),  w = 2 pi corner_hz
// (flux diffusion into solid or laminated iron). Its diffusive form is exact,
//   H(s) = integral m(u) u w/(s + u w) du/u,  m(u) = sqrt(u)/(pi (1 + u)),
// and the trapezoidal rule on nodes r = u w that are even in ln r makes it a sum of first-order lags. What lies below
// the lowest and above the highest node is one lag each, with its weight and its first moment: all weights positive,
// their sum 1, exact at rest, never an overshoot. The effect is 1 - H, which far below the corner is the small
// sqrt(s/w): so the nodes lie where rotors move, whatever the corner, and from 2 to 4000 Hz the error is below 0.8 % of
// 1 - H (checked by a test). The lags are propagated exactly behind the amplifier.
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
  /// The lags of a corner [rad/s], slowest first.
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

inline std::array<EddyCurrentLag::Lag, EddyCurrentLag::nodes> EddyCurrentLag::rule(double corner) {
  // [rad/s], by search: the least error of 2 to 4000 Hz
  constexpr double lowest = two_pi * 0.5, highest = two_pi * 2e4;
  constexpr int inner = nodes - 2;
  const double step = std::log(highest / lowest) / (inner - 1);
  std::array<Lag, nodes> lags{};
  double sum = 0.0;
  for (int k = 0; k < inner; ++k) {
    const double u = lowest * std::exp(k * step) / corner;
    lags[k + 1] = {step * std::sqrt(u) / (pi * (1.0 + u)), u * corner};
  }
  // with q^2 = u at the border, weight and first moment of the tails: integrals of m, and of m u or m/u, over ln u
  const double low = std::sqrt(lowest * std::exp(-0.5 * step) / corner);
  const double high = std::sqrt(corner / (highest * std::exp(0.5 * step)));
  lags.front() = {std::atan(low) / (0.5 * pi), corner * (low - std::atan(low)) / std::atan(low)};
  lags.back() = {std::atan(high) / (0.5 * pi), corner * std::atan(high) / (high - std::atan(high))};
  for (const Lag& lag : lags) sum += lag.weight;
  for (Lag& lag : lags) lag.weight /= sum;
  return lags;
}

}  // namespace amb_rotor::effects
