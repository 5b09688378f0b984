// What a run without contact hands to the fit, against the whole least-squares problem written out: the same
// predictions, one row a sample, with the run's own unknowns (offset and drift of each displacement channel
// with their priors, the angle at standstill, angle and speed of a constant speed about what is known already)
// as columns of their own. Taking these columns out of the others
// by orthogonal projection must leave the fit's curvature, gradient, sums and scores.
#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <utility>

#include "../support/made_sets.hpp"
#include "amb_rotor/validation/fit.hpp"
#include "amb_rotor/validation/stretches.hpp"

namespace amb_rotor {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr double share_of_scale = step_without_contact;
constexpr double angle_prior = 1e-6;     // weight that keeps the angle where nothing shows it
constexpr double score_block_s = 0.2;
/// Both sides use the same predictions and 1e5 rows: round-off of the sums, 1e-11 at most. A term of the
/// elimination with the wrong sign changes what it explains by twice itself, and each test requires that to
/// be seen.
constexpr double elimination_round_off = 1e-8, seen_share = 100.0 * elimination_round_off;

/// The problem of one run, row by row: the displacement and current channels one after the other, then the
/// priors.
struct Rows {
  MatrixXd coordinates, local;
  VectorXd residual;
  long samples = 0;
  std::vector<int> channels;
};

Rows rowsOf(const MadeSet& set, const Recording& rec, const FitSpace& space, const LocalState& state,
            bool with_angle) {
  const bool turning = rec.angle_std_rad > 0.0;
  const int p = space.size(), angle = with_angle ? 1 : turning ? 2 : 0;
  std::vector<Model> models = {space.model(space.start())};
  for (int k = 0; k < p; ++k) {
    VectorXd moved = space.start();
    moved[k] += share_of_scale * space.coordinates()[k].scale;
    EXPECT_LE(moved[k], space.coordinates()[k].upper) << "a step downwards is not written out here";
    models.push_back(space.model(moved));
  }
  std::vector<LaneJob> jobs;
  const double steps[2] = {angle_step_rad, angle_step_rad / rec.duration()};
  const auto add = [&](const Model& model, double more_angle, double more_speed) {
    jobs.push_back(jobOf(rec, model, state.angle_rad + more_angle));
    if (!turning) return;
    const double faster = state.turning.rad_s + more_speed;
    jobs.back().speed_rad_s += faster;
    jobs.back().angle0_rad += state.turning.rad + more_angle - faster * rec.first_turns_s;
  };
  for (const Model& model : models) add(model, 0.0, 0.0);
  if (angle > 0) add(models[0], steps[0], 0.0);
  if (angle > 1) add(models[0], 0.0, steps[1]);
  const std::size_t width = static_cast<std::size_t>(rec.samples) * predicted_channels;
  std::vector<std::vector<double>> out(jobs.size(), std::vector<double>(width));
  for (std::size_t k = 0; k < jobs.size(); ++k) jobs[k].out = out[k].data();
  predict(stretchOf(rec, models[0]), jobs);

  Rows rows;
  rows.samples = rec.samples;
  for (int c = 0; c < predicted_channels; ++c)
    if (rec.noise[c] > 0.0) rows.channels.push_back(c);
  const long data = rec.samples * static_cast<long>(rows.channels.size()), locals = angle + 8;
  rows.coordinates = MatrixXd::Zero(data + locals, p);
  rows.local = MatrixXd::Zero(data + locals, locals);
  rows.residual = VectorXd::Zero(data + locals);
  long row = 0;
  for (const int c : rows.channels)
    for (long i = 0; i < rec.samples; ++i, ++row) {
      const std::size_t at = static_cast<std::size_t>(i) * predicted_channels + c;
      const double noise = rec.noise[c];
      rows.residual[row] = (rec.measured[at] - out[0][at]) / noise;
      for (int k = 0; k < p; ++k)
        rows.coordinates(row, k) =
            (out[k + 1][at] - out[0][at]) / (share_of_scale * space.coordinates()[k].scale) / noise;
      for (int k = 0; k < angle; ++k) rows.local(row, k) = (out[p + 1 + k][at] - out[0][at]) / steps[k] / noise;
      if (c < 4) {
        rows.local(row, angle + c) = 1.0 / noise;
        rows.local(row, angle + 4 + c) =
            (static_cast<double>(i) / static_cast<double>(rec.samples) - 0.5) / noise;
      }
    }
  for (int k = 0; k < locals; ++k)
    rows.local(data + k, k) = with_angle && k == 0 ? std::sqrt(angle_prior) : 1.0 / set.offset_std_m;
  if (turning) {
    rows.local(data, 0) = 1.0 / rec.angle_std_rad;
    rows.local(data + 1, 1) = 1.0 / rec.speed_std_rad_s;
    rows.residual[data] = -state.turning.rad / rec.angle_std_rad;
    rows.residual[data + 1] = -state.turning.rad_s / rec.speed_std_rad_s;
  }
  return rows;
}

/// Orthonormal columns of the same span; Gram and Schmidt, twice.
MatrixXd orthonormal(MatrixXd columns) {
  for (int pass = 0; pass < 2; ++pass)
    for (Eigen::Index k = 0; k < columns.cols(); ++k) {
      for (Eigen::Index j = 0; j < k; ++j)
        columns.col(k) -= columns.col(j).dot(columns.col(k)) * columns.col(j);
      columns.col(k).normalize();
    }
  return columns;
}

void expectAsWrittenOut(const MadeSet& set, int run, const FitSpace& space, double angle_rad,
                        bool with_angle) {
  std::vector<Recording> recordings = set.recordings;
  Recording& rec = recordings[run];
  rec.angle_std_rad *= 1e3;  // so that no end is met: this model is off by more than the pulses' times
  rec.speed_std_rad_s *= 1e3;
  const FitProblem problem(recordings, space, set.offset_std_m);
  std::vector<LocalState> local(set.recordings.size());
  local[run].angle_rad = angle_rad;
  local[run].angle_searches = 1000;  // the angle is the one given
  local[run].turning.rad = 0.7 * rec.angle_std_rad;
  local[run].turning.rad_s = -1.3 * rec.speed_std_rad_s;
  const LocalState given = local[run];
  EvaluationOptions options;
  options.scores = true;
  std::vector<RunResult> results;
  const NormalEquations found = problem.evaluate(space.start(), {run}, local, options, &results);
  ASSERT_TRUE(found.finite);

  const Rows rows = rowsOf(set, rec, space, given, with_angle);
  const MatrixXd q = orthonormal(rows.local);
  const MatrixXd free = rows.coordinates - q * (q.transpose() * rows.coordinates);
  const VectorXd left = rows.residual - q * (q.transpose() * rows.residual);
  const int p = space.size();
  const long data = rows.samples * static_cast<long>(rows.channels.size());

  const double before = rows.residual.squaredNorm(), chi2 = left.squaredNorm();
  EXPECT_GT(before - chi2, seen_share * before) << "the run's own unknowns explain something";
  EXPECT_NEAR(found.chi2, chi2, elimination_round_off * before);
  EXPECT_NEAR(found.squares, left.head(data).squaredNorm(), elimination_round_off * before);
  EXPECT_NEAR(results[0].mean_square, left.head(data).squaredNorm() / static_cast<double>(data),
              elimination_round_off * before / static_cast<double>(data));
  for (std::size_t c = 0; c < rows.channels.size(); ++c)
    EXPECT_NEAR(results[0].channel_mean_square[rows.channels[c]],
                left.segment(static_cast<long>(c) * rows.samples, rows.samples).squaredNorm() /
                    static_cast<double>(rows.samples),
                elimination_round_off * before / static_cast<double>(rows.samples))
        << rows.channels[c];

  const long length = static_cast<long>(score_block_s * rec.run.sample_rate_hz);
  MatrixXd blocks = MatrixXd::Zero(p, (rows.samples + length - 1) / length);
  for (long row = 0; row < data; ++row)
    blocks.col(row % rows.samples / length) += left[row] * free.row(row).transpose();
  const MatrixXd scores = blocks * blocks.transpose();
  int seen = 0, curvature_moved = 0, slope_moved = 0;
  for (int i = 0; i < p; ++i) {
    const double length_i = rows.coordinates.col(i).norm();
    EXPECT_NEAR(found.g[i], free.col(i).dot(left), elimination_round_off * length_i * std::sqrt(before))
        << space.coordinates()[i].name;
    if (length_i == 0.0) continue;
    ++seen;
    const double taken = (q.transpose() * rows.coordinates.col(i)).squaredNorm();
    if (taken > seen_share * length_i * length_i) ++curvature_moved;
    if (std::fabs(rows.coordinates.col(i).dot(rows.residual) - free.col(i).dot(left)) >
        seen_share * length_i * std::sqrt(before))
      ++slope_moved;
    for (int j = 0; j < p; ++j) {
      EXPECT_NEAR(found.h(i, j), free.col(i).dot(free.col(j)),
                  elimination_round_off * length_i * rows.coordinates.col(j).norm())
          << space.coordinates()[i].name << ", " << space.coordinates()[j].name;
      EXPECT_NEAR(found.scores(i, j), scores(i, j), 1e-6 * std::sqrt(scores(i, i) * scores(j, j)))
          << space.coordinates()[i].name << ", " << space.coordinates()[j].name;
    }
  }
  EXPECT_GE(seen, 4);
  EXPECT_GE(curvature_moved, 1) << "nothing to eliminate would show nothing";
  EXPECT_GE(slope_moved, 1);

  // the offsets and drifts that are kept are those of the least squares at the start
  const VectorXd solved = (rows.local.transpose() * rows.residual);
  const VectorXd kept = [&] {
    VectorXd all(rows.local.cols());
    if (with_angle) all[0] = local[run].angle_rad - angle_rad;
    if (rec.angle_std_rad > 0.0) all.head(2) << local[run].turning.rad - given.turning.rad,
                                 local[run].turning.rad_s - given.turning.rad_s;
    for (int a = 0; a < 4; ++a) {
      all[all.size() - 8 + a] = local[run].offset_m[a];
      all[all.size() - 4 + a] = local[run].drift_m[a];
    }
    return all;
  }();
  EXPECT_LT((rows.local.transpose() * (rows.residual - rows.local * kept)).norm(),
            elimination_round_off * solved.norm());
}

TEST(FitElimination, TheOffsetsAngleAndSpeedOfARun) {
  const MadeSet& set = madeSet(21, "none", 0.0, false);
  const FitSpace space(set.dataset.belief, {});
  const int run = set.indexOf("steady_2");
  ASSERT_GE(run, 0);
  ASSERT_FALSE(set.recordings[run].standstill);
  ASSERT_GT(set.recordings[run].angle_std_rad, 0.0);
  ASSERT_GT(set.recordings[run].speed_std_rad_s, 0.0);
  expectAsWrittenOut(set, run, space, 0.0, false);
}

/// A path turned back by an angle.
class TurnedBack final : public ShaftPath {
 public:
  TurnedBack(std::shared_ptr<ShaftPath> path, double by_rad) : path_(std::move(path)), by_rad_(by_rad) {}
  ShaftInstant at(double time) const override {
    ShaftInstant now = path_->at(time);
    now.angle -= by_rad_;
    return now;
  }

 private:
  std::shared_ptr<ShaftPath> path_;
  double by_rad_;
};

TEST(FitElimination, ADrivenRunIsTurnedBesideAPathThatIsOff) {
  constexpr double off_rad = 0.02;
  const MadeSet& set = madeSet(21, "none", 0.0, false);
  const FitSpace space(set.truth(), {});
  std::vector<Recording> recordings = set.recordings;
  const auto driven = std::find_if(recordings.begin(), recordings.end(), [](const Recording& rec) { return rec.path != nullptr; });
  ASSERT_NE(driven, recordings.end());
  EXPECT_EQ(driven->angle_std_rad, 0.0) << "pulses with values between the levels tell it";
  const int run = static_cast<int>(driven - recordings.begin());
  driven->path = std::make_shared<TurnedBack>(driven->path, off_rad);
  const auto leftOf = [&] {
    const FitProblem problem(recordings, space, set.offset_std_m);
    std::vector<LocalState> local(recordings.size());
    std::vector<RunResult> results;
    for (int pass = 0; pass < 2; ++pass) problem.evaluate(space.start(), {run}, local, {}, &results);
    return std::make_pair(results[0].mean_square, local[run].turning);
  };
  const double held = leftOf().first;
  driven->angle_std_rad = off_rad;
  driven->speed_std_rad_s = 0.1;
  driven->first_turns_s = 0.5 * driven->duration();
  const auto [freed, turning] = leftOf();
  EXPECT_GT(held, 1.1);
  EXPECT_LT(freed, 1.02 * 1.02);  // the truth, at its noise
  EXPECT_NEAR(turning.rad, off_rad, 0.05 * off_rad);
  EXPECT_NEAR(turning.rad_s, 0.0, 0.02);
}

TEST(FitElimination, AWrongModelDoesNotTurnTheShaft) {
  const MadeSet& set = madeSet(21, "none", 0.0, false);
  const FitSpace space(set.dataset.belief, {});
  const FitProblem problem(set.recordings, space, set.offset_std_m);
  const int run = set.indexOf("steady_2");
  const Recording& rec = set.recordings[run];
  std::vector<LocalState> local(set.recordings.size());
  std::vector<RunResult> results;
  const NormalEquations found = problem.evaluate(space.start(), {run}, local, {}, &results);
  EXPECT_NEAR(std::fabs(local[run].turning.rad), 3.0 * rec.angle_std_rad, 1e-3 * rec.angle_std_rad) << "it would go on";
  EXPECT_LE(std::fabs(local[run].turning.rad_s), 3.001 * rec.speed_std_rad_s);
  // and the sum is that of where it stands: the same again, from there
  const double again = problem.evaluate(space.start(), {run}, local, {}, &results).chi2;
  EXPECT_NEAR(again, found.chi2, 1e-5 * found.chi2);
}

TEST(FitElimination, TheAngleAtStandstill) {
  const MadeSet& set = madeSet(21, "none", 0.0, false);
  const FitSpace space(set.dataset.belief,
                       {{"sensor_runout", {2e-5, 0.4, 1e-5, 1.0, 1e-5, -0.8, 5e-6, 0.2}}});
  int run = -1;
  for (std::size_t i = 0; i < set.recordings.size(); ++i)
    if (set.recordings[i].standstill && run < 0) run = static_cast<int>(i);
  ASSERT_GE(run, 0) << "no run at standstill";
  expectAsWrittenOut(set, run, space, 0.7, true);
}

}  // namespace
}  // namespace amb_rotor
