#pragma once
// One run of a data set, made ready to be predicted: channels side by side, noise, shaft angle, excitation, events.
#include <array>
#include <memory>
#include <string>
#include <vector>

#include "amb_rotor/analysis/tacho.hpp"
#include "amb_rotor/excitation/schedule.hpp"
#include "amb_rotor/validation/dataset.hpp"
#include "amb_rotor/validation/loop_offsets.hpp"
#include "amb_rotor/validation/predict.hpp"

namespace amb_rotor {

/// A shaft that spins freely: W' = -decay W - constant from W0 at t = 0,
///   W = W0 (1 - decay reach(t)) - constant reach(t),  angle = angle0 + W0 reach(t) - constant lost(t)
struct FreeSpin {
  double decay_per_s = 0.0, constant_rad_s2 = 0.0;

  double reach(double time_s) const;  ///< (1 - e^(-decay t))/decay [s]
  double lost(double time_s) const;   ///< (t - reach(t))/decay [s^2]
};

/// What is found of the shaft of a run beyond what its pulses tell: added to its angle in the middle of the turns that they were taken
/// from, and to its speed.
struct ShaftTurn {
  double rad = 0.0, rad_s = 0.0;
};

struct Recording {
  Run run;
  long samples = 0;
  std::vector<double> measured;         ///< samples * predicted_channels, as a prediction
  std::array<double, predicted_channels> noise{};   ///< of a residual [m or A]; 0: the channel is not there
  HeldExcitation excitation;
  Schedule schedule;                    ///< bearings off and on
  bool standstill = false;              ///< the tacho tells no angle
  /// At t = 0, of a constant speed: from the first turns, or from all where edges are known to half a sample and lie on one line.
  double angle0_rad = 0.0, speed_rad_s = 0.0;
  /// How well these turns, or those of a path, tell angle and speed, at their middle [s]; 0: nothing tells them, or a path does exactly.
  double angle_std_rad = 0.0, speed_std_rad_s = 0.0, first_turns_s = 0.0;
  std::shared_ptr<ShaftPath> path;      ///< of a driven speed: through all pulses; else null
  bool stays_inside = false;            ///< no end can have touched: predicted without contact
  bool offsets_in_loop = false;         ///< the sensors' offsets and drifts: the controller acts on them, too
  std::vector<double> offset_columns;   ///< then: what they show without contact, see offsetsInLoop()
  /// Of the controller's integrators at the start of a run without contact, and how fast they follow what turns in its run-in; 0: not.
  std::array<double, axis_count> integral_m_s{};
  double integrator_leak_per_s = 0.0;
  TachoPulses pulses;
  std::vector<std::string> remarks;     ///< what is odd in the data: dropouts, missing pulses, saturation

  double duration() const { return samples / run.sample_rate_hz; }
  /// [rad/s], with the spin's sign.
  double startingSpeed() const { return path != nullptr ? path->at(0.0).speed : speed_rad_s; }
  bool holdsContact() const { return run.holdsContact(); }
  /// Angle and speed at t = 0 that fit the first turns when the shaft slows down in a known way.
  void startOfSpin(const FreeSpin& spin, double& angle0, double& speed) const;
};

/// Distance of a straight shaft from the centre at an axial position, by its displacements at the sensors ax, ay, bx, by [m].
double radiusAt(const double* displacement, const Model& model, double z_m);

/// Whether a run was measured to stay so far inside the clearance that no end can have touched, and the belief predicts it
/// without contact. What is not true of its displacements (unmeasured ones too) makes it false.
bool staysInside(const Recording& rec, const Model& belief);

/// Angle and speed of a run of constant speed without pulses, by its first harmonic and the belief's phase of it; false where that
/// is not above the noise. `rec` turns at its believed speed.
bool findShaft(Recording& rec, const Model& belief);

/// Reads and prepares all runs of a data set.
/// @throw InputError: a table; a speed that is in the pulses of a tacho that shows none
std::vector<Recording> prepareRecordings(const Dataset& dataset);
Recording prepareRecording(const Dataset& dataset, const Run& run);

}  // namespace amb_rotor
