// The breakdown of an error on residuals made by hand, against closed forms.
#include <gtest/gtest.h>

#include <cmath>

#include "amb_rotor/common/units.hpp"
#include "amb_rotor/validation/breakdown.hpp"

namespace amb_rotor {
namespace {

constexpr double rate = 1e4, noise_m = 1e-6, noise_A = 0.01;
constexpr long samples = 4000;   // 40 turns at 100 Hz
constexpr double speed_hz = 100.0;

struct Made {
  std::vector<Recording> recordings;
  std::vector<PredictedRun> runs;
};

/// A run with residual(channel, angle) in units of the noise.
template <class F>
void add(Made& made, const std::string& id, RunKind kind, bool standstill, F&& residual) {
  Recording rec;
  rec.run.id = id;
  rec.run.kind = kind;
  rec.run.sample_rate_hz = rate;
  rec.samples = samples;
  rec.standstill = standstill;
  PredictedRun run;
  run.id = id;
  run.sample_rate_hz = rate;
  run.predicted.assign(samples * predicted_channels, 0.25e-6);
  run.measured = run.predicted;
  for (int c = 0; c < predicted_channels; ++c) run.noise[c] = rec.noise[c] = c < 4 ? noise_m : noise_A;
  double sum = 0.0;
  for (long i = 0; i < samples; ++i) {
    const double angle = standstill ? 0.0 : two_pi * speed_hz * i / rate;
    run.angle_rad.push_back(angle);
    run.speed_rad_s.push_back(standstill ? 0.0 : two_pi * speed_hz);
    for (int c = 0; c < predicted_channels; ++c) {
      const double value = residual(c, angle);
      run.measured[i * predicted_channels + c] += value * run.noise[c];
      sum += value * value;
    }
  }
  run.error = std::sqrt(sum / (samples * predicted_channels));
  made.recordings.push_back(std::move(rec));
  made.runs.push_back(std::move(run));
}

// Whole turns of 100 samples: sums of harmonics vanish to round-off, 4000 terms of up to 10 noises.
constexpr double round_off = 1e-6;

TEST(BreakdownTest, ABackwardTwiceTurningResidualIsFoundInItsCell) {
  Made made;
  constexpr double size = 6.0, phase = 0.7;
  add(made, "steady_1", RunKind::steady, false, [](int c, double angle) {
    if (c == 2) return size * std::cos(-2.0 * angle + phase);  // bx
    if (c == 3) return size * std::sin(-2.0 * angle + phase);  // by
    return 0.0;
  });
  add(made, "chirp_1", RunKind::chirp, true, [](int, double) { return 1.0; });
  const ErrorBreakdown out = breakDown(made.recordings, made.runs, {0, 1});
  // the pair's squares are size^2 in the mean, over 8 channels
  const double steady = size / std::sqrt(8.0);
  EXPECT_NEAR(out.by_run.at("steady_1"), steady, round_off);
  EXPECT_NEAR(out.by_run.at("chirp_1"), 1.0, round_off);
  EXPECT_NEAR(out.error, std::sqrt(0.5 * (steady * steady + 1.0)), round_off) << "runs weigh equally";
  EXPECT_NEAR(out.error_free, out.error, round_off);
  EXPECT_LT(out.error_contact, 0.0) << "there is none";
  // bx over both runs: mean of size^2/2 and 1
  EXPECT_NEAR(out.by_channel.at("bx"), std::sqrt(0.5 * (0.5 * size * size + 1.0)), round_off);
  EXPECT_NEAR(out.by_channel.at("ax"), std::sqrt(0.5), round_off);
  EXPECT_NEAR(out.by_regime.at("steady"), steady, round_off);
  EXPECT_NEAR(out.by_regime.at("standstill"), 1.0, round_off);
  // |z|^2/2 of one pair of four
  for (const auto& [order, error] : out.by_harmonic)
    EXPECT_NEAR(error, order == -2 ? size / std::sqrt(8.0) : 0.0, round_off) << order;
  ASSERT_EQ(out.by_speed.size(), 2u);
  EXPECT_NEAR(out.by_speed[0].speed_hz, 5.0, 1e-9);
  EXPECT_NEAR(out.by_speed[0].error, 1.0, round_off);
  EXPECT_NEAR(std::floor(out.by_speed[1].speed_hz / 10.0), std::floor(speed_hz / 10.0), 1.0) << "bin of 100 Hz";
  EXPECT_NEAR(out.by_speed[1].error, steady, round_off);
  EXPECT_NE(out.worst.find("100 % of the error above the floor is in run steady_1"), std::string::npos) << out.worst;
  EXPECT_NE(out.worst.find("100 % is 2X backward in the turning runs, at 100 Hz, most in the displacement at end b"), std::string::npos)
      << out.worst;
}

TEST(BreakdownTest, WhatIsAtTheFloorHasNoWorstCell) {
  Made made;
  add(made, "steady_1", RunKind::steady, false, [](int, double) { return 1.0; });
  const ErrorBreakdown out = breakDown(made.recordings, made.runs, {0});
  EXPECT_NEAR(out.error, 1.0, round_off);
  EXPECT_NE(out.worst.find("at the noise floor"), std::string::npos) << out.worst;
}

TEST(BreakdownTest, ContactAndAbsentChannelsCountForThemselves) {
  Made made;
  add(made, "drop_1", RunKind::drop, false, [](int c, double) { return c < 4 ? 3.0 : 0.0; });
  add(made, "steady_1", RunKind::steady, false, [](int, double) { return 2.0; });
  made.recordings[0].run.events.push_back({0.1, false});
  for (int c = 4; c < predicted_channels; ++c) made.runs[1].noise[c] = 0.0;  // not measured
  const ErrorBreakdown out = breakDown(made.recordings, made.runs, {0, 1});
  EXPECT_NEAR(out.error_contact, 3.0 / std::sqrt(2.0), round_off);
  EXPECT_NEAR(out.error_free, 2.0, round_off);
  EXPECT_NEAR(out.by_channel.at("ax"), std::sqrt(0.5 * (9.0 + 4.0)), round_off);
  EXPECT_NEAR(out.by_channel.at("iax"), 0.0, round_off) << "only the run that has it";
  EXPECT_NEAR(out.by_regime.at("amb_off"), 3.0 / std::sqrt(2.0), round_off);
  for (const auto& [order, error] : out.by_harmonic) EXPECT_NEAR(error, 0.0, round_off) << order;
}

}  // namespace
}  // namespace amb_rotor
