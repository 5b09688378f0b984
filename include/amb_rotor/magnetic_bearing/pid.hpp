#pragma once
// Sampled PID, one an axis, decentralised, on the sensor's signal s (not the rotor's position: the planes
// differ). At sample n, period T:
//   d_n = a d_(n-1) + (1 - a)(s_n - s_(n-1))/T,  a = exp(-2 pi f_d T)
//   I_n = I_(n-1) + T s_n
//   i_n = -(kp s_n + kd d_n + ki I_n)          [A]
// The command reaches the amplifier delay_s after the sample and is held until the next one.
// Valid: f_d and the loop's own frequencies well below 1/(2 T).
// Source: thesis 3.2.2, the PD law before 3.29 (with the sign of 3.22), and 4.1.4 for sampling and an integrator in parallel;
// filter and difference equation derived from it.
// Left out: anti-windup (the current limit acts behind the command), quantisation.
#include "amb_rotor/common/units.hpp"
#include "amb_rotor/model/rig.hpp"

namespace amb_rotor {

template <class S>
struct PidMemory {
  S previous_signal = S(0.0);  ///< s_(n-1) [m]
  S derivative = S(0.0);       ///< d_(n-1) [m/s]
  S integral = S(0.0);         ///< I_(n-1) [m s]
};

template <class S>
class Pid {
 public:
  Pid() = default;
  explicit Pid(const Rig<S>& rig)
      : period_(S(1.0) / rig.controller.sample_rate_hz),
        kp_(rig.controller.kp_A_per_m),
        kd_(rig.controller.kd_A_s_per_m),
        ki_(rig.controller.ki_A_per_m_s),
        pole_(exponential(S(-two_pi) * rig.controller.derivative_filter_hz * period_)) {}

  /// Takes the sample, updates the memory and gives the command [A].
  /// @param integrate  false: the integrator rests at its value
  S sample(const S& signal, PidMemory<S>& memory, bool integrate = true) const {
    memory.derivative =
        pole_ * memory.derivative + (S(1.0) - pole_) * (signal - memory.previous_signal) / period_;
    if (integrate) memory.integral += period_ * signal;
    memory.previous_signal = signal;
    return -(kp_ * signal + kd_ * memory.derivative + ki_ * memory.integral);
  }

 private:
  S period_ = S(1.0), kp_ = S(0.0), kd_ = S(0.0), ki_ = S(0.0), pole_ = S(0.0);
};

}  // namespace amb_rotor
