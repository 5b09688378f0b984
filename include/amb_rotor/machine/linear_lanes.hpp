#pragma once
// A machine out of contact as linear equations, read from its own rates in every lane, at a speed W and an acceleration W':
//   y' = A y + B i + g + rc cos(angle) + rs sin(angle) + uc (W^2 cos(angle) + W' sin(angle)) + us (W^2 sin(angle) - W' cos(angle))
// i: the currents that make the force, ax, ay, bx, by; A, B, g at W; r: what turns at any speed (a bow); u: unbalance.
// usable() is false where that is not what the rates are (checked at states, angles, accelerations and times of both signs),
// where filters or coils are states too, and where the spin is a state. Left out: forces and unbalances of a schedule.
#include <algorithm>
#include <cmath>
#include <vector>

#include "amb_rotor/common/units.hpp"
#include "amb_rotor/machine/machine.hpp"

namespace amb_rotor {

template <class S>
class LinearLanes {
 public:
  LinearLanes(const Machine<S>& machine, const S& speed_rad_s, const Vec2<S> bearing_on[2])
      : machine_(machine), n_(machine.stateSize()), speed_(speed_rad_s) {
    if (machine.spin() != Spin::prescribed || machine.electrics().coils() || machine.electrics().filters()) return;
    in_.bearing_on[0] = bearing_on[0];
    in_.bearing_on[1] = bearing_on[1];
    in_.far_from_contact = true;
    in_.contact_mode = free_;
    read();
    usable_ = holds();
  }

  bool usable() const { return usable_; }
  int size() const { return n_; }
  const S& speed() const { return speed_; }
  const S& a(int row, int column) const { return columns_[column][row]; }
  const std::vector<S>& column(int j) const { return columns_[j]; }
  const std::vector<S>& byCurrent(int axis) const { return by_current_[axis]; }
  const std::vector<S>& constant() const { return constant_; }
  /// rc, rs, uc, us.
  static constexpr int turning_columns = 4;
  const std::vector<S>& turning(int k) const { return turning_[k]; }

  /// What turning() is multiplied with.
  static void turningInputs(const Shaft<S>& shaft, S out[turning_columns]) {
    const S square = shaft.speed * shaft.speed;
    out[0] = shaft.cosine;
    out[1] = shaft.sine;
    out[2] = square * shaft.cosine + shaft.acceleration * shaft.sine;
    out[3] = square * shaft.sine - shaft.acceleration * shaft.cosine;
  }

 private:
  static constexpr int free_[2] = {0, 0};
  /// Misfit at other states that counts as nonlinear, of the size of the terms: round-off is a thousand times smaller,
  /// the weakest effect of the catalogue at its weakest a thousand times larger.
  static constexpr double largest_misfit = 1e-9;
  /// Share of a row's largest entry below which another is what round-off leaves where terms cancel.
  static constexpr double cancelled_share = 1e-15;
  static constexpr int trials = 3;

  void rates(const std::vector<S>& state, const Shaft<S>& shaft, const S current[4], std::vector<S>& rate) {
    in_.shaft = shaft;
    in_.force_current[0] = {current[0], current[1]};
    in_.force_current[1] = {current[2], current[3]};
    machine_.derivatives(in_, state.data(), rate.data());
  }

  void read() {
    const S none[4] = {S(0.0), S(0.0), S(0.0), S(0.0)};
    const Shaft<S> zero = Shaft<S>::at(S(0.0), speed_, S(0.0)), half = Shaft<S>::at(S(pi), speed_, S(0.0));
    std::vector<S> state(n_, S(0.0)), at_zero(n_, S(0.0)), rate(n_, S(0.0));
    rates(state, zero, none, at_zero);
    rates(state, half, none, rate);
    constant_ = at_zero;
    for (int i = 0; i < n_; ++i) constant_[i] = S(0.5) * (at_zero[i] + rate[i]);
    // what an acceleration as large as the square of the speed makes of the unbalance, and what is left without it
    const S acceleration = maximum(speed_ * speed_, S(1.0));
    for (int k = 0; k < 2; ++k) {
      std::vector<S>&turning = turning_[k], &unbalance = turning_[2 + k];
      turning = unbalance = constant_;
      const S angle(k == 0 ? 0.0 : 0.5 * pi), quarter_on(k == 0 ? 0.5 * pi : pi);
      rates(state, Shaft<S>::at(quarter_on, speed_, acceleration), none, unbalance);
      rates(state, Shaft<S>::at(quarter_on, speed_, -acceleration), none, rate);
      rates(state, Shaft<S>::at(angle, speed_, S(0.0)), none, turning);
      for (int i = 0; i < n_; ++i) {
        unbalance[i] = S(0.5) * (unbalance[i] - rate[i]) / acceleration;
        turning[i] -= constant_[i] + speed_ * speed_ * unbalance[i];
      }
    }
    columns_.assign(n_, at_zero);
    for (int j = 0; j < n_; ++j) {
      state[j] = S(1.0);
      rates(state, zero, none, columns_[j]);
      state[j] = S(0.0);
      for (int i = 0; i < n_; ++i) columns_[j][i] -= at_zero[i];
    }
    for (int i = 0; i < n_; ++i) {
      S largest(0.0);
      for (int j = 0; j < n_; ++j) largest = maximum(largest, magnitude(columns_[j][i]));
      for (int j = 0; j < n_; ++j)
        columns_[j][i] = select(magnitude(columns_[j][i]) < largest * S(cancelled_share), S(0.0), columns_[j][i]);
    }
    for (int a = 0; a < 4; ++a) {
      S current[4] = {S(0.0), S(0.0), S(0.0), S(0.0)};
      current[a] = S(1.0);
      by_current_[a] = at_zero;
      rates(state, zero, current, by_current_[a]);
      for (int i = 0; i < n_; ++i) by_current_[a][i] -= at_zero[i];
    }
  }

  /// Whether the equations give the machine's rates elsewhere, and finite ones.
  bool holds() {
    const S clearance = machine_.rig().auxiliary_bearing.clearance_m;
    const int places = machine_.coordinates();
    double weyl = 0.0;
    const auto spread = [&weyl] {  // in (-1, 1), the same each time
      weyl += 0.6180339887498949;
      weyl -= std::floor(weyl);
      return 2.0 * weyl - 1.0;
    };
    std::vector<S> state(n_), rate(n_, S(0.0));
    for (int trial = 0; trial < trials; ++trial) {
      std::vector<double> shape(n_ + 4);
      for (double& value : shape) value = spread();
      const double angle = pi * spread(), time = 10.0 * spread(), acceleration = 1000.0 * spread();
      for (const double sign : {1.0, -1.0}) {
        S current[4];
        for (int i = 0; i < n_; ++i) state[i] = clearance * S(sign * shape[i] * (i < places ? 0.5 : 100.0));
        for (int a = 0; a < 4; ++a) current[a] = S(0.5 * sign * shape[n_ + a]);
        Shaft<S> shaft = Shaft<S>::at(S(sign * angle), speed_, S(sign * acceleration));
        shaft.time = time;
        rates(state, shaft, current, rate);
        S turn[turning_columns];
        turningInputs(shaft, turn);
        for (int i = 0; i < n_; ++i) {
          S value = constant_[i];
          S terms = magnitude(constant_[i]);
          for (int k = 0; k < turning_columns; ++k) {
            value += turn[k] * turning_[k][i];
            terms += magnitude(turn[k] * turning_[k][i]);
          }
          for (int j = 0; j < n_; ++j) {
            value += columns_[j][i] * state[j];
            terms += magnitude(columns_[j][i] * state[j]);
          }
          for (int a = 0; a < 4; ++a) {
            value += by_current_[a][i] * current[a];
            terms += magnitude(by_current_[a][i] * current[a]);
          }
          const S misfit = magnitude(rate[i] - value);
          for (std::size_t l = 0; l < ScalarTraits<S>::lanes; ++l)
            if (!(laneValue(misfit, l) <= largest_misfit * laneValue(terms, l) + 1e-300)) return false;
        }
      }
    }
    return true;
  }

  const Machine<S>& machine_;
  int n_;
  S speed_;
  Inputs<S> in_;
  bool usable_ = false;
  std::vector<std::vector<S>> columns_;
  std::vector<S> by_current_[4], constant_, turning_[turning_columns];
};

}  // namespace amb_rotor
