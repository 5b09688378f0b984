// Runs without contact: predicted in one piece from the settled state.
#include <algorithm>
#include <array>
#include <cmath>

#include "amb_rotor/common/linear_algebra.hpp"
#include "amb_rotor/common/units.hpp"
#include "amb_rotor/validation/fit.hpp"
#include "amb_rotor/validation/loop_offsets.hpp"
#include "amb_rotor/validation/stretches.hpp"
#include "free_columns.hpp"

namespace amb_rotor {
namespace {

/// Of offsets that go round the loop, and of their drift over a run [m].
constexpr double offset_step_m = 1e-7;
/// Length of the blocks whose scores are taken as independent [s]: several times what a mode rings on that is next to unstable.
constexpr double score_block_s = 0.2;
/// Angles tried at standstill: over the whole turn, then about the best. The hills of a crack, which opens over a small
/// angle, are narrow; what else turns with the shaft goes by sine and cosine.
constexpr int angle_grid = 16, crack_grid = 64, fine_grid = 8;
constexpr std::size_t most_hollows = 3;
/// How far a run's angle and speed go from those of its first turns, in standard deviations; and how much stiffer what has
/// come so far is than it was.
constexpr double most_clock_deviations = 3.0, held_there = 1e6;
/// How often that is done before the angle only moves with the fit.
constexpr int most_angle_searches = 2;
/// Of a run so much is searched within a fit [s], which moves the angle further; to judge, all of it.
constexpr double angle_search_s = 0.3;

/// Mean square of a residual over the noise above which a machine that is not linear may have settled elsewhere than the rig.
constexpr double far_off = 4.0;
/// Share of the sum of squares that must be left where the run-in begins at the other end.
constexpr double much_less = 0.5;

/// Where a run's prediction begins: settled from rest, or from the motion that was measured at its begin. A motion that bends
/// its own resonance can settle in more than one place.
class Beginning {
 public:
  Beginning(const Recording& rec, const Model& model, const Stretch& stretch, bool from_motion) : stretch_(stretch) {
    if (!from_motion) return;
    const double speed = std::fabs(rec.startingSpeed());
    if (speed > 0.0) stretch_.settle_s = std::ceil(stretch.settle_s * speed / two_pi) * two_pi / speed;
    motion_ = stateFromMeasurement(rec, model, stretch.spin, 0);
    moving_ = true;
  }
  static bool canMove(const Recording& rec) {
    return std::all_of(rec.noise.begin(), rec.noise.begin() + 4, [](double noise) { return noise > 0.0; });
  }
  const Stretch& stretch() const { return stretch_; }
  const MachineState<double>* motion() const { return moving_ ? &motion_ : nullptr; }

 private:
  Stretch stretch_;
  MachineState<double> motion_;
  bool moving_ = false;
};

/// Sum of squares over the noise of the first `samples`, with the best constant offset of each displacement channel
/// within its prior.
double sumOfSquares(const Recording& rec, long samples, const std::vector<double>& out, double offset_std) {
  double sum = 0.0;
  for (int c = 0; c < predicted_channels; ++c) {
    if (rec.noise[c] <= 0.0) continue;
    double mean = 0.0, square = 0.0;
    for (long i = 0; i < samples; ++i) {
      const double r = (rec.measured[i * predicted_channels + c] - out[i * predicted_channels + c]) / rec.noise[c];
      mean += r;
      square += r * r;
    }
    const double prior = offset_std > 0.0 ? std::pow(rec.noise[c] / offset_std, 2) : 0.0;
    sum += c < 4 && offset_std > 0.0 ? square - mean * mean / (samples + prior) : square;
  }
  return sum;
}

/// Sums of squares at angles of the standing shaft; 1e300: not finite.
std::vector<double> sumsAtAngles(const Recording& rec, const Model& model, const Stretch& stretch, double offset_std,
                                 const std::vector<double>& angles) {
  std::vector<std::vector<double>> outs(angles.size(), std::vector<double>(stretch.last * predicted_channels));
  std::vector<LaneJob> jobs;
  for (std::size_t k = 0; k < angles.size(); ++k) {
    jobs.push_back(jobOf(rec, model, angles[k]));
    jobs.back().out = outs[k].data();
  }
  predict(stretch, jobs);
  std::vector<double> sums(angles.size(), 1e300);
  for (std::size_t k = 0; k < angles.size(); ++k)
    if (jobs[k].finite) sums[k] = sumOfSquares(rec, stretch.last, outs[k], offset_std);
  return sums;
}

/// At which the prediction comes nearest: the whole turn, then about its lowest hollows, of which a narrow one may be the
/// deeper between two angles tried. None of them finite: `now`.
double standstillAngle(const Recording& rec, const Model& model, const Stretch& stretch, double offset_std, double now) {
  const bool crack = std::any_of(model.effects.begin(), model.effects.end(),
                                 [](const EffectSetting& effect) { return effect.id == "shaft_crack"; });
  const int turn_grid = crack ? crack_grid : angle_grid;
  const double spacing = two_pi / turn_grid;
  std::vector<double> turn;
  for (int k = 0; k < turn_grid; ++k) turn.push_back(spacing * k);
  const std::vector<double> sums = sumsAtAngles(rec, model, stretch, offset_std, turn);
  std::vector<int> hollows;
  for (int k = 0; k < turn_grid; ++k)
    if (sums[k] < 1e300 && sums[k] <= sums[(k + 1) % turn_grid] && sums[k] <= sums[(k + turn_grid - 1) % turn_grid])
      hollows.push_back(k);
  std::sort(hollows.begin(), hollows.end(), [&](int one, int other) { return sums[one] < sums[other]; });
  if (hollows.size() > most_hollows) hollows.resize(most_hollows);
  std::vector<double> near;
  for (const int k : hollows)
    for (int i = 0; i < fine_grid; ++i) near.push_back(spacing * (k - 1 + 2.0 * i / (fine_grid - 1)));
  if (near.empty()) return now;
  const std::vector<double> finer = sumsAtAngles(rec, model, stretch, offset_std, near);
  const long best = std::min_element(finer.begin(), finer.end()) - finer.begin();
  if (best % fine_grid == 0 || best % fine_grid == fine_grid - 1 || finer[best - 1] >= 1e300 || finer[best + 1] >= 1e300)
    return near[best];
  const double bend = finer[best - 1] - 2.0 * finer[best] + finer[best + 1];  // of the parabola through the three
  const double share = bend > 0.0 ? 0.5 * (finer[best - 1] - finer[best + 1]) / bend : 0.0;
  return near[best] + share * (near[best + 1] - near[best]);
}

/// Whether a motion may settle in more than one place. A crack's stiffness goes with the turns and not with the motion.
bool bendsResonances(const Stretch& stretch, const Model& model) {
  Model without = model;
  auto& effects = without.effects;
  effects.erase(std::remove_if(effects.begin(), effects.end(), [](const EffectSetting& e) { return e.id == "shaft_crack"; }),
                effects.end());
  return !predictsExactly(stretch, without);
}

/// Whether the prediction comes much nearer where it begins at the other end than it did in `base`.
bool beginsElsewhere(const Recording& rec, const Stretch& stretch, bool from_motion, LaneJob job,
                     const std::vector<double>& base, double offset_std) {
  if (!Beginning::canMove(rec) || !bendsResonances(stretch, *job.model)) return false;
  const Beginning other(rec, *job.model, stretch, !from_motion);
  std::vector<double> out(static_cast<std::size_t>(rec.samples) * predicted_channels);
  job.out = out.data();
  job.settle_from = other.motion();
  std::vector<LaneJob> jobs = {job};
  predict(other.stretch(), jobs);
  return jobs[0].finite &&
         sumOfSquares(rec, rec.samples, out, offset_std) < much_less * sumOfSquares(rec, rec.samples, base, offset_std);
}

}  // namespace

NormalEquations FitProblem::evaluateFree(const std::vector<Model>& given, const std::vector<int>& moved,
                                         const Recording& rec, LocalState& local, const EvaluationOptions& options,
                                         RunResult& result) const {
  const int p = space_.size();
  const int lanes = static_cast<int>(given.size());
  NormalEquations normal(p);
  const bool trial = !rec.run.unbalance.empty();
  const std::vector<Model> extended = trial ? withTrialWeights(given, rec) : std::vector<Model>();
  const std::vector<Model>& models = trial ? extended : given;
  Stretch stretch = stretchOf(rec, models[0]);
  // when the model has moved, and where it counts; never shorter, or two evaluations would differ by it
  const int evaluation = local.evaluations++;
  const bool looked_at = evaluation == 0 || evaluation == 2 || evaluation == 8 || options.thorough;
  if (looked_at)
    local.run_in_s = std::max(local.run_in_s, settledRunIn(rec, models[0], stretch, local.angle_rad));
  stretch.settle_s = std::max(stretch.settle_s, local.run_in_s);
  const long n = rec.samples;
  const std::size_t width = static_cast<std::size_t>(n) * predicted_channels;
  const bool angle = rec.standstill && dependsOnAngle(models[0]);
  const bool turning = rec.angle_std_rad > 0.0 && rec.speed_std_rad_s > 0.0;

  if (angle && local.angle_searches < most_angle_searches) {
    // again while the model still moves
    ++local.angle_searches;
    Stretch searched = stretch;
    if (options.all_or_nothing)
      searched.last = std::min(n, std::max<long>(1, static_cast<long>(angle_search_s * rec.run.sample_rate_hz)));
    local.angle_rad = standstillAngle(rec, models[0], searched, offset_std_, local.angle_rad);
  }

  // lanes: base, one for each coordinate, then the shaft's: one for the angle, one for a constant speed
  std::vector<LaneJob> jobs;
  const Eigen::VectorXd taken_offsets = offsetsInLanes(rec, local, offset_std_);
  const auto add = [&](const Model& model, double more_angle, double more_speed) {
    jobs.push_back(jobOf(rec, model, local.angle_rad + more_angle));
    takeOffsets(rec, taken_offsets, jobs.back());
    if (turning) turnShaft(rec, {local.turning.rad + more_angle, local.turning.rad_s + more_speed}, jobs.back());
  };
  for (int k = 0; k < lanes; ++k) add(models[k], 0.0, 0.0);
  const Beginning beginning(rec, models[0], stretch, local.from_motion);
  const double speed_step = angle_step_rad / rec.duration();
  if (angle || turning) add(models[0], angle_step_rad, 0.0);
  if (turning) add(models[0], 0.0, speed_step);
  // what offsets in the loop show beside an effect may be several times what the believed loop makes of them (a stiffness that is
  // nearly gone), and steps by that would lead away
  const bool own_offsets = offset_std_ > 0.0 && rec.offsets_in_loop && !models[0].effects.empty();
  const std::size_t first_offset = jobs.size();
  for (int k = 0; k < 2 * axis_count && own_offsets; ++k) {
    Eigen::VectorXd moved_offsets = taken_offsets;
    moved_offsets[k] += offset_step_m;
    add(models[0], 0.0, 0.0);
    takeOffsets(rec, moved_offsets, jobs.back());
  }
  std::vector<double> outs(width * jobs.size());
  for (std::size_t k = 0; k < jobs.size(); ++k) {
    jobs[k].out = outs.data() + k * width;
    jobs[k].settle_from = beginning.motion();
  }
  predict(beginning.stretch(), jobs);
  for (const auto& job : jobs) normal.finite = normal.finite && job.finite;
  result.finite = jobs[0].finite;
  if (!normal.finite) {
    normal.chi2 = normal.squares = 1e300;
    result.mean_square = 1e300;
    return normal;
  }

  // columns: coordinates (where asked), the shaft's, offsets, drifts
  const int g = static_cast<int>(moved.size()), frozen = g - (lanes - 1);
  const int la = angle ? 1 : turning ? 2 : 0;  // the shaft's
  const bool offsets = offset_std_ > 0.0, in_loop = offsets && rec.offsets_in_loop;
  const int lc = la + (in_loop ? 2 * axis_count : 0);  // the shaft's, and offsets and drifts that are predicted
  const int local_size = la + (offsets ? 2 * axis_count : 0);
  const int size = g + local_size;
  std::vector<const float*> known;
  for (int k = 0; k < frozen; ++k)
    known.push_back(options.frozen->of_recording.at(static_cast<int>(&rec - recordings_.data()))->col(moved[k]).data());
  const double shaft_step[2] = {angle_step_rad, speed_step};
  std::vector<double> steps;
  for (int k = frozen; k < g; ++k) steps.push_back(free_steps_[moved[k]]);
  for (int k = 0; k < la; ++k) steps.push_back(shaft_step[k]);
  for (std::size_t k = first_offset; k < jobs.size(); ++k) steps.push_back(offset_step_m);
  const FreeColumns columns(rec, std::move(known), outs, steps, in_loop && !own_offsets);
  const ChannelProducts sums = columns.products();
  const int dense = g + lc;  // columns that come from predictions
  const int one = columns.one(), residual = columns.residual();
  Eigen::MatrixXd gram = Eigen::MatrixXd::Zero(size, size);
  Eigen::VectorXd right = Eigen::VectorXd::Zero(size);
  double squares = 0.0, count = 0.0;
  std::array<Eigen::MatrixXd, predicted_channels> products;
  for (int c = 0; c < predicted_channels; ++c) {
    if (rec.noise[c] <= 0.0) continue;
    const Eigen::MatrixXd& small = products[c] = sums.of(c);
    squares += small(residual, residual);
    count += static_cast<double>(n);
    gram.topLeftCorner(dense, dense) += small.topLeftCorner(dense, dense);
    right.head(dense) += small.col(residual).head(dense);
    if (!offsets || in_loop || c >= 4) continue;
    const int o = dense + c, d = dense + 4 + c;
    for (int which = 0; which < 2; ++which) {
      const int at = which == 0 ? o : d;
      gram.block(0, at, dense, 1) += small.block(0, one + which, dense, 1);
      gram.block(at, 0, 1, dense) += small.block(one + which, 0, 1, dense);
      right[at] += small(one + which, residual);
      gram(at, at) += small(one + which, one + which);
    }
    gram(o, d) += small(one, one + 1);
    gram(d, o) += small(one, one + 1);
  }
  // eliminate the local unknowns
  Eigen::VectorXd solved = Eigen::VectorXd::Zero(local_size), weights = solved, away = solved;  // priors: 1/variance, from 0
  if (angle) weights[0] = 1e-6;
  if (turning) {
    weights[0] = 1.0 / (rec.angle_std_rad * rec.angle_std_rad);
    weights[1] = 1.0 / (rec.speed_std_rad_s * rec.speed_std_rad_s);
    away[0] = local.turning.rad;
    away[1] = local.turning.rad_s;
  }
  if (offsets) {
    weights.tail(8).setConstant(1.0 / (offset_std_ * offset_std_));
    away.tail(8) = taken_offsets;
  }
  Eigen::MatrixXd cross(local_size, g);
  if (local_size > 0) {
    Eigen::MatrixXd own = gram.bottomRightCorner(local_size, local_size);
    own.diagonal() += weights;
    Eigen::VectorXd pull = right.tail(local_size) - weights.cwiseProduct(away);
    solved = Ldlt(own).solve(pull);
    // a model that is wrong must not turn the shaft for it: what would go further than the pulses allow stays at that end
    for (int k = 0; k < la && turning; ++k) {
      const double most = most_clock_deviations / std::sqrt(weights[k]);
      if (std::fabs(away[k] + solved[k]) <= most) continue;
      const double end = std::copysign(most, away[k] + solved[k]) - away[k];
      own(k, k) += held_there * own(k, k);
      pull[k] += held_there / (1.0 + held_there) * own(k, k) * end;
      solved = Ldlt(own).solve(pull);
    }
    const Ldlt factor(own);
    cross = factor.solveColumns(gram.bottomLeftCorner(local_size, g));
    normal.h(moved, moved) =
        gram.topLeftCorner(g, g) - gram.topRightCorner(g, local_size) * cross;
    normal.g(moved) = right.head(g) - gram.topRightCorner(g, local_size) * solved;
  } else {
    normal.h(moved, moved) = gram;
    normal.g(moved) = right;
  }
  normal.count = count;
  // what is left of the residual itself, the local unknowns' priors apart
  double left = squares;
  if (local_size > 0) {
    const Eigen::MatrixXd own = gram.bottomRightCorner(local_size, local_size);
    left = squares - 2.0 * right.tail(local_size).dot(solved) + solved.dot(own * solved);
  }
  // squares below 0 by more than the noise: sums so large that nothing is left but how they are rounded, of a prediction that ran away
  if (left < -count) {
    normal.finite = result.finite = false;
    normal.chi2 = normal.squares = result.mean_square = 1e300;
    return normal;
  }
  result.mean_square = left / count;
  if (looked_at && result.mean_square > far_off &&
      beginsElsewhere(rec, stretch, local.from_motion, jobs[0], outs, offset_std_)) {
    local.from_motion = !local.from_motion;
    return evaluateFree(given, moved, rec, local, options, result);
  }
  if (angle) local.angle_rad += std::min(std::max(solved[0], -0.5), 0.5);
  if (turning) {
    local.turning.rad += solved[0];
    local.turning.rad_s += solved[1];
  }
  for (int a = 0; a < 4 && offsets; ++a) {
    local.offset_m[a] = taken_offsets[a] + solved[la + a];
    local.drift_m[a] = taken_offsets[4 + a] + solved[la + 4 + a];
  }
  normal.squares = left;
  away += solved;
  normal.chi2 = left + away.dot(weights.cwiseProduct(away));
  std::array<Eigen::VectorXd, predicted_channels> taken;  // of the columns, which leave what the local unknowns do not show
  for (int c = 0; c < predicted_channels; ++c) {
    if (rec.noise[c] <= 0.0) continue;
    taken[c] = Eigen::VectorXd::Zero(columns.size());
    taken[c].segment(g, lc) = -solved.head(lc);
    if (offsets && !in_loop && c < 4) taken[c].segment(one, 2) << -solved[la + c], -solved[la + 4 + c];
    taken[c][residual] = 1.0;
    result.channel_mean_square[c] = taken[c].dot(products[c] * taken[c]) / n;
  }

  if (options.scores && g > 0) {
    const long length = std::max<long>(1, static_cast<long>(score_block_s * rec.run.sample_rate_hz));
    std::array<Eigen::MatrixXd, predicted_channels> freed;  // likewise of each coordinate's column
    for (int c = 0; c < predicted_channels; ++c) {
      freed[c] = Eigen::MatrixXd::Identity(g, columns.size());
      freed[c].middleCols(g, lc) = -cross.topRows(lc).transpose();
      if (offsets && !in_loop && c < 4)
        for (int which = 0; which < 2; ++which) freed[c].col(one + which) = -cross.row(la + 4 * which + c).transpose();
    }
    const Eigen::MatrixXd scores = columns.blockProducts(length, taken, freed);
    normal.scores(moved, moved) = scores * scores.transpose();
  }
  if (options.keep_prediction) {
    result.predicted.assign(outs.begin(), outs.begin() + static_cast<long>(width));
    for (std::size_t at = 0; at < width; ++at)
      for (int k = 0; k < la; ++k)
        result.predicted[at] += (outs[(lanes + k) * width + at] - outs[at]) / shaft_step[k] * solved[k];
    for (std::size_t at = 0; at < width && in_loop; ++at)
      for (int k = la; k < lc; ++k)
        result.predicted[at] += solved[k] * (own_offsets ? (outs[(first_offset + k - la) * width + at] - outs[at]) / offset_step_m
                                                         : rec.offset_columns[at * 2 * axis_count + (k - la)]);
    for (long i = 0; i < n && !in_loop; ++i)
      for (int a = 0; a < 4; ++a)
        result.predicted[i * predicted_channels + a] +=
            local.offset_m[a] + local.drift_m[a] * (static_cast<double>(i) / n - 0.5);
  }
  return normal;
}

}  // namespace amb_rotor
