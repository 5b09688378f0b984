#include "amb_rotor/validation/start_screen.hpp"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>

#include "amb_rotor/common/linear_algebra.hpp"
#include "amb_rotor/validation/channel_products.hpp"
#include "amb_rotor/validation/loop_offsets.hpp"
#include "amb_rotor/validation/stretches.hpp"

namespace amb_rotor {
namespace {

/// Two changes that differ by less than this share of their squares count as one.
constexpr double hardly_apart = 1e-6;

/// Predictions of all models of one structure, in the smallest step that any of them needs.
std::vector<std::vector<double>> predictions(const Recording& rec, const std::vector<Model>& given, double angle,
                                             const ShaftTurn& turning, double run_in_s, const Eigen::VectorXd& offsets,
                                             std::vector<bool>& finite) {
  const std::vector<Model> models = rec.run.unbalance.empty() ? given : withTrialWeights(given, rec);
  Stretch stretch = stretchOf(rec, models[0]);
  stretch.settle_s = std::max(stretch.settle_s, run_in_s);
  std::vector<std::vector<double>> outs(models.size());
  std::vector<LaneJob> jobs;
  for (std::size_t k = 0; k < models.size(); ++k) {
    stretch.largest_step_s = std::min(stretch.largest_step_s, freeStep(models[k]));
    outs[k].resize(static_cast<std::size_t>(rec.samples) * predicted_channels);
    jobs.push_back(jobOf(rec, models[k], angle));
    turnShaft(rec, turning, jobs.back());
    takeOffsets(rec, offsets, jobs.back());
    jobs.back().out = outs[k].data();
  }
  predict(stretch, jobs);
  finite.clear();
  for (const auto& job : jobs) finite.push_back(job.finite);
  return outs;
}

/// Products of a run's columns, over the noise: those known, changes (empty: none), then `own` of its offsets and drifts.
ChannelProducts runProducts(const Recording& rec, const Eigen::MatrixXf& known, const std::vector<std::vector<double>>& changes,
                            int own, long first) {
  std::array<double, predicted_channels> weight;
  for (int c = 0; c < predicted_channels; ++c) weight[c] = rec.noise[c] > 0.0 ? 1.0 / rec.noise[c] : 0.0;
  ChannelProducts sums(static_cast<int>(known.cols() + changes.size()) + own);
  for (long from = first; from < rec.samples; from += ChannelProducts::block) {
    const long instants = std::min(ChannelProducts::block, rec.samples - from), numbers = instants * predicted_channels;
    const long at = from * predicted_channels;
    int k = 0;
    for (; k < known.cols(); ++k) std::copy_n(known.col(k).data() + at, numbers, sums.column(k));
    for (const auto& change : changes) {  // what has none stays at zero
      if (!change.empty()) sums.fill(k, change.data() + at, weight.data(), instants);
      ++k;
    }
    for (long i = 0; i < numbers; ++i) {
      const double w = weight[i % predicted_channels];
      for (int o = 0; o < own && rec.offsets_in_loop; ++o) sums.column(k + o)[i] = rec.offset_columns[(at + i) * own + o] * w;
      if (rec.offsets_in_loop) continue;
      sums.column(k)[i] = w;
      sums.column(k + 1)[i] = w * (static_cast<double>(from + i / predicted_channels) / rec.samples - 0.5);
    }
    sums.add(instants);
  }
  return sums;
}

}  // namespace

StartScreen::StartScreen(const std::vector<Recording>& recordings, const std::vector<int>& which, const FitSpace& space,
                         const Eigen::VectorXd& x, const std::vector<LocalState>& local, double offset_std_m)
    : recordings_(recordings), offset_std_(offset_std_m), parts_(which.size()) {
  const int p = space.size();
  prior_weight_ = Eigen::VectorXd::Zero(p);
  prior_pull_ = Eigen::VectorXd::Zero(p);
  std::vector<Model> models = {space.model(x)};
  std::vector<double> steps;
  for (int k = 0; k < p; ++k) {
    const Coordinate& c = space.coordinates()[k];
    if (c.prior_std > 0.0) {
      prior_weight_[k] = 1.0 / (c.prior_std * c.prior_std);
      prior_pull_[k] = prior_weight_[k] * (c.prior_mean - x[k]);
    }
    const double step = step_without_contact * c.scale;
    steps.push_back(x[k] + step <= c.upper ? step : -step);
    Eigen::VectorXd moved = x;
    moved[k] += steps.back();
    models.push_back(space.model(moved));
  }
  tbb::parallel_for(std::size_t{0}, which.size(), [&](std::size_t n) {
    Part& part = parts_[n];
    part.recording = which[n];
    part.angle_rad = local[which[n]].angle_rad;
    part.turning = local[which[n]].turning;
    part.run_in_s = local[which[n]].run_in_s;
    const Recording& rec = recordings_[which[n]];
    part.offsets = offsetsInLanes(rec, local[which[n]], offset_std_);
    std::vector<bool> finite;
    auto outs = predictions(rec, models, part.angle_rad, part.turning, part.run_in_s, part.offsets, finite);
    part.columns = Eigen::MatrixXf::Zero(rec.samples * predicted_channels, p + 1);
    part.lost = !finite[0];
    for (long i = 0; i < part.columns.rows() && !part.lost; ++i) {
      const double noise = rec.noise[i % predicted_channels];
      if (noise <= 0.0) continue;
      for (int k = 0; k < p; ++k)
        if (finite[k + 1]) part.columns(i, k) = static_cast<float>((outs[k + 1][i] - outs[0][i]) / (steps[k] * noise));
      part.columns(i, p) = static_cast<float>((rec.measured[i] - outs[0][i]) / noise);
    }
    part.predicted = std::move(outs[0]);
  });
}

bool StartScreen::isFinite() const {
  return std::none_of(parts_.begin(), parts_.end(), [](const Part& part) { return part.lost; });
}

FrozenColumns StartScreen::directions() const {
  FrozenColumns out;
  out.size = static_cast<int>(prior_weight_.size());
  for (const Part& part : parts_) out.of_recording[part.recording] = &part.columns;
  return out;
}

Eigen::MatrixXd StartScreen::products(int count, const Changes& changes, double from_s) const {
  const int p = static_cast<int>(prior_weight_.size()), s = count;
  const int size = p + 1 + s;
  std::vector<Eigen::MatrixXd> grams(parts_.size(), Eigen::MatrixXd::Zero(size, size));
  tbb::parallel_for(std::size_t{0}, parts_.size(), [&](std::size_t n) {
    const Part& part = parts_[n];
    const Recording& rec = recordings_[part.recording];
    if (part.lost) return;
    const auto outs = changes({rec, part.angle_rad, part.turning, part.run_in_s, part.offsets, part.predicted});
    if (outs.empty()) return;
    const bool in_loop = rec.offsets_in_loop;
    const int own = in_loop ? 2 * axis_count : 2;  // 1, t of one channel, or what offsets and drifts show there
    const ChannelProducts sums = runProducts(rec, part.columns, outs, own, std::lround(from_s * rec.run.sample_rate_hz));
    const auto eliminate = [&](const Eigen::MatrixXd& gram) {
      const double weight = 1.0 / (offset_std_ * offset_std_);
      Eigen::MatrixXd locals = gram.bottomRightCorner(own, own), pull = gram.bottomLeftCorner(own, size);
      locals.diagonal().array() += weight;
      if (in_loop) pull.col(p) -= weight * part.offsets;
      grams[n] -= pull.transpose() * Ldlt(locals).solveColumns(pull);
    };
    Eigen::MatrixXd all = Eigen::MatrixXd::Zero(size + own, size + own);
    for (int c = 0; c < predicted_channels; ++c) {
      if (rec.noise[c] <= 0.0) continue;
      const Eigen::MatrixXd small = sums.of(c);
      grams[n] += small.topLeftCorner(size, size);
      if (in_loop) all += small;
      if (offset_std_ > 0.0 && !in_loop && c < 4) eliminate(small);
    }
    if (offset_std_ > 0.0 && in_loop) eliminate(all);
  });
  Eigen::MatrixXd gram = Eigen::MatrixXd::Zero(size, size);
  for (const auto& part : grams) gram += part;
  return gram;
}

StartScreen::Freed StartScreen::freed(const std::vector<Model>& moved, bool standstill) const {
  const int p = static_cast<int>(prior_weight_.size()), s = static_cast<int>(moved.size());
  std::vector<std::atomic<bool>> lost(moved.size());
  const Eigen::MatrixXd gram = products(s, [&](const ReferenceRun& run) {
    std::vector<std::vector<double>> outs;
    if (run.recording.standstill && !standstill) return outs;
    std::vector<bool> finite;
    outs = predictions(run.recording, moved, run.angle_rad, run.turning, run.run_in_s, run.offsets, finite);
    for (std::size_t k = 0; k < outs.size(); ++k) {
      if (!finite[k]) {
        lost[k] = true;
        outs[k].clear();
      }
      for (std::size_t at = 0; at < outs[k].size(); ++at) outs[k][at] -= run.predicted[at];
    }
    return outs;
  });
  Eigen::MatrixXd nuisance = gram.topLeftCorner(p, p);
  nuisance.diagonal() += prior_weight_;
  const Eigen::VectorXd pull = gram.col(p).head(p) + prior_pull_;
  const Eigen::MatrixXd cross = gram.block(0, p + 1, p, s);
  const Eigen::MatrixXd along = p > 0 ? Eigen::MatrixXd(Ldlt(nuisance).solveColumns(cross)) : cross;
  Freed out;
  out.squares = gram.bottomRightCorner(s, s) - cross.transpose() * along;
  out.along = gram.col(p).tail(s) - along.transpose() * pull;
  out.lost.assign(lost.begin(), lost.end());
  return out;
}

std::vector<StartGain> StartScreen::gains(const std::vector<Model>& starts, bool either_sign, bool standstill) const {
  const Freed changes = freed(starts, standstill);
  std::vector<StartGain> out;
  for (long k = 0; k < changes.along.size(); ++k) {
    if (changes.lost[k]) {
      out.emplace_back();
      continue;
    }
    const double square = changes.squares(k, k), along = changes.along[k];
    const bool uphill = !(square > 0.0) || (!either_sign && along <= 0.0);
    out.push_back(uphill ? StartGain{0.0, 0.0} : StartGain{0.5 * along * along / square, along / square});
  }
  return out;
}

double StartScreen::gainTogether(const std::vector<Model>& moved, bool standstill) const {
  const Freed changes = freed(moved, standstill);
  if (std::any_of(changes.lost.begin(), changes.lost.end(), [](bool lost) { return lost; })) return 0.0;
  const long s = changes.along.size();
  const Eigen::VectorXd size = changes.squares.diagonal().cwiseMax(0.0).cwiseSqrt();
  std::vector<int> seen;  // what changes nothing is no direction
  for (int k = 0; k < s; ++k)
    if (size[k] > 0.0) seen.push_back(k);
  if (seen.empty()) return 0.0;
  const Eigen::VectorXd scale = size(seen).cwiseInverse();
  Eigen::MatrixXd alike = scale.asDiagonal() * changes.squares(seen, seen) * scale.asDiagonal();
  alike.diagonal().array() += hardly_apart;
  const Eigen::VectorXd along = scale.cwiseProduct(changes.along(seen));
  const double drop = along.dot(Ldlt(alike).solve(along));
  return std::isfinite(drop) ? 0.5 * std::max(0.0, drop) : 0.0;
}

}  // namespace amb_rotor
