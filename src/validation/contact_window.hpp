// A window of a run through contact: the state that it begins with is unknown and estimated from the window itself.
//
// The estimate minimises sum((measured - predicted) / noise)^2 + sum((state - guess) / prior)^2, the coordinates and the
// run's offsets held, by Levenberg and Marquardt, several dampings at once; derivatives are differences of predictions, all in packs of lanes.
#pragma once
#include <Eigen/Core>
#include <array>
#include <vector>

#include "amb_rotor/validation/fit.hpp"
#include "amb_rotor/validation/stretches.hpp"

namespace amb_rotor {

/// Of the unknowns of a starting state: displacement [m or rad], rate, current [A], speed of a ring [rad/s].
struct StartScales {
  double displacement, rate, current, ring;
};
/// Finite differences.
inline constexpr StartScales steps_of_start = {2e-9, 2e-6, 1e-4, 0.05};
/// The starting guess comes from the measurement, that of a ring from where the last window led; the estimate may move
/// it by about so much.
inline constexpr StartScales prior_of_start = {1e-4, 0.3, 1.0, 20.0};
/// Mean square over the noise from which on a window counts as thrown off: a thorough evaluation then tries all guesses of its
/// start.
inline constexpr double thrown_off = 1.5;
/// Share of a window's squares that its start may still win for the linear step to be trusted.
inline constexpr double linear_share = 0.1;

/// What is unknown of the state in which a window begins: the mechanics but the shaft's turning, the four currents and, as
/// they hold what the sensors' offsets seem to ask for, the four integrators.
class StartUnknowns {
 public:
  StartUnknowns(const Machine<double>& machine, const Model& model, Spin spin);

  int size() const { return free_ + 4 + (ki_ > 0.0 ? 4 : 0); }
  bool hasRing() const { return ring_ >= 0; }
  double ringSpeed(const MachineState<double>& state, int end) const { return state.mechanics[ring_ + end]; }
  void setRingSpeeds(MachineState<double>& state, const std::array<double, 2>& speeds) const;
  void takeRingSpeeds(MachineState<double>& state, const MachineState<double>& from) const;
  /// Whether a state is one of this machine's at all: kept ones may be from before the first evaluation.
  bool belongs(const MachineState<double>& state) const { return static_cast<int>(state.mechanics.size()) == mechanics_; }
  double scale(int unknown, const StartScales& scales) const;
  double value(const MachineState<double>& state, int unknown) const;
  MachineState<double> moved(MachineState<double> state, const Eigen::VectorXd& step) const;
  /// Adds what the prior about a guess gives to normal equations of the unknowns about another state.
  void addPrior(const MachineState<double>& guess, const MachineState<double>& at, Eigen::MatrixXd& h, Eigen::VectorXd& b) const;
  /// A change of one unknown, as a lane of a prediction takes it.
  std::vector<double> change(int unknown, double by) const;

 private:
  int mechanics_, free_, coordinates_, electrics_, filter_order_, ring_, mount_;
  double ki_;
};

/// What all windows of a run share while it is evaluated once.
struct WindowedRun {
  /// @param given  the base, then one model for each coordinate that is moved, by `steps`
  WindowedRun(const Recording& recording, const std::vector<Model>& given, std::vector<double> steps, const LocalState& state,
              bool with_offsets);
  WindowedRun(const WindowedRun&) = delete;
  WindowedRun& operator=(const WindowedRun&) = delete;

  const Model& base() const { return models[0]; }
  int coordinates() const { return static_cast<int>(steps.size()); }
  int offsetUnknowns() const { return offsets ? 2 * axis_count : 0; }  ///< offsets, drifts of the sensors

  const Recording& rec;
  std::vector<Model> models;
  std::vector<double> steps;
  const LocalState& local;  ///< the run's angle, offsets and drifts
  bool offsets;
  Stretch whole;
  Machine<double> machine;
  StartUnknowns unknowns;
  double channels;  ///< that are measured
};

class ContactWindow {
 public:
  ContactWindow(const WindowedRun& run, long first, long last);

  long samples() const { return samples_; }
  double residuals() const { return static_cast<double>(samples_) * run_.channels; }
  /// What the sensors' offsets add to a prediction that knows nothing of them.
  double offset(int channel, long sample) const;

  /// Predicts the window from `start`, with a column for each unknown of it and, where asked for, each coordinate before
  /// these; fills everything below. False: a prediction does not stay finite.
  /// @param known  the base's prediction, where there is one (then `end` stays as it is); empty: none
  bool linearise(bool with_coordinates, const std::vector<double>& known = {});
  /// What Newton's step of the start alone would take off the squares; the linearisation had the coordinates.
  double ownGain() const;
  /// Searches the start anew from the guess that predicts best; where `thorough`, from the next ones, too, until one is good.
  /// Where none is and `grow`, each start is then fitted to the beginning of the window first: with the first impacts right
  /// the later ones come within reach. Linearised at the end; false: see there, or no guess stays finite.
  bool search(std::vector<MachineState<double>> guesses, int passes, bool thorough, bool grow);

  MachineState<double> start, guess;  ///< where it begins, about what its prior stands
  Eigen::MatrixXd h;                  ///< coordinates, unknowns of the start, offsets
  Eigen::VectorXd b;
  double squares = 0.0;
  MachineState<double> end;
  std::vector<MachineState<double>> ends;  ///< of the unknowns' columns, where a ring goes on from there
  std::vector<double> predicted;           ///< the base's comes first

 private:
  double shareOfDrift(long sample) const;
  /// A prediction of the base or another model from where the window begins.
  LaneJob jobFrom(const Model& model, const MachineState<double>& from) const;
  std::vector<MachineState<double>> byPrediction(std::vector<MachineState<double>> guesses) const;
  double squaresOf(const double* out) const;
  /// What predictions from these starts leave; 1e300: one that does not stay finite. `outs`: the predictions, one behind another.
  std::vector<double> squaresFrom(const std::vector<MachineState<double>>& starts, std::vector<double>& outs) const;
  struct Step {
    double damping;
    MachineState<double> to;
  };
  /// Steps of the start by the normal equations, damped more and less.
  std::vector<Step> stepsFromHere(double damping) const;
  /// Moves the start to where it fits best about `guess`; the squares that are left.
  double refine(int passes);

  const WindowedRun& run_;
  Stretch stretch_;
  long first_, samples_, used_;  ///< used: from the window's beginning, see search
};

}  // namespace amb_rotor
