// The gain that a start's own direction promises: against the parabola through the fit's own sums of squares, and at
// the work it is for, telling where a hidden resonance lies.
#include "amb_rotor/validation/start_screen.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "../support/made_sets.hpp"
#include "amb_rotor/common/linear_algebra.hpp"
#include "amb_rotor/validation/starts.hpp"
#include "amb_rotor/validation/stretches.hpp"

namespace amb_rotor {
namespace {

Model with(Model model, const std::string& effect, const std::vector<double>& values) {
  model.effects.push_back({effect, values});
  return model;
}

TEST(StartScreenTest, GainIsThatOfTheParabolaAlongTheStart) {
  const MadeSet& set = madeSet(21, "none", 0.0, false);
  Model truth = set.truth();
  const FitSpace space(truth, {});
  ASSERT_EQ(space.size(), 0) << "nothing but the start may move";
  std::vector<LocalState> local(set.recordings.size());
  const std::vector<int> which = {set.indexOf("steady_1"), set.indexOf("steady_2")};
  ASSERT_GE(*std::min_element(which.begin(), which.end()), 0);
  constexpr double load_N = 0.05;
  const auto loaded = [&](double share) { return with(truth, "static_load", {share * load_N, 0.0, 0.0, 0.0}); };
  const auto squares = [&](double share) {
    const FitSpace own(loaded(share), {});
    std::vector<LocalState> fresh(set.recordings.size());
    EvaluationOptions value_only;
    value_only.jacobian = false;
    return FitProblem(set.recordings, own, set.offset_std_m).evaluate(own.start(), which, fresh, value_only).chi2;
  };
  const double none = squares(0.0), up = squares(1.0), down = squares(-1.0);
  const double slope = (down - up) / 4.0, curvature = (up + down - 2.0 * none) / 2.0;
  ASSERT_GT(curvature, 0.0);
  const StartScreen screen(set.recordings, which, space, space.start(), local, set.offset_std_m);
  const auto gains = screen.gains({loaded(1.0), loaded(-1.0)}, false, true);
  // the model is linear in the load; what differs is that the screen keeps its residual in single precision (6e-8 of
  // some 1e6 squares, of which the gain is a difference)
  const double expected = 0.5 * slope * slope / curvature;
  EXPECT_NEAR(gains[slope > 0.0 ? 0 : 1].gain, expected, 0.01 * expected + 0.01);
  EXPECT_EQ(gains[slope > 0.0 ? 1 : 0].gain, 0.0) << "the other way uphill";
  const auto both = screen.gains({loaded(1.0), loaded(-1.0)}, true, true);
  EXPECT_NEAR(both[0].gain, both[1].gain, 0.01 * expected + 0.01);
  const double share = slope / curvature;
  EXPECT_NEAR(both[0].share, share, 0.01 * std::fabs(share));
  EXPECT_NEAR(both[1].share, -share, 0.01 * std::fabs(share));
}

/// Least of half the sum of squares over the columns named, with the residual as last column and priors as weights.
double leastSquares(const Eigen::MatrixXd& rows, const Eigen::VectorXd& priors, const Eigen::VectorXd& pull,
                    const std::vector<int>& columns, double* last = nullptr) {
  const int n = static_cast<int>(columns.size()), residual = static_cast<int>(rows.cols()) - 1;
  Eigen::MatrixXd h(n, n);
  Eigen::VectorXd g(n);
  for (int i = 0; i < n; ++i) {
    for (int j = 0; j < n; ++j) h(i, j) = rows.col(columns[i]).dot(rows.col(columns[j]));
    h(i, i) += priors[columns[i]];
    g[i] = rows.col(columns[i]).dot(rows.col(residual)) + pull[columns[i]];
  }
  const Eigen::VectorXd solved = Ldlt(h).solve(g);
  if (last != nullptr) *last = solved[n - 1];
  return 0.5 * rows.col(residual).squaredNorm() - 0.5 * g.dot(solved);
}

TEST(StartScreenTest, GainIsThatOfTheWholeProblemWithNuisanceOffsetsAndDrifts) {
  // Two short runs written out row by row: a column for each uncertain number, for offset and drift of each run's
  // displacement channels, and for the start. What the start is worth is the difference of two least squares.
  const MadeSet& set = cleanSet();
  std::vector<Recording> recordings;
  for (const char* id : {"steady_1", "steady_2"})
    recordings.push_back(beginningOf(set.recordings.at(set.indexOf(id)), 1500));
  const FitSpace space(set.dataset.belief, {});
  const int p = space.size(), locals = 8, start = p + 2 * locals, residual = start + 1;
  Eigen::VectorXd x = space.start();
  for (int k = 0; k < p; ++k) x[k] += 0.2 * space.coordinates()[k].prior_std;  // off the priors' middle: they pull
  const Model reference = space.model(x);
  const Model started = with(reference, "static_load", {1.5, 0.5, 0.0, 0.0});
  std::vector<Model> models = {reference, started};
  std::vector<double> steps;
  for (int k = 0; k < p; ++k) {
    steps.push_back(0.01 * space.coordinates()[k].scale);  // the screen's is another one
    Eigen::VectorXd moved = x;
    moved[k] += steps[k];
    models.push_back(space.model(moved));
  }
  const long samples = recordings[0].samples, width = samples * predicted_channels;
  Eigen::MatrixXd rows = Eigen::MatrixXd::Zero(2 * width, residual + 1);
  for (int run = 0; run < 2; ++run) {
    Recording& rec = recordings[run];
    std::vector<std::vector<double>> outs(models.size(), std::vector<double>(width));
    for (std::size_t m = 0; m < models.size(); ++m) {  // one structure at a time
      std::vector<LaneJob> jobs = {jobOf(rec, models[m], 0.0)};
      jobs[0].out = outs[m].data();
      predict(stretchOf(rec, models[m]), jobs);
      ASSERT_TRUE(jobs[0].finite);
    }
    for (long i = 0; i < width; ++i) {
      const int c = static_cast<int>(i % predicted_channels);
      rec.measured[i] += 0.4 * (outs[1][i] - outs[0][i]);  // a share of the start is there
      if (rec.noise[c] <= 0.0) continue;
      auto row = rows.row(run * width + i);
      for (int k = 0; k < p; ++k) row[k] = (outs[2 + k][i] - outs[0][i]) / (steps[k] * rec.noise[c]);
      row[start] = (outs[1][i] - outs[0][i]) / rec.noise[c];
      row[residual] = (rec.measured[i] - outs[0][i]) / rec.noise[c];
      if (c >= 4) continue;
      row[p + locals * run + c] = 1.0 / rec.noise[c];
      row[p + locals * run + 4 + c] = (double(i / predicted_channels) / samples - 0.5) / rec.noise[c];
    }
  }
  Eigen::VectorXd priors = Eigen::VectorXd::Zero(start + 1), pull = priors;
  for (int k = 0; k < p; ++k) {
    const Coordinate& c = space.coordinates()[k];
    priors[k] = 1.0 / (c.prior_std * c.prior_std);
    pull[k] = priors[k] * (c.prior_mean - x[k]);
  }
  priors.segment(p, 2 * locals).setConstant(1.0 / (set.offset_std_m * set.offset_std_m));
  std::vector<int> without, all;
  for (int k = 0; k < start; ++k) without.push_back(k);
  all = without;
  all.push_back(start);
  double share = 0.0;
  const double gain = leastSquares(rows, priors, pull, without) - leastSquares(rows, priors, pull, all, &share);
  const double alone = std::pow(rows.col(start).dot(rows.col(residual)), 2) / (2.0 * rows.col(start).squaredNorm());
  ASSERT_GT(gain, 10.0);
  EXPECT_GT(std::fabs(alone / gain - 1.0), 0.5) << "what the run's and the machine's own unknowns take must matter";

  std::vector<LocalState> local(2);
  const StartScreen screen(recordings, {0, 1}, space, x, local, set.offset_std_m);
  const auto found = screen.gains({started}, true, true);
  // single precision of the screen's columns, and differences over another step: the prediction is bent by less
  // than 1 % over a hundredth of a scale
  EXPECT_NEAR(found[0].gain, gain, 0.02 * gain);
  EXPECT_NEAR(found[0].share, share, 0.02 * std::fabs(share));
}

TEST(StartScreenTest, PointsAtTheHiddenResonance) {
  const MadeSet& set = madeSet(21, "none", 0.0, false);
  constexpr double frequency_hz = 56.0;  // between two starts
  const Model bare = set.truth();
  const Model resonant = with(bare, "foundation_resonance", {12.0 * bare.rig.rotor.mass_kg, frequency_hz, 0.04});
  // the event-accurate runs with their noise, and on top what the resonance changes
  std::vector<Recording> recordings = set.recordings;
  const std::vector<int> which = set.runs(RunUse::fit, false);
  const auto predicted = [&](const Model& model) {
    const FitSpace own(model, {});
    std::vector<LocalState> fresh(recordings.size());
    EvaluationOptions keep;
    keep.jacobian = false;
    keep.keep_prediction = true;
    std::vector<RunResult> results;
    FitProblem(set.recordings, own, 0.0).evaluate(own.start(), which, fresh, keep, &results);
    return results;
  };
  const auto before = predicted(bare), after = predicted(resonant);
  for (std::size_t k = 0; k < which.size(); ++k) {
    ASSERT_TRUE(before[k].finite && after[k].finite);
    auto& measured = recordings[which[k]].measured;
    for (std::size_t i = 0; i < measured.size(); ++i) measured[i] += after[k].predicted[i] - before[k].predicted[i];
  }
  const FitSpace space(set.dataset.belief, {});
  std::vector<LocalState> local(recordings.size());
  const FitResult reference = fit(FitProblem(recordings, space, set.offset_std_m), space.start(), which, local, {});
  const StartScreen screen(recordings, which, space, reference.x, local, set.offset_std_m);
  std::string reason;
  const auto starts = startingValues("foundation_resonance", set.dataset.belief, recordings, reason);
  std::vector<Model> models;
  std::vector<double> apart;  // from the truth, in log frequency
  for (const auto& start : starts) {
    models.push_back(with(space.model(reference.x), "foundation_resonance", start));
    apart.push_back(std::fabs(std::log(start[1] / frequency_hz)));
  }
  const auto gains = screen.gains(models, false, true);
  const auto best = std::max_element(gains.begin(), gains.end(),
                                     [](const StartGain& a, const StartGain& b) { return a.gain < b.gain; }) - gains.begin();
  EXPECT_GT(gains[best].gain, 100.0) << "it is plain in these runs";
  // the starts are a factor of about 1.45 apart
  EXPECT_LT(apart[best], std::log(1.45)) << "best start at " << starts[best][1] << " Hz";
}

}  // namespace
}  // namespace amb_rotor
