// Runs with contact: predicted over consecutive windows of 10 ms, each from its own estimated starting state.
#include <algorithm>
#include <cmath>

#include "amb_rotor/common/linear_algebra.hpp"
#include "contact_window.hpp"

namespace amb_rotor {
namespace {

constexpr double score_floor = 1e-12;
/// Mean square over the noise beyond which a window's squares count by their logarithm: one that an impact has thrown off must
/// not outweigh all others.
constexpr double robust_excess = 3.0;
/// Share of the squares that the steps of starts and offsets may still take where a run stands.
constexpr double standing_share = 0.002;
/// Windows that a first look takes or leaves together span so much: what no sensor sees (a mount, a ring) is known only from
/// the window before.
constexpr double group_s = 10 * contact_window_s;

struct Extent {
  long first, last;
};

std::vector<Extent> extentsOf(const Recording& rec, double window_s) {
  std::vector<Extent> out;
  const long length = std::max<long>(8, std::lround(window_s * rec.run.sample_rate_hz));
  for (long first = 0; first + length / 2 <= rec.samples; first += length)
    out.push_back({first, std::min(first + length, rec.samples)});
  if (!out.empty()) out.back().last = rec.samples;
  return out;
}

/// Turns the columns of coordinates that stand at their upper limit: they were moved downwards.
void turnColumnsAtLimit(Eigen::MatrixXd& response, const FitSpace& space, const Eigen::VectorXd& x,
                        const std::vector<int>& moved, const std::vector<double>& steps) {
  for (const int k : moved)
    if (x[k] + steps[k] > space.coordinates()[k].upper) response.col(k) *= -1.0;
}

/// The starts and the run's offsets follow the coordinates to first order, a step of all together, as in multiple shooting.
/// Returns how far the coordinates have come; empty: nothing to follow from.
Eigen::VectorXd followCoordinates(LocalState& local, const Eigen::VectorXd& x, std::size_t windows) {
  if (local.window_start.size() != windows) local.window_start.assign(windows, {});
  if (local.window_ring.size() != windows) local.window_ring.assign(windows, {});
  Eigen::VectorXd way;
  if (local.window_at.size() == x.size() && local.window_response.size() == windows) {
    way = x - local.window_at;
    if (local.run_response.size() > 0) {
      const Eigen::VectorXd along = local.run_response * way;
      for (int a = 0; a < 4; ++a) {
        local.offset_m[a] += along[a];
        local.drift_m[a] += along[4 + a];
      }
    }
  } else {
    local.window_response.assign(windows, {});
    local.run_response.resize(0, 0);
  }
  local.window_at = x;
  return way;
}

/// A window's normal equations with its start eliminated.
struct Eliminated {
  Eigen::MatrixXd h;         ///< coordinates, then the run's offsets
  Eigen::VectorXd g;
  Eigen::MatrixXd response;  ///< of the start to the coordinates
  Eigen::VectorXd step;      ///< Newton's, of the start
  double gain = 0.0;         ///< that it takes off the squares
  double occam = 0.0;
};

Eliminated eliminateStart(const ContactWindow& window, const WindowedRun& run) {
  const int g = run.coordinates(), w = run.unknowns.size(), r = run.offsetUnknowns();
  std::vector<int> order;
  for (int k = 0; k < g; ++k) order.push_back(k);
  for (int k = 0; k < r; ++k) order.push_back(g + w + k);
  const Eigen::MatrixXd outer = window.h(order, order);
  const Eigen::MatrixXd between = window.h(order, Eigen::seqN(g, w));
  Eigen::MatrixXd own = window.h.block(g, g, w, w);
  Eigen::VectorXd own_b = window.b.segment(g, w);
  run.unknowns.addPrior(window.guess, window.start, own, own_b);
  const Ldlt factor(own);
  const Eigen::VectorXd pivots = factor.pivots();
  Eliminated out;
  for (int k = 0; k < w; ++k)
    out.occam += std::log(std::max(pivots[k], 1e-300)) + 2.0 * std::log(run.unknowns.scale(k, prior_of_start));
  out.step = factor.solve(own_b);
  if (g > 0) out.response = -factor.solveColumns(between.topRows(g).transpose());
  out.gain = std::max(0.0, own_b.dot(out.step));
  out.h = outer - between * factor.solveColumns(between.transpose());
  out.g = window.b(order) - between * out.step;
  return out;
}

/// Sums of a run over its windows, before its offsets are eliminated.
struct RunSums {
  RunSums(const WindowedRun& run, std::size_t windows)
      : h(Eigen::MatrixXd::Zero(run.coordinates() + run.offsetUnknowns(), run.coordinates() + run.offsetUnknowns())),
        g(Eigen::VectorXd::Zero(h.rows())),
        scores(Eigen::MatrixXd::Zero(run.coordinates(), static_cast<long>(windows))) {}

  /// The mean square that the window's own step leaves.
  double add(const ContactWindow& window, const Eliminated& part, std::size_t number) {
    const double left = std::max(window.squares - std::min(part.gain, 0.5 * window.squares), score_floor);
    const double residuals = window.residuals(), excess = std::max(0.0, left / residuals - 1.0);
    const double weight = 1.0 / (1.0 + excess / robust_excess);
    h += weight * part.h;
    g += weight * part.g;
    scores.col(static_cast<long>(number)) = weight * part.g.head(scores.rows());
    chi2 += excess > 0.0 ? residuals * (1.0 + robust_excess * std::log1p(excess / robust_excess)) : left;
    squares += std::max(window.squares - part.gain, score_floor);
    before += window.squares;
    count += residuals;
    occam += part.occam;
    starts += static_cast<double>(part.step.size());
    return left / residuals;
  }

  Eigen::MatrixXd h;
  Eigen::VectorXd g;
  Eigen::MatrixXd scores;
  double chi2 = 0.0, squares = 0.0, count = 0.0, occam = 0.0, starts = 0.0;
  double before = 0.0;  ///< squares before the steps of the windows' starts
};

void keepPrediction(const ContactWindow& window, long first, std::vector<double>& predicted) {
  for (long i = 0; i < window.samples(); ++i)
    for (int c = 0; c < predicted_channels; ++c)
      predicted[(first + i) * predicted_channels + c] = window.predicted[i * predicted_channels + c] + window.offset(c, i);
}

}  // namespace

NormalEquations FitProblem::evaluateWindows(const Eigen::VectorXd& x, const std::vector<Model>& given,
                                            const std::vector<int>& moved_coordinates, const Recording& rec,
                                            LocalState& local, const EvaluationOptions& options,
                                            RunResult& result) const {
  const int p = space_.size();
  std::vector<double> steps;
  for (std::size_t k = 0; k + 1 < given.size(); ++k) steps.push_back(steps_[moved_coordinates[k]]);
  const std::vector<Extent> extents = extentsOf(rec, options.window_s);
  const Eigen::VectorXd way = followCoordinates(local, x, extents.size());
  const WindowedRun run(rec, given, steps, local, offset_std_ > 0.0);
  const StartUnknowns& unknowns = run.unknowns;
  const int g = run.coordinates(), r = run.offsetUnknowns();
  const std::size_t lags = 4 * run.machine.relaxationRates().size();
  const long group_samples = std::max(1L, std::lround(group_s * rec.run.sample_rate_hz));
  NormalEquations normal(p);
  RunSums sums(run, extents.size());
  MachineState<double> led_to;                    // by the window before
  bool after_good = false, all_good = true;       // it is not thrown off, and no other
  std::array<double, 2> ring_speed = {0.0, 0.0};  // where the windows so far led; at rest in the beginning
  if (options.keep_prediction) result.predicted.assign(rec.samples * predicted_channels, 0.0);
  const auto left_out = [&] {
    led_to = {};
    after_good = false;
  };

  for (std::size_t number = 0; number < extents.size(); ++number) {
    const Extent extent = extents[number];
    if (extent.first / group_samples % options.window_stride != options.window_offset % options.window_stride) {
      left_out();
      continue;
    }
    ContactWindow window(run, extent.first, extent.last);
    MachineState<double>& kept = local.window_start[number];
    std::array<double, 2>& ring_beyond = local.window_ring[number];
    const bool fresh = !unknowns.belongs(kept);
    kept.takeLags(lags);  // it may be from a fit without lags
    window.start = kept;
    if (!fresh && way.size() > 0 && local.window_response[number].size() != 0) {
      const MachineState<double> followed = unknowns.moved(kept, local.window_response[number] * way);
      if (std::all_of(followed.mechanics.begin(), followed.mechanics.end(), [](double v) { return std::isfinite(v); }))
        window.start = followed;
    }
    window.guess = window.start;
    if (!fresh) {
      unknowns.setRingSpeeds(window.guess, ring_speed);
      unknowns.setRingSpeeds(window.start, {ring_speed[0] + ring_beyond[0], ring_speed[1] + ring_beyond[1]});
    }
    // a start kept from the last evaluation is mostly good as it stands: then one linearisation does
    bool good = !fresh && window.linearise(true) && window.ownGain() < linear_share * window.squares;
    if (!good || (options.thorough && window.squares > thrown_off * window.residuals())) {
      // begin where the last evaluation ended, where the window before led to, or at what was measured
      std::vector<MachineState<double>> guesses;
      if (!fresh) guesses.push_back(window.start);
      if (unknowns.belongs(led_to)) guesses.push_back(led_to);
      for (const MeasuredFrom span : {MeasuredFrom{0, 8}, MeasuredFrom{-2, 5}})  // the second sees through an impact
        guesses.push_back(stateFromMeasurement(rec, run.base(), run.whole.spin, extent.first, span));
      for (auto& one : guesses) unknowns.setRingSpeeds(one, ring_speed);
      good = window.search(std::move(guesses), options.window_passes + (fresh ? 4 : 1), options.thorough, after_good);
    }
    if (!good || !std::isfinite(window.squares)) {
      normal.finite = false;
      left_out();
      if (options.all_or_nothing) return normal;
      continue;
    }
    const Eliminated part = eliminateStart(window, run);
    if (g > 0) {
      Eigen::MatrixXd response = Eigen::MatrixXd::Zero(unknowns.size(), p);
      response(Eigen::all, moved_coordinates) = part.response;
      turnColumnsAtLimit(response, space_, x, moved_coordinates, steps_);
      local.window_response[number] = std::move(response);
    }
    after_good = sums.add(window, part, number) < thrown_off;
    all_good = all_good && after_good;
    // the linear step is taken next time where it is small; the state that this window leads to goes on from here
    const bool moves = part.gain < linear_share * window.squares;
    kept = moves ? unknowns.moved(window.start, part.step) : window.start;
    for (int e = 0; e < 2 && unknowns.hasRing(); ++e) {
      ring_beyond[e] = unknowns.ringSpeed(kept, e) - ring_speed[e];
      const double led = ring_speed[e] = unknowns.ringSpeed(window.end, e);
      for (int k = 0; k < unknowns.size() && moves; ++k)  // as from the moved start: the next must not count that as its own
        ring_speed[e] += (unknowns.ringSpeed(window.ends[k], e) - led) / unknowns.scale(k, steps_of_start) * part.step[k];
    }
    led_to = window.end;
    if (options.keep_prediction) keepPrediction(window, extent.first, result.predicted);
  }

  double taken = sums.before - sums.squares;  // by steps
  if (r > 0) {  // eliminate the run's offsets
    Eigen::MatrixXd own = sums.h.bottomRightCorner(r, r);
    Eigen::VectorXd own_b = sums.g.tail(r);
    own.diagonal().array() += 1.0 / (offset_std_ * offset_std_);
    for (int a = 0; a < 4; ++a) {
      own_b[a] -= local.offset_m[a] / (offset_std_ * offset_std_);
      own_b[4 + a] -= local.drift_m[a] / (offset_std_ * offset_std_);
    }
    const Ldlt factor(own);
    const Eigen::VectorXd solved = factor.solve(own_b);
    const Eigen::MatrixXd between = sums.h.topRightCorner(g, r);
    if (g > 0) {
      local.run_response = Eigen::MatrixXd::Zero(r, p);
      local.run_response(Eigen::all, moved_coordinates) = -factor.solveColumns(between.transpose());
      turnColumnsAtLimit(local.run_response, space_, x, moved_coordinates, steps_);
    }
    normal.h(moved_coordinates, moved_coordinates) = sums.h.topLeftCorner(g, g) - between * factor.solveColumns(between.transpose());
    normal.g(moved_coordinates) = sums.g.head(g) - between * solved;
    const double gain = std::max(0.0, own_b.dot(solved));
    sums.chi2 -= std::min(gain, 0.5 * sums.chi2);
    taken += gain;
    for (int a = 0; a < 4; ++a) {
      local.offset_m[a] += solved[a];
      local.drift_m[a] += solved[4 + a];
    }
  } else {
    normal.h(moved_coordinates, moved_coordinates) = sums.h;
    normal.g(moved_coordinates) = sums.g;
  }
  if (g > 0 && options.scores) normal.scores(moved_coordinates, moved_coordinates) = sums.scores * sums.scores.transpose();
  normal.chi2 = sums.chi2;
  normal.squares = sums.squares;
  normal.occam = sums.occam;
  normal.starts = sums.starts;
  normal.count = sums.count;
  result.mean_square = sums.count > 0.0 ? sums.squares / sums.count : 0.0;
  result.finite = normal.finite;
  result.stands = normal.finite && all_good && taken < standing_share * sums.before;
  return normal;
}

}  // namespace amb_rotor
