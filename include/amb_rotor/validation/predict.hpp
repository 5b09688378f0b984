#pragma once
// Predictions of what a rig's channels show, for many machines at once: one lane, one machine. Every machine of a
// batch has the same structure (effects, rotor model) and runs through the same stretch of a recording.
#include <array>
#include <vector>

#include "amb_rotor/machine/drive.hpp"
#include "amb_rotor/machine/machine.hpp"
#include "amb_rotor/machine/state.hpp"

namespace amb_rotor {

/// Channels of a prediction, a row each instant: displacement ax, ay, bx, by [m], then current ax, ay, bx, by [A].
constexpr int axis_count = 4;  ///< ax, ay, bx, by
constexpr int predicted_channels = 8;

/// A stretch of a recording: recorded instants first .. last - 1.
struct Stretch {
  const ShaftPath* path = nullptr;  ///< null: the lane's own constant speed (or spin_drag from it)
  const HeldExcitation* excitation = nullptr;
  const Schedule* schedule = nullptr;
  Spin spin = Spin::prescribed;
  double record_rate_hz = 0.0;
  long first = 0, last = 0;
  double largest_step_s = 5e-5;
  double contact_step_s = 2.5e-6;  ///< 0: contact is left out
  /// Run-in where a lane has no starting state. A long one of machines that are linear out of contact is not gone through: they
  /// begin with the motion that they settle in (machine/settled_motion.hpp), where all of them have one.
  double settle_s = 0.15;
  double integrator_leak_per_s = 0.0;  ///< in the run-in, see Simulator::leakIntegrators(); 0: they rest
  double calm_s = 0.0;     ///< before that, with weakly damped modes held back: their static deflection would ring for long
  /// Through contact of set-valued friction: every machine goes by itself, its events located (machine/event_stepper.hpp).
  /// Otherwise friction is regularised, which stretches without contact do not feel.
  bool by_events = false;
  bool exact = false;  ///< set by predict(): the machines are linear out of contact
};

/// One machine of a batch.
struct LaneJob {
  const Model* model = nullptr;
  const HeldExcitation* excitation = nullptr;  ///< in the place of the stretch's, at one rate in all lanes or in none
  double angle0_rad = 0.0, speed_rad_s = 0.0;  ///< of a constant speed; on a path: added to its angle and speed
  double offset_m[4] = {0, 0, 0, 0};        ///< of the sensors
  double drift_m_per_s[4] = {0, 0, 0, 0};
  double integral_m_s[4] = {0, 0, 0, 0};    ///< that the controller's integrators hold in a run-in, or lie about, and begin with
  const MachineState<double>* start = nullptr;  ///< at instant `first`; null: settled at t = 0 (first must be 0)
  /// Where there is no starting state: a motion from which the run-in begins instead of from rest, at the shaft's angle of
  /// instant `first`; settle_s is whole turns then. Of several motions that a machine can settle in it tells the one.
  const MachineState<double>* settle_from = nullptr;
  const double* start_change = nullptr;     ///< added to the starting mechanics, 4 currents, 4 integrators; null: none
  double* out = nullptr;                    ///< (last - first) * predicted_channels, instant by instant
  MachineState<double>* end = nullptr;      ///< state at instant `last`, where asked for
  MachineState<double>* begin = nullptr;    ///< state at instant `first` before start_change, where asked for
  bool finite = true;                       ///< result: whether the prediction stayed finite
};

/// A model whose foundation and bending mode come to rest within a few periods, and whose currents know no effect's limit.
Model calmed(const Model& model);

/// Predicts all lanes (from rest, where the way over a calmed model loses one of them); serial (callers spread stretches over
/// threads). Uses the widest instruction set there is, none where it goes by events.
void predict(const Stretch& stretch, std::vector<LaneJob>& jobs);

/// Whether a stretch out of contact is predicted exactly: a model whose motion is linear.
bool predictsExactly(const Stretch& stretch, const Model& model);

/// Lanes of a pack on this machine, and its name.
int predictionLanes();
const char* predictionInstructionSet();

/// Size of the mechanics of a model's machine (the starting state that a stretch may change, without currents).
int mechanicsSize(const Model& model, Spin spin);

}  // namespace amb_rotor
