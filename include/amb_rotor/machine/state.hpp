#pragma once
// Everything of a machine that changes in a run. All of it can be written out and read back: a run that is
// continued from a state equals the run that was not interrupted.
#include <vector>

#include "amb_rotor/magnetic_bearing/pid.hpp"

namespace amb_rotor {

/// A command on its way from the controller to the amplifiers.
template <class S>
struct PendingCommand {
  double due = 0.0;  ///< [s]
  S command[4];      ///< ax, ay, bx, by [A]
};

/// No contact yet: whether it slides or sticks is found when it begins.
constexpr int sliding_unset = 2;

template <class S>
struct MachineState {
  double time = 0.0;
  std::vector<S> mechanics;             ///< machine/machine.hpp
  PidMemory<S> controller[4];           ///< ax, ay, bx, by (or the motions, magnetic_bearing/controller.hpp)
  std::vector<S> control;               ///< of the controller beside the PIDs; empty for a plain PID
  S command[4] = {S(0.0), S(0.0), S(0.0), S(0.0)};  ///< at the amplifiers now
  S current[4] = {S(0.0), S(0.0), S(0.0), S(0.0)};  ///< behind the amplifiers' lag [A]
  std::vector<S> lag;                   ///< eddy-current lags, nodes times 4
  std::vector<PendingCommand<S>> pending;  ///< in order of time
  long next_sample = 0;                 ///< index of the controller's next sample
  long next_record = 0;                 ///< index of the next recorded instant
  int contact_mode[2] = {0, 0};         ///< 1: carries (event-accurate runs)
  int sliding[2] = {sliding_unset, sliding_unset};  ///< set-valued friction: 1 with the spin, -1 against it, 0 sticks

  /// Made a state of a machine with so many lags: where it had another number, each is where its axis's current is.
  void takeLags(std::size_t count) {
    if (lag.size() == count) return;
    lag.resize(count);
    for (std::size_t i = 0; i < count; ++i) lag[i] = current[i / (count / 4)];
  }
};

}  // namespace amb_rotor
