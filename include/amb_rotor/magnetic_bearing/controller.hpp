#pragma once
// The sampled controller of all four axes as a model file states it: AD converter, unbalance force rejection,
// coordinates, second-order sections, the law, back to the axes, DA converter.
//
//   law of a channel, pid: magnetic_bearing/pid.hpp
//   law of a channel, state_space (thesis 4.4, 4.5), input X, parallel integrator J:
//     i = -(c W + d X + J),  W' = a W + b X,  J' = J + DI X       (a prime: the next sample's)
//   four channels: X and i are the columns ax, ay, bx, by
//   tilt_translation: the signals at the sensors' planes z are turned into the centre of gravity's translation and
//   the tilt b times half the span l of the magnets; commands into currents that make no moment, and no force:
//     x_t = (z_b s_a - z_a s_b)/(z_b - z_a),  x_r = l (s_b - s_a)/(z_b - z_a)               (z of the sensors)
//     i_a = z_b i_t/l - i_r,  i_b = -z_a i_t/l + i_r,  l = (z_b - z_a)/2                    (z of the magnets)
//   so F = 2 Ki i_t and M = 2 Ki l i_r: each motion has its own loop, as if both bearings stood at +-l.
// The sign is the PID's: a positive gain pulls back. Where a model says nothing of all this the command is the PID's,
// bit for bit.
// Valid: sensors and magnets of both ends at different z for tilt_translation; numbers of a law that belong to its rate.
// Source: thesis 4.4, 4.5, figure 4.9 (without DI's unit: A/m a sample here); tilt and translation derived in doc/physics.md
// section 2.
// Left out: anti-windup; the controller's word length; axes that are skewed to each other.
#include <array>
#include <vector>

#include "amb_rotor/common/check.hpp"
#include "amb_rotor/magnetic_bearing/biquad.hpp"
#include "amb_rotor/magnetic_bearing/converter.hpp"
#include "amb_rotor/magnetic_bearing/pid.hpp"
#include "amb_rotor/magnetic_bearing/unbalance_rejection.hpp"

namespace amb_rotor {

template <class S>
class Controller {
 public:
  /// The options are the same for all lanes.
  Controller(const Rig<S>& rig, const ControlOptions& options, const SignalChain& chain)
      : plain_(options.plain()),
        options_(options),
        chain_(chain),
        period_(1.0 / laneValue(rig.controller.sample_rate_hz, 0)),
        pid_{Pid<S>(rig), Pid<S>(rig)} {
    if (plain_) return;
    if (options.decoupled) {
      Rig<S> tilt = rig;
      tilt.controller.kp_A_per_m = S(options.tilt.kp_A_per_m);
      tilt.controller.kd_A_s_per_m = S(options.tilt.kd_A_s_per_m);
      tilt.controller.ki_A_per_m_s = S(options.tilt.ki_A_per_m_s);
      pid_[1] = Pid<S>(tilt);
      const S width = rig.planes.sensor[1] - rig.planes.sensor[0];
      half_span_ = S(0.5) * (rig.planes.amb[1] - rig.planes.amb[0]);
      for (int e = 0; e < 2; ++e) {
        sensor_[e] = rig.planes.sensor[e] / width;
        magnet_[e] = rig.planes.amb[e] / half_span_;
      }
      per_width_ = S(1.0) / width;
    }
    for (int c = 0; c < 2; ++c)
      for (const auto& section : channel(2 * c).sections) sections_[c].push_back(biquadOf(section, period_));
    if (options.unbalance_rejection) notch_.emplace_back(*options.unbalance_rejection, period_);
    std::size_t size = notch_.empty() ? 0 : SynchronousNotch<S>::numbers;
    for (int c = 0; c < 4; ++c) {
      offset_[c] = size;
      size += 2 * sections_[kind(c)].size();
      if (options.type == ControllerType::state_space && (c == 0 || channel(c).law.channels == 1)) {
        const StateSpaceLaw& law = channel(c).law;
        const auto n = static_cast<std::size_t>(law.states), m = static_cast<std::size_t>(law.channels);
        AMB_ROTOR_CHECK(law.a.size() == n * n && law.b.size() == n * m && law.c.size() == m * n && law.d.size() == m * m,
                        "matrices of n states and m channels");
        size += n;
      }
      if (options.type == ControllerType::state_space) ++size;  // the integrator
    }
    size_ = size;
  }

  /// Numbers of the memory beside the PIDs'.
  std::size_t memorySize() const { return size_; }
  double period() const { return period_; }

  /// Takes the samples, updates the memory and gives the commands [A].
  /// @param speed      of the shaft [rad/s]
  /// @param memory     memorySize() numbers
  /// @param integrate  false: the integrators rest at their values
  void sample(const S raw[4], const S& speed, PidMemory<S> pid[4], S* memory, S command[4], bool integrate = true) const {
    S signal[4];
    for (int a = 0; a < 4; ++a) signal[a] = chain_.ad ? converted(*chain_.ad, raw[a]) : raw[a];
    if (plain_)
      for (int a = 0; a < 4; ++a) command[a] = pid_[0].sample(signal[a], pid[a], integrate);
    else
      composed(signal, speed, pid, memory, command, integrate);
    if (chain_.da)
      for (int a = 0; a < 4; ++a) command[a] = converted(*chain_.da, command[a]);
  }

 private:
  int kind(int c) const { return options_.decoupled && c >= 2 ? 1 : 0; }
  const ChannelControl& channel(int c) const { return kind(c) == 1 ? options_.tilt : options_.main; }

  void composed(S signal[4], const S& speed, PidMemory<S> pid[4], S* memory, S command[4], bool integrate) const {
    S push[4] = {S(0.0), S(0.0), S(0.0), S(0.0)};
    if (!notch_.empty()) notch_[0].sample(speed, signal, memory, push);
    if (options_.decoupled) toMotions(signal);
    S* place[4];
    for (int c = 0; c < 4; ++c) {
      place[c] = memory + offset_[c];
      for (const Biquad& section : sections_[kind(c)]) {
        signal[c] = filtered(section, signal[c], place[c]);
        place[c] += 2;
      }
    }
    if (options_.type == ControllerType::pid) {
      for (int c = 0; c < 4; ++c) command[c] = pid_[kind(c)].sample(signal[c], pid[c], integrate);
    } else if (options_.main.law.channels == 4) {
      stateSpace(options_.main.law, signal, place[0], command);
      place[0] += options_.main.law.states;
    } else {
      for (int c = 0; c < 4; ++c) {
        stateSpace(channel(c).law, signal + c, place[c], command + c);
        place[c] += channel(c).law.states;
      }
    }
    if (options_.type == ControllerType::state_space)
      for (int c = 0; c < 4; ++c) {
        command[c] -= *place[c];
        if (integrate) *place[c] += S(channel(c).integrator_gain_A_per_m) * signal[c];
      }
    if (options_.decoupled) toAxes(command);
    for (int a = 0; a < 4; ++a) command[a] += push[a];
  }

  /// command = -(c W + d X), then the next W.
  void stateSpace(const StateSpaceLaw& law, const S* x, S* w, S* command) const {
    const int n = law.states, m = law.channels;
    for (int i = 0; i < m; ++i) {
      S sum(0.0);
      for (int j = 0; j < n; ++j) sum += S(law.c[static_cast<std::size_t>(i * n + j)]) * w[j];
      for (int j = 0; j < m; ++j) sum += S(law.d[static_cast<std::size_t>(i * m + j)]) * x[j];
      command[i] = -sum;
    }
    std::vector<S> next(static_cast<std::size_t>(n), S(0.0));
    for (int i = 0; i < n; ++i) {
      S& sum = next[static_cast<std::size_t>(i)];
      for (int j = 0; j < n; ++j) sum += S(law.a[static_cast<std::size_t>(i * n + j)]) * w[j];
      for (int j = 0; j < m; ++j) sum += S(law.b[static_cast<std::size_t>(i * m + j)]) * x[j];
    }
    for (int i = 0; i < n; ++i) w[i] = next[static_cast<std::size_t>(i)];
  }

  void toMotions(S signal[4]) const {
    for (int axis = 0; axis < 2; ++axis) {
      const S a = signal[axis], b = signal[2 + axis];
      signal[axis] = sensor_[1] * a - sensor_[0] * b;
      signal[2 + axis] = half_span_ * per_width_ * (b - a);
    }
  }
  void toAxes(S command[4]) const {
    for (int axis = 0; axis < 2; ++axis) {
      const S translation = command[axis], tilt = command[2 + axis];
      command[axis] = magnet_[1] * translation - tilt;
      command[2 + axis] = tilt - magnet_[0] * translation;
    }
  }

  bool plain_;
  ControlOptions options_;
  SignalChain chain_;
  double period_;
  Pid<S> pid_[2];  ///< of the axes or the translation, of the tilt
  std::vector<Biquad> sections_[2];
  std::vector<SynchronousNotch<S>> notch_;  ///< one, or none
  std::size_t offset_[4] = {0, 0, 0, 0}, size_ = 0;
  S half_span_ = S(0.0), per_width_ = S(0.0), sensor_[2] = {S(0.0), S(0.0)}, magnet_[2] = {S(0.0), S(0.0)};
};

}  // namespace amb_rotor
