// Sensors' offsets that go round the control loop, and integrators that are settled, or at 0, when a recording begins: as predictions
// have them, the offsets' response against the statics of a beam on its bearings, and fits that are not taken in by them.
#include "amb_rotor/validation/loop_offsets.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "../support/heavy_loops.hpp"
#include "../support/made_sets.hpp"
#include "../support/models.hpp"
#include "amb_rotor/common/units.hpp"
#include "amb_rotor/validation/fit.hpp"

namespace amb_rotor {
namespace {

using namespace testing_support;

/// What a machine shows from the run's settled start, its sensors off by so much, the mean of a drift among it.
std::vector<double> shownWith(const Model& model, const Recording& rec, const double* offset_m, double drift_m) {
  std::vector<double> out(rec.samples * predicted_channels);
  std::vector<LaneJob> jobs = {jobOf(rec, model, 0.0)};
  for (int a = 0; a < axis_count && offset_m != nullptr; ++a) {
    jobs[0].offset_m[a] = offset_m[a];
    jobs[0].drift_m_per_s[a] = drift_m / rec.duration();
  }
  jobs[0].out = out.data();
  predict(stretchOf(rec, model), jobs);
  EXPECT_TRUE(jobs[0].finite);
  return out;
}

/// The recording of a rig whose offsets go round the loop: what the generator has put into the recording alone, constant or drifting, is
/// taken out.
Recording withOffsetsInLoop(Recording rec, const Model& truth) {
  const std::vector<double> with = shownWith(truth, rec, loop_offset_m, 0.5e-6), without = shownWith(truth, rec, nullptr, 0.0);
  for (int c = 0; c < predicted_channels; ++c) {
    double mean = 0.0, along = 0.0, squares = 0.0;
    for (long i = 0; i < rec.samples && c < axis_count; ++i) {
      const std::size_t at = i * predicted_channels + c;
      const double share = (i + 0.5) / static_cast<double>(rec.samples) - 0.5;
      mean += (rec.measured[at] - without[at]) / static_cast<double>(rec.samples);
      along += share * (rec.measured[at] - without[at]);
      squares += share * share;
    }
    for (long i = 0; i < rec.samples; ++i) {
      const std::size_t at = i * predicted_channels + c;
      rec.measured[at] += with[at] - without[at];
      if (c < axis_count) rec.measured[at] -= mean + along / squares * ((i + 0.5) / static_cast<double>(rec.samples) - 0.5);
    }
  }
  return rec;
}

TEST(LoopOffsets, InTheRecordingAloneTheyAreBesideTheControllersLaw) {
  const MadeSet& made = cleanSet();
  EXPECT_FALSE(readLoop(made.recordings, made.dataset.belief, made.offset_std_m).offsets_in_loop);
  EXPECT_FALSE(made.recordings[0].offsets_in_loop);
}

TEST(LoopOffsets, InTheLoopTheControllerActsOnThem) {
  const MadeSet& made = cleanSet();
  std::vector<Recording> recordings;
  for (const int run : made.runs(RunUse::fit, false)) {
    const Recording& rec = made.recordings[run];
    recordings.push_back(rec);
    recordings.back().measured = shownWith(made.truth(), rec, loop_offset_m, 0.5e-6);
  }
  EXPECT_TRUE(readLoop(recordings, made.dataset.belief, made.offset_std_m).offsets_in_loop);
  // offsets that nobody states are none
  EXPECT_FALSE(readLoop(recordings, made.dataset.belief, 0.0).offsets_in_loop);
  Model without_coils = made.dataset.belief;
  without_coils.amb_model = AmbModel::equivalent;
  EXPECT_FALSE(readLoop(recordings, without_coils, made.offset_std_m).offsets_in_loop);
}

TEST(LoopOffsets, ASettledIntegratorGoesIntoThePrediction) {
  Model model = heavyRotor();
  model.uncertainty["sensor.offset_m"] = 1e-6;
  std::vector<Recording> recordings = {heldByIntegrators(model, 1.0, loop_offset_m)};
  recordings[0].integral_m_s = {};
  applyLoopReading(recordings, model);
  EXPECT_TRUE(recordings[0].offsets_in_loop);
  const std::vector<double> predicted = predictedBy(model, recordings[0]);
  for (int a = 0; a < axis_count; ++a)  // the offsets' own part is left
    EXPECT_NEAR(predicted[a], recordings[0].measured[a], 2.5e-6) << a;
}

/// Integrators that begin at 0 carry an offset of the loop off as they carry the weight: the sensors' mean goes to 0, the rotor to the other
/// side of it. Of an offset in the recording alone they know nothing, and it stays.
TEST(LoopOffsets, IntegratorsThatBeginAtZeroCarryThemOff) {
  Model model = heavyRotor();
  model.uncertainty["sensor.offset_m"] = 1e-6;
  Recording rec = heldByIntegrators(model, 0.0, loop_offset_m);
  std::mt19937 dice(17);
  std::normal_distribution<double> normal;
  for (int c = 0; c < predicted_channels; ++c) rec.noise[c] = c < axis_count ? 1e-7 : 1e-3;
  for (std::size_t at = 0; at < rec.measured.size(); ++at) rec.measured[at] += rec.noise[at % predicted_channels] * normal(dice);
  std::vector<Recording> read = {rec};
  applyLoopReading(read, model);
  ASSERT_TRUE(read[0].offsets_in_loop);
  EXPECT_EQ(read[0].integral_m_s, (std::array<double, axis_count>{}));
  const FitSpace space(model, {});
  const auto left = [&](LocalState& local) {
    const FitProblem problem(read, space, 1e-6);
    std::vector<LocalState> locals(1);
    double squares = 0.0;
    for (int pass = 0; pass < 3; ++pass) squares = problem.evaluate(space.start(), {0}, locals, {}).squares;
    local = locals[0];
    return squares / static_cast<double>(rec.measured.size());
  };
  LocalState local, unused;
  // 40000 residuals: 0.02 is three of their mean square's deviations
  EXPECT_NEAR(left(local), 1.0, 0.02);
  // they show for a quarter of a second only, beside a drift: 1e-7 over the root of 2500 instants, ten times that
  for (int a = 0; a < axis_count; ++a) EXPECT_NEAR(local.offset_m[a], loop_offset_m[a], 0.02e-6) << a;
  read[0].offsets_in_loop = false;
  EXPECT_GT(left(unused), 2.0);
}

/// A drift in the loop moves the rotor: the displacements' mean is not what the recording is off by, and says nothing of the integrators.
TEST(LoopOffsets, WhatADriftInTheLoopMovesIsNoOffsetOfTheRecording) {
  Model model = heavyRotor();
  model.uncertainty["sensor.offset_m"] = 1e-6;
  Recording rec = turning(8000);
  for (int end = 0; end < 2; ++end) rec.integral_m_s[1 + 2 * end] = -heldCurrent(model, end) / model.rig.controller.ki_A_per_m_s;
  rec.measured.resize(rec.samples * predicted_channels);
  std::vector<LaneJob> jobs = {jobOf(rec, model, 0.0)};
  for (int a = 0; a < axis_count; ++a) jobs[0].drift_m_per_s[a] = 2e-6 / rec.duration();
  jobs[0].out = rec.measured.data();
  predict(stretchOf(rec, model), jobs);
  ASSERT_TRUE(jobs[0].finite);
  const double ki = model.rig.controller.ki_A_per_m_s;
  const std::array<double, 4> held = rec.integral_m_s;
  rec.integral_m_s = {};
  std::vector<Recording> read = {rec};
  applyLoopReading(read, model);
  ASSERT_TRUE(read[0].offsets_in_loop);
  const Eigen::Vector4d by_mean = readLaw(rec, model, 1e-6).settled_integral_A;
  // it begins without the ripple that is taken out of the reading; what turns leaves 1e-4 of its 0.1 A behind the window
  const Eigen::Vector4d ripple = integralRipple_m_s(rec);
  constexpr double reading_A = 3e-5;
  for (int a = 0; a < axis_count; ++a) {
    EXPECT_NEAR(ki * (read[0].integral_m_s[a] + ripple[a]), ki * held[a], reading_A) << a;
    EXPECT_GT(std::fabs(by_mean[a] - ki * held[a]), 30.0 * reading_A) << "by the mean it would be as well, and this shows nothing";
  }
}

TEST(LoopOffsets, SettledIntegratorsOfATurningRotorBeginWithTheirRipple) {
  // unbalance makes the sensors' signals s a turning vector, and the integrators one of s/w: 3 s on, nothing else is left of a start
  Model model = heavyRotor();
  model.rig.controller.ki_A_per_m_s = 1.2e5;
  model.uncertainty["sensor.offset_m"] = 1e-6;
  const Recording longer = turning(35000);
  const std::vector<double> all = predictedBy(model, longer);
  Recording rec = longer;
  constexpr long cut = 30000;
  rec.samples -= cut;
  rec.angle0_rad = longer.speed_rad_s * static_cast<double>(cut) / longer.run.sample_rate_hz;
  rec.measured.assign(all.begin() + cut * predicted_channels, all.end());
  const auto farthest = [&](const Recording& at) {
    const std::vector<double> predicted = predictedBy(model, at);
    double most = 0.0;
    for (long i = 0; i < at.samples; ++i)
      for (int a = 0; a < axis_count; ++a)
        most = std::max(most, std::fabs(predicted[i * predicted_channels + a] - rec.measured[i * predicted_channels + a]));
    return most;
  };
  std::vector<Recording> read = {rec};
  applyLoopReading(read, model);
  EXPECT_NEAR(read[0].integrator_leak_per_s, 0.05 * rec.speed_rad_s, 1e-9);
  Recording rests = read[0];
  rests.integrator_leak_per_s = 0.0;
  double orbit = 0.0;
  for (long i = 0; i < 2000; ++i) orbit = std::max(orbit, std::fabs(rec.measured[i * predicted_channels]));
  const double off_by_ripple = model.rig.controller.ki_A_per_m_s / model.rig.controller.kp_A_per_m * orbit / rec.speed_rad_s;
  EXPECT_GT(farthest(rests), 0.5 * off_by_ripple);
  // the leak's share, 0.05, in ripple and motion alike, e^-4 of a start, and what the reading is off by
  EXPECT_LT(farthest(read[0]), 0.2 * off_by_ripple);
}

TEST(LoopOffsets, TheirResponseIsTheStaticsOfTheBeam) {
  const Model model = levitated();
  const auto& rig = model.rig;
  Recording rec;
  rec.run.kind = RunKind::steady;
  rec.run.sample_rate_hz = 1e4;
  rec.samples = 500;
  rec.standstill = true;
  const std::vector<double> columns = offsetsInLoop(rec, model);
  const auto found = [&](int channel, int sensor) {
    return columns[((rec.samples - 1) * predicted_channels + channel) * 2 * axis_count + sensor];
  };
  const double ki = rig.amb.current_stiffness_N_per_A, ks = rig.amb.displacement_stiffness_N_per_m, kp = rig.controller.kp_A_per_m;
  for (int end = 0; end < 2; ++end) {
    // sum of F_j and of z_j F_j is 0 with F_j = Ks x(z_j) - Ki kp (x(sensor_j) + o_j), x(z) = u + z beta
    Eigen::Matrix2d stiffness = Eigen::Matrix2d::Zero();
    Eigen::Vector2d asked = Eigen::Vector2d::Zero();
    for (int j = 0; j < 2; ++j) {
      const Eigen::Vector2d at(1.0, rig.planes.amb[j]), seen(1.0, rig.planes.sensor[j]);
      stiffness += at * (ki * kp * seen - ks * at).transpose();
      if (j == end) asked -= ki * kp * at;
    }
    const double determinant = stiffness(0, 0) * stiffness(1, 1) - stiffness(0, 1) * stiffness(1, 0);
    const Eigen::Vector2d moved((stiffness(1, 1) * asked[0] - stiffness(0, 1) * asked[1]) / determinant,
                                (stiffness(0, 0) * asked[1] - stiffness(1, 0) * asked[0]) / determinant);
    for (int j = 0; j < 2; ++j) {
      const double signal = moved[0] + rig.planes.sensor[j] * moved[1] + (j == end ? 1.0 : 0.0);
      // the run-in of 0.15 s leaves e^-12 of the start; the probe of 1 um is 1e10 times the round-off of a displacement
      EXPECT_NEAR(found(2 * j, 2 * end), signal, 1e-6);
      EXPECT_NEAR(found(axis_count + 2 * j, 2 * end), -kp * signal, 1e-6 * kp);
      EXPECT_NEAR(found(2 * j + 1, 2 * end), 0.0, 1e-9);
    }
  }
}

/// Mean square over the noise of the runs to fit, as the true machine leaves it.
double leftOf(const MadeSet& made, bool in_loop) {
  std::vector<Recording> recordings;
  for (const int run : made.runs(RunUse::fit, false)) {
    recordings.push_back(withOffsetsInLoop(made.recordings[run], made.truth()));
    recordings.back().offsets_in_loop = in_loop;
    if (in_loop) recordings.back().offset_columns = offsetsInLoop(recordings.back(), made.dataset.belief);
  }
  const FitSpace space(made.truth(), {});
  const FitProblem problem(recordings, space, made.offset_std_m);
  std::vector<LocalState> local(recordings.size());
  std::vector<int> all;
  for (int i = 0; i < static_cast<int>(recordings.size()); ++i) all.push_back(i);
  EvaluationOptions options;
  options.thorough = true;
  options.window_passes = 3;
  double left = 0.0;
  for (int pass = 0; pass < 3; ++pass) {  // the offsets of runs in windows come from pass to pass
    const NormalEquations normal = problem.evaluate(space.start(), all, local, options);
    left = normal.squares / normal.count;
  }
  for (const LocalState& state : local)
    for (int a = 0; a < axis_count && in_loop; ++a) EXPECT_NEAR(state.offset_m[a], loop_offset_m[a], 0.1e-6);
  return left;
}

TEST(LoopOffsets, TheTrueMachineLeavesTheNoiseWhereTheyAreLookedForInTheLoop) {
  // 1 um in the loop moves the currents by a few mA, about their noise; a model that has it in the recording alone is off by that
  const double right = leftOf(cleanSet(), true), wrong = leftOf(cleanSet(), false);
  EXPECT_NEAR(right, 1.0, 0.02);
  EXPECT_GT(wrong, right + 0.1);
}

/// Mean square over the noise that the true machine leaves of a run in which its unbalance takes a current to its limit and offsets go
/// round the loop, after so many evaluations.
double leftThroughLimit(int passes, LocalState& local) {
  const Model unlimited = withUnbalance(levitated(), 4e-5, 0.3);
  Recording rec = turning(3000);
  for (int c = axis_count; c < predicted_channels; ++c) rec.noise[c] = 1e-3;
  double most = 0.0;
  const std::vector<double> free = shownWith(unlimited, rec, nullptr, 0.0);
  for (long i = 0; i < rec.samples; ++i) most = std::max(most, free[i * predicted_channels + axis_count]);
  const Model model = with(unlimited, "current_saturation", {unlimited.rig.amb.bias_current_A + 0.85 * most});
  rec.measured = shownWith(model, rec, loop_offset_m, 0.5e-6);
  std::mt19937 generator(7);
  std::normal_distribution<double> normal;
  for (std::size_t at = 0; at < rec.measured.size(); ++at) rec.measured[at] += rec.noise[at % predicted_channels] * normal(generator);
  rec.offsets_in_loop = true;
  const std::vector<Recording> one = {rec};
  const FitSpace space(model, {});
  const FitProblem problem(one, space, 1e-6);
  std::vector<LocalState> locals(1);
  double left = 0.0;
  for (int pass = 0; pass < passes; ++pass) left = problem.evaluate(space.start(), {0}, locals, {}).squares;
  local = locals[0];
  return left / static_cast<double>(rec.measured.size());
}

TEST(LoopOffsets, ThroughALimitTheyCountAtTheirSize) {
  LocalState local, unused;
  // 24000 residuals: 0.02 is two of their mean square's deviations
  EXPECT_NEAR(leftThroughLimit(4, local), 1.0, 0.02);
  // the noise leaves 1e-7/sqrt(3000) = 2e-9, more along what sensors share with the drift
  for (int a = 0; a < axis_count; ++a) EXPECT_NEAR(local.offset_m[a], loop_offset_m[a], 0.02e-6) << a;
  EXPECT_GT(leftThroughLimit(1, unused), 1.1);  // to first order alone they are not found
}

TEST(LoopOffsets, WindowsThroughContactBeginInTheLoopThatHasThem) {
  const MadeSet& made = madeSet(21, "none", 0.0, true, {"chirp_1", "rub_1"});
  const Model truth = made.truth();
  Recording rec = beginningOf(made.recordings[made.indexOf("rub_1")], 3000);
  std::vector<LaneJob> jobs = {jobOf(rec, truth, 0.0)};
  std::copy_n(loop_offset_m, axis_count, jobs[0].offset_m);
  jobs[0].out = rec.measured.data();
  Stretch stretch = stretchOf(rec, truth);
  stretch.contact_step_s = contactStep(truth);
  predict(stretch, jobs);
  ASSERT_TRUE(jobs[0].finite);
  std::mt19937 generator(5);
  std::normal_distribution<double> normal;
  for (std::size_t at = 0; at < rec.measured.size(); ++at) rec.measured[at] += rec.noise[at % predicted_channels] * normal(generator);
  const auto left = [&](bool in_loop, LocalState& local) {
    rec.offsets_in_loop = in_loop;
    const std::vector<Recording> one = {rec};
    const FitSpace space(truth, {});
    const FitProblem problem(one, space, made.offset_std_m);
    std::vector<LocalState> locals(1);
    EvaluationOptions options;
    options.thorough = true;
    options.window_passes = 3;
    double mean = 0.0;
    for (int pass = 0; pass < 3; ++pass) {
      const NormalEquations sum = problem.evaluate(space.start(), {0}, locals, options);
      mean = sum.squares / sum.count;
    }
    local = locals[0];
    return mean;
  };
  LocalState local, other;
  const double right = left(true, local), wrong = left(false, other);
  EXPECT_LT(right, 1.0);  // each window's start is fitted
  EXPECT_GT(wrong, right + 0.1);
  for (int a = 0; a < axis_count; ++a) EXPECT_NEAR(local.offset_m[a], loop_offset_m[a], 0.3e-6) << a;
}

}  // namespace
}  // namespace amb_rotor
