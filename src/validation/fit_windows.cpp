// Runs with contact: predicted over consecutive windows of 10 ms, each from its own estimated starting state.
#include <algorithm>
#include <cmath>

#include "amb_rotor/validation/fit.hpp"
#include "amb_rotor/validation/stretches.hpp"

namespace amb_rotor {
namespace {

/// Finite-difference steps of a starting state: displacement [m or rad], rate, current [A].
constexpr double displacement_step = 2e-9, rate_step = 2e-6, current_step = 1e-4;
/// The starting guess comes from the measurement; the estimate may move it by about so much.
constexpr double displacement_prior = 2e-5, rate_prior = 5e-2, current_prior = 0.5;
constexpr double score_floor = 1e-12;

struct Window {
  long first, last;
};

}  // namespace

NormalEquations FitProblem::evaluateWindows(const std::vector<Model>& given, const Recording& rec, LocalState& local,
                                            const EvaluationOptions& options, RunResult& result) const {
  const int p = space_.size();
  NormalEquations normal(p);
  const std::vector<Model> models = withTrialWeights(given, rec);
  const Model& base_model = models[0];
  const int g = static_cast<int>(models.size()) - 1;
  Stretch whole = stretchOf(rec, base_model);
  whole.contact_step_s = contactStep(base_model);
  const int mechanics = mechanicsSize(base_model, whole.spin);
  const int spin_states = whole.spin == Spin::prescribed ? 0 : 2;
  const int free_states = mechanics - spin_states;
  const int w = free_states + 4;  // unknowns of a window
  const bool offsets = offset_std_ > 0.0;
  const int r = offsets ? 8 : 0;  // unknowns of the run: offsets, drifts
  const int coordinates = 2 * (free_states > 0 ? Machine<double>({&base_model}, whole.spin).rotor().modes() : 0);

  std::vector<Window> windows;
  const long length = std::max<long>(8, std::lround(contact_window_s * rec.run.sample_rate_hz));
  for (long first = 0; first + length / 2 <= rec.samples; first += length)
    windows.push_back({first, std::min(first + length, rec.samples)});
  if (!windows.empty()) windows.back().last = rec.samples;
  if (local.window_start.size() != windows.size()) local.window_start.assign(windows.size(), {});
  if (options.keep_prediction) result.predicted.assign(rec.samples * predicted_channels, 0.0);

  Eigen::MatrixXd run_h = Eigen::MatrixXd::Zero(g + r, g + r);
  Eigen::VectorXd run_g = Eigen::VectorXd::Zero(g + r);
  double chi2 = 0.0, squares = 0.0, count = 0.0;
  std::array<double, predicted_channels> channel{};
  Eigen::MatrixXd scores = Eigen::MatrixXd::Zero(g, static_cast<long>(windows.size()));
  const double* old_offset = local.offset_m;
  const double* old_drift = local.drift_m;

  std::vector<double> outs;
  for (std::size_t number = 0; number < windows.size(); ++number) {
    const Window window = windows[number];
    const long n = window.last - window.first;
    const std::size_t width = static_cast<std::size_t>(n) * predicted_channels;
    Stretch stretch = whole;
    stretch.first = window.first;
    stretch.last = window.last;
    MachineState<double> start = stateFromMeasurement(rec, base_model, whole.spin, window.first);
    for (int a = 0; a < 4; ++a)  // the parabola went through measured values: take the known offset out
      (void)a;
    const MachineState<double> guess = start;
    std::vector<double>& kept = local.window_start[number];
    if (static_cast<int>(kept.size()) == w) {
      std::copy(kept.begin(), kept.begin() + free_states, start.mechanics.begin());
      std::copy(kept.begin() + free_states, kept.end(), start.current);
    }
    const auto scaleOf = [&](int k, double displacement, double rate, double current) {
      if (k >= free_states) return current;
      if (k < coordinates) return displacement;
      return k < 2 * coordinates ? rate : (k - 2 * coordinates) % 4 < 2 ? displacement : rate;
    };
    const auto valueOf = [&](const MachineState<double>& state, int k) {
      return k < free_states ? state.mechanics[k] : state.current[k - free_states];
    };
    const int passes = std::max(1, options.window_passes) + (kept.empty() ? 4 : 0);
    double damping = 1e-3, previous = 1e300;
    MachineState<double> best = start;
    Eigen::MatrixXd h;
    Eigen::VectorXd b;
    double window_squares = 0.0;
    bool finite = true;
    for (int pass = 0; pass <= passes; ++pass) {
      const bool last = pass == passes;
      const int columns = (last ? g : 0) + w;
      std::vector<LaneJob> jobs;
      std::vector<std::vector<double>> changes(w, std::vector<double>(mechanics + 4, 0.0));
      const auto add = [&](const Model& model, const double* change) {
        LaneJob job = jobOf(rec, model, local.angle_rad);
        job.start = &start;
        job.start_change = change;
        jobs.push_back(job);
      };
      add(base_model, nullptr);
      if (last)
        for (int k = 0; k < g; ++k) add(models[k + 1], nullptr);
      for (int k = 0; k < w; ++k) {
        changes[k][k < free_states ? k : mechanics + k - free_states] =
            scaleOf(k, displacement_step, rate_step, current_step);
        add(base_model, changes[k].data());
      }
      outs.resize(width * jobs.size());
      for (std::size_t k = 0; k < jobs.size(); ++k) jobs[k].out = outs.data() + k * width;
      predict(stretch, jobs);
      finite = true;
      for (const auto& job : jobs) finite = finite && job.finite;
      if (!finite) break;
      // rows: all channels; columns: coordinates, window, offsets and drifts, residual
      const int size = columns + r;
      h = Eigen::MatrixXd::Zero(size, size);
      b = Eigen::VectorXd::Zero(size);
      Eigen::VectorXd row(size);
      window_squares = 0.0;
      if (last) channel.fill(0.0);
      for (int c = 0; c < predicted_channels; ++c) {
        if (rec.noise[c] <= 0.0) continue;
        const double weight = 1.0 / rec.noise[c];
        for (long i = 0; i < n; ++i) {
          const std::size_t at = i * predicted_channels + c;
          const double y = outs[at];
          int k = 0, lane = 1;
          if (last)
            for (; k < g; ++k, ++lane) row[k] = (outs[lane * width + at] - y) / steps_[k] * weight;
          for (int j = 0; j < w; ++j, ++k, ++lane)
            row[k] = (outs[lane * width + at] - y) / scaleOf(j, displacement_step, rate_step, current_step) * weight;
          double residual = (rec.measured[(window.first + i) * predicted_channels + c] - y) * weight;
          if (r > 0) {
            row.tail(r).setZero();
            if (c < 4) {
              const double share = static_cast<double>(window.first + i) / rec.samples - 0.5;
              residual -= (old_offset[c] + old_drift[c] * share) * weight;
              row[columns + c] = weight;
              row[columns + 4 + c] = weight * share;
            }
          }
          h.selfadjointView<Eigen::Lower>().rankUpdate(row);
          b += residual * row;
          window_squares += residual * residual;
        }
      }
      h = h.selfadjointView<Eigen::Lower>();
      if (last) break;
      // refine the start with the run's unknowns held
      Eigen::MatrixXd own = h.topLeftCorner(w, w);
      Eigen::VectorXd right = b.head(w);
      for (int k = 0; k < w; ++k) {
        const double prior = scaleOf(k, displacement_prior, rate_prior, current_prior);
        own(k, k) += 1.0 / (prior * prior);
        right[k] += (valueOf(guess, k) - valueOf(start, k)) / (prior * prior);
      }
      if (window_squares > previous) {
        damping = std::min(damping * 30.0, 1e6);
        start = best;
      } else {
        if (previous - window_squares < 1e-3 * window_squares && pass > 0 && pass + 1 < passes) pass = passes - 2;
        damping = std::max(damping * 0.1, 1e-6);
        previous = window_squares;
        best = start;
      }
      own.diagonal() *= 1.0 + damping;
      const Eigen::VectorXd step = own.ldlt().solve(right);
      if (!step.allFinite()) break;
      for (int k = 0; k < free_states; ++k) start.mechanics[k] += step[k];
      for (int a = 0; a < 4; ++a) start.current[a] += step[free_states + a];
      if (pass == passes - 1 && window_squares > 2.0 * previous) start = best;
    }
    if (!finite || !std::isfinite(window_squares)) {
      normal.finite = false;
      continue;
    }
    if (window_squares > 1.5 * previous) {  // the last step went wrong: stay at the best start
      start = best;
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
      const double prior = scaleOf(k, displacement_prior, rate_prior, current_prior);
      own(k, k) += 1.0 / (prior * prior);
      own_b[k] += (valueOf(guess, k) - valueOf(start, k)) / (prior * prior);
    }
    const Eigen::LDLT<Eigen::MatrixXd> factor(own);
    const Eigen::VectorXd solved = factor.solve(own_b);
    run_h += outer - between * factor.solve(between.transpose());
    const Eigen::VectorXd reduced = outer_b - between * solved;
    run_g += reduced;
    if (g > 0) scores.col(static_cast<long>(number)) = reduced.head(g);
    const double gain = std::max(0.0, own_b.dot(solved));
    chi2 += window_squares - std::min(gain, 0.5 * window_squares);
    // after the linear refinement: what the window's own fit leaves
    squares += std::max(window_squares - gain, score_floor);
    count += static_cast<double>(n) * std::count_if(rec.noise.begin(), rec.noise.end(), [](double s) { return s > 0.0; });
    kept.assign(w, 0.0);
    const double take = gain < 0.2 * window_squares ? 1.0 : 0.3;
    for (int k = 0; k < w; ++k) kept[k] = valueOf(start, k) + take * solved[k];
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
    const Eigen::LDLT<Eigen::MatrixXd> factor(own);
    const Eigen::VectorXd solved = factor.solve(own_b);
    const Eigen::MatrixXd between = run_h.topRightCorner(g, r);
    normal.h.topLeftCorner(g, g) = run_h.topLeftCorner(g, g) - between * factor.solve(between.transpose());
    normal.g.head(g) = run_g.head(g) - between * solved;
    chi2 -= std::min(std::max(0.0, own_b.dot(solved)), 0.5 * chi2);
    for (int a = 0; a < 4; ++a) {
      local.offset_m[a] += solved[a];
      local.drift_m[a] += solved[4 + a];
    }
    if (g > 0 && options.scores) normal.scores.topLeftCorner(g, g) = scores * scores.transpose();
  } else {
    normal.h.topLeftCorner(g, g) = run_h;
    normal.g.head(g) = run_g;
    if (g > 0 && options.scores) normal.scores.topLeftCorner(g, g) = scores * scores.transpose();
  }
  normal.chi2 = chi2;
  normal.squares = squares;
  normal.count = count;
  result.mean_square = count > 0.0 ? squares / count : 0.0;
  result.finite = normal.finite;
  return normal;
}

}  // namespace amb_rotor
