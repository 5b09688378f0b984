// The run-in before a recording: long enough for a weakly damped resonance of an effect to forget how it
// began.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>

#include "../support/models.hpp"
#include "amb_rotor/common/units.hpp"
#include "amb_rotor/effects/catalogue.hpp"
#include "amb_rotor/validation/stretches.hpp"

namespace amb_rotor {
namespace {

using namespace testing_support;

/// A levitated rotor with an unbalance; on a foundation where it is asked for. Its converter's steps of 0.1 nm move nothing, but
/// what is not linear has to run in (machine_settled_motion.cpp has what is).
Model turningRotor() {
  Model model = withUnbalance(levitated(), 2e-5, 0.3);
  model.signal_chain.ad = Converter{24.0, 1e-3};
  return model;
}

Model onFoundation(double frequency_hz, double damping_ratio) {
  Model model = turningRotor();
  model.effects.push_back({"foundation_resonance", {100.0, frequency_hz, damping_ratio}});
  return model;
}

/// A tenth of a second at a speed, for the lanes.
Recording tenthOfASecond(double speed_hz) {
  Recording rec;
  rec.run.kind = RunKind::steady;
  rec.run.sample_rate_hz = 1e4;
  rec.samples = 1000;
  rec.speed_rad_s = radPerSecond(speed_hz);
  return rec;
}

/// What the sensors show of it behind a run-in [m]: the displacement of end a in x or y.
std::vector<double> shown(const Model& model, const Recording& rec, Stretch stretch, int axis) {
  std::vector<double> out(rec.samples * predicted_channels);
  stretch.excitation = nullptr;
  stretch.schedule = nullptr;
  std::vector<LaneJob> jobs = {jobOf(rec, model, 0.0)};
  // every run-in ends at the same angle of the shaft
  jobs[0].angle0_rad = 0.0;
  jobs[0].speed_rad_s = rec.speed_rad_s;
  jobs[0].out = out.data();
  predict(stretch, jobs);
  EXPECT_TRUE(jobs[0].finite);
  std::vector<double> seen;
  for (long i = 0; i < rec.samples; ++i) seen.push_back(out[i * predicted_channels + axis]);
  return seen;
}

std::vector<double> shown(const Model& model, double settle_s) {
  const Recording rec = tenthOfASecond(50.0);
  Stretch stretch = stretchOf(rec, model);
  stretch.settle_s = settle_s;
  return shown(model, rec, stretch, 0);
}

double farthest(const std::vector<double>& one, const std::vector<double>& other) {
  double most = 0.0;
  for (std::size_t i = 0; i < one.size(); ++i) most = std::max(most, std::fabs(one[i] - other[i]));
  return most;
}

Recording withNoise(double noise_m) {
  Recording rec = tenthOfASecond(50.0);
  rec.noise.fill(noise_m);
  return rec;
}

/// Its share of the derivative gain: a quarter leaves the loop little damping, less none.
Model withDerivativeGain(double share) {
  Model model = turningRotor();
  model.rig.controller.kd_A_s_per_m *= share;
  return model;
}

TEST(RunInTest, IsAsLongAsAWeaklyDampedLoopNeeds) {
  // A quarter of the derivative gain leaves the loop little damping: no effect says so, its prediction does.
  Recording rec = tenthOfASecond(50.0);
  const double noise = 4e-7;
  rec.noise.fill(noise);
  Model weak = turningRotor();
  const double damped = settledRunIn(rec, weak, stretchOf(rec, weak), 0.0);
  weak.rig.controller.kd_A_s_per_m *= 0.25;
  const Stretch stretch = stretchOf(rec, weak);
  const double needed = settledRunIn(rec, weak, stretch, 0.0);
  EXPECT_GT(needed, damped);
  const auto after = [&](double settle_s) {
    Stretch longer = stretch;
    longer.settle_s = settle_s;
    return shown(weak, rec, longer, 0);
  };
  // 0.05 of the noise is the rms of all channels; the peak of one is a few times that
  const auto settled = after(4.0);
  EXPECT_LT(farthest(after(needed), settled), 0.3 * noise);
  EXPECT_GT(farthest(after(stretch.settle_s), settled), 0.3 * noise) << "too short as it was";
}

TEST(RunInTest, IsNoLongerWhereThePredictionIsFarOffAnyway) {
  Recording rec = withNoise(4e-7);
  const Model weak = withDerivativeGain(0.25);
  const Stretch stretch = stretchOf(rec, weak);
  const double needed = settledRunIn(rec, weak, stretch, 0.0);
  rec.measured.assign(rec.samples * predicted_channels, 0.0);
  for (long i = 0; i < rec.samples; ++i)
    for (int c = 0; c < predicted_channels; ++c) rec.measured[i * predicted_channels + c] = 1e-4 * std::sin(1.0 * i);
  EXPECT_LT(settledRunIn(rec, weak, stretch, 0.0), needed);
}

TEST(RunInTest, IsAsItWasWhereNothingSettles) {
  const Recording rec = withNoise(4e-7);
  const Model unstable = withDerivativeGain(0.15);
  const Stretch stretch = stretchOf(rec, unstable);
  EXPECT_EQ(settledRunIn(rec, unstable, stretch, 0.0), stretch.settle_s) << "a longer one is as far from settled";
}

TEST(RunInTest, OfALinearMachineALongOneEndsInTheSettledMotion) {
  // However long it is beyond the 0.3 s from which it is solved for: 12 Hz at a damping of 0.001 ring for minutes.
  Model model = withUnbalance(levitated(), 2e-5, 0.3);
  model.rig.gravity_m_s2 = 9.81;
  model.effects.push_back({"foundation_resonance", {100.0, 12.0, 0.001}});
  const std::vector<double> one = shown(model, 0.8), longer = shown(model, 2.4);
  EXPECT_LT(farthest(one, longer), 1e-12);
  const Recording rec = withNoise(4e-7);
  const Stretch stretch = stretchOf(rec, model);
  EXPECT_EQ(settledRunIn(rec, model, stretch, 0.0), stretch.settle_s) << "no need of more";
}

TEST(RunInTest, IsSixTimeConstantsOfTheSlowestResonanceUpToALimit) {
  EXPECT_EQ(settlingTime(turningRotor()), 0.0) << "nothing that rings";
  // 6/(2 pi f zeta)
  EXPECT_NEAR(settlingTime(onFoundation(40.0, 0.05)), 0.477465, 1e-6);
  EXPECT_NEAR(settlingTime(onFoundation(80.0, 0.05)), 0.238732, 1e-6);
  EXPECT_NEAR(settlingTime(onFoundation(40.0, 0.1)), 0.238732, 1e-6);
  EXPECT_EQ(settlingTime(onFoundation(40.0, 0.001)), 0.8) << "no longer than that";
  EXPECT_EQ(settlingTime(onFoundation(40.0, 0.0)), 0.8);
  Model both = onFoundation(40.0, 0.05);
  const EffectSchema& shaft = *effectCatalogue().find("shaft_flexibility");
  std::vector<double> values;
  for (const auto& parameter : shaft.parameters) values.push_back(parameter.typical);
  values[shaft.indexOf("frequency_hz")] = 400.0;
  values[shaft.indexOf("damping_ratio")] = 0.01;
  both.effects.push_back({"shaft_flexibility", values});
  EXPECT_NEAR(settlingTime(both), 0.477465, 1e-6) << "the foundation's, which is the longer one";
  // a recording never gets less than a machine without resonances
  const Recording rec;
  const double shortest = Stretch().settle_s;
  EXPECT_EQ(stretchOf(rec, turningRotor()).settle_s, shortest);
  EXPECT_EQ(stretchOf(rec, onFoundation(400.0, 0.05)).settle_s, shortest);
  EXPECT_NEAR(stretchOf(rec, onFoundation(40.0, 0.05)).settle_s, 0.477465, 1e-6);
}

TEST(RunInTest, AfterItTheMotionIsThatOfAFarLongerOne) {
  const Model model = onFoundation(40.0, 0.05);
  const std::vector<double> settled = shown(model, 3.0);
  const double early = farthest(shown(model, Stretch().settle_s), settled),
               own = farthest(shown(model, settlingTime(model)), settled);
  EXPECT_GT(early, 1e-3 * 1.25e-6) << "of the amplitude [m]: there is something to forget";
  // what rings at first falls by exp(-2 pi f zeta t); a factor of two for where in its swing it is met
  const double fall = std::exp(-two_pi * 40.0 * 0.05 * (settlingTime(model) - Stretch().settle_s));
  EXPECT_LT(own, 2.0 * fall * early);
  EXPECT_GT(own, 0.1 * fall * early) << "and it is this resonance that rang";
}

TEST(RunInTest, AStaticSagOfAWeakFoundationDoesNotRing) {
  // The rotor's weight lies on the foundation: f0 = m g/(M w^2) below where it began. From there the foundation swings
  // with f0 exp(-zeta w t), and the rotor follows its acceleration: seen by the sensors, (w/wr)^2 of it with wr the
  // rotor's own frequency on its bearings. 0.8 s are as long as a run-in may be, which is too short for 12 Hz.
  constexpr double frequency_hz = 12.0, damping_ratio = 0.01, foundation_kg = 100.0;
  Model model = with(levitated(), "foundation_resonance", {foundation_kg, frequency_hz, damping_ratio});
  model.signal_chain.ad = Converter{24.0, 1e-3};
  model.rig.gravity_m_s2 = 9.81;
  const Recording rec = tenthOfASecond(0.0);
  const Stretch own = stretchOf(rec, model);
  ASSERT_EQ(own.settle_s, 0.8);
  Stretch at_once = own;
  at_once.calm_s = 0.0;
  const auto swing = [&](const Stretch& stretch) {
    double most = 0.0;
    for (int axis = 0; axis < 2; ++axis) {
      const auto seen = shown(model, rec, stretch, axis);
      most = std::max(most, *std::max_element(seen.begin(), seen.end()) - *std::min_element(seen.begin(), seen.end()));
    }
    return most;
  };
  const double w = radPerSecond(frequency_hz), mass = model.rig.rotor.mass_kg;
  const double sag = mass * 9.81 / (foundation_kg * w * w), follows = w * w * mass / (2.0 * netStiffness(model));
  // from crest to trough in the tenth of a second that is seen; 15 % for the decay in it, and for the rotor's share of
  // the foundation's frequency
  const double rings = 2.0 * sag * follows * std::exp(-damping_ratio * w * own.settle_s);
  EXPECT_NEAR(swing(at_once) / rings, 1.0, 0.15);
  // held back at 0.7 of critical for 0.15 s first: exp(-0.7 w 0.15) = 4e-4 of the sag is left to swing
  EXPECT_LT(swing(own), 0.01 * rings);
}

TEST(RunInTest, ACurrentLimitThatTheSettledMotionKeepsDoesNotLoseTheRotorOnTheWayThere) {
  // 100 g mm turn near the critical speed. From rest the loop swings beyond what the limit lets it hold; from the motion
  // without limit it comes down. At 60 Hz it is the other way round: that motion is beyond the limit's reach, the start is not.
  struct Case {
    double speed_hz, gravity_m_s2, limit_A;
    bool from_rest;
  };
  for (const Case& one : {Case{90.0, 9.81, 4.1, false}, Case{100.0, 0.0, 2.8, false}, Case{60.0, 0.0, 2.9, true}}) {
    SCOPED_TRACE(one.speed_hz);
    Model model = with(withUnbalance(levitated(), 1e-4, 0.3), "current_saturation", {one.limit_A});
    model.rig.gravity_m_s2 = one.gravity_m_s2;
    Recording rec = tenthOfASecond(one.speed_hz);
    rec.stays_inside = true;
    Stretch own = stretchOf(rec, model), from_rest = own;
    from_rest.calm_s = 0.0;
    own.excitation = from_rest.excitation = nullptr;
    own.schedule = from_rest.schedule = nullptr;
    std::vector<double> out(rec.samples * predicted_channels);
    std::vector<LaneJob> jobs = {jobOf(rec, model, 0.0)};
    jobs[0].speed_rad_s = rec.speed_rad_s;
    jobs[0].out = out.data();
    predict(from_rest, jobs);
    EXPECT_EQ(jobs[0].finite, one.from_rest);
    predict(own, jobs);
    EXPECT_TRUE(jobs[0].finite);
  }
}

}  // namespace
}  // namespace amb_rotor
