#pragma once
// Least squares of a model against recordings, with everything that belongs to one run or window only eliminated
// on the spot (Schur complement), so that a fit has as many unknowns as the machine has parameters.
//
// Local unknowns: of a run, the offset and the linear drift of each sensor (they lie in the recording alone, or go round the
// control loop where the data say so: loop_offsets.hpp), at standstill the shaft's angle where the model depends on it, at a constant speed what the
// first turns leave open of angle and speed (their pulses' times are rounded); of a window of 10 ms in a run with contact,
// its starting mechanics, currents and integrators besides.
#include <Eigen/Core>
#include <functional>
#include <limits>
#include <map>
#include <memory>
#include <vector>

#include "amb_rotor/validation/coordinates.hpp"
#include "amb_rotor/validation/recording.hpp"

namespace amb_rotor {

/// Length of a prediction through contact [s].
constexpr double contact_window_s = 0.01;

/// Finite differences of predictions without contact, over a coordinate's scale. These are smooth to round-off, and what a
/// difference is off by adds curvature to valleys that are nearly flat (a sensor's gain against Ki), where fits then stop.
constexpr double step_without_contact = 0.0005;
constexpr double angle_step_rad = 5e-4;  ///< of the shaft's angle; of a speed, at the end of the run

/// Part of the noise that a model may be off by in every residual alike without being found out: clocks, integrators and
/// calibrations are no better. It adds share^2 times the number of residuals to the variances that white noise gives.
constexpr double shared_misfit = 0.003;

/// What windows through contact make up of normal equations whose columns were asked for; empty: none do.
struct WindowsShare {
  Eigen::MatrixXd h;
  Eigen::VectorXd g;
  double chi2 = 0.0, count = 0.0;

  bool empty() const { return g.size() == 0; }
};

/// Quadratic model of half the sum of squares about a point: H, g, and the sum itself.
struct NormalEquations {
  Eigen::MatrixXd h;
  Eigen::VectorXd g;   ///< minus the gradient of half the sum of squares
  double chi2 = 0.0;   ///< with the priors of the local unknowns, without those of the coordinates
  double squares = 0.0;  ///< of the residuals alone, each over its noise
  double count = 0.0;  ///< residuals
  double occam = 0.0;  ///< log det of the windows' unknowns' curvature over their priors': what free starts cost
  double starts = 0.0;  ///< number of these unknowns
  WindowsShare windows;
  Eigen::MatrixXd scores;  ///< sum over blocks of time of the outer product of their scores
  bool finite = true;
  int ended_at = -1;   ///< of the recordings asked for, the one behind which the others are of no use; -1: none

  explicit NormalEquations(int size = 0)
      : h(Eigen::MatrixXd::Zero(size, size)), g(Eigen::VectorXd::Zero(size)), scores(Eigen::MatrixXd::Zero(size, size)) {}
  void add(const NormalEquations& other);
};

/// What belongs to one recording only and is kept from one evaluation to the next.
struct LocalState {
  int angle_searches = 0;                ///< over the whole turn, so far
  double angle_rad = 0.0;                ///< at standstill
  ShaftTurn turning;
  int evaluations = 0;                   ///< without contact, so far
  double run_in_s = 0.0;                 ///< the longest that one of them has needed
  bool from_motion = false;              ///< the run-in begins at the measured motion, where that comes much nearer than from rest
  std::vector<MachineState<double>> window_start;  ///< of each window; without mechanics: not yet
  std::vector<std::array<double, 2>> window_ring;  ///< rings' speeds beyond those that the window before led to [rad/s]
  std::vector<Eigen::MatrixXd> window_response;    ///< how it moves with the coordinates, about those of the start
  Eigen::MatrixXd run_response;                    ///< how offsets, then drifts, move with them: a window begins at both
  Eigen::VectorXd window_at;                       ///< the coordinates that the starts belong to
  double offset_m[4] = {0, 0, 0, 0}, drift_m[4] = {0, 0, 0, 0};  ///< drift: over the whole run
};

/// A run's unknowns without the windows' starts and the offsets that a model has led to.
LocalState begunAnew(const LocalState& state);
std::vector<LocalState> begunAnew(std::vector<LocalState> states);

struct RunResult {
  double mean_square = 0.0;             ///< of the residual over the noise; 1 is the floor
  double window_mean_square = 0.0;
  std::vector<double> predicted;        ///< samples * predicted_channels, with offset and drift; where asked for
  std::array<double, predicted_channels> channel_mean_square{};
  bool finite = true;
  bool stands = false;  ///< through contact: no window is thrown off, and another evaluation would hardly take anything off
};

/// Derivatives of the predictions, over the noise, taken once about a point near by: of the first `size` coordinates, for
/// recordings without contact. A row for each channel at each instant, a column for each coordinate.
struct FrozenColumns {
  int size = 0;
  std::map<int, const Eigen::MatrixXf*> of_recording;
};

struct EvaluationOptions {
  bool jacobian = true;
  const FrozenColumns* frozen = nullptr;  ///< instead of predictions of their own; recordings without contact only
  std::vector<bool> held;    ///< coordinates that stay where they are: no columns for them (empty: none)
  bool scores = false;       ///< fill NormalEquations::scores
  bool keep_prediction = false;
  int window_passes = 1;     ///< refinements of the windows' starts
  int window_stride = 1;     ///< of tenths of a second: only every so many-th
  int window_offset = 0;     ///< the first of them
  double window_s = contact_window_s;  ///< length of a window through contact
  bool thorough = false;     ///< try every guess of a start where a window is left far off: for errors that are reported
  bool all_or_nothing = false;  ///< a window whose prediction does not stay finite ends the run's evaluation
  /// Of a step that is tried: the chi2 from which on it is not taken. Once the recordings evaluated so far leave more, or one does
  /// not stay finite, the others are spared, and the sum is not finite.
  double useful_chi2 = std::numeric_limits<double>::infinity();
  int first = 0;  ///< of the recordings asked for, the one to begin with
};

/// One model class (belief and fitted effects) against recordings.
class FitProblem {
 public:
  /// @param recordings  must outlive the problem
  FitProblem(const std::vector<Recording>& recordings, const FitSpace& space, double offset_std_m);

  const FitSpace& space() const { return space_; }
  bool holdsContact(int recording) const { return recordings_[recording].holdsContact(); }
  /// Whether an evaluation leads on from what the one before has left of the run.
  bool settlesByPasses(int recording) const { return holdsContact(recording) || recordings_[recording].offsets_in_loop; }
  /// Whether an evaluation estimates windows with the sensors' offsets that the one before has found.
  bool findsOffsetsByWindows(int recording) const { return holdsContact(recording) && offset_std_ > 0.0; }
  /// Evaluates the recordings of the given indices (into the list of the constructor), in parallel.
  NormalEquations evaluate(const Eigen::VectorXd& x, const std::vector<int>& which, std::vector<LocalState>& local,
                           const EvaluationOptions& options, std::vector<RunResult>* results = nullptr) const;

 private:
  /// @param models  the base, then one with each of the coordinates `moved` a step on; those that are frozen come first
  ///                in `moved` and have none
  NormalEquations evaluateFree(const std::vector<Model>& models, const std::vector<int>& moved, const Recording& rec,
                               LocalState& local, const EvaluationOptions& options, RunResult& result) const;
  NormalEquations evaluateWindows(const Eigen::VectorXd& x, const std::vector<Model>& models, const std::vector<int>& moved,
                                  const Recording& rec, LocalState& local, const EvaluationOptions& options,
                                  RunResult& result) const;
  bool dependsOnAngle(const Model& model) const;

  const std::vector<Recording>& recordings_;
  const FitSpace& space_;
  double offset_std_;
  std::vector<double> steps_, free_steps_;  ///< of the finite differences, through contact and without
};

/// Evaluates runs until what belongs to them alone stands: windows, and loops that offsets go round, count with the offsets of their run
/// only once those are known, and lead on from where they were left. Other runs need one evaluation.
/// @param results  of the last one
void evaluateSettled(const FitProblem& problem, const Eigen::VectorXd& x, const std::vector<int>& which, std::vector<LocalState>& local,
                     const EvaluationOptions& options, std::vector<RunResult>& results);

struct FitOptions {
  int most_iterations = 8;
  std::function<bool()> give_up;  ///< asked before each iteration: true ends the fit where it is (may be empty)
  double tolerance = 1e-4;   ///< relative change of chi2 that ends the fit
  int first_window_passes = 9, window_passes = 3;  ///< refinements of the windows' starts in the first evaluation, and later
  int window_stride = 1, window_offset = 0;  ///< see EvaluationOptions
  double window_s = contact_window_s;  ///< see EvaluationOptions
  bool thorough_first = false;  ///< the first evaluation is thorough, see EvaluationOptions
  std::vector<bool> held;    ///< see EvaluationOptions
  const FrozenColumns* frozen = nullptr;  ///< see EvaluationOptions
  int attempts = 6;          ///< damped steps tried in an iteration
  /// An iteration's first attempt brings the columns that the next one needs, too: cheaper where most steps do well at once.
  /// Without it such a step is evaluated twice, and what belongs to one run alone (its shaft's angle) moves twice.
  bool columns_at_once = false;
  bool covariance = true;    ///< linearise once more at the end; false: the covariance is that of the last iteration
  bool scores = false;       ///< fill the robust covariance
};

struct FitResult {
  Eigen::VectorXd x;
  Eigen::MatrixXd covariance;  ///< of the coordinates; where scores were asked for, robust against coloured noise and
                               ///< with the shared misfit
  double chi2 = 0.0;           ///< with all priors
  double squares = 0.0, count = 0.0;
  int iterations = 0;
  bool finite = true;
  NormalEquations normal;      ///< at x, without the coordinates' priors
};

/// Levenberg and Marquardt over the given recordings. `extra` is a quadratic prior on the first coordinates from data
/// that are not evaluated again (may be null): half (x - centre)' H (x - centre).
struct QuadraticPrior {
  Eigen::MatrixXd h;
  Eigen::VectorXd centre;
  double chi2 = 0.0;
};
/// Iterations at most of a fit that begins at the beliefs: a model that carries an effect may be next to its stability's limit there, and
/// far off. One that begins near ends after eight.
constexpr int most_iterations_from_belief = 40;
FitResult fit(const FitProblem& problem, const Eigen::VectorXd& start, const std::vector<int>& which,
              std::vector<LocalState>& local, const FitOptions& options, const QuadraticPrior* extra = nullptr);

/// A fit that begins at the beliefs. Where the motion does not stay finite there, at the place of least chi2 beside them, each moved by one
/// and two of its deviations alone (at the beliefs again where none of these stays finite either). Next to its stability's limit a loop has
/// hollows: where the fit leaves plainly more than the noise and one of those places leaves less than it, also from there, and the better.
FitResult fitFromBelief(const FitProblem& problem, const std::vector<int>& which, std::vector<LocalState>& local, const FitOptions& options);

}  // namespace amb_rotor
