#pragma once
// One run of one machine, in process: a model and a scenario in, a trajectory out.
#include <array>
#include <optional>
#include <string>
#include <vector>

#include "amb_rotor/machine/drive.hpp"
#include "amb_rotor/machine/machine.hpp"
#include "amb_rotor/machine/state.hpp"
#include "amb_rotor/model/model.hpp"

namespace amb_rotor {

class ModalStepper;

/// What was recorded, one entry an instant. Axes: ax, ay, bx, by. SI.
struct Trajectory {
  std::vector<double> time_s, angle_rad, speed_rad_s;
  std::array<std::vector<double>, 4> displacement_m;   ///< the sensors' signals, with all their errors but noise
  std::array<std::vector<double>, 4> position_m;       ///< the rotor at the sensors, relative to the stator
  std::array<std::vector<double>, 4> aux_position_m;   ///< the rotor at the auxiliary bearings, absolute
  std::array<std::vector<double>, 4> aux_centre_m;     ///< of the auxiliary bearings, absolute
  std::array<std::vector<double>, 4> current_A;        ///< control currents behind the lag
  std::array<std::vector<double>, 4> bearing_force_N;
  std::array<std::vector<double>, 4> contact_force_N;  ///< on the rotor, normal and friction together
  std::array<std::vector<double>, 2> normal_force_N, friction_force_N, penetration_m, slip_m_s, ring_speed_rad_s;
  double clearance_m = 0.0;
  /// Located contacts (event-accurate runs): end, start, end of contact; a contact that lasts ends with the run.
  struct ContactSpan {
    int end;
    double from_s, to_s;
  };
  std::vector<ContactSpan> contacts;
};

enum class RunStatus { ok, diverged, magnet_hit, integration_failed };

/// The rotor has reached a magnet. No air gap is left, so that no law of the bearing's force holds from here on, and
/// iron meets iron, whether the bearing is on or off.
struct MagnetHit {
  int end = 0;                  ///< 0: bearing a, 1: bearing b
  double time_s = 0.0;          ///< of the first instant at which it was seen
  double displacement_m = 0.0;  ///< of the rotor from the bearing's axis, in any direction: the poles stand all round
  double air_gap_m = 0.0;
  std::string text() const;
};

struct RunOutcome {
  RunStatus status = RunStatus::ok;
  std::string reason;   ///< empty where ok
  std::optional<MagnetHit> magnet_hit;  ///< where that is the status
  double time_s = 0.0;  ///< reached
  long steps = 0, evaluations = 0, events = 0;
  std::string path;     ///< modal coordinates or event stepper, and why (machine/modal_stepper.hpp)
};

struct RunOptions {
  double relative_tolerance = 1e-8;
  double settle_s = 0.5;  ///< length of the run-in before t = 0 where a scenario starts settled
  bool modal = true;  ///< a rotor that bends goes in modal coordinates where it can; false: by the event stepper
};

struct Simulation {
  Trajectory trajectory;
  RunOutcome outcome;
  MachineState<double> final_state;
};

/// Event-accurate run. The trajectory up to a failure is kept.
Simulation simulate(const Model& model, const Scenario& scenario, const RunOptions& options = {});

/// Puts a state where a scenario that does not start settled says, and its contacts by their guards.
void startAsGiven(const Machine<double>& machine, const Scenario& scenario, MachineState<double>& state);

/// Why a run ends as diverged: the rotor is farther than 50 clearances from the stator's axis, or not a number, at a
/// magnetic bearing, a sensor or an auxiliary bearing. A tilt or a bend that grows moves one of these six planes,
/// wherever its nodes are. Empty: it goes on. One rule for runs in process and in the node graph.
std::string divergence(const Machine<double>& machine, const double* mechanics);

/// Whether the rotor is at a magnet. Every bearing whose model states an air gap has one: a linear law is one about the
/// centre of this gap, and ends with it as the others do. Springs and dampers (AmbModel::equivalent) have no magnets.
/// Looked at at every instant of a run (samples, commands, records): a hit is told at most one of them late.
std::optional<MagnetHit> magnetHit(const Machine<double>& machine, const double* mechanics, double time_s);

/// The settled state of a machine at the start of a drive: run in at its starting speed without excitation,
/// faults and integrator, for options.settle_s.
/// @param modes  where the rotor bends: takes the steps, and knows the machine's equations from then on; null: one of its own
MachineState<double> settledState(const Machine<double>& machine, const Drive<double>& drive, const RunOptions& options,
                                  RunOutcome& outcome, ModalStepper* modes = nullptr);

/// How a spin is treated for a model and a speed law.
Spin spinOf(const Model& model, const Scenario& scenario);

}  // namespace amb_rotor
