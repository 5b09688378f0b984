#pragma once
// What is continuous in the electric part of a bearing and moves with the rotor: anti-alias filters in front of the
// samples, coils behind the commands (coil.hpp). Part of a machine's state, for each axis ax, ay, bx, by:
//   filter  y, and y' where the order is 2:  y' = w (s - y);  y'' = w^2 (s - y) - sqrt(2) w y'     (Butterworth)
//   coil    the control current i
// s [m] the sensor's signal with its errors, w = 2 pi corner [rad/s]. Both start at 0.
// Valid: filters that stay linear; coils as in coil.hpp.
// Source: thesis 3.23, figures 3.11 and 3.12 (the filter in the loop, without its order or corner).
// Left out: noise of the filter, tolerance between the axes.
#include <cmath>
#include <complex>
#include <optional>

#include "amb_rotor/magnetic_bearing/coil.hpp"

namespace amb_rotor {

template <class S>
class Electrics {
 public:
  Electrics() = default;
  Electrics(const Rig<S>& rig, const SignalChain& chain, const std::optional<CoilCircuit>& circuit) {
    if (chain.anti_alias) {
      order_ = static_cast<int>(chain.anti_alias->order);
      corner_ = radPerSecond(chain.anti_alias->corner_hz);
    }
    if (circuit) coil_.emplace(rig, *circuit);
  }

  int size() const { return 4 * order_ + (coil_ ? 4 : 0); }
  bool filters() const { return order_ > 0; }
  int filterOrder() const { return order_; }
  bool coils() const { return coil_.has_value(); }
  const Coil<S>& coil() const { return *coil_; }

  /// Rates from the sensors' signals [m], the rotor's velocity at the magnets [m/s] and the limited commands [A].
  void rates(const S signal[4], const S velocity[4], const S target[4], const S* state, S* rate) const {
    const S w(corner_);
    for (int a = 0; a < 4; ++a) {
      const S* y = state + a * order_;
      S* change = rate + a * order_;
      if (order_ == 1) change[0] = w * (signal[a] - y[0]);
      if (order_ == 2) {
        change[0] = y[1];
        change[1] = w * w * (signal[a] - y[0]) - S(std::sqrt(2.0)) * w * y[1];
      }
      if (!coil_) continue;
      const int i = 4 * order_ + a;
      rate[i] = coil_->slope(target[a], state[i], velocity[a]);
    }
  }
  /// What the controller samples; leaves the signals as they are without a filter.
  void filtered(const S* state, S signal[4]) const {
    if (order_ > 0)
      for (int a = 0; a < 4; ++a) signal[a] = state[a * order_];
  }
  /// Leaves the currents as they are without coils.
  void currents(const S* state, S current[4]) const {
    if (coil_)
      for (int a = 0; a < 4; ++a) current[a] = state[4 * order_ + a];
  }
  /// The state of signals that go on as straight lines, and of currents.
  void set(const S signal[4], const S slope[4], const S current[4], S* state) const {
    for (int a = 0; a < 4; ++a) {
      if (order_ > 0) state[a * order_] = signal[a];
      if (order_ > 1) state[a * order_ + 1] = slope[a];
      if (coil_) state[4 * order_ + a] = current[a];
    }
  }
  /// Response of the filter at w [rad/s].
  std::complex<double> filterResponse(double w) const {
    const std::complex<double> s(0.0, corner_ > 0.0 ? w / corner_ : 0.0);
    if (order_ == 0) return 1.0;
    return order_ == 1 ? 1.0 / (1.0 + s) : 1.0 / (1.0 + std::sqrt(2.0) * s + s * s);
  }

 private:
  int order_ = 0;
  double corner_ = 0.0;
  std::optional<Coil<S>> coil_;
};

}  // namespace amb_rotor
