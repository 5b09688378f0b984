// What the controller's law says of a recording: where its integrators stood, beside offsets, drifts, pushes, late currents and noise.
#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "../support/heavy_loops.hpp"
#include "../support/made_sets.hpp"
#include "amb_rotor/validation/loop_offsets.hpp"

namespace amb_rotor {
namespace {

using namespace testing_support;

TEST(LoopReadings, WhereIntegratorsStoodIsReadOffTheLaw) {
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

TEST(LoopReadings, NeitherADriftNorAPushIsTakenForAStart) {
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

TEST(LoopReadings, OfATurningRotorTheMeanOfItsTurnsIsTheOffset) {
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

TEST(LoopReadings, ALateCurrentIsNoStart) {
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

TEST(LoopReadings, WhatIsHeldBesideOffsetsIsSeenWhereItIsSmall) {
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

/// Beside an offset the law tells of a start by the slope alone; where offsets go round the loop there is none in it.
TEST(LoopReadings, NoiseIsNotTakenForWhatIntegratorsHold) {
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

}  // namespace
}  // namespace amb_rotor
