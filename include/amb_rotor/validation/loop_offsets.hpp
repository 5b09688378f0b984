#pragma once
// What the controller's law says of a recording: where the sensors' offsets lie, and where its integrators stood at the start.
//
// A PID by axis holds  y(t) = i - excitation + kp s + kd s' + ki int_0^t s = -ki I(0)  but for what turns or rings, whatever forces act. Of an
// offset o that lies in the recording alone the current knows nothing: it adds kp o + ki o t to y. One in the loop adds nothing; it then
// moves the rotor and its currents by what the closed loop makes of it; integrators that begin at 0 then carry it off.
// Left out: controllers beyond a PID by axis. Their offsets are taken to lie in the recording alone, and their integrators to begin at 0.
#include <Eigen/Core>
#include <array>
#include <vector>

#include "amb_rotor/model/model.hpp"
#include "amb_rotor/validation/predict.hpp"

namespace amb_rotor {

struct LocalState;
struct Recording;

/// Of a recording, by axis ax, ay, bx, by; NaN where a channel is not there.
struct LawReading {
  Eigen::Vector4d offset_m = Eigen::Vector4d::Zero();    ///< that lies in the recording alone
  Eigen::Vector4d integral_A = Eigen::Vector4d::Zero();  ///< ki I(0); 0 without integrator
  /// Integrators that have settled hold the signals' mean at 0: until an excitation or event, what is left in the displacements is their
  /// offset. ki I(0) with this, the offsets' drifts free.
  Eigen::Vector4d settled_integral_A = Eigen::Vector4d::Zero();
  /// ki I(0) where offsets go round the loop: the law knows nothing of them, and the displacements' mean is what a drift moves the rotor by.
  Eigen::Vector4d loop_integral_A = Eigen::Vector4d::Zero();
  double settled_gain = 0.0;  ///< by how much less it leaves, as chi2 of all axes, than integrators that begin at 0
};

/// Least squares of y, weighted by a Hann window, which leaves next to nothing of what turns: its mean, or, with an integrator, that, an
/// offset, and what delay and lag of the current are beside the believed ones (steps of an excitation show them). A drift of 0.4 um, taken
/// for a slope, would be integrators that begin 2.5 mA aside.
/// @param offset_std_m  of an offset's drift over the run; 0: there is none
LawReading readLaw(const Recording& rec, const Model& belief, double offset_std_m);

/// What the recordings of a set say together.
struct LoopReading {
  bool offsets_in_loop = false;     ///< the median offset beside the law is less than a tenth of the stated deviation
  bool integrators_settled = false; ///< they begin where forces and offsets hold them, and not at 0
};

/// By the runs without contact; both false where the belief has no plain PID, or a channel is missing.
LoopReading readLoop(const std::vector<Recording>& recordings, const Model& belief, double offset_std_m);

/// What constant offsets of the sensors, then drifts that grow from the start to 1 m at the end, show in a recording without contact by
/// the belief's loop: samples * predicted_channels rows of 2 * axis_count [1 or A/m]. It is taken for that of the true rig: what Ki or a
/// sensor's gain is off by changes it in proportion. Empty: the belief does not stay finite.
std::vector<double> offsetsInLoop(const Recording& rec, const Model& belief);

/// Offsets, then drifts over the run [m], that a run without contact is predicted with where they go round the loop; else all 0. What
/// does not go round it in proportion (a current's limit) so counts at its size; the columns lead from there on.
/// @param offset_std_m  they are taken up to a few of these: a model that is far off must not be thrown out by them
Eigen::VectorXd offsetsInLanes(const Recording& rec, const LocalState& local, double offset_std_m);
/// Puts these into a lane.
void takeOffsets(const Recording& rec, const Eigen::VectorXd& offsets, LaneJob& job);

/// How far the integrators of a turning rotor, settled, are at t = 0 from what they stand about: the integral of the signals' first order,
/// read over the first turns. 0 at standstill, and where the run is shorter than these.
Eigen::Vector4d integralRipple_m_s(const Recording& rec);

/// Fills what the recordings say into them: offsets_in_loop, offset_columns, integral_m_s, integrator_leak_per_s.
void applyLoopReading(std::vector<Recording>& recordings, const Model& belief);

}  // namespace amb_rotor
