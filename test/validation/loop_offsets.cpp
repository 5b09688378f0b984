// Sensors' offsets that go round the control loop, and integrators that are settled when a recording begins: told by the controller's
// law, the offsets' response against the statics of a beam on its bearings, and fits that are not taken in by them.
#include "amb_rotor/validation/loop_offsets.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "../support/made_sets.hpp"
#include "../support/models.hpp"
#include "amb_rotor/common/units.hpp"
#include "amb_rotor/validation/fit.hpp"

namespace amb_rotor {
namespace {

using namespace testing_support;

constexpr double loop_offset_m[4] = {1.2e-6, -0.8e-6, 0.6e-6, 1.0e-6};

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

/// Of a rotor that turns at 70 Hz.
Recording turning(long samples) {
  Recording rec;
  rec.run.kind = RunKind::steady;
  rec.run.sample_rate_hz = 1e4;
  rec.samples = samples;
  rec.speed_rad_s = radPerSecond(70.0);
  rec.noise.fill(1e-7);
  return rec;
}

/// Half a second of a rotor that its weight pulls at and that a controller with integrators holds, which begin with so much.
Recording heldByIntegrators(const Model& model, double share, const double* offset_m) {
  Recording rec = turning(5000);
  // at the sensors' zero each bearing carries half of the weight, by its current alone
  const auto& rig = model.rig;
  const double current = 0.5 * rig.rotor.mass_kg * 9.81 / rig.amb.current_stiffness_N_per_A;
  for (const int a : {1, 3}) rec.integral_m_s[a] = -share * current / rig.controller.ki_A_per_m_s;
  rec.measured.resize(rec.samples * predicted_channels);
  std::vector<LaneJob> jobs = {jobOf(rec, model, 0.0)};
  if (offset_m != nullptr) std::copy_n(offset_m, axis_count, jobs[0].offset_m);
  jobs[0].out = rec.measured.data();
  predict(stretchOf(rec, model), jobs);
  EXPECT_TRUE(jobs[0].finite);
  return rec;
}

Model heavyRotor() {
  Model model = withUnbalance(levitated(), 2e-5, 0.3);
  model.rig.gravity_m_s2 = 9.81;
  model.rig.controller.ki_A_per_m_s = 2e4;
  return model;
}

TEST(LoopOffsets, WhereIntegratorsStoodIsReadOffTheLaw) {
  const Model model = heavyRotor();
  const Recording settled = heldByIntegrators(model, 1.0, nullptr), begun = heldByIntegrators(model, 0.0, nullptr);
  const double current = 0.5 * model.rig.rotor.mass_kg * 9.81 / model.rig.amb.current_stiffness_N_per_A;
  for (const int a : {1, 3}) {
    // what turns leaves 1e-4 of its 10 um (0.1 A) behind the window; delay and lag, 0.18 ms, stand for 1e-3 of a current that comes
    // in a quarter of a second
    EXPECT_NEAR(readLaw(settled, model, 1e-6).integral_A[a], -current, 1e-4);
    EXPECT_NEAR(readLaw(begun, model, 1e-6).integral_A[a], 0.0, 1e-3 * current);
    EXPECT_LT(std::fabs(settled.measured[a]), 2e-5);  // it does not sag
  }
  EXPECT_TRUE(readLoop({settled}, model, 1e-6).integrators_settled);
  EXPECT_FALSE(readLoop({begun}, model, 1e-6).integrators_settled);
  // an offset of the recording alone, 1 um, is told from either
  Recording off = begun;
  for (long i = 0; i < off.samples; ++i) off.measured[i * predicted_channels + 1] += 1e-6;
  EXPECT_NEAR(readLaw(off, model, 1e-6).offset_m[1], 1e-6, 0.1e-6);
  EXPECT_NEAR(readLaw(off, model, 1e-6).integral_A[1], 0.0, 2e-3 * current);
  EXPECT_FALSE(readLoop({off}, model, 1e-6).integrators_settled);
}

/// That the weight takes at a bearing where the sensors show nothing.
double heldCurrent(const Model& model, int end) {
  const auto& z = model.rig.planes.amb;
  return model.rig.rotor.mass_kg * model.rig.gravity_m_s2 * z[1 - end] / (z[1 - end] - z[end]) / model.rig.amb.current_stiffness_N_per_A;
}

/// A third of a second of a rotor at rest whose integrators begin with so much of what holds it, pushed by a current from that instant to
/// 0.2 s, by one axis; and what the recording alone adds: an offset that drifts, and so much of the stated noise.
Recording pushedAtRest(const Model& model, double share, long pushed, double offset_m, double drift_m, double noise = 1.0) {
  Recording rec = turning(3300);
  rec.speed_rad_s = 0.0;
  rec.standstill = true;
  rec.noise.fill(3e-7);
  const auto& rig = model.rig;
  const double noise_A = rec.noise[axis_count] = rec.noise[5] = rec.noise[6] = rec.noise[7] = 5e-3;
  for (int end = 0; end < 2; ++end) rec.integral_m_s[1 + 2 * end] = -share * heldCurrent(model, end) / rig.controller.ki_A_per_m_s;
  rec.excitation.rate_hz = rec.run.sample_rate_hz;
  rec.excitation.axis[1].assign(rec.samples, 0.0);
  std::fill(rec.excitation.axis[1].begin() + pushed, rec.excitation.axis[1].begin() + 2000, 0.2);
  rec.measured = predictedBy(model, rec);
  rec.integral_m_s = {};
  std::mt19937 dice(7);
  std::normal_distribution<double> normal;
  for (long i = 0; i < rec.samples; ++i)
    for (int a = 0; a < axis_count; ++a) {
      rec.measured[i * predicted_channels + a] +=
          offset_m + drift_m * static_cast<double>(i) / static_cast<double>(rec.samples) + noise * rec.noise[a] * normal(dice);
      rec.measured[i * predicted_channels + axis_count + a] += noise * noise_A * normal(dice);
    }
  return rec;
}

TEST(LoopOffsets, NeitherADriftNorAPushIsTakenForAStart) {
  const Model model = heavyRotor();
  constexpr double drift_m = 0.6e-6;
  constexpr long quiet = 500;
  const Recording rec = pushedAtRest(model, 1.0, quiet, 0.5e-6, drift_m), at_once = pushedAtRest(model, 1.0, 1, 0.5e-6, drift_m);
  const double kp = model.rig.controller.kp_A_per_m, ki = model.rig.controller.ki_A_per_m_s;
  const LawReading read = readLaw(rec, model, 1e-6);
  // the offset is a mean of so many instants, of twice the noise's variance over their number
  const double reading_std_A = kp * std::sqrt(2.0 / quiet) * rec.noise[0];
  for (const int a : {1, 3}) EXPECT_NEAR(read.settled_integral_A[a], -heldCurrent(model, a / 2), 3.0 * reading_std_A) << a;
  EXPECT_GT(read.settled_gain, 1000.0);  // the weight's current is a thousand times the reading's deviation
  // a slope alone, kp d/T, would be an offset of kp d/(ki T) and a start of kp times that
  EXPECT_GT(kp * kp * drift_m / (ki * rec.duration()), 10.0 * reading_std_A) << "there is nothing to tell apart";
  // the one instant before a push tells nothing; what is left is the law, its drift held by its stated deviation
  for (const int a : {1, 3})
    EXPECT_NEAR(readLaw(at_once, model, 1e-6).settled_integral_A[a], -heldCurrent(model, a / 2), kp * kp * 1e-6 / (ki * rec.duration())) << a;
  EXPECT_EQ(readLaw(at_once, model, 1e-6).settled_gain, 0.0);  // nothing tells before the push
}

TEST(LoopOffsets, OfATurningRotorTheMeanOfItsTurnsIsTheOffset) {
  const Model model = heavyRotor();
  Recording rec = heldByIntegrators(model, 1.0, nullptr);
  const double start_A = readLaw(rec, model, 0.0).integral_A[1];  // with its ripple: nothing is added yet
  std::mt19937 dice(11);
  std::normal_distribution<double> normal;
  rec.noise.fill(3e-7);
  for (int a = axis_count; a < predicted_channels; ++a) rec.noise[a] = 5e-3;
  for (long i = 0; i < rec.samples; ++i)
    for (int c = 0; c < predicted_channels; ++c)
      rec.measured[i * predicted_channels + c] +=
          rec.noise[c] * normal(dice) + (c < axis_count ? 0.5e-6 + 0.4e-6 * static_cast<double>(i) / static_cast<double>(rec.samples) : 0.0);
  // what noise moves the end of a line by, under Hann's window
  const double reading_std_A = std::sqrt(1.5) * 2.0 * model.rig.controller.kp_A_per_m * rec.noise[0] / std::sqrt(static_cast<double>(rec.samples));
  EXPECT_NEAR(readLaw(rec, model, 1e-6).settled_integral_A[1], start_A, 3.0 * reading_std_A);
}

TEST(LoopOffsets, ALateCurrentIsNoStart) {
  const Model model = heavyRotor();
  Model earlier = model, later = model;
  earlier.rig.controller.delay_s = 0.0;
  later.rig.controller.delay_s += 1e-4;
  const Recording rec = pushedAtRest(model, 1.0, 500, 0.0, 0.0, 0.0);
  // a push of 0.2 A for 0.15 s that the current follows late by 0.1 ms is a slope of 12 times its moment over T^3 in the law
  const double slope_A_per_s = 12.0 * 0.2 * 0.15 * 1e-4 / std::pow(rec.duration(), 3);
  const auto& control = model.rig.controller;
  const double as_a_start_A = control.kp_A_per_m * slope_A_per_s / control.ki_A_per_m_s;
  const double held_A = readLaw(rec, model, 1e-6).integral_A[1];
  for (const Model& belief : {earlier, later})
    EXPECT_NEAR(readLaw(rec, belief, 1e-6).integral_A[1], held_A, 0.2 * as_a_start_A) << belief.rig.controller.delay_s;
}

TEST(LoopOffsets, WhatIsHeldBesideOffsetsIsSeenWhereItIsSmall) {
  Model model = heavyRotor();
  model.rig.gravity_m_s2 = 0.4;
  constexpr double offset_std_m = 1e-6;
  // offsets of three deviations would be as much
  EXPECT_LT(heldCurrent(model, 0), 3.0 * model.rig.controller.kp_A_per_m * offset_std_m);
  const auto settled = [&](double share) {
    std::vector<Recording> recordings;
    for (const double offset_m : {0.5e-6, -0.4e-6, 0.9e-6}) recordings.push_back(pushedAtRest(model, share, 500, offset_m, 0.2e-6));
    return readLoop(recordings, model, offset_std_m).integrators_settled;
  };
  EXPECT_TRUE(settled(1.0));
  EXPECT_FALSE(settled(0.0));
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

/// Beside an offset the law tells of a start by the slope alone; where offsets go round the loop there is none in it.
TEST(LoopOffsets, NoiseIsNotTakenForWhatIntegratorsHold) {
  const Model model = heavyRotor();
  std::mt19937 dice(3);
  std::normal_distribution<double> normal;
  std::vector<Recording> recordings;
  int beside_offsets = 0;
  const double told_A = 0.1 * model.rig.controller.kp_A_per_m * 1e-6;
  for (int run = 0; run < 5; ++run) {
    Recording rec = heldByIntegrators(model, 0.0, loop_offset_m);
    for (int c = 0; c < predicted_channels; ++c) rec.noise[c] = c < axis_count ? 0.7e-6 : 1e-2;
    for (std::size_t at = 0; at < rec.measured.size(); ++at) rec.measured[at] += rec.noise[at % predicted_channels] * normal(dice);
    if (readLaw(rec, model, 1e-6).integral_A.cwiseAbs().maxCoeff() > told_A) ++beside_offsets;
    recordings.push_back(std::move(rec));
  }
  ASSERT_GT(beside_offsets, 2) << "there is nothing to be taken in by";
  const LoopReading read = readLoop(recordings, model, 1e-6);
  EXPECT_TRUE(read.offsets_in_loop);
  EXPECT_FALSE(read.integrators_settled);
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
