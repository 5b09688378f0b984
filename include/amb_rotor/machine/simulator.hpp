#pragma once
// Runs a machine: the schedule of instants (samples, commands, records, faults) between which a stepper integrates.
// One schedule for both steppers: event-accurate (machine/event_stepper.hpp, double) and fixed-step lanes
// (machine/lane_stepper.hpp).
//
// Order at an instant: faults, record, sample (its command is due delay_s later), commands that are due, excitation.
// A scenario's excitation current is sampled and held at the controller's rate, a recorded one at its own; its start
// and its end are instants of their own. Neither depends on what is recorded.
//
// A stepper may keep a state's mechanics in coordinates of its own between instants (machine/modal_stepper.hpp). They are
// then in the state when a sink sees it (but for a sink that asks the stepper) and when run() returns; the sensors'
// signals do not need them.
#include <algorithm>
#include <cmath>
#include <type_traits>
#include <utility>

#include "amb_rotor/magnetic_bearing/amplifier.hpp"
#include "amb_rotor/machine/drive.hpp"
#include "amb_rotor/machine/machine.hpp"
#include "amb_rotor/machine/state.hpp"

namespace amb_rotor {

/// Currents between two instants: exact behind held commands (magnetic_bearing/amplifier.hpp), and the lags behind
/// them:  z' = r (i - z), i = c + A exp(-a t)  ->  z = c + B exp(-a t) + (z0 - c - B) exp(-r t), B = A r/(r - a).
template <class S>
class CurrentTrack {
 public:
  /// No lag is slower than least_rate [1/s].
  explicit CurrentTrack(const Machine<S>& machine, double least_rate = 0.0)
      : amplifier_(machine.rig()), weights_(machine.relaxationWeights()) {
    for (S rate : machine.relaxationRates()) {
      rate = maximum(rate, S(least_rate));
      // equal rates would divide by zero: part them by 1e-6
      const S difference = rate - amplifier_.rate();
      rate = select(magnitude(difference) < S(1e-6) * rate, rate * S(1.0 + 2e-6), rate);
      rates_.push_back(rate);
      gain_.push_back(rate / (rate - amplifier_.rate()));
    }
  }
  bool lags() const { return !rates_.empty(); }
  std::size_t lagCount() const { return 4 * rates_.size(); }
  const std::vector<S>& weights() const { return weights_; }
  const std::vector<S>& rates() const { return rates_; }
  const std::vector<S>& gains() const { return gain_; }  ///< r / (r - a)
  const Amplifier<S>& amplifier() const { return amplifier_; }

  /// Decays over dt, to be reused for equal dt.
  struct Decay {
    double dt = -1.0;
    S amplifier = S(1.0);
    std::vector<S> lag;
  };
  Decay decay(double dt) const {
    Decay d;
    d.dt = dt;
    d.amplifier = amplifier_.decay(dt);
    for (const S& rate : rates_) d.lag.push_back(exponential(-rate * S(dt)));
    return d;
  }

  /// Moves currents and lags of all four axes on by a decay, towards the targets.
  void move(const Decay& d, const S target[4], S current[4], S* lag) const {
    const std::size_t n = rates_.size();
    for (int a = 0; a < 4; ++a) {
      const S excess = current[a] - target[a];
      for (std::size_t j = 0; j < n; ++j) {
        const S b = excess * gain_[j];
        S& z = lag[a * n + j];
        z = target[a] + b * d.amplifier + (z - target[a] - b) * d.lag[j];
      }
      current[a] = target[a] + excess * d.amplifier;
    }
  }
  /// Current that makes the force.
  void forceCurrent(const S current[4], const S* lag, Vec2<S> out[2]) const {
    const std::size_t n = rates_.size();
    S value[4];
    for (int a = 0; a < 4; ++a) {
      value[a] = current[a];
      if (n > 0) {
        value[a] = S(0.0);
        for (std::size_t j = 0; j < n; ++j) value[a] += weights_[j] * lag[a * n + j];
      }
    }
    out[0] = {value[0], value[1]};
    out[1] = {value[2], value[3]};
  }

 private:
  Amplifier<S> amplifier_;
  std::vector<S> weights_, rates_, gain_;
};

/// What a sink is given at a recorded instant.
template <class S>
struct Record {
  long index;
  double time;
  const MachineState<S>* state;
  Shaft<S> shaft;
  S signal[4];  ///< of the sensors, with all their errors but noise [m]
};

/// Whether a stepper keeps mechanics of its own. It then offers
///   void bring(MachineState&)                          writes them into the state, where they are not there yet
///   bool atSensors(const MachineState&, Vec2 out[2])   the rotor at the sensors relative to the stator [m]; false: only
///                                                      the state has it
template <class Stepper, class S, class = void>
struct KeepsMechanics : std::false_type {};
template <class Stepper, class S>
struct KeepsMechanics<Stepper, S,
                      std::void_t<decltype(std::declval<Stepper&>().bring(std::declval<MachineState<S>&>()))>>
    : std::true_type {};

/// Whether a sink asks the stepper for what it wants to see (`static constexpr bool asks_stepper = true`): mechanics that a
/// stepper keeps are then not written into the state for it.
template <class Sink, class = void>
struct AsksStepper : std::false_type {};
template <class Sink>
struct AsksStepper<Sink, std::void_t<decltype(Sink::asks_stepper)>> : std::bool_constant<Sink::asks_stepper> {};

template <class S>
class Simulator {
 public:
  /// The machine, the drive and what they point to must outlive the simulator.
  Simulator(const Machine<S>& machine, const Drive<S>& drive, double record_rate_hz)
      : machine_(machine),
        drive_(drive),
        controller_(machine.controller()),
        track_(machine),
        controlled_(machine.ambModel() == AmbModel::linear),
        sample_rate_(controlled_ ? laneValue(machine.rig().controller.sample_rate_hz, 0) : 0.0),
        delay_(controlled_ ? laneValue(machine.rig().controller.delay_s, 0) : 0.0),
        record_rate_(record_rate_hz) {
    for (std::size_t i = 1; i < ScalarTraits<S>::lanes && controlled_; ++i)
      AMB_ROTOR_CHECK(laneValue(machine.rig().controller.delay_s, i) == delay_ &&
                          laneValue(machine.rig().controller.sample_rate_hz, i) == sample_rate_,
                      "lanes share sample rate and delay");
  }

  /// Keeps the controller's integrators where they are (a run-in before a recording).
  void restIntegrators() { integrate_ = false; }
  /// Lets them follow what turns about these values [m s] and no mean: I' = s - leak (I - about). Of a PID by axis.
  void leakIntegrators(double leak_per_s, const S about[4]) {
    leak_ = std::min(1.0, leak_per_s / sample_rate_);
    std::copy(about, about + 4, about_);
  }
  /// Hurries lags that would not settle within a run-in: each is e^-8 of its start at the end, the slowest follow the
  /// current's mean as they should.
  void settleLags(double run_in_s) {
    if (track_.lags()) track_ = CurrentTrack<S>(machine_, 8.0 / std::max(run_in_s, 1e-3));
  }

  /// Lets every command through: the machine as linear as its equations.
  void liftLimits() { limited_ = false; }

  const Machine<S>& machine() const { return machine_; }
  const Drive<S>& drive() const { return drive_; }
  const CurrentTrack<S>& track() const { return track_; }

  /// At rest at the origin, at a time (its next sample and record are the first at or after it).
  MachineState<S> atRest(double time) const {
    MachineState<S> state;
    state.time = time;
    state.mechanics.assign(machine_.stateSize(), S(0.0));
    machine_.initialise(state.mechanics.data());
    if (machine_.spin() != Spin::prescribed) {
      const Shaft<S> shaft = drive_.shaft(time);
      state.mechanics[machine_.stateSize() - 2] = shaft.angle;
      state.mechanics[machine_.stateSize() - 1] = shaft.speed;
    }
    state.lag.assign(track_.lagCount(), S(0.0));
    state.control.assign(controller_.memorySize(), S(0.0));
    state.next_sample = controlled_ ? static_cast<long>(std::ceil(time * sample_rate_ - 1e-6)) : 0;
    state.next_record = static_cast<long>(std::ceil(time * record_rate_ - 1e-6));
    return state;
  }

  /// Advances to `end`. The stepper offers  bool advance(const Simulator&, double from, double to,
  /// MachineState&, const Held&)  (false: it failed); the sink is called at each recorded instant in [time, end).
  /// With include_end, instants at `end` itself are still processed.
  struct Held {
    S target[4];          ///< limited command of each axis [A]
    Vec2<S> bearing_on[2];
  };
  template <class Stepper, class Sink>
  bool run(MachineState<S>& state, double end, Stepper& stepper, Sink&& sink, bool include_end = false) const {
    AMB_ROTOR_CHECK(static_cast<int>(state.mechanics.size()) == machine_.stateSize() && state.lag.size() == track_.lagCount() &&
                        state.control.size() == controller_.memorySize(),
                    "the state is one of this machine");
    // instants closer than this are one; at most schedule_tolerance_s, also where nothing is sampled or recorded
    const double tolerance = 1e-9 * std::max(1e-4, 1.0 / std::max({sample_rate_, record_rate_, 10.0}));
    const auto breakpoints = drive_.schedule != nullptr ? drive_.schedule->breakpoints() : std::vector<double>();
    Held held;
    for (;;) {
      const double now = state.time;
      const bool finished = now >= end - tolerance;
      if (!finished || include_end) instant(state, tolerance, stepper, sink);
      if (finished) {
        bring(stepper, state);
        return true;
      }
      hold(state, held);
      double next = end;
      if (record_rate_ > 0.0) next = std::min(next, state.next_record / record_rate_);
      if (controlled_) next = std::min(next, state.next_sample / sample_rate_);
      if (!state.pending.empty()) next = std::min(next, state.pending.front().due);
      if (drive_.excitation != nullptr && drive_.excitation->rate_hz > 0.0)
        next = std::min(next, (std::floor(now * drive_.excitation->rate_hz + 1e-6) + 1.0) / drive_.excitation->rate_hz);
      const auto kink = std::upper_bound(breakpoints.begin(), breakpoints.end(), now + tolerance);
      if (kink != breakpoints.end()) next = std::min(next, *kink);
      if (!stepper.advance(*this, now, next, state, held)) {
        bring(stepper, state);
        return false;
      }
      state.time = next;
    }
  }

  /// The sensors' signals at a state.
  void signals(const MachineState<S>& state, const Shaft<S>& shaft, S signal[4]) const {
    Vec2<S> s[2];
    machine_.signals(shaft, state.mechanics.data(), s);
    addOffsets(s, state.time, signal);
  }

  /// What filters and coils follow at a time between the instant `since` and the next.
  void electricInputs(double time, double since, const Held& held, Inputs<S>& in) const {
    if (machine_.electrics().coils()) std::copy(held.target, held.target + 4, in.target);
    if (!machine_.electrics().filters()) return;
    for (int a = 0; a < 4; ++a) {
      in.sensor_offset[a] = drive_.sensor_offset[a] + drive_.sensor_drift[a] * S(time);
      if (drive_.schedule != nullptr) in.sensor_offset[a] += S(drive_.schedule->sensorOffset(a, time, since));
    }
  }
  /// The currents of the coils as the state's currents, where the machine has coils.
  void readCoils(MachineState<S>& state) const {
    machine_.electrics().currents(state.mechanics.data() + machine_.electricsOffset(), state.current);
  }

  Shaft<S> shaft(const MachineState<S>& state) const {
    if (machine_.spin() == Spin::prescribed) return drive_.shaft(state.time);
    Shaft<S> shaft = machine_.shaftOf(state.mechanics.data());
    shaft.time = state.time;
    return shaft;
  }

  bool bearingOn(int axis, double time) const {
    return drive_.schedule == nullptr || drive_.schedule->bearingOn(axis, time);
  }

 private:
  template <class Stepper>
  static void bring(Stepper& stepper, MachineState<S>& state) {
    if constexpr (KeepsMechanics<Stepper, S>::value) stepper.bring(state);
  }
  void addOffsets(const Vec2<S> at[2], double time, S signal[4]) const {
    const S value[4] = {at[0].x, at[0].y, at[1].x, at[1].y};
    for (int a = 0; a < 4; ++a) {
      signal[a] = value[a] + drive_.sensor_offset[a] + drive_.sensor_drift[a] * S(time);
      if (drive_.schedule != nullptr) signal[a] += S(drive_.schedule->sensorOffset(a, time));
    }
  }
  /// By the stepper where it knows them, whether or not the instant is recorded: a run does not depend on that.
  template <class Stepper>
  void signals(Stepper& stepper, const MachineState<S>& state, const Shaft<S>& shaft, S signal[4]) const {
    if constexpr (KeepsMechanics<Stepper, S>::value) {
      Vec2<S> s[2];
      if (stepper.atSensors(state, s)) {
        machine_.sense(shaft, s);
        addOffsets(s, state.time, signal);
        return;
      }
    }
    signals(state, shaft, signal);
  }

  template <class Stepper, class Sink>
  void instant(MachineState<S>& state, double tolerance, Stepper& stepper, Sink&& sink) const {
    const bool record = record_rate_ > 0.0 && state.next_record / record_rate_ <= state.time + tolerance;
    const bool sample = controlled_ && state.next_sample / sample_rate_ <= state.time + tolerance;
    if (record || sample) {
      Record<S> seen;
      seen.shaft = shaft(state);
      signals(stepper, state, seen.shaft, seen.signal);
      if (record) {
        if constexpr (!AsksStepper<std::decay_t<Sink>>::value) bring(stepper, state);
        seen.index = state.next_record++;
        seen.time = state.time;
        seen.state = &state;
        sink(seen);
      }
      if (sample) {
        PendingCommand<S> command;
        command.due = state.next_sample / sample_rate_ + delay_;
        machine_.electrics().filtered(state.mechanics.data() + machine_.electricsOffset(), seen.signal);
        controller_.sample(seen.signal, seen.shaft.speed, state.controller, state.control.data(), command.command,
                           integrate_);
        for (int a = 0; a < 4 && leak_ > 0.0; ++a) state.controller[a].integral -= S(leak_) * (state.controller[a].integral - about_[a]);
        state.pending.push_back(command);
        ++state.next_sample;
      }
    }
    while (!state.pending.empty() && state.pending.front().due <= state.time + tolerance) {
      std::copy(state.pending.front().command, state.pending.front().command + 4, state.command);
      state.pending.erase(state.pending.begin());
    }
  }

  void hold(const MachineState<S>& state, Held& held) const {
    // a scenario's currents are samples of the controller: held from one of its instants to the next
    const double sampled =
        controlled_ ? std::floor(state.time * sample_rate_ + 1e-6) / sample_rate_ : state.time;
    for (int a = 0; a < 4; ++a) {
      const bool on = bearingOn(a, state.time);
      S sum = state.command[a];
      if (drive_.excitation != nullptr) sum += drive_.excited(a, state.time);
      if (drive_.schedule != nullptr) sum += S(drive_.schedule->current(a, sampled, state.time));
      held.target[a] = !(on && controlled_) ? S(0.0) : limited_ ? track_.amplifier().limited(sum) : sum;
      (a % 2 == 0 ? held.bearing_on[a / 2].x : held.bearing_on[a / 2].y) = S(on ? 1.0 : 0.0);
    }
  }

  const Machine<S>& machine_;
  const Drive<S>& drive_;
  Controller<S> controller_;
  CurrentTrack<S> track_;
  bool controlled_;
  bool integrate_ = true, limited_ = true;
  double leak_ = 0.0;  ///< of a sample
  S about_[4] = {S(0.0), S(0.0), S(0.0), S(0.0)};
  double sample_rate_, delay_, record_rate_;
};

}  // namespace amb_rotor
