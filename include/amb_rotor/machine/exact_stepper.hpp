#pragma once
// Steps of machines whose equations out of contact are linear: exact at a constant speed (machine/linear_step.hpp). Where the
// speed changes, a step is taken at the speed of its middle, by interpolation between speeds that are kept: what is left out,
// the change of the speed within a step, is 1e-6 of the unbalance at 1000 rad/s^2 and 10 kHz. What is near contact, and every
// machine that is not linear, goes by Runge and Kutta (machine/lane_stepper.hpp).
#include <algorithm>
#include <cmath>
#include <map>
#include <memory>
#include <utility>
#include <vector>

#include "amb_rotor/machine/lane_stepper.hpp"
#include "amb_rotor/machine/linear_step.hpp"

namespace amb_rotor {

template <class S>
class ExactStepper {
 public:
  ExactStepper(const Machine<S>& machine, double largest_step_s, double contact_step_s)
      : fixed_(machine, largest_step_s, contact_step_s), next_(machine.stateSize(), S(0.0)), other_(next_) {}

  /// Whether a machine's equations are linear at a drive's first speed.
  static bool takes(const Machine<S>& machine, const Drive<S>& drive) {
    const Vec2<S> on[2] = {{S(1.0), S(1.0)}, {S(1.0), S(1.0)}};
    return LinearLanes<S>(machine, drive.shaft(0.0).speed, on).usable();
  }

  bool advance(const Simulator<S>& sim, double from, double to, MachineState<S>& state,
               const typename Simulator<S>::Held& held) {
    if (!begun_) begin(sim, held);
    Length* length = linear_ && same(held.bearing_on) && !couldTouch(sim.machine(), state, to - from)
                         ? lengthOf(to - from) : nullptr;
    if (length == nullptr) return fixed_.advance(sim, from, to, state, held);
    const Drive<S>& drive = sim.drive();
    Shaft<S> shaft;
    S share(0.0);  // of the way from the lower to the upper of the speeds that are kept
    if (constant_) {
      shaft = drive.shaft(from);
      if (length->low == nullptr) length->low = stepAt(sim, 0, shaft.speed, to - from);
    } else {
      const ShaftInstant middle = drive.path->at(0.5 * (from + to));
      shaft = Shaft<S>::at(S(middle.angle - 0.5 * middle.speed * (to - from)), S(middle.speed), S(middle.acceleration));
      if (drive.turned) shaft = Shaft<S>::at(shaft.angle + drive.angle0 + drive.speed * S(from), shaft.speed + drive.speed, shaft.acceleration);
      const double place = middle.speed / speed_spacing_rad_s;
      const long segment = static_cast<long>(std::floor(place));
      share = S(place - static_cast<double>(segment));
      if (drive.turned) share += drive.speed * S(1.0 / speed_spacing_rad_s);
      if (length->low == nullptr || length->segment != segment) {
        length->segment = segment;
        length->low = stepAt(sim, segment, S(segment * speed_spacing_rad_s), to - from);
        length->high = stepAt(sim, segment + 1, S((segment + 1) * speed_spacing_rad_s), to - from);
      }
      if (length->low == nullptr || length->high == nullptr) return fixed_.advance(sim, from, to, state, held);
    }
    std::copy(state.mechanics.begin(), state.mechanics.end(), from_.begin());
    LinearStep<S>::read(sim.track(), state, held.target, shaft, from_.data() + state.mechanics.size());
    length->low->move(from_.data(), next_.data());
    if (!constant_) {
      length->high->move(from_.data(), other_.data());
      for (std::size_t i = 0; i < next_.size(); ++i) next_[i] += share * (other_[i] - next_[i]);
    }
    state.mechanics.swap(next_);
    sim.track().move(fixed_.decayOf(sim.track(), to - from), held.target, state.current, state.lag.data());
    return true;
  }

 private:
  /// Lengths of steps that are kept; beyond them (rates of controller and record that hardly ever meet) they are not exact.
  static constexpr std::size_t most_lengths = 64, most_lengths_of_changing_speed = 4;
  /// Interpolation between speeds is off by (30 rad/s * 100 us)^2/8 = 1.1e-6 of the turning forces, and less of the gyroscopic.
  static constexpr double speed_spacing_rad_s = 30.0;
  /// Steps from one look at the distance to the auxiliary bearings to the next.
  static constexpr int unseen_steps = 8;

  struct Length {
    double dt = 0.0;
    long segment = 0;
    const LinearStep<S>*low = nullptr, *high = nullptr;  ///< null: not yet, or not linear at that speed
  };

  void begin(const Simulator<S>& sim, const typename Simulator<S>::Held& held) {
    begun_ = true;
    const Drive<S>& drive = sim.drive();
    const Schedule* schedule = drive.schedule;
    if (schedule != nullptr && !(schedule->forcePlanes().empty() && schedule->unbalances().empty())) return;
    constant_ = drive.path == nullptr || drive.path->constantSpeed();
    std::copy(held.bearing_on, held.bearing_on + 2, on_);
    linear_ = LinearLanes<S>(sim.machine(), drive.shaft(0.0).speed, on_).usable();
    from_.assign(next_.size() + LinearStep<S>::inputs(sim.track()), S(0.0));
  }

  bool same(const Vec2<S> on[2]) const {
    for (int end = 0; end < 2; ++end)
      if (laneValue(on[end].x, 0) != laneValue(on_[end].x, 0) || laneValue(on[end].y, 0) != laneValue(on_[end].y, 0))
        return false;
    return true;
  }

  /// Whether an end could touch in this step; where none could in a good many, that many are taken unseen.
  bool couldTouch(const Machine<S>& machine, const MachineState<S>& state, double dt) {
    if (unseen_ > 0) {
      --unseen_;
      return false;
    }
    if (!fixed_.couldTouch(machine, state, 2.0 * unseen_steps * dt)) {
      unseen_ = unseen_steps - 1;
      return false;
    }
    return fixed_.couldTouch(machine, state, dt);
  }

  Length* lengthOf(double dt) {
    for (Length& length : lengths_)
      if (std::fabs(length.dt - dt) < 1e-13) return &length;
    if (lengths_.size() == (constant_ ? most_lengths : most_lengths_of_changing_speed)) return nullptr;
    lengths_.push_back({dt, 0, nullptr, nullptr});
    return &lengths_.back();
  }

  /// The step of a length at a speed; kept. Null where the machine is not linear there.
  const LinearStep<S>* stepAt(const Simulator<S>& sim, long speed_index, const S& speed, double dt) {
    std::unique_ptr<LinearLanes<S>>& linear = readings_[speed_index];
    if (linear == nullptr) linear = std::make_unique<LinearLanes<S>>(sim.machine(), speed, on_);
    if (!linear->usable()) return nullptr;
    const std::pair<long, long> key(speed_index, std::lround(dt * 1e12));
    auto found = steps_.find(key);
    if (found == steps_.end()) found = steps_.emplace(key, LinearStep<S>(*linear, sim.track(), dt)).first;
    return &found->second;
  }

  LaneStepper<S> fixed_;
  bool begun_ = false, linear_ = false, constant_ = true;
  int unseen_ = 0;
  Vec2<S> on_[2];
  std::vector<Length> lengths_;
  std::map<long, std::unique_ptr<LinearLanes<S>>> readings_;
  std::map<std::pair<long, long>, LinearStep<S>> steps_;
  std::vector<S> from_, next_, other_;  ///< (y, u) before a step, y behind it
};

}  // namespace amb_rotor
