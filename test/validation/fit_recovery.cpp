// The fit on made recordings (event-accurate runs with noise): the gradient is that of its own sum of squares, the
// refitted nuisance is the truth, and windows through contact are predicted at the noise by the true machine only.
#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <cmath>

#include "../../src/validation/candidates.hpp"
#include "../support/made_sets.hpp"
#include "../support/models.hpp"
#include "amb_rotor/effects/catalogue.hpp"
#include "amb_rotor/machine/machine.hpp"
#include "amb_rotor/validation/compare.hpp"
#include "amb_rotor/validation/fit.hpp"

namespace amb_rotor {
namespace {

double valueOf(const Model& model, const std::string& name) {
  double value = NAN;
  Rig<double>::visit(model.rig, [&](const char* path, const double& field) {
    if (name == path) value = field;
  });
  return value;
}

TEST(FitTest, GradientIsThatOfTheSumOfSquares) {
  const MadeSet& set = cleanSet();
  const FitSpace space(set.dataset.belief, {});
  const FitProblem problem(set.recordings, space, set.offset_std_m);
  const std::vector<int> which = {set.indexOf("chirp_1"), set.indexOf("steady_2")};
  ASSERT_GE(which[0], 0);
  ASSERT_GE(which[1], 0);
  std::vector<LocalState> local(set.recordings.size());
  const NormalEquations here = problem.evaluate(space.start(), which, local, {});
  ASSERT_GT(here.count, 1e5);
  EvaluationOptions value_only;
  value_only.jacobian = false;
  int checked = 0;
  for (int k = 0; k < space.size(); ++k) {
    const Coordinate& c = space.coordinates()[k];
    if (c.name.find("auxiliary_bearing") == 0) {
      EXPECT_EQ(here.g[k], 0.0) << c.name << ": no contact, no slope";
      continue;
    }
    const double h = 0.05 * c.scale;
    double chi2[2];
    for (int side = 0; side < 2; ++side) {
      Eigen::VectorXd x = space.start();
      x[k] += side == 0 ? -h : h;
      chi2[side] = problem.evaluate(x, which, local, value_only).chi2;
    }
    // g is minus half the slope of chi2. The Jacobian is a forward difference over a small share of the scale, the reference a
    // central one over 5 %: a curvature that changes g by more than 2 % over one scale would be needed for more.
    EXPECT_NEAR(here.g[k], -(chi2[1] - chi2[0]) / (4.0 * h), 0.02 * here.h(k, k) * c.scale + 0.02 * std::fabs(here.g[k]))
        << c.name;
    ++checked;
  }
  EXPECT_GE(checked, 4);
}

TEST(FitTest, AStepThatWouldNotBeTakenSparesTheOtherRuns) {
  const tbb::global_control one_by_one(tbb::global_control::max_allowed_parallelism, 1);
  const MadeSet& set = cleanSet();
  const FitSpace space(set.dataset.belief, {});
  const FitProblem problem(set.recordings, space, set.offset_std_m);
  const std::vector<int> which = {set.indexOf("chirp_1"), set.indexOf("steady_2"), set.indexOf("steady_1")};
  std::vector<LocalState> local(set.recordings.size());
  EvaluationOptions options;
  options.jacobian = false;
  const auto evaluated = [&] {
    std::vector<LocalState> own = local;
    NormalEquations sum = problem.evaluate(space.start(), which, own, options);
    int looked_at = 0;
    for (const int i : which) looked_at += own[i].evaluations;
    return std::make_pair(sum, looked_at);
  };
  const double whole = evaluated().first.chi2;
  // where it is taken it is the same, in whatever order
  options.useful_chi2 = 1.001 * whole;
  options.first = 1;
  const auto taken = evaluated();
  EXPECT_EQ(taken.first.chi2, whole);
  EXPECT_EQ(taken.first.ended_at, -1);
  EXPECT_EQ(taken.second, 3);
  options.useful_chi2 = 0.999 * whole;
  EXPECT_FALSE(evaluated().first.finite);
  // beyond what the first one leaves the others need not be looked at
  options.useful_chi2 = 1.0;
  const auto lost = evaluated();
  EXPECT_FALSE(lost.first.finite);
  EXPECT_GT(lost.first.chi2, whole);
  EXPECT_EQ(lost.first.ended_at, options.first);
  EXPECT_EQ(lost.second, 1);
}

/// Ki is 2.6 deviations above its belief here, at which the loop is next to its stability's limit: a fit that only descends from there stays
/// in a hollow at 26 times the noise.
TEST(FitTest, AHollowNextToTheStabilitysLimitIsLeft) {
  const MadeSet& set = madeSet(2000086, "none", 0.0, false);
  Model belief = set.dataset.belief;
  belief.rig.rotor.mass_kg = 1.1174795;
  belief.rig.amb.current_stiffness_N_per_A = 91.536167;
  belief.rig.unbalance[0].moment_kg_m = 1.5178553e-05;
  belief.rig.unbalance[0].phase_rad = -1.3407077;
  const FitSpace space(belief, {});
  const FitProblem problem(set.recordings, space, set.offset_std_m);
  const std::vector<int> which = indicesToFit(set.recordings);
  const std::vector<LocalState> fresh(set.recordings.size());
  FitOptions options;
  options.most_iterations = most_iterations_from_belief;
  std::vector<LocalState> local = fresh;
  const FitResult descended = fit(problem, space.start(), which, local, options);
  ASSERT_GT(descended.squares, 100.0 * descended.count) << "there is no hollow, and this shows nothing";
  local = fresh;
  const FitResult found = fitFromBelief(problem, which, local, options);
  // what the rotor answers to the noise in its loop leaves up to 1.06 here
  EXPECT_LT(found.squares, 1.06 * 1.06 * found.count);
  const double ki = set.made.truth.rig.amb.current_stiffness_N_per_A;
  EXPECT_NEAR(space.model(found.x).rig.amb.current_stiffness_N_per_A, ki, 0.001 * ki);
  // what a diagnosis begins with, and a comparison
  const Candidates candidates(belief, set.dataset);
  const FitResult baseline = candidates.fit({}, nullptr, fresh, {Through::free, most_iterations_from_belief}).fit;
  EXPECT_LT(baseline.squares, 1.06 * 1.06 * baseline.count);
  EXPECT_LT(compare(belief, set.dataset).validation_errors.error, 1.06);
}

TEST(FitTest, TheValleyOfGainAgainstKiIsWalkedToItsEnd) {
  // all sensors' gains up by a factor with Ki and the unbalance down by it change next to nothing: the beliefs of Ki and
  // unbalance alone say where in that valley the rig is. Differences over 2 % of the scale lead the fit a factor astray.
  const MadeSet& set = cleanSet();
  constexpr double factor = 1.4;
  const FitSpace space(set.dataset.belief, {{"sensor_gain_error", {factor, factor, factor, factor}}});
  const FitProblem problem(set.recordings, space, set.offset_std_m);
  std::vector<LocalState> local(set.recordings.size());
  Eigen::VectorXd start = space.start();
  for (int k = 0; k < space.nuisances(); ++k) {
    if (space.coordinates()[k].name == "amb.current_stiffness_N_per_A") start[k] /= factor;
    if (space.coordinates()[k].name == "unbalance.moment_kg_m") start[k] /= factor;
  }
  FitOptions options;
  options.scores = true;
  const FitResult result = fit(problem, start, set.runs(RunUse::fit, false), local, options);
  ASSERT_TRUE(result.finite);
  for (const auto& p : space.effectValues(0, result.x, result.covariance)) {
    EXPECT_LT(std::fabs(p.value - 1.0), 3.0 * p.std) << p.name;
    EXPECT_LT(3.0 * p.std, factor - 1.0) << p.name << ": the start was farther off";
  }
}

TEST(FitTest, NuisanceIsRecoveredWithinItsStandardDeviations) {
  const MadeSet& set = cleanSet();
  const FitSpace space(set.dataset.belief, {});
  const FitProblem problem(set.recordings, space, set.offset_std_m);
  std::vector<LocalState> local(set.recordings.size());
  FitOptions options;
  options.scores = true;
  const FitResult result = fit(problem, space.start(), set.runs(RunUse::fit, false), local, options);
  ASSERT_TRUE(result.finite);
  int moved = 0, sharpened = 0;
  for (int k = 0; k < space.size(); ++k) {
    const Coordinate& c = space.coordinates()[k];
    const double value = valueOf(set.made.truth, c.name), std = std::sqrt(result.covariance(k, k));
    const double truth = c.by_logarithm ? std::log(value) : value;
    ASSERT_TRUE(std::isfinite(truth)) << c.name;
    constexpr double most_deviations = 3.0;
    EXPECT_LT(std::fabs(result.x[k] - truth), most_deviations * std) << c.name;
    if (std::fabs(space.start()[k] - truth) > most_deviations * std) ++moved;
    if (std < 0.5 * c.prior_std) ++sharpened;
  }
  EXPECT_GE(moved, 2) << "the belief was off by more than that, so that there was something to find";
  EXPECT_GE(sharpened, 3) << "these runs tell mass, Ki and unbalance better than the belief";
  // 2 in 1000 for what few parameters take away, the rest for what the lanes' steps and the held noise of the loop add
  EXPECT_NEAR(std::sqrt(result.squares / result.count), 1.0, 0.05);
}

/// The part of the contact runs to fit in which the rotor touches: the rub is strongest at 0.22 s, the drop falls at
/// 0.05 s.
std::vector<Recording> touching() {
  const MadeSet& set = madeSet(21, "none", 0.0, true);
  return {beginningOf(set.recordings.at(set.indexOf("rub_1")), 3000),
          beginningOf(set.recordings.at(set.indexOf("drop_1")), 2000)};
}

/// Error over windows, the run's offsets found in a first pass.
double windowError(const std::vector<Recording>& recordings, double offset_std_m, const Model& model, int run) {
  const FitSpace space(model, {});
  const FitProblem problem(recordings, space, offset_std_m);
  std::vector<LocalState> local(recordings.size());
  const std::vector<int> which = {run};
  EvaluationOptions options;
  options.jacobian = false;
  options.window_passes = 3;
  options.thorough = true;
  problem.evaluate(space.start(), which, local, options);
  std::vector<RunResult> results;
  problem.evaluate(space.start(), which, local, options, &results);
  double sum = 0.0;
  for (const RunResult& result : results) {
    EXPECT_TRUE(result.finite);
    sum += result.mean_square;
  }
  return std::sqrt(sum / results.size());
}

TEST(WindowsTest, TheTrueMachinePredictsContactAtTheNoise) {
  const MadeSet& set = madeSet(21, "none", 0.0, true);
  Model truth = set.truth();
  Model soft = truth;
  soft.rig.auxiliary_bearing.stiffness_N_per_m *= 0.5;
  const std::vector<Recording> recordings = touching();
  for (int run = 0; run < 2; ++run) {
    const std::string& id = recordings[run].run.id;
    // Part of the stated noise goes round the control loop: it only begins within a window of 10 ms, and is not there
    // while the bearings are off, so that the floor is below 1 and above what is white alone. Above 1 only by windows
    // that hold a touch, which amplify what their start is not known by.
    constexpr double lower = 0.7, upper = 1.1, wrong = 1.3;
    const double error = windowError(recordings, set.offset_std_m, truth, run);
    EXPECT_GT(error, lower) << id;
    EXPECT_LT(error, upper) << id;
    EXPECT_GT(windowError(recordings, set.offset_std_m, soft, run), wrong * error)
        << id << " holds contact, and the windows see its stiffness";
  }
}

TEST(WindowsTest, IntegratorsAreUnknownsOfAWindow) {
  // The sensors' offsets lie in the recording alone: an integrator that is read off measured displacements holds them, kp
  // times 1 um or several times the current's noise, in every window. Left so, the true machine stood at 1.4 and 1.5.
  const MadeSet& set = madeSet(2700099, "auxiliary_bearing_misalignment", 0.0, true, {"rub_1", "drop_1"});
  const Model truth = set.truth();
  ASSERT_GT(truth.rig.controller.ki_A_per_m_s, 1e4);
  for (const char* id : {"rub_1", "drop_1"}) {
    const std::vector<Recording> recordings = {beginningOf(set.recordings.at(set.indexOf(id)), 4000)};
    EXPECT_LT(windowError(recordings, set.offset_std_m, truth, 0), 1.1) << id;  // as above
  }
}

TEST(WindowsTest, EddyCurrentsAreFollowedThroughContact) {
  const MadeSet& set = madeSet(21, "eddy_current_lag", 2.0, true, {"rub_1", "drop_1"});
  const Model truth = set.truth();
  Model plain = truth;
  plain.effects.clear();
  for (const char* id : {"rub_1", "drop_1"}) {
    const std::vector<Recording> recordings = {beginningOf(set.recordings.at(set.indexOf(id)), 3000)};
    // kept: what was fitted before the lag is adopted knows of none, and the other way round
    for (const bool before : {false, true}) {
      std::vector<LocalState> local(1);
      std::vector<RunResult> results;
      const auto evaluate = [&](const Model& model) {
        const FitSpace space(model, {});
        EvaluationOptions options;
        options.jacobian = false;
        options.window_passes = 3;
        options.thorough = true;
        FitProblem(recordings, space, set.offset_std_m).evaluate(space.start(), {0}, local, options, &results);
        EXPECT_TRUE(results[0].finite);
        return std::sqrt(results[0].mean_square);
      };
      if (before) evaluate(plain);
      evaluate(truth);
      const double error = evaluate(truth);
      EXPECT_LT(error, 1.1) << id << ", " << before;  // as above
      if (std::string(id) == "rub_1") {  // while bearings are off it is not seen
        EXPECT_GT(evaluate(plain), 1.05 * error);
      }
    }
  }
}

TEST(WindowsTest, StartsGoFromMachineToMachine) {
  // states of mounts, rings and lags come and go as effects are tried and withdrawn
  const MadeSet& set = madeSet(21, "none", 0.0, true);
  const std::vector<Recording> recordings = {beginningOf(set.recordings.at(set.indexOf("rub_1")), 600)};
  std::vector<LocalState> local(1);
  for (const auto& schema : effectCatalogue().all()) {
    if (schema.only_by_name) continue;
    for (const bool with : {true, false}) {
      Model model = set.truth();
      if (with) model.effects.push_back({schema.id, testing_support::typicalValues(schema.id)});
      const FitSpace space(model, {});
      EvaluationOptions options;
      options.jacobian = true;
      std::vector<RunResult> results;
      FitProblem(recordings, space, set.offset_std_m).evaluate(space.start(), {0}, local, options, &results);
      if (!with) {
        EXPECT_TRUE(results[0].finite) << "after " << schema.id;
      }
    }
  }
}

TEST(WindowsTest, DryWhirlThatRollsIsPredicted) {
  // A drop whose whirl rolls under some 10 kN: regularised friction would bring the surfaces to rest within a few us. With
  // steps of 20 us that did not look at that, the true machine stood at over 100 times the noise.
  const MadeSet& set = madeSet(2700100, "hertzian_contact", 0.0, true, {"rub_1", "drop_1"});
  const std::vector<Recording> recordings = {beginningOf(set.recordings.at(set.indexOf("drop_1")), 1500)};
  EXPECT_LT(windowError(recordings, set.offset_std_m, set.truth(), 0), 2.0) << "pieces of 1.25 us leave some of the fastest";
}

TEST(WindowsTest, AThoroughFirstEvaluationLeavesFewerWindowsThrownOff) {
  const MadeSet& set = madeSet(21, "none", 0.0, true);
  const std::vector<Recording> recordings = touching();
  // rings that run along slip less than these runs show: windows that begin where others led are thrown off. More
  // passes lead windows on by chance, which would hide it.
  double plain = 0.0, thorough = 0.0;
  for (const double inertia_kg_m2 : {5e-6, 2e-5}) {
    const FitSpace space(set.dataset.belief, {{"inner_ring_spin", {inertia_kg_m2, 5e-3}}});
    const FitProblem problem(recordings, space, set.offset_std_m);
    for (const bool with_guesses : {false, true}) {
      std::vector<LocalState> local(recordings.size());
      FitOptions options;
      options.most_iterations = 0;
      options.covariance = false;
      options.first_window_passes = 1;
      options.thorough_first = with_guesses;
      (with_guesses ? thorough : plain) += fit(problem, space.start(), {0, 1}, local, options).chi2;
    }
  }
  EXPECT_LT(thorough, 0.97 * plain) << "more than the chance of which windows are thrown off";
}

TEST(WindowsTest, AShiftOfASensorIsFoundAsItsOffset) {
  const MadeSet& set = madeSet(21, "none", 0.0, true);
  const FitSpace space(set.truth(), {});
  constexpr double shift =
      3e-6;  // three standard deviations of the belief, a tenth of what contact bends back
  for (const char* id : {"rub_1", "drop_1"}) {
    const int run = set.indexOf(id);
    ASSERT_GE(run, 0);
    LocalState found[2];
    double squares[2];
    for (int shifted = 0; shifted < 2; ++shifted) {
      std::vector<Recording> recordings = set.recordings;
      for (long i = 0; i < recordings[run].samples && shifted == 1; ++i)
        recordings[run].measured[i * predicted_channels] += shift;
      const FitProblem problem(recordings, space, set.offset_std_m);
      std::vector<LocalState> local(recordings.size());
      EvaluationOptions options;
      options.jacobian = false;
      options.window_passes = 3;
      for (int pass = 0; pass < 3; ++pass)
        squares[shifted] = problem.evaluate(space.start(), {run}, local, options).squares;
      found[shifted] = local[run];
    }
    // the prior holds back (noise / offset_std)^2 / samples, below 1e-3; the windows' own starts take up the
    // rest
    EXPECT_NEAR(found[1].offset_m[0] - found[0].offset_m[0], shift, 0.01 * shift) << id;
    for (int a = 1; a < 4; ++a)
      EXPECT_NEAR(found[1].offset_m[a], found[0].offset_m[a], 0.01 * shift) << id << " " << a;
    for (int a = 0; a < 4; ++a)
      EXPECT_NEAR(found[1].drift_m[a], found[0].drift_m[a], 0.03 * shift) << id << " " << a;
    EXPECT_NEAR(squares[1] / squares[0], 1.0, 0.02) << id;
  }
}

/// Through contact: the true machine with an effect that stands somewhere, a step of that effect, and the same once the run's
/// own unknowns have settled there.
struct StepThroughContact {
  double before = 0.0, stepped = 0.0, settled = 0.0;                        ///< sums of squares
  std::vector<MachineState<double>> starts_before, starts_stepped, starts_settled;  ///< of the windows
};

StepThroughContact stepOf(const std::string& effect, const std::vector<double>& from, const std::vector<double>& to,
                          const MadeSet& set, const std::string& run, long samples) {
  const std::vector<Recording> recordings = {beginningOf(set.recordings.at(set.indexOf(run)), samples)};
  Model without = set.truth();
  without.effects.clear();
  const FitSpace there(without, {{effect, to}}), space(without, {{effect, from}});
  const FitProblem problem(recordings, space, set.offset_std_m);
  std::vector<LocalState> local(1);
  EvaluationOptions options;
  options.window_passes = 3;
  StepThroughContact out;
  for (int pass = 0; pass < 4; ++pass) out.before = problem.evaluate(space.start(), {0}, local, options).chi2;
  out.starts_before = local[0].window_start;
  out.stepped = problem.evaluate(there.start(), {0}, local, options).chi2;
  out.starts_stepped = local[0].window_start;
  for (int pass = 0; pass < 4; ++pass) out.settled = problem.evaluate(there.start(), {0}, local, options).chi2;
  out.starts_settled = local[0].window_start;
  return out;
}

TEST(WindowsTest, OffsetsFollowTheCoordinates) {
  // A model that lacks an offset of the bearing puts it into the sensors': were these to stay, a step towards the truth would
  // be judged with them, ten times worse than where it came from, and no fit would take it.
  const MadeSet& set = madeSet(2700099, "auxiliary_bearing_misalignment", 0.0, true, {"rub_1", "drop_1"});
  const EffectSetting truth = set.truth().effects.at(0);
  const StepThroughContact step = stepOf(truth.id, {0.0, 0.0, 0.0, 0.0}, truth.values, set, "drop_1", 4000);
  ASSERT_LT(step.settled, 0.8 * step.before) << "the truth is better";
  EXPECT_LT(step.stepped, step.settled + 0.5 * (step.before - step.settled)) << "a first-order step gains most of it at once";
}

TEST(WindowsTest, RingsFollowTheCoordinates) {
  // A ring's speed is known from window to window only: were the windows to begin at those that another inertia had led to,
  // the step to the right one could look worse than the wrong one.
  const MadeSet& set = madeSet(21, "none", 0.0, true);
  const StepThroughContact step =
      stepOf("inner_ring_spin", {2e-5, 5e-3}, {4e-5, 5e-3}, set, "drop_1", 4000);
  Model ringed = set.truth();
  ringed.effects.push_back({"inner_ring_spin", {4e-5, 5e-3}});
  const int ring = Machine<double>({&ringed}, Spin::prescribed).ringState();
  ASSERT_GE(ring, 0);
  // a ring that has come up to the rotor's speed tells nothing of its inertia: from there its speed goes with the slips of the
  // moment, differently on each processor
  constexpr double told_rad_s = 50.0, still_rising = 0.85;
  double highest = 0.0, far = 0.0, left = 0.0;
  for (const auto& start : step.starts_settled)
    for (int e = 0; e < 2; ++e) highest = std::max(highest, start.mechanics[ring + e]);
  int told = 0;
  for (int e = 0; e < 2; ++e)
    for (std::size_t n = 0; n < step.starts_settled.size(); ++n) {
      const auto speed = [&](const std::vector<MachineState<double>>& starts) { return starts[n].mechanics[ring + e]; };
      if (speed(step.starts_settled) > still_rising * highest) break;
      if (std::fabs(speed(step.starts_before) - speed(step.starts_settled)) < told_rad_s) continue;
      ++told;
      far += std::fabs(speed(step.starts_before) - speed(step.starts_settled));
      left += std::fabs(speed(step.starts_stepped) - speed(step.starts_settled));
    }
  ASSERT_GE(told, 10) << "another inertia, other speeds";
  EXPECT_LT(left, 0.01 * far) << "rad/s, of " << told << " speeds";
}

TEST(WindowsTest, ANewtonStepLeadsBackToTheStiffnessOfTheBearing) {
  const MadeSet& set = madeSet(21, "none", 0.0, true);
  const FitSpace space(set.dataset.belief, {});
  Eigen::VectorXd truth = space.start();
  int stiffness = -1;
  for (int k = 0; k < space.size(); ++k) {
    const std::string& name = space.coordinates()[k].name;
    truth[k] = valueOf(set.made.truth, name);
    if (space.coordinates()[k].by_logarithm) truth[k] = std::log(truth[k]);
    ASSERT_TRUE(std::isfinite(truth[k])) << name;
    if (name == "auxiliary_bearing.contact.stiffness_N_per_m") stiffness = k;
  }
  ASSERT_GE(stiffness, 0);
  const FitProblem problem(set.recordings, space, set.offset_std_m);
  for (const char* id : {"rub_1", "drop_1"})
    for (const double side : {1.0, -1.0}) {
      const int run = set.indexOf(id);
      ASSERT_GE(run, 0);
      const double off = side * 0.5 * space.coordinates()[stiffness].scale;  // 5 % of the stiffness
      Eigen::VectorXd x = truth;
      x[stiffness] += off;
      std::vector<LocalState> local(set.recordings.size());
      EvaluationOptions options;
      options.window_passes = 3;
      NormalEquations normal;
      for (int pass = 0; pass < 3; ++pass) {
        options.jacobian = pass == 2;  // the starts are found before
        normal = problem.evaluate(x, {run}, local, options);
      }
      ASSERT_TRUE(normal.finite) << id;
      // the force over a penetration that itself gives way is curved: 5 % of stiffness, and as much again of
      // the step where touches are deep; windows thrown off count less. A third of the step leaves a factor
      // of two in the curvature seen.
      const double step = normal.g[stiffness] / normal.h(stiffness, stiffness);
      EXPECT_NEAR(step / -off, 1.0, 1.0 / 3.0) << id << " " << side;
    }
}

}  // namespace
}  // namespace amb_rotor
