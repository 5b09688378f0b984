// The gain that a start's own direction promises: against the parabola through the fit's own sums of squares, and at
// the work it is for, telling where a hidden resonance lies.
#include "amb_rotor/validation/start_screen.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "../support/made_sets.hpp"
#include "amb_rotor/validation/starts.hpp"

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
