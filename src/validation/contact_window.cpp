#include "contact_window.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

#include "amb_rotor/common/error.hpp"
#include "amb_rotor/common/linear_algebra.hpp"

namespace amb_rotor {
namespace {

/// Parts of a window that a start which is out of reach is fitted to, one after another.
constexpr long growing_parts[] = {16, 8, 5, 3, 2, 1};
constexpr long fewest_samples = 8;
/// Steps at each of them.
constexpr int growing_passes = 10;
/// Mean square over the noise in a part beyond which the rest of the window is out of reach from there.
constexpr double lost = 30.0;
/// Passes from each guess before the best goes on, and the mean square over the noise up to which the others go on, too: a wrong
/// model comes near from none of them.
constexpr int first_passes = 3;
constexpr double hopeless = 300.0;

/// Dampings of a step that are tried at once, relative to the last that helped: one pack of lanes, where a linearisation takes three.
constexpr double damping_factors[] = {1e-2, 1e-1, 1.0, 10.0, 100.0, 1e3, 1e4, 1e5};
constexpr double first_damping = 1e-4, least_damping = 1e-7, most_damping = 1e8;
/// Share of its squares below which a step has taken off what there was.
constexpr double refined_share = 2e-3;
/// Guesses that are followed: of four the worst one, by what it predicts, hardly ever leads further than the others.
constexpr std::size_t most_guesses = 3;

/// Finite difference of a sensor's offset that goes round the loop [m].
constexpr double step_of_offset_m = 2e-9;

Stretch wholeOf(const Recording& rec, const Model& base) {
  Stretch whole = stretchOf(rec, base);
  whole.contact_step_s = contactStep(base);
  whole.by_events = base.friction_law == FrictionLaw::set_valued;
  return whole;
}

}  // namespace

StartUnknowns::StartUnknowns(const Machine<double>& machine, const Model& model, Spin spin)
    : mechanics_(mechanicsSize(model, spin)),
      free_(mechanics_ - (spin == Spin::prescribed ? 0 : 2)),
      coordinates_(2 * (free_ > 0 ? machine.rotor().modes() : 0)),
      electrics_(machine.electricsOffset()),
      filter_order_(machine.electrics().filterOrder()),
      ring_(machine.ringState()),
      mount_(machine.mountState()),
      ki_(model.amb_model == AmbModel::linear ? model.rig.controller.ki_A_per_m_s : 0.0) {}

void StartUnknowns::setRingSpeeds(MachineState<double>& state, const std::array<double, 2>& speeds) const {
  for (int e = 0; e < 2 && ring_ >= 0; ++e) state.mechanics[ring_ + e] = speeds[e];
}

void StartUnknowns::takeRingSpeeds(MachineState<double>& state, const MachineState<double>& from) const {
  if (hasRing()) setRingSpeeds(state, {ringSpeed(from, 0), ringSpeed(from, 1)});
}

double StartUnknowns::scale(int unknown, const StartScales& scales) const {
  const int k = unknown;
  if (k >= free_ + 4) return scales.current / ki_;
  if (k >= free_) return scales.current;
  if (k >= electrics_) {  // filters: value, slope; coils: current
    const int place = k - electrics_;
    if (place >= 4 * filter_order_) return scales.current;
    return place % filter_order_ == 0 ? scales.displacement : scales.rate;
  }
  if (k < coordinates_) return scales.displacement;
  if (k < 2 * coordinates_) return scales.rate;
  if (ring_ >= 0 && (k == ring_ || k == ring_ + 1)) return scales.ring;
  if (mount_ >= 0 && k >= mount_ + 8) return scales.displacement;  // branches of an elastomer's mount
  return (k - 2 * coordinates_) % 4 < 2 ? scales.displacement : scales.rate;
}

double StartUnknowns::value(const MachineState<double>& state, int unknown) const {
  if (unknown >= free_ + 4) return state.controller[unknown - free_ - 4].integral;
  return unknown < free_ ? state.mechanics[unknown] : state.current[unknown - free_];
}

void StartUnknowns::addPrior(const MachineState<double>& guess, const MachineState<double>& at, Eigen::MatrixXd& h,
                             Eigen::VectorXd& b) const {
  for (int k = 0; k < size(); ++k) {
    const double prior = scale(k, prior_of_start);
    h(k, k) += 1.0 / (prior * prior);
    b[k] += (value(guess, k) - value(at, k)) / (prior * prior);
  }
}

MachineState<double> StartUnknowns::moved(MachineState<double> state, const Eigen::VectorXd& step) const {
  for (int k = 0; k < free_; ++k) state.mechanics[k] += step[k];
  for (int a = 0; a < 4; ++a) state.current[a] += step[free_ + a];
  for (int k = free_ + 4; k < size(); ++k) state.controller[k - free_ - 4].integral += step[k];
  return state;
}

std::vector<double> StartUnknowns::change(int unknown, double by) const {
  std::vector<double> out(mechanics_ + 8, 0.0);
  out[unknown < free_ ? unknown : mechanics_ + unknown - free_] = by;
  return out;
}

WindowedRun::WindowedRun(const Recording& recording, const std::vector<Model>& given, std::vector<double> of_coordinates,
                         const LocalState& state, bool with_offsets)
    : rec(recording),
      models(withTrialWeights(given, recording)),
      steps(std::move(of_coordinates)),
      local(state),
      offsets(with_offsets),
      whole(wholeOf(recording, models[0])),
      machine({&models[0]}, whole.spin),
      unknowns(machine, models[0], whole.spin),
      channels(static_cast<double>(
          std::count_if(recording.noise.begin(), recording.noise.end(), [](double noise) { return noise > 0.0; }))) {}

ContactWindow::ContactWindow(const WindowedRun& run, long first, long last)
    : run_(run), stretch_(run.whole), first_(first), samples_(last - first), used_(last - first) {
  stretch_.first = first;
  stretch_.last = last;
  stretch_.by_events = run.whole.by_events && !slidesThroughout(run.rec, run.base(), first, last);
}

double ContactWindow::shareOfDrift(long sample) const { return static_cast<double>(first_ + sample) / run_.rec.samples - 0.5; }

double ContactWindow::offset(int channel, long sample) const {
  if (channel >= axis_count || run_.rec.offsets_in_loop) return 0.0;
  return run_.local.offset_m[channel] + run_.local.drift_m[channel] * shareOfDrift(sample);
}

LaneJob ContactWindow::jobFrom(const Model& model, const MachineState<double>& from) const {
  LaneJob job = jobOf(run_.rec, model, run_.local.angle_rad);
  job.start = &from;
  for (int a = 0; a < axis_count && run_.rec.offsets_in_loop; ++a)  // a drift is next to nothing within a window
    job.offset_m[a] = run_.local.offset_m[a] + run_.local.drift_m[a] * shareOfDrift(samples_ / 2);
  return job;
}

double ContactWindow::squaresOf(const double* out) const {
  double sum = 0.0;
  for (int c = 0; c < predicted_channels; ++c) {
    if (run_.rec.noise[c] <= 0.0) continue;
    for (long i = 0; i < used_; ++i) {
      const double e = run_.rec.measured[(first_ + i) * predicted_channels + c] - out[i * predicted_channels + c] - offset(c, i);
      sum += (e / run_.rec.noise[c]) * (e / run_.rec.noise[c]);
    }
  }
  return sum;
}

std::vector<double> ContactWindow::squaresFrom(const std::vector<MachineState<double>>& starts, std::vector<double>& outs) const {
  const std::size_t width = static_cast<std::size_t>(used_) * predicted_channels;
  std::vector<LaneJob> jobs;
  outs.resize(width * starts.size());
  for (std::size_t k = 0; k < starts.size(); ++k) {
    jobs.push_back(jobFrom(run_.base(), starts[k]));
    jobs.back().out = outs.data() + k * width;
  }
  Stretch stretch = stretch_;
  stretch.last = first_ + used_;
  if (!jobs.empty()) predict(stretch, jobs);
  std::vector<double> left;
  for (std::size_t k = 0; k < starts.size(); ++k) left.push_back(jobs[k].finite ? squaresOf(outs.data() + k * width) : 1e300);
  return left;
}

std::vector<MachineState<double>> ContactWindow::byPrediction(std::vector<MachineState<double>> guesses) const {
  for (auto& one : guesses)
    one.pending.resize(guesses[0].pending.size(),
                       guesses[0].pending.empty() ? PendingCommand<double>{} : guesses[0].pending.back());
  std::vector<double> outs;
  const std::vector<double> left = squaresFrom(guesses, outs);
  std::vector<std::size_t> order(guesses.size());
  std::iota(order.begin(), order.end(), 0);
  std::sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) { return left[a] < left[b]; });
  std::vector<MachineState<double>> sorted;
  for (const std::size_t place : order) sorted.push_back(guesses[place]);
  return sorted;
}

bool ContactWindow::linearise(bool with_coordinates, const std::vector<double>& known) {
  const int g = with_coordinates ? run_.coordinates() : 0, w = run_.unknowns.size(), r = run_.offsetUnknowns();
  std::vector<LaneJob> jobs;
  std::vector<std::vector<double>> changes;
  for (int k = 0; k < w; ++k) changes.push_back(run_.unknowns.change(k, run_.unknowns.scale(k, steps_of_start)));
  const auto add = [&](const Model& model, const double* change) {
    jobs.push_back(jobFrom(model, start));
    jobs.back().start_change = change;
  };
  add(run_.base(), nullptr);
  for (int k = 0; k < g; ++k) add(run_.models[k + 1], nullptr);
  for (int k = 0; k < w; ++k) add(run_.base(), changes[k].data());
  const bool moves = with_coordinates && r > 0 && run_.rec.offsets_in_loop;  // what an offset does is predicted, too
  for (int a = 0; a < axis_count && moves; ++a) {
    add(run_.base(), nullptr);
    jobs.back().offset_m[a] += step_of_offset_m;
  }
  Stretch stretch = stretch_;
  stretch.last = first_ + used_;
  const std::size_t width = static_cast<std::size_t>(used_) * predicted_channels;
  predicted.resize(width * jobs.size());
  for (std::size_t k = 0; k < jobs.size(); ++k) jobs[k].out = predicted.data() + k * width;
  jobs[0].end = &end;
  if (run_.unknowns.hasRing()) ends.resize(w);
  for (std::size_t k = 0; k < ends.size(); ++k) jobs[1 + g + k].end = &ends[k];
  if (!known.empty()) {
    AMB_ROTOR_CHECK(known.size() == width && !with_coordinates, "a known prediction is of the window, and has no end to go on from");
    std::copy(known.begin(), known.end(), predicted.begin());
    jobs.erase(jobs.begin());
  }
  predict(stretch, jobs);
  if (!std::all_of(jobs.begin(), jobs.end(), [](const LaneJob& job) { return job.finite; })) return false;
  const int columns = g + w, size = columns + r;
  std::vector<double> steps(run_.steps.begin(), run_.steps.begin() + g);
  for (int k = 0; k < w; ++k) steps.push_back(run_.unknowns.scale(k, steps_of_start));
  h = Eigen::MatrixXd::Zero(size, size);
  b = Eigen::VectorXd::Zero(size);
  squares = 0.0;
  Eigen::MatrixXd rows(used_, size);
  Eigen::VectorXd residuals(used_);
  for (int c = 0; c < predicted_channels; ++c) {
    if (run_.rec.noise[c] <= 0.0) continue;
    const double weight = 1.0 / run_.rec.noise[c];
    if (r > 0) rows.rightCols(r).setZero();
    for (long i = 0; i < used_; ++i) {
      const std::size_t place = i * predicted_channels + c;
      const double y = predicted[place];
      for (int k = 0; k < columns; ++k) rows(i, k) = (predicted[(k + 1) * width + place] - y) / steps[k] * weight;
      residuals[i] = (run_.rec.measured[(first_ + i) * predicted_channels + c] - y) * weight;
      if (r > 0) residuals[i] -= offset(c, i) * weight;
      for (int a = 0; a < axis_count && moves; ++a) {
        const double shown = (predicted[(columns + 1 + a) * width + place] - y) / step_of_offset_m * weight;
        rows(i, columns + a) = shown;
        rows(i, columns + axis_count + a) = shown * shareOfDrift(samples_ / 2);
      }
      if (r > 0 && c < axis_count && !run_.rec.offsets_in_loop) {
        rows(i, columns + c) = weight;
        rows(i, columns + axis_count + c) = weight * shareOfDrift(i);
      }
    }
    h.noalias() += rows.transpose() * rows;
    b.noalias() += rows.transpose() * residuals;
    squares += residuals.squaredNorm();
  }
  return true;
}

double ContactWindow::ownGain() const {
  const int g = run_.coordinates(), w = run_.unknowns.size();
  Eigen::MatrixXd own = h.block(g, g, w, w);
  Eigen::VectorXd right = b.segment(g, w);
  run_.unknowns.addPrior(guess, start, own, right);
  const Eigen::VectorXd solved = Ldlt(own).solve(right);
  return solved.allFinite() ? std::max(0.0, right.dot(solved)) : 1e300;
}

std::vector<ContactWindow::Step> ContactWindow::stepsFromHere(double damping) const {
  const int w = run_.unknowns.size();
  std::vector<Step> steps;
  for (const double factor : damping_factors) {
    const double tried = std::clamp(damping * factor, least_damping, most_damping);
    Eigen::MatrixXd own = h.topLeftCorner(w, w);
    Eigen::VectorXd right = b.head(w);
    own.diagonal() *= 1.0 + tried;
    run_.unknowns.addPrior(guess, start, own, right);
    const Eigen::VectorXd step = Ldlt(own).solve(right);
    if (step.allFinite()) steps.push_back({tried, run_.unknowns.moved(start, step)});
  }
  return steps;
}

double ContactWindow::refine(int passes) {
  if (!linearise(false)) return 1e300;
  double least = squares, damping = first_damping;
  std::vector<double> there;  // the base's prediction from the start
  for (int pass = 1; pass < passes; ++pass) {
    if (pass > 1 && !linearise(false, there)) break;
    const std::vector<Step> steps = stepsFromHere(damping);
    std::vector<MachineState<double>> starts;
    for (const Step& step : steps) starts.push_back(step.to);
    std::vector<double> outs;
    const std::vector<double> left = squaresFrom(starts, outs);
    const auto lowest = std::min_element(left.begin(), left.end());
    if (lowest == left.end() || !(*lowest < least)) break;
    const auto taken = static_cast<std::size_t>(lowest - left.begin());
    const double drop = least - *lowest;
    least = *lowest;
    start = steps[taken].to;
    damping = steps[taken].damping;
    const auto width = static_cast<std::ptrdiff_t>(outs.size() / starts.size());
    there.assign(outs.begin() + width * static_cast<std::ptrdiff_t>(taken), outs.begin() + width * static_cast<std::ptrdiff_t>(taken + 1));
    if (drop < refined_share * least) break;
  }
  return least;
}

bool ContactWindow::search(std::vector<MachineState<double>> guesses, int passes, bool thorough, bool grow) {
  const double good = thrown_off * residuals();
  double least = 1e300;
  MachineState<double> best_start = start, best_guess = guess;
  const auto keepIfBetter = [&](double left) {
    if (!(left < least)) return;
    least = left;
    best_start = start;
    best_guess = guess;
  };
  guesses = byPrediction(guesses);
  guesses.resize(std::min(guesses.size(), most_guesses));
  struct Attempt {
    MachineState<double> guess, start;
    double left;
  };
  std::vector<Attempt> attempts;
  for (const auto& one : guesses) {
    guess = start = one;
    const double left = refine(thorough ? std::min(passes, first_passes) : passes);
    keepIfBetter(left);
    if (!thorough || least < good) break;
    attempts.push_back({guess, start, left});
  }
  std::stable_sort(attempts.begin(), attempts.end(), [](const Attempt& a, const Attempt& b) { return a.left < b.left; });
  for (std::size_t k = 0; k < attempts.size() && passes > first_passes && least >= good; ++k) {
    if (k > 0 && attempts[k].left > hopeless * residuals()) break;
    guess = attempts[k].guess;
    start = attempts[k].start;
    keepIfBetter(refine(passes - first_passes + 1));  // the first of them is where it stands
  }
  for (std::size_t k = 0; grow && thorough && least >= good && k < guesses.size(); ++k) {
    start = guesses[k];
    double left = 1e300;
    long before = 0;
    for (const long part : growing_parts) {
      used_ = std::min(samples_, std::max(fewest_samples, samples_ / part));
      if (used_ == before) continue;
      before = used_;
      guess = start;
      run_.unknowns.takeRingSpeeds(guess, guesses[k]);  // these the windows before tell
      left = refine(growing_passes);
      if (!(left < lost * static_cast<double>(used_) * run_.channels)) {
        left = 1e300;
        break;
      }
    }
    used_ = samples_;
    keepIfBetter(left);
  }
  start = best_start;
  guess = best_guess;
  return run_.unknowns.belongs(start) && linearise(true);
}

}  // namespace amb_rotor
