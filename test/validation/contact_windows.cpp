// Starts of windows through contact that are out of reach: found through the beginning of the window.
#include <gtest/gtest.h>

#include "../../src/validation/contact_window.hpp"
#include "../support/made_sets.hpp"

namespace amb_rotor {
namespace {

/// Windows of a drop that a model leaves thrown off, each searched from what was measured at its beginning.
int thrownOff(const WindowedRun& run, bool grow) {
  constexpr long length = 100;
  int count = 0;
  for (long first = length; first + length <= run.rec.samples; first += length) {
    ContactWindow window(run, first, first + length);
    std::vector<MachineState<double>> guesses;
    for (const MeasuredFrom span : {MeasuredFrom{0, 8}, MeasuredFrom{-2, 5}})
      guesses.push_back(stateFromMeasurement(run.rec, run.base(), run.whole.spin, first, span));
    const bool finite = window.search(std::move(guesses), 7, true, grow);
    EXPECT_TRUE(finite) << first;
    if (window.squares > thrown_off * window.residuals()) ++count;
  }
  return count;
}

TEST(ContactWindows, StartsOutOfReachAreFoundThroughTheBeginningOfTheWindow) {
  // a contact of 1.4e8 N/m: some ten impacts in a window of 10 ms
  const MadeSet& set = madeSet(4300147, "auxiliary_bearing_misalignment", 0.0, true, {"chirp_1", "rub_1", "drop_1"});
  const std::vector<Recording>& recordings = set.recordings;
  const auto drop = std::find_if(recordings.begin(), recordings.end(), [](const Recording& r) { return r.run.kind == RunKind::drop; });
  ASSERT_NE(drop, recordings.end());
  // what the run's offsets are, the windows that are followed tell
  const FitSpace space(set.truth(), {});
  const double offset_std_m = 1e-6;
  const FitProblem problem(recordings, space, offset_std_m);
  std::vector<LocalState> local(recordings.size());
  EvaluationOptions options;
  options.jacobian = false;
  options.thorough = true;
  for (int round = 0; round < 2; ++round)
    problem.evaluate(space.start(), {static_cast<int>(drop - recordings.begin())}, local, options);
  const WindowedRun run(*drop, {set.truth()}, {}, local[drop - recordings.begin()], true);
  const int at_once = thrownOff(run, false), grown = thrownOff(run, true);
  ASSERT_GT(at_once, 0) << "the right model is followed everywhere, and this shows nothing";
  EXPECT_EQ(grown, 0) << "of " << at_once;
}

TEST(ContactWindows, RunsAreEvaluatedUntilTheyStand) {
  const MadeSet& set = madeSet(4300147, "auxiliary_bearing_misalignment", 0.0, true, {"chirp_1", "rub_1", "drop_1"});
  const FitSpace space(set.truth(), {});
  const FitProblem problem(set.recordings, space, set.offset_std_m);
  const std::vector<int> touching = {set.indexOf("rub_1"), set.indexOf("drop_1")};
  EvaluationOptions options;
  options.jacobian = false;
  options.thorough = true;
  options.window_passes = 3;
  std::vector<LocalState> local(set.recordings.size()), other = local;
  std::vector<RunResult> first, settled, more;
  problem.evaluate(space.start(), touching, other, options, &first);
  evaluateSettled(problem, space.start(), touching, local, options, settled);
  problem.evaluate(space.start(), touching, local, options, &more);
  double led_on = 0.0;
  EXPECT_TRUE(settled[0].stands || settled[1].stands);
  for (std::size_t i = 0; i < touching.size(); ++i) {
    EXPECT_FALSE(first[i].stands);
    // one that stands stays; any other would have gone on
    EXPECT_NEAR(more[i].mean_square, settled[i].mean_square, (settled[i].stands ? 0.004 : 0.02) * settled[i].mean_square);
    EXPECT_LT(settled[i].mean_square, 1.05);  // the true machine, each window's start fitted
    led_on = std::max(led_on, first[i].mean_square / settled[i].mean_square);
  }
  EXPECT_GT(led_on, 1.02);  // one evaluation is not enough
  // nor is it where a fit begins: windows that it has led astray would hold the coordinates
  std::vector<LocalState> anew(set.recordings.size());
  FitOptions where_it_begins;
  where_it_begins.most_iterations = 0;
  where_it_begins.thorough_first = true;
  const FitResult begun = fit(problem, space.start(), touching, anew, where_it_begins);
  EXPECT_LT(begun.squares, 1.02 * 0.5 * (settled[0].mean_square + settled[1].mean_square) * begun.count);
}

}  // namespace
}  // namespace amb_rotor
