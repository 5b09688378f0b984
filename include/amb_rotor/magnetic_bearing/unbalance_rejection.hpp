#pragma once
// Unbalance force rejection: an estimate of the part of a signal that turns with the shaft, taken out of the signal
// before the control law. At sample n, period T, speed W [rad/s], P = p + j q the estimate of one axis:
//   e_n = s_n - p_n,   P_(n+1) = exp(j W T) (P_n + g exp(j phase) e_n),   g = 2 pi bandwidth T
// From s to e it is the notch (s^2 + W^2)/(s^2 + 2 pi b s + W^2) that follows the speed (phase 0): no synchronous
// current. The magnet's displacement force Ks x stays; with a compensation kc = Ks/Ki [A/m] the command
//   i -= kc Re(P_n exp(j W lead))
// cancels that too where `lead` is the time from sample to force, and the rotor turns about its axis of inertia.
// Below the minimum speed the estimate is 0 and the signal passes.
// Valid: bandwidth well below the speed. Stable for a small bandwidth if the loop's sensitivity at W, turned by `phase`,
// has a positive real part: phase near 0 above the rigid modes, near pi below them. Source: derived in doc/physics.md section 2.
// Left out: harmonics; a wrong tacho.
#include "amb_rotor/common/scalar.hpp"
#include "amb_rotor/common/units.hpp"
#include "amb_rotor/model/control_options.hpp"

namespace amb_rotor {

template <class S>
class SynchronousNotch {
 public:
  static constexpr std::size_t numbers = 8;  ///< p, q of the four axes

  SynchronousNotch(const UnbalanceRejection& r, double period)
      : period_(period),
        in_phase_(two_pi * r.bandwidth_hz * period * std::cos(r.phase_rad)),
        quadrature_(two_pi * r.bandwidth_hz * period * std::sin(r.phase_rad)),
        least_speed_(radPerSecond(r.minimum_speed_hz)),
        compensation_(r.displacement_compensation_A_per_m),
        lead_(r.lead_s) {}

  /// Takes the synchronous part out of the four signals; `push` [A] is to be added to the commands.
  void sample(const S& speed, S signal[4], S* memory, S push[4]) const {
    const auto on = magnitude(speed) >= S(least_speed_);
    S sine, cosine, lead_sine, lead_cosine;
    sineCosine(speed * S(period_), sine, cosine);
    sineCosine(speed * S(lead_), lead_sine, lead_cosine);
    for (int a = 0; a < 4; ++a) {
      S& p = memory[2 * a];
      S& q = memory[2 * a + 1];
      p = select(on, p, S(0.0));
      q = select(on, q, S(0.0));
      push[a] = -S(compensation_) * (p * lead_cosine - q * lead_sine);
      signal[a] -= p;
      const S change = select(on, signal[a], S(0.0));
      const S next_p = p + S(in_phase_) * change, next_q = q + S(quadrature_) * change;
      p = cosine * next_p - sine * next_q;
      q = sine * next_p + cosine * next_q;
    }
  }

 private:
  double period_, in_phase_, quadrature_, least_speed_, compensation_, lead_;
};

}  // namespace amb_rotor
