// The gain that a start's own direction promises: against the parabola through the fit's own sums of squares, and at
// the work it is for, telling where a hidden resonance lies.
#include "amb_rotor/validation/start_screen.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "../support/made_sets.hpp"
#include "../support/models.hpp"
#include "amb_rotor/common/linear_algebra.hpp"
#include "amb_rotor/common/units.hpp"
#include "amb_rotor/validation/starts.hpp"
#include "amb_rotor/validation/stretches.hpp"

namespace amb_rotor {
namespace {

using namespace testing_support;

TEST(StartScreenTest, GainIsThatOfTheParabolaAlongTheStart) {
  const MadeSet& set = madeSet(21, "none", 0.0, false);
  Model truth = set.truth();
  const FitSpace space(truth, {});
  ASSERT_EQ(space.size(), 0) << "nothing but the start may move";
  std::vector<LocalState> local(set.recordings.size());
  const std::vector<int> which = {set.indexOf("steady_1"), set.indexOf("steady_2")};
  ASSERT_GE(*std::min_element(which.begin(), which.end()), 0);
  constexpr double load_N = 0.05;
  const auto loaded = [&](double share) { return with(truth, "static_load", {share * load_N, 0.0}); };
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

TEST(StartScreenTest, ARotorThatIsLostPromisesNothing) {
  const MadeSet& set = madeSet(21, "none", 0.0, false);
  const std::vector<LocalState> local(set.recordings.size());
  const std::vector<int> which = {set.indexOf("steady_1")};
  const auto screenOf = [&](const Model& model) {
    const FitSpace space(model, {});
    return StartScreen(set.recordings, which, space, space.start(), local, set.offset_std_m);
  };
  Model lost = set.truth();
  lost.rig.controller.kp_A_per_m *= 0.01;  // less than the magnets pull
  const std::vector<Model> loaded = {with(lost, "static_load", {0.05, 0.0})};
  const StartScreen screen = screenOf(lost);
  EXPECT_FALSE(screen.isFinite());
  EXPECT_EQ(screen.gains(loaded, true, true)[0].gain, 0.0);
  EXPECT_TRUE(screenOf(set.truth()).isFinite());
}

TEST(StartScreenTest, TheShaftStandsWhereTheRunsHaveTurnedIt) {
  // a tacho of two levels leaves the shaft's angle open to some hundredths of a radian: taken where the pulses have it, a model at its
  // floor promised a bow 26000 of evidence
  const MadeSet& set = madeSet(21, "none", 0.0, false);
  const FitSpace space(set.truth(), {});
  const std::vector<int> which = {set.indexOf("steady_1"), set.indexOf("steady_2")};
  std::vector<LocalState> local(set.recordings.size());
  const std::vector<Model> bows = {with(set.truth(), "shaft_bow", {1e-6, 1e-6, 0.3})};
  const auto gainOf = [&](const std::vector<Recording>& recordings) {
    return StartScreen(recordings, which, space, space.start(), local, set.offset_std_m).gains(bows, true, false)[0].gain;
  };
  const double exact = gainOf(set.recordings);
  std::vector<Recording> turned = set.recordings;
  for (const int run : which) {
    constexpr double off_rad = 0.03, off_rad_s = 0.02;
    turned[run].angle0_rad -= off_rad - off_rad_s * turned[run].first_turns_s;
    turned[run].speed_rad_s -= off_rad_s;
    local[run].turning = {off_rad, off_rad_s};
  }
  EXPECT_NEAR(gainOf(turned), exact, 1e-3 * exact + 1e-3);  // residuals are kept in single precision
  for (const int run : which) local[run].turning = {};
  EXPECT_GT(gainOf(turned), 3.0 * exact + 10.0) << "where the pulses have it, it is off";
}

TEST(StartScreenTest, RunsThatDoNotCountAreOutOfTheNuisanceToo) {
  // what the shaft's angle does to an effect at standstill is not known: such a run says nothing, not that nothing happens
  const MadeSet& set = madeSet(21, "none", 0.0, false);
  const FitSpace space(set.dataset.belief, {});
  ASSERT_GT(space.size(), 0);
  const std::vector<LocalState> local(set.recordings.size());
  const std::vector<int> turning = {set.indexOf("steady_1"), set.indexOf("steady_2")}, all = {turning[0], turning[1], set.indexOf("chirp_1")};
  ASSERT_TRUE(set.recordings.at(all[2]).standstill);
  const std::vector<Model> starts = {with(space.model(space.start()), "static_load", {0.05, 0.0})};
  const auto gainOver = [&](const std::vector<int>& which, bool standstill) {
    return StartScreen(set.recordings, which, space, space.start(), local, set.offset_std_m).gains(starts, true, standstill)[0].gain;
  };
  const double without = gainOver(turning, true);
  EXPECT_GT(std::fabs(gainOver(all, true) - without), 1e-3 * without) << "the run at standstill would tell something";
  EXPECT_NEAR(gainOver(all, false), without, 1e-9 * without);
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
  const Model started = with(reference, "static_load", {1.5, 0.5});
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
    std::vector<std::vector<double>> outs;
    for (const Model& model : models) outs.push_back(predictedBy(model, rec));  // one structure at a time
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
  std::vector<Recording> recordings;
  std::vector<int> which;
  for (const int run : set.runs(RunUse::fit, false)) {
    which.push_back(static_cast<int>(recordings.size()));
    recordings.push_back(asOf(resonant, bare, set.recordings[run]));
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
  // the starts are a factor of 1.1 apart: one of the two beside the truth
  EXPECT_LT(apart[best], std::log(1.1)) << "best start at " << starts[best][1] << " Hz";
}

/// Two short runs of a set, one at standstill and one that turns.
std::vector<Recording> twoShortRuns(const MadeSet& set) {
  std::vector<Recording> out;
  for (const char* id : {"chirp_1", "steady_2"}) out.push_back(beginningOf(set.recordings.at(set.indexOf(id)), 1200));
  EXPECT_TRUE(out[0].standstill && !out[1].standstill);
  return out;
}

TEST(StartScreenTest, ItsDirectionsAreTheColumnsThatAFitWouldPredictAtTheReference) {
  const MadeSet& set = cleanSet();
  const std::vector<Recording> recordings = twoShortRuns(set);
  const std::vector<int> which = {0, 1};
  const Model& belief = set.dataset.belief;
  const FitSpace reference(belief, {}), space(belief, {{"static_load", {0.0, 0.0}}});
  const int p = reference.size(), q = space.size();
  ASSERT_GT(q, p) << "an effect beside what the reference holds";
  std::vector<LocalState> local(2);
  const StartScreen screen(recordings, which, reference, reference.start(), local, set.offset_std_m);
  const FrozenColumns directions = screen.directions();
  ASSERT_EQ(directions.size, p);
  const FitProblem problem(recordings, space, set.offset_std_m);
  // the largest difference of two curvatures, each over its own diagonal
  const auto apart = [&](const Eigen::VectorXd& x, const std::vector<bool>& held) {
    EvaluationOptions predicted, frozen;
    predicted.held = frozen.held = held;
    frozen.frozen = &directions;
    std::vector<LocalState> one = local, other = local;  // an evaluation moves what belongs to the runs
    const NormalEquations a = problem.evaluate(x, which, one, predicted), b = problem.evaluate(x, which, other, frozen);
    EXPECT_NEAR(b.chi2, a.chi2, 1e-9 * a.chi2) << "the residual is predicted in any case";
    double most = 0.0;
    for (int i = 0; i < q; ++i)
      for (int j = 0; j < q; ++j) {
        const double scale = std::sqrt(a.h(i, i) * a.h(j, j));
        if (scale > 0.0) most = std::max(most, std::fabs(b.h(i, j) - a.h(i, j)) / scale);
        if (scale > 0.0 && i == j) most = std::max(most, std::fabs(b.g[i] - a.g[i]) / std::sqrt(a.h(i, i) * a.chi2));
        if (!held.empty() && (held[i] || held[j])) {
          EXPECT_EQ(b.h(i, j), 0.0);
        }
      }
    return most;
  };
  // the same differences over the same step, kept in single precision
  constexpr double single_precision = 1e-5;
  const Eigen::VectorXd at = space.start();
  EXPECT_LT(apart(at, {}), single_precision);
  std::vector<bool> held(q, false);
  held[0] = held[p - 1] = true;
  EXPECT_LT(apart(at, held), single_precision) << "those that are held leave no gap";
  Eigen::VectorXd away = at;
  for (int k = 0; k < p; ++k) away[k] += 2.0 * space.coordinates()[k].prior_std;
  EXPECT_GT(apart(space.clamped(away), {}), 100.0 * single_precision) << "elsewhere they are others: these stay";
}

TEST(StartScreenTest, TheAngleOfACrackAtStandstillIsFound) {
  // A crack at rest makes one direction of the rotor softer by (1 + cos u)/2: the turn is unknown, and sought.
  const MadeSet& set = cleanSet();
  const Recording rec = beginningOf(set.recordings.at(set.indexOf("chirp_1")), 4000);
  ASSERT_TRUE(rec.standstill);
  const Model whole = set.truth(), cracked = with(whole, "shaft_crack", {0.3, 0.0});
  const FitSpace space(cracked, {});
  EvaluationOptions value_only;
  value_only.jacobian = false;
  for (const double angle : {0.6, 2.2, 5.03}) {
    const std::vector<Recording> recordings = {asOf(cracked, whole, rec, angle)};
    std::vector<LocalState> local(1);
    const NormalEquations found =
        FitProblem(recordings, space, set.offset_std_m).evaluate(space.start(), {0}, local, value_only);
    EXPECT_EQ(local[0].angle_searches, 1);
    // the last grid's spacing is 0.028 rad: half of it, and what the noise moves
    EXPECT_NEAR(std::remainder(local[0].angle_rad - angle, two_pi), 0.0, 0.025) << angle;
    EXPECT_NEAR(found.squares / found.count, 1.0, 0.1) << "at the noise: " << angle;
    const FitSpace without(whole, {});
    std::vector<LocalState> fresh(1);
    const NormalEquations none =
        FitProblem(recordings, without, set.offset_std_m).evaluate(without.start(), {0}, fresh, value_only);
    EXPECT_GT(none.squares / none.count, 1.5) << "the crack is there: " << angle;
  }
}

}  // namespace
}  // namespace amb_rotor
