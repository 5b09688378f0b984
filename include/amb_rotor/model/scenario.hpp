#pragma once
// What is done to a machine in a run: speed, excitation, faults, starting state. File format
// amb-scenario/1; doc/formats.md. The node graph's Fault message carries the same FaultEvent.
#include <memory>
#include <string>
#include <vector>

namespace amb_rotor {

class FaultList;  // model/yaml_document.hpp

enum class SpeedType {
  constant,  ///< the drive keeps it (spin_drag may lower it)
  ramp,      ///< linear in time from start to end speed, then constant
  decay,     ///< Omega = Omega_0 / (1 + a t) from start_s on (thesis 4.3)
  free       ///< no drive: friction, spin_drag and the unbalance change it; needs a polar inertia
};

struct SpeedLaw {
  SpeedType type = SpeedType::constant;
  double start_hz = 0.0;
  double end_hz = 0.0;             ///< ramp
  double start_s = 0.0;            ///< ramp, decay: when it begins
  double duration_s = 0.0;         ///< ramp
  double decay_factor_per_s = 0.0; ///< decay: a
  double initial_angle_rad = 0.0;  ///< shaft angle at t = 0
};

enum class Waveform { step, impulse, chirp, sine };

/// One excitation. A force acts on the rotor at plane_z_m in direction_rad (0: x, pi/2: y); a current is
/// added to the command of one bearing axis.
struct Excitation {
  enum class Kind { force, current } kind = Kind::force;
  Waveform waveform = Waveform::step;
  double plane_z_m = 0.0;      ///< force
  double direction_rad = 0.0;  ///< force
  int end = 0;                 ///< current: 0 a, 1 b
  int axis = 0;                ///< current: 0 x, 1 y
  double amplitude = 0.0;      ///< N or A
  double start_s = 0.0;
  double duration_s = 0.0;     ///< impulse: a half sine of this length
  double start_hz = 0.0;       ///< chirp (linear), sine
  double end_hz = 0.0;         ///< chirp
};

enum class FaultType {
  unbalance_step,     ///< amount [kg m] at plane_z_m with phase_rad is added
  amb_off,            ///< no force from the bearing axes addressed
  amb_on,
  force_impulse,      ///< amount [N] at plane_z_m in direction phase_rad: half sine over duration_s
  force_step,         ///< amount [N], constant for duration_s (0: for good)
  sensor_offset,      ///< amount [m] added to the sensors addressed
  speed_change        ///< amount [Hz]: new speed, reached over ramp_s
};

/// A fault: begins at start_s, grows linearly over ramp_s, lasts duration_s (0: for good).
struct FaultEvent {
  FaultType type = FaultType::amb_off;
  double start_s = 0.0;
  double ramp_s = 0.0;
  double duration_s = 0.0;
  int end = -1;             ///< -1 both, 0 a, 1 b
  int axis = -1;            ///< -1 both, 0 x, 1 y
  double amount = 0.0;      ///< unit by type
  double plane_z_m = 0.0;   ///< unbalance, force
  double phase_rad = 0.0;   ///< unbalance: in the rotor; force: direction in the stator
};

struct Scenario {
  std::string name;
  double duration_s = 0.0;
  double record_rate_hz = 0.0;
  SpeedLaw speed;
  std::vector<Excitation> excitations;
  std::vector<FaultEvent> faults;
  bool start_settled = true;        ///< begin in the settled state of the starting speed
  std::vector<double> initial_displacement_m;  ///< else: x_G, y_G, beta, -alpha (rigid_mass: x_G, y_G)
  std::vector<double> initial_velocity_m_s;    ///< likewise, per second
  std::shared_ptr<const FaultList> source;     ///< as Model::source
};

}  // namespace amb_rotor
