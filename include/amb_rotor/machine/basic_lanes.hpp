#pragma once
// Many basic models at once: each lane of a SIMD pack is one machine with its own parameters, speed and
// initial state; classical Runge-Kutta of order 4 with a fixed number of steps a turn.
//
// How it is fast: (1) the step is the unit of time, so a Runge-Kutta step is
//   q2 = q + w/2,        w2 = w + a1/2      q3 = q + w/2 + a1/4,  w3 = w + a2/2
//   q4 = q + w + a2/2,   w4 = w + a3        q+ = q + w + (a1 + a2 + a3)/6,  w+ = w + (a1 + 2 a2 + 2 a3 +
//   a4)/6
// (w: velocity per step), (2) all lanes run at the same phase, whatever their speed, so cosine and sine come
// from one table of 2 steps_per_turn points, (3) four packs are interleaved, which hides the latency of
// square root and division. The instruction set is chosen when the program runs.
//
// Accuracy: order 4 between contact events; a step that straddles an event has an error of order h^3 times
// the jump of the force's slope, because the force itself is continuous. checkBasicSteps refuses steps that
// are too coarse for the contact.
//
// Errors: InputError for parameters out of range, a step too coarse, sizes that do not match. A machine that
// diverges is a result (diverged = true), not an error.
#include <cstddef>
#include <string>
#include <vector>

#include "amb_rotor/common/error.hpp"
#include "amb_rotor/machine/basic_model.hpp"

namespace amb_rotor {

enum class BasicContact { linear, hertz };
enum class BasicFriction { spin, sliding };

/// What is run, the same for all machines of a call.
struct BasicLaneOptions {
  BasicContact contact = BasicContact::linear;
  BasicFriction friction = BasicFriction::spin;
  int steps_per_turn = 200;     ///< of the shaft; the phase of the forcing advances by 2 pi in these
  int turns_skipped = 400;      ///< transient, not recorded
  int turns_kept = 100;         ///< recorded; 0: only the end state
  bool lyapunov = false;        ///< largest Lyapunov exponent over the kept turns; costs about twice the time
  int threads = 0;              ///< 0: all
  std::string instruction_set;  ///< "", "baseline", "avx2" or "avx512"; empty: the best of this processor
};

/// What came out, one entry a machine (machine-major for the sections).
struct BasicLaneResult {
  std::size_t machines = 0;
  int turns_kept = 0;
  std::vector<BasicState<double>> end;       ///< after the last turn
  std::vector<BasicState<double>> sections;  ///< [machine * turns_kept + turn], at the end of each kept turn
  std::vector<double> contact_fraction;      ///< share of the kept time in contact
  std::vector<double> max_radius;  ///< distance from the auxiliary bearing's centre over the clearance
  std::vector<double> min_radius;
  std::vector<double> whirl;     ///< turns about the bearing's centre per turn of the shaft, with sign
  std::vector<double> lyapunov;  ///< largest exponent [1 per turn]; empty when not asked for
  std::vector<char> diverged;    ///< not finite, or farther than 1e6 clearances
  double machine_steps = 0.0;    ///< Runge-Kutta steps that were taken
  std::string instruction_set;   ///< that was used
};

/// Steps a turn that the contact needs at this machine: the step times the highest contact frequency, at the
/// largest penetration expected, is at most 0.3 (at 0.3 a turn's Poincare point is within 1e-3 of the
/// clearance of the event-accurate one: test/convergence/basic_lanes_test.cpp).
int requiredBasicSteps(const BasicParameters<double>& p, BasicContact contact);

/// Throws InputError with every parameter out of range.
void checkBasicParameters(const BasicParameters<double>& p);
/// Throws InputError naming the number of steps that would do.
void checkBasicSteps(const std::vector<BasicParameters<double>>& machines, const BasicLaneOptions& options);

/// Runs all machines. States are at phase 0 of the forcing (time 0). One state for all, or one a machine.
BasicLaneResult runBasicLanes(const std::vector<BasicParameters<double>>& machines,
                              const std::vector<BasicState<double>>& initial,
                              const BasicLaneOptions& options);

/// Instruction sets that this build has and this processor runs, best first.
std::vector<std::string> basicInstructionSets();

}  // namespace amb_rotor
