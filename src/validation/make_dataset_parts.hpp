#pragma once
// Parts of the generator of data sets, shared by its source files.
#include <array>
#include <random>
#include <string>
#include <vector>

#include "amb_rotor/machine/drive.hpp"
#include "amb_rotor/machine/state.hpp"
#include "amb_rotor/validation/dataset.hpp"
#include "amb_rotor/validation/make_dataset.hpp"

namespace amb_rotor::making {

constexpr int channels = 8;  ///< displacement ax, ay, bx, by [m], current ax, ay, bx, by [A]
constexpr double sample_rate_hz = 10000.0;
/// Length of a prediction through contact, as a diagnosis cuts it [samples].
constexpr long window_samples = 100;

/// Random numbers that are the same with every standard library.
class Dice {
 public:
  explicit Dice(std::uint64_t seed) : engine_(seed) {}
  double uniform(double from, double to) { return from + (to - from) * (engine_() >> 11) * 0x1.0p-53; }
  double logUniform(double from, double to);
  double normal();
  bool chance(double share) { return uniform(0.0, 1.0) < share; }
  int pick(int count) { return static_cast<int>(uniform(0.0, count)); }
  double sign() { return chance(0.5) ? 1.0 : -1.0; }

 private:
  std::mt19937_64 engine_;
};

enum class Law {
  none,
  quadratic_damping,
  cubic_stiffness,
  sensor_dead_zone,
  hum,
  third_harmonic_force,
  speed_stiffness,
  current_dead_zone
};
struct HiddenLaw {
  Law law = Law::none;
  double amount = 0.0;  ///< N s2/m2, N/m3, share, N, N, N s/m, N/A
  double second = 0.0;  ///< dead zones: their width [m, A]; hum: its frequency [Hz]; harmonic force: its phase [rad]
};
Law lawOf(const std::string& name);
std::vector<std::string> lawDependsOn(Law law);

struct TrueMachine {
  Model model;
  HiddenLaw law;
};

/// One run to make: what the owner states, and what really happens.
struct RunPlan {
  Run run;
  long samples = 0;
  double angle0 = 0.0, speed_hz = 0.0, end_speed_hz = 0.0;  ///< true; end: of a run_up or coast_down
  HeldExcitation excitation;
};

/// What the rig's channels would show without noise of the recording.
struct Signals {
  std::array<std::vector<double>, channels> rows;
  std::vector<double> angle, speed;          ///< [rad], [rad/s]
  double reach = 0.0;                        ///< largest radius at an auxiliary bearing over the clearance
  bool touched = false, sound = true;
  std::vector<MachineState<double>> window_start;  ///< each window_samples
  int coordinates = 0;                             ///< of the machine that those are states of
};

/// Noise in the control loop, a value a sample and axis [m].
using LoopNoise = std::vector<std::array<double, 4>>;

/// Runs the machine through a plan, event-accurate. The noise may be null.
Signals runMachine(const TrueMachine& machine, const RunPlan& plan, const LoopNoise* noise);
/// The same in windows of 10 ms, each from a state of another machine's run, of which the coordinates that this one has not are left out.
Signals runWindows(const TrueMachine& machine, const RunPlan& plan, const Signals& of);

/// Whether a small kick dies away, at standstill and at a speed.
bool isStable(const TrueMachine& machine, double speed_hz);

/// make_dataset_rig.cpp
Model drawBelief(Dice& dice, bool horizontal, bool polar_inertia_unknown);
Model drawTruth(Dice& dice, const Model& belief);
double criticalHz(const Model& model);
double netStiffness(const Model& model);
/// Speed above all runs [Hz].
double topSpeedHz(const Model& model);

/// make_dataset_plan.cpp
std::vector<RunPlan> drawPlans(Dice& dice, const Model& belief, bool contact, double amplitude);
/// Scales the burst of each rub until the machine touches. False: it does not.
bool makeRubsTouch(const TrueMachine& machine, std::vector<RunPlan>& plans);

/// make_dataset_effects.cpp: an effect's dice, thrown once; its values then depend on the size alone.
struct EffectDraw {
  std::string id;
  std::array<double, 16> uniform{}, normal{};
};
EffectDraw drawEffect(Dice& dice, const std::string& id);
/// @param peak_current_A  largest control current in the runs of the machine without effects
EffectSetting effectOfSize(const EffectDraw& draw, double size, const Model& truth, double peak_current_A);
HiddenLaw lawOfSize(Law law, const EffectDraw& draw, double size, const Model& truth, double peak_current_A);

/// make_dataset_write.cpp
struct ChannelNoise {
  std::array<double, channels> stated{};   ///< noise_rms, before rounding
  std::array<double, channels> white{};    ///< added in the recording
  double displacement_resolution_m = 0.0, current_resolution_A = 1e-4;
  double loop_m = 0.0;                     ///< of each sensor, round the control loop

  double residual(int channel) const;      ///< noise and rounding together
};
struct RecordedRun {
  std::array<std::vector<double>, channels> rows;
  std::vector<double> tacho;
  double floor = 0.0;
};
/// Adds noise, offsets and drift and rounds. `quiet`: the same run without noise in the loop.
RecordedRun record(Dice& dice, const Signals& signals, const Signals& quiet, const ChannelNoise& noise);
void writeRun(const std::string& folder, const RunPlan& plan, const RecordedRun& run);
void writeDescription(const std::string& folder, const std::string& name, const Model& belief,
                      const ChannelNoise& noise, const std::vector<RunPlan>& plans);
void writeTruth(const std::string& folder, const MadeDataset& made, const HiddenLaw& law, std::uint64_t seed);

}  // namespace amb_rotor::making
