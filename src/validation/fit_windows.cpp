// Runs with contact: predicted over consecutive windows of 10 ms, each from its own estimated starting state.
#include <algorithm>
#include <cmath>

#include "amb_rotor/common/linear_algebra.hpp"
#include "amb_rotor/validation/fit.hpp"
#include "amb_rotor/validation/stretches.hpp"

namespace amb_rotor {
namespace {

/// Of the unknowns of a starting state: displacement [m or rad], rate, current [A], speed of a ring [rad/s].
struct Scales {
  double displacement, rate, current, ring;
};
/// Finite differences.
constexpr Scales steps_of_start = {2e-9, 2e-6, 1e-4, 0.05};
/// The starting guess comes from the measurement, that of a ring from where the last window led; the estimate may move
/// it by about so much.
constexpr Scales prior_of_start = {1e-4, 0.3, 1.0, 20.0};
constexpr double score_floor = 1e-12;
/// Mean square over the noise beyond which a window's squares count by their logarithm.
constexpr double robust_excess = 3.0;
/// Windows that a first look takes or leaves together span so much: what no sensor sees (a mount, a ring) is known only from
/// the window before.
constexpr double group_s = 10 * contact_window_s;
/// Mean square over the noise from which on a thorough evaluation tries all guesses of a window's start.
constexpr double thrown_off = 1.5;
/// Share of a window's squares that its start may still win for the linear step to be trusted.
constexpr double linear_share = 0.1;

struct Window {
  long first, last;
};

/// Sum of squares of a window's residual over the noise, the run's offsets taken out.
double squaresOf(const Recording& rec, long first, long n, const double* out, const double* offset,
                 const double* drift) {
  double sum = 0.0;
  for (int c = 0; c < predicted_channels; ++c) {
    if (rec.noise[c] <= 0.0) continue;
    for (long i = 0; i < n; ++i) {
      double e = rec.measured[(first + i) * predicted_channels + c] - out[i * predicted_channels + c];
      if (c < 4) e -= offset[c] + drift[c] * (static_cast<double>(first + i) / rec.samples - 0.5);
      sum += (e / rec.noise[c]) * (e / rec.noise[c]);
    }
  }
  return sum;
}

}  // namespace

NormalEquations FitProblem::evaluateWindows(const Eigen::VectorXd& x, const std::vector<Model>& given,
                                            const std::vector<int>& moved_coordinates, const Recording& rec,
                                            LocalState& local, const EvaluationOptions& options,
                                            RunResult& result) const {
  const int p = space_.size();
  NormalEquations normal(p);
  const std::vector<Model> models = withTrialWeights(given, rec);
  const Model& base_model = models[0];
  const int g = static_cast<int>(models.size()) - 1;
  Stretch whole = stretchOf(rec, base_model);
  whole.contact_step_s = contactStep(base_model);
  whole.by_events = base_model.friction_law == FrictionLaw::set_valued;
  const int mechanics = mechanicsSize(base_model, whole.spin);
  const int spin_states = whole.spin == Spin::prescribed ? 0 : 2;
  const int free_states = mechanics - spin_states;
  // integrators hold what the sensors' offsets, which are unknown, would seem to ask for: unknowns, too
  const double ki = base_model.amb_model == AmbModel::linear ? base_model.rig.controller.ki_A_per_m_s : 0.0;
  const int w = free_states + 4 + (ki > 0.0 ? 4 : 0);  // unknowns of a window
  const bool offsets = offset_std_ > 0.0;
  const int r = offsets ? 8 : 0;  // unknowns of the run: offsets, drifts
  const Machine<double> machine({&base_model}, whole.spin);
  const int ring = machine.ringState(), mount = machine.mountState();
  const std::size_t lags = 4 * machine.relaxationRates().size();
  const int coordinates = 2 * (free_states > 0 ? machine.rotor().modes() : 0);

  std::vector<Window> windows;
  const long length = std::max<long>(8, std::lround(options.window_s * rec.run.sample_rate_hz));
  for (long first = 0; first + length / 2 <= rec.samples; first += length)
    windows.push_back({first, std::min(first + length, rec.samples)});
  if (!windows.empty()) windows.back().last = rec.samples;
  const long group_samples = std::max(1L, std::lround(group_s * rec.run.sample_rate_hz));
  if (local.window_start.size() != windows.size()) local.window_start.assign(windows.size(), {});
  if (local.window_ring.size() != windows.size()) local.window_ring.assign(windows.size(), {});
  // the starts follow the coordinates to first order: a step of both together, as in multiple shooting
  const bool follow = local.window_at.size() == x.size() && local.window_response.size() == windows.size();
  const Eigen::VectorXd way = follow ? Eigen::VectorXd(x - local.window_at) : Eigen::VectorXd();
  if (!follow) {
    local.window_response.assign(windows.size(), {});
    local.run_response.resize(0, 0);
  } else if (local.run_response.size() > 0) {
    const Eigen::VectorXd along = local.run_response * way;
    for (int a = 0; a < 4; ++a) {
      local.offset_m[a] += along[a];
      local.drift_m[a] += along[4 + a];
    }
  }
  local.window_at = x;
  MachineState<double> led_to;
  double ring_speed[2] = {0.0, 0.0};  // where the windows so far led; at rest in the beginning
  if (options.keep_prediction) result.predicted.assign(rec.samples * predicted_channels, 0.0);

  Eigen::MatrixXd run_h = Eigen::MatrixXd::Zero(g + r, g + r);
  Eigen::VectorXd run_g = Eigen::VectorXd::Zero(g + r);
  double chi2 = 0.0, squares = 0.0, count = 0.0, occam = 0.0;
  Eigen::MatrixXd scores = Eigen::MatrixXd::Zero(g, static_cast<long>(windows.size()));
  const double* old_offset = local.offset_m;
  const double* old_drift = local.drift_m;

  const auto channels = static_cast<double>(
      std::count_if(rec.noise.begin(), rec.noise.end(), [](double noise) { return noise > 0.0; }));
  std::vector<double> outs;
  for (std::size_t number = 0; number < windows.size(); ++number) {
    const Window window = windows[number];
    if (window.first / group_samples % options.window_stride != options.window_offset % options.window_stride) {
      led_to = {};
      continue;
    }
    const long n = window.last - window.first;
    const std::size_t width = static_cast<std::size_t>(n) * predicted_channels;
    Stretch stretch = whole;
    stretch.first = window.first;
    stretch.last = window.last;
    stretch.by_events = whole.by_events && !slidesThroughout(rec, base_model, window.first, window.last);
    MachineState<double>& kept = local.window_start[number];
    const bool fresh = static_cast<int>(kept.mechanics.size()) != mechanics;
    kept.takeLags(lags);  // it may be from a fit without lags
    MachineState<double> start = kept, guess = kept;
    const auto ringFollows = [&](MachineState<double>& state, const std::array<double, 2>& beyond = {}) {
      for (int e = 0; e < 2 && ring >= 0; ++e) state.mechanics[ring + e] = ring_speed[e] + beyond[e];
    };
    std::array<double, 2>& ring_beyond = local.window_ring[number];
    if (!fresh) {
      ringFollows(guess);
      ringFollows(start, ring_beyond);
    }
    const auto scaleOf = [&](int k, const Scales& scales) {
      if (k >= free_states + 4) return scales.current / ki;
      if (k >= free_states) return scales.current;
      if (k >= machine.electricsOffset()) {  // filters: value, slope; coils: current
        const int order = machine.electrics().filterOrder(), place = k - machine.electricsOffset();
        if (place >= 4 * order) return scales.current;
        return place % order == 0 ? scales.displacement : scales.rate;
      }
      if (k < coordinates) return scales.displacement;
      if (k < 2 * coordinates) return scales.rate;
      if (ring >= 0 && (k == ring || k == ring + 1)) return scales.ring;
      if (mount >= 0 && k >= mount + 8) return scales.displacement;  // branches of an elastomer's mount
      return (k - 2 * coordinates) % 4 < 2 ? scales.displacement : scales.rate;
    };
    const auto valueOf = [&](const MachineState<double>& state, int k) {
      if (k >= free_states + 4) return state.controller[k - free_states - 4].integral;
      return k < free_states ? state.mechanics[k] : state.current[k - free_states];
    };
    const auto moved = [&](MachineState<double> state, const Eigen::VectorXd& step) {
      for (int k = 0; k < free_states; ++k) state.mechanics[k] += step[k];
      for (int a = 0; a < 4; ++a) state.current[a] += step[free_states + a];
      for (int k = free_states + 4; k < w; ++k) state.controller[k - free_states - 4].integral += step[k];
      return state;
    };
    // the guesses, that which predicts the window best first
    const auto byPrediction = [&](std::vector<MachineState<double>> guesses) {
      std::vector<LaneJob> jobs;
      std::vector<double> predicted(width * guesses.size());
      for (std::size_t k = 0; k < guesses.size(); ++k) {
        jobs.push_back(jobOf(rec, base_model, local.angle_rad));
        jobs.back().start = &guesses[k];
        jobs.back().out = predicted.data() + k * width;
        guesses[k].pending.resize(guesses[0].pending.size(), guesses[0].pending.empty()
                                                                 ? PendingCommand<double>{}
                                                                 : guesses[0].pending.back());
      }
      predict(stretch, jobs);
      std::vector<std::pair<double, std::size_t>> order;
      for (std::size_t k = 0; k < guesses.size(); ++k)
        order.emplace_back(jobs[k].finite ? squaresOf(rec, window.first, n, predicted.data() + k * width, old_offset, old_drift)
                                          : 1e300,
                           k);
      std::sort(order.begin(), order.end());
      std::vector<MachineState<double>> sorted;
      for (const auto& place : order) sorted.push_back(guesses[place.second]);
      return sorted;
    };
    // base, w columns of the start, and (where asked) the coordinates; fills h, b, window_squares
    Eigen::MatrixXd h;
    Eigen::VectorXd b;
    double window_squares = 0.0;
    MachineState<double> end_state;
    std::vector<MachineState<double>> ends;  // of the columns of the start, where a ring goes on from there
    const auto linearise = [&](const MachineState<double>& at, bool with_coordinates) {
      const int columns = (with_coordinates ? g : 0) + w;
      std::vector<LaneJob> jobs;
      std::vector<std::vector<double>> changes(w, std::vector<double>(mechanics + 8, 0.0));
      const auto add = [&](const Model& model, const double* change) {
        LaneJob job = jobOf(rec, model, local.angle_rad);
        job.start = &at;
        job.start_change = change;
        jobs.push_back(job);
      };
      add(base_model, nullptr);
      if (with_coordinates)
        for (int k = 0; k < g; ++k) add(models[k + 1], nullptr);
      for (int k = 0; k < w; ++k) {
        changes[k][k < free_states ? k : mechanics + k - free_states] =
            scaleOf(k, steps_of_start);
        add(base_model, changes[k].data());
      }
      outs.resize(width * jobs.size());
      for (std::size_t k = 0; k < jobs.size(); ++k) jobs[k].out = outs.data() + k * width;
      jobs[0].end = &end_state;
      if (ring >= 0) ends.resize(w);
      for (std::size_t k = 0; k < ends.size(); ++k) jobs[jobs.size() - w + k].end = &ends[k];
      predict(stretch, jobs);
      for (const auto& job : jobs)
        if (!job.finite) return false;
      const int size = columns + r;
      h = Eigen::MatrixXd::Zero(size, size);
      b = Eigen::VectorXd::Zero(size);
      window_squares = 0.0;
      Eigen::MatrixXd rows(n, size);
      Eigen::VectorXd residuals(n);
      for (int c = 0; c < predicted_channels; ++c) {
        if (rec.noise[c] <= 0.0) continue;
        const double weight = 1.0 / rec.noise[c];
        if (r > 0) rows.rightCols(r).setZero();
        for (long i = 0; i < n; ++i) {
          const std::size_t place = i * predicted_channels + c;
          const double y = outs[place];
          int k = 0, lane = 1;
          if (with_coordinates)
            for (; k < g; ++k, ++lane) rows(i, k) = (outs[lane * width + place] - y) / steps_[moved_coordinates[k]] * weight;
          for (int j = 0; j < w; ++j, ++k, ++lane)
            rows(i, k) =
                (outs[lane * width + place] - y) / scaleOf(j, steps_of_start) * weight;
          residuals[i] = (rec.measured[(window.first + i) * predicted_channels + c] - y) * weight;
          if (r > 0 && c < 4) {
            const double share = static_cast<double>(window.first + i) / rec.samples - 0.5;
            residuals[i] -= (old_offset[c] + old_drift[c] * share) * weight;
            rows(i, columns + c) = weight;
            rows(i, columns + 4 + c) = weight * share;
          }
        }
        h.noalias() += rows.transpose() * rows;
        b.noalias() += rows.transpose() * residuals;
        window_squares += residuals.squaredNorm();
      }
      return true;
    };
    // Newton's gain of the start alone at the last linearisation, which began at column `first`
    const auto ownGain = [&](const MachineState<double>& at, int first) {
      Eigen::MatrixXd own = h.block(first, first, w, w);
      Eigen::VectorXd right = b.segment(first, w);
      for (int k = 0; k < w; ++k) {
        const double prior = scaleOf(k, prior_of_start);
        own(k, k) += 1.0 / (prior * prior);
        right[k] += (valueOf(guess, k) - valueOf(at, k)) / (prior * prior);
      }
      const Eigen::VectorXd solved = Ldlt(own).solve(right);
      return solved.allFinite() ? std::max(0.0, right.dot(solved)) : 1e300;
    };
    if (follow && !fresh && local.window_response[number].size() != 0) {
      const MachineState<double> followed = moved(start, local.window_response[number] * way);
      bool finite = true;
      for (const double v : followed.mechanics) finite = finite && std::isfinite(v);
      if (finite) {
        guess = start = followed;
        ringFollows(guess);
        ringFollows(start, ring_beyond);
      }
    }
    // moves the start to where it fits best from `guess`, the run's unknowns held; its squares
    const auto refine = [&]() {
      double damping = 1e-4, best_squares = 1e300;
      MachineState<double> best = start;
      Eigen::MatrixXd best_h;
      Eigen::VectorXd best_b;
      const int passes = options.window_passes + (fresh ? 4 : 1);
      for (int pass = 0; pass < passes; ++pass) {
        const bool finite = linearise(start, false);
        const bool better = finite && window_squares < best_squares;
        const double drop = best_squares - window_squares;
        if (better) {
          best = start;
          best_squares = window_squares;
          best_h = h.topLeftCorner(w, w);
          best_b = b.head(w);
          damping = std::max(damping * 0.1, 1e-7);
        } else {
          if (best_h.size() == 0) break;
          damping = std::min(std::max(damping * 30.0, 1e-3), 1e8);
        }
        if (better && pass > 0 && drop < 2e-3 * best_squares) break;
        Eigen::MatrixXd own = best_h;
        Eigen::VectorXd right = best_b;
        for (int k = 0; k < w; ++k) {
          const double prior = scaleOf(k, prior_of_start);
          own(k, k) = own(k, k) * (1.0 + damping) + 1.0 / (prior * prior);
          right[k] += (valueOf(guess, k) - valueOf(best, k)) / (prior * prior);
        }
        const Eigen::VectorXd step = Ldlt(own).solve(right);
        if (!step.allFinite()) break;
        start = moved(best, step);
      }
      if (best_h.size() != 0) start = best;
      return best_squares;
    };
    // a start kept from the last evaluation is mostly good as it stands: then one linearisation does
    const double far_off = thrown_off * static_cast<double>(n) * channels;
    bool good = !fresh && linearise(start, true) && ownGain(start, g) < linear_share * window_squares;
    if (!good || (options.thorough && window_squares > far_off)) {
      // begin where the last evaluation ended, where the window before led to, or at what was measured
      std::vector<MachineState<double>> guesses;
      if (!fresh) guesses.push_back(start);
      if (static_cast<int>(led_to.mechanics.size()) == mechanics) guesses.push_back(led_to);
      for (const MeasuredFrom span : {MeasuredFrom{0, 8}, MeasuredFrom{-2, 5}})  // the second sees through an impact
        guesses.push_back(stateFromMeasurement(rec, base_model, whole.spin, window.first, span));
      for (auto& one : guesses) ringFollows(one);
      double least = 1e300;
      MachineState<double> best_start = start, best_guess = guess;
      for (const auto& one : byPrediction(guesses)) {
        guess = start = one;
        const double squares_left = refine();
        if (squares_left < least) {
          least = squares_left;
          best_start = start;
          best_guess = guess;
        }
        if (!options.thorough || least < far_off) break;
      }
      start = best_start;
      guess = best_guess;
      good = linearise(start, true);
    }
    if (!good || !std::isfinite(window_squares)) {
      normal.finite = false;
      led_to = {};
      if (options.all_or_nothing) return normal;
      continue;
    }
    // eliminate the window
    const int rest = g + r;
    std::vector<int> order;
    for (int k = 0; k < g; ++k) order.push_back(k);
    for (int k = 0; k < r; ++k) order.push_back(g + w + k);
    Eigen::MatrixXd outer(rest, rest), between(rest, w), own = h.block(g, g, w, w);
    Eigen::VectorXd outer_b(rest), own_b = b.segment(g, w);
    for (int i = 0; i < rest; ++i) {
      outer_b[i] = b[order[i]];
      for (int j = 0; j < rest; ++j) outer(i, j) = h(order[i], order[j]);
      for (int j = 0; j < w; ++j) between(i, j) = h(order[i], g + j);
    }
    for (int k = 0; k < w; ++k) {
      const double prior = scaleOf(k, prior_of_start);
      own(k, k) += 1.0 / (prior * prior);
      own_b[k] += (valueOf(guess, k) - valueOf(start, k)) / (prior * prior);
    }
    const Ldlt factor(own);
    const Eigen::VectorXd pivots = factor.pivots();
    for (int k = 0; k < w; ++k)
      occam += std::log(std::max(pivots[k], 1e-300)) +
               2.0 * std::log(scaleOf(k, prior_of_start));
    const Eigen::VectorXd solved = factor.solve(own_b);
    if (g > 0) {
      Eigen::MatrixXd response = Eigen::MatrixXd::Zero(w, p);
      response(Eigen::all, moved_coordinates) = -factor.solveColumns(between.topRows(g).transpose());
      for (const int k : moved_coordinates)
        if (x[k] + steps_[k] > space_.coordinates()[k].upper) response.col(k) *= -1.0;  // was stepped downwards
      local.window_response[number] = std::move(response);
    }
    const double gain = std::max(0.0, own_b.dot(solved));
    const double left = std::max(window_squares - std::min(gain, 0.5 * window_squares), score_floor);
    const double residuals = static_cast<double>(n) * channels;
    // a window that an impact has thrown off must not outweigh all others: beyond the noise its squares count by their
    // logarithm
    const double excess = std::max(0.0, left / residuals - 1.0);
    const double weight = 1.0 / (1.0 + excess / robust_excess);
    run_h += weight * (outer - between * factor.solveColumns(between.transpose()));
    const Eigen::VectorXd reduced = weight * (outer_b - between * solved);
    run_g += reduced;
    if (g > 0) scores.col(static_cast<long>(number)) = reduced.head(g);
    chi2 += excess > 0.0 ? residuals * (1.0 + robust_excess * std::log1p(excess / robust_excess)) : left;
    // after the linear refinement: what the window's own fit leaves
    squares += std::max(window_squares - gain, score_floor);
    count += residuals;
    // the linear step is taken next time where it is small; the state that this window leads to goes on from here
    const bool moves = gain < linear_share * window_squares;
    kept = moves ? moved(start, solved) : start;
    for (int e = 0; e < 2 && ring >= 0; ++e) {
      ring_beyond[e] = kept.mechanics[ring + e] - ring_speed[e];
      const double led = ring_speed[e] = end_state.mechanics[ring + e];
      for (int k = 0; k < w && moves; ++k)  // as from the moved start: the next window must not count that as its own
        ring_speed[e] += (ends[k].mechanics[ring + e] - led) / scaleOf(k, steps_of_start) * solved[k];
    }
    led_to = end_state;
    if (options.keep_prediction)
      for (long i = 0; i < n; ++i)
        for (int c = 0; c < predicted_channels; ++c)
          result.predicted[(window.first + i) * predicted_channels + c] =
              outs[i * predicted_channels + c] +
              (c < 4 ? old_offset[c] + old_drift[c] * (static_cast<double>(window.first + i) / rec.samples - 0.5) : 0.0);
  }
  // eliminate the run's offsets
  if (r > 0) {
    Eigen::MatrixXd own = run_h.bottomRightCorner(r, r);
    Eigen::VectorXd own_b = run_g.tail(r);
    for (int k = 0; k < r; ++k) {
      own(k, k) += 1.0 / (offset_std_ * offset_std_);
      own_b[k] -= (k < 4 ? local.offset_m[k] : local.drift_m[k - 4]) / (offset_std_ * offset_std_);
    }
    const Ldlt factor(own);
    const Eigen::VectorXd solved = factor.solve(own_b);
    const Eigen::MatrixXd between = run_h.topRightCorner(g, r);
    if (g > 0) {
      local.run_response = Eigen::MatrixXd::Zero(r, p);
      local.run_response(Eigen::all, moved_coordinates) = -factor.solveColumns(between.transpose());
      for (const int k : moved_coordinates)
        if (x[k] + steps_[k] > space_.coordinates()[k].upper) local.run_response.col(k) *= -1.0;
    }
    normal.h(moved_coordinates, moved_coordinates) = run_h.topLeftCorner(g, g) - between * factor.solveColumns(between.transpose());
    normal.g(moved_coordinates) = run_g.head(g) - between * solved;
    chi2 -= std::min(std::max(0.0, own_b.dot(solved)), 0.5 * chi2);
    for (int a = 0; a < 4; ++a) {
      local.offset_m[a] += solved[a];
      local.drift_m[a] += solved[4 + a];
    }
    if (g > 0 && options.scores) normal.scores(moved_coordinates, moved_coordinates) = scores * scores.transpose();
  } else {
    normal.h(moved_coordinates, moved_coordinates) = run_h;
    normal.g(moved_coordinates) = run_g;
    if (g > 0 && options.scores) normal.scores(moved_coordinates, moved_coordinates) = scores * scores.transpose();
  }
  normal.chi2 = chi2;
  normal.squares = squares;
  normal.occam = occam;
  normal.count = count;
  result.mean_square = count > 0.0 ? squares / count : 0.0;
  result.finite = normal.finite;
  return normal;
}

}  // namespace amb_rotor
