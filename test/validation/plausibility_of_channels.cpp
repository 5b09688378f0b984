// What is wrong with a recording's channels is found, named, and nothing is said of good ones.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <functional>

#include "../support/made_sets.hpp"
#include "amb_rotor/common/units.hpp"
#include "amb_rotor/validation/compare.hpp"
#include "amb_rotor/validation/plausibility.hpp"
#include "amb_rotor/validation/sensor_remarks.hpp"

namespace amb_rotor {
namespace {

Recording spoilt(const std::string& id, const std::function<void(Recording&)>& spoil) {
  Recording rec = cleanSet().recordings.at(cleanSet().indexOf(id));
  spoil(rec);
  return rec;
}

void swapColumns(Recording& rec, int one, int other) {
  for (long i = 0; i < rec.samples; ++i)
    std::swap(rec.measured[i * predicted_channels + one], rec.measured[i * predicted_channels + other]);
}

void scaleColumn(Recording& rec, int channel, double factor) {
  for (long i = 0; i < rec.samples; ++i) rec.measured[i * predicted_channels + channel] *= factor;
}

std::vector<std::string> said(const Recording& rec) { return channelRemarks(rec, cleanSet().dataset); }

TEST(PlausibilityTest, NothingIsSaidOfGoodRecordings) {
  for (const MadeSet* set : {&cleanSet(), &madeSet(21, "none", 0.0, true)})
    for (const Recording& rec : set->recordings)
      EXPECT_TRUE(rec.remarks.empty()) << rec.run.id << ": " << rec.remarks.front();
}

TEST(PlausibilityTest, SwappedAxesAreFoundAndSuggested) {
  const auto remarks = said(spoilt("steady_2", [](Recording& rec) { swapColumns(rec, 0, 1); }));
  ASSERT_EQ(remarks.size(), 1u);
  EXPECT_EQ(remarks[0].find("ax_um goes with the control current of ay_um"), 0u) << remarks[0];
  EXPECT_NE(remarks[0].find("swapped"), std::string::npos) << remarks[0];
}

TEST(PlausibilityTest, SwappedEndsAreFoundWhereOneIsExcited) {
  // chirp_1 excites ax alone: bx moves by the tilt, differently
  const auto remarks = said(spoilt("chirp_1", [](Recording& rec) { swapColumns(rec, 0, 2); }));
  ASSERT_EQ(remarks.size(), 1u);
  EXPECT_EQ(remarks[0].find("ax_um goes with the control current of bx_um"), 0u) << remarks[0];
}

TEST(PlausibilityTest, AWrongSignIsFound) {
  for (int channel : {2, 6}) {  // displacement, or its current
    const auto remarks = said(spoilt("steady_3", [&](Recording& rec) { scaleColumn(rec, channel, -1.0); }));
    ASSERT_EQ(remarks.size(), 1u) << channel;
    EXPECT_EQ(remarks[0].find("bx_um has the wrong sign"), 0u) << remarks[0];
  }
}

TEST(PlausibilityTest, MixedUnitsAreFoundWithTheirFactor) {
  const auto remarks = said(spoilt("chirp_1", [](Recording& rec) { scaleColumn(rec, 0, 1e-3); }));
  ASSERT_EQ(remarks.size(), 1u);
  EXPECT_NE(remarks[0].find("ax_um asks for a control current 0.00"), std::string::npos) << remarks[0];
  EXPECT_NE(remarks[0].find("unit"), std::string::npos) << remarks[0];
}

TEST(PlausibilityTest, ACurrentAtItsLimitIsNoWrongUnit) {
  // a sine cut at 0.24 of its height goes with the whole one (correlation 0.94) at a gain of 0.30, below a third
  const auto remarks = said(spoilt("steady_3", [](Recording& rec) {
    double mean = 0.0, square = 0.0;
    for (long i = 0; i < rec.samples; ++i) mean += rec.measured[i * predicted_channels + 4] / rec.samples;
    for (long i = 0; i < rec.samples; ++i) square += std::pow(rec.measured[i * predicted_channels + 4] - mean, 2) / rec.samples;
    const double limit = 0.24 * std::sqrt(2.0 * square);
    for (long i = 0; i < rec.samples; ++i) {
      double& value = rec.measured[i * predicted_channels + 4];
      value = std::clamp(value, mean - limit, mean + limit);
    }
  }));
  EXPECT_TRUE(remarks.empty()) << remarks.front();
}

TEST(PlausibilityTest, AnIntegratorThatTakesOverIsNoWrongUnit) {
  // y = A exp(-t/tau): of the proportional current, ki = 0.7 kp/tau leaves 0.3 to be seen
  constexpr double settling_s = 0.1, left = 0.3;
  Dataset dataset = cleanSet().dataset;
  auto& controller = dataset.belief.rig.controller;
  controller.ki_A_per_m_s = (1.0 - left) * controller.kp_A_per_m / settling_s;
  const Recording rec = spoilt("steady_3", [&](Recording& one) {
    for (long i = 0; i < one.samples; ++i) {
      const double decay = std::exp(-i / one.run.sample_rate_hz / settling_s);
      one.measured[i * predicted_channels] = 2e-5 * decay;
      one.measured[i * predicted_channels + 4] = -2e-5 * controller.kp_A_per_m * (left * decay + 1.0 - left);
    }
  });
  const auto remarks = channelRemarks(rec, dataset);
  EXPECT_TRUE(remarks.empty()) << remarks.front();
}

/// The one remark holds these words.
void expectSaid(const std::vector<std::string>& remarks, const std::vector<std::string>& words) {
  ASSERT_EQ(remarks.size(), 1u) << words[0] << (remarks.empty() ? "" : ": " + remarks[0]);
  for (const auto& one : words) EXPECT_NE(remarks[0].find(one), std::string::npos) << one << ": " << remarks[0];
}

TEST(PlausibilityTest, ExcitationIsHeldAgainstTheCurrents) {
  // chirp_1 drives ax
  const auto heard = [](const std::function<void(Recording&)>& spoil) {
    return excitationRemarks(spoilt("chirp_1", spoil), cleanSet().dataset);
  };
  expectSaid(heard([](Recording& rec) { std::swap(rec.excitation.axis[0], rec.excitation.axis[2]); }),
             {"exc_bx_A is found in iax_A", "swapped"});
  expectSaid(heard([](Recording& rec) {  // the ends, in all but the excitation
               for (int c : {0, 1, 4, 5}) swapColumns(rec, c, c + 2);
             }),
             {"exc_ax_A is found in ibx_A", "swapped"});
  expectSaid(heard([](Recording& rec) {
               for (double& i : rec.excitation.axis[0]) i = -i;
             }),
             {"exc_ax_A has the wrong sign against iax_A"});
  expectSaid(heard([](Recording& rec) {
               for (double& i : rec.excitation.axis[0]) i *= 1e3;
             }),
             {"exc_ax_A is found in iax_A 0.00", "unit"});
  expectSaid(heard([](Recording& rec) {
               for (auto& axis : rec.excitation.axis) axis.clear();
             }),
             {"without an excitation current"});
}

TEST(PlausibilityTest, SensorsThatAreDeadStuckCutOffOrBeyondTheGapAreNamed) {
  const auto heard = [](const std::function<void(double&, double)>& change) {
    return sensorRemarks(spoilt("steady_3",
                                [&](Recording& rec) {
                                  for (long i = 0; i < rec.samples; ++i)
                                    change(rec.measured[i * predicted_channels], static_cast<double>(i) / rec.samples);
                                }),
                         cleanSet().dataset);
  };
  expectSaid(heard([](double& x, double) { x = 12e-6; }), {"one value throughout (12) in ax_um", "dead"});
  expectSaid(heard([](double& x, double share) { x = share < 0.5 ? x : 1e-6; }), {"ax_um stays at 1 um", "stuck"});
  double most = 0.0;
  heard([&](double& x, double) { most = std::max(most, x); });
  expectSaid(heard([&](double& x, double) { x = std::min(x, 0.7 * most); }), {"ax_um is cut off at", "at its end"});
  expectSaid(heard([](double& x, double share) { x = std::fabs(share - 0.25) < 1e-4 ? -5e-3 : x; }),
             {"ax_um reads -5000 um", "beyond the air gap"});
}

TEST(PlausibilityTest, NoiseThatTheSamplesContradictIsSaidOnceForAllChannels) {
  for (const double wrong : {0.1, 10.0}) {
    Dataset dataset = cleanSet().dataset;
    for (Channel& channel : dataset.channels)
      if (channel.meaning == ChannelMeaning::displacement) channel.noise_rms *= wrong, channel.resolution *= wrong;
    const auto remarks = sensorRemarks(spoilt("steady_3", [](Recording&) {}), dataset);
    expectSaid(remarks, {"of the stated noise in ax_um, ay_um, bx_um and by_um"});
    const std::string told = "the scatter is ";
    const double share = std::stod(remarks[0].substr(told.size()));
    EXPECT_GT(share * wrong, 0.4);  // part of the noise moves the rotor, and so is no scatter
    EXPECT_LT(share * wrong, 1.1);
  }
}

TEST(PlausibilityTest, MirroredAxesAndHiddenTurnsAreFound) {
  expectSaid(turningRemarks(spoilt("steady_3",
                                   [](Recording& rec) {
                                     for (int c : {0, 2, 4, 6}) scaleColumn(rec, c, -1.0);
                                   })),
             {"whirls backward at both ends", "mirrored"});
  expectSaid(turningRemarks(spoilt("steady_3", [](Recording& rec) { rec.standstill = true; })), {"standing still", "Hz"});
}

TEST(PlausibilityTest, WhatIsSaidOfSeveralRunsIsOneLine) {
  std::vector<Recording> recordings(3);
  const char* ids[] = {"one", "two", "three"};
  for (int i = 0; i < 3; ++i) recordings[i].run.id = ids[i];
  recordings[0].remarks = {"1 pulse is missing after 0.3 s", "1 pulse is missing after 0.5 s"};
  recordings[1].remarks = {"another thing"};
  recordings[2].remarks = {"1 pulse is missing after 1.25 s"};
  const auto lines = remarksOn(recordings);
  ASSERT_EQ(lines.size(), 2u);
  EXPECT_EQ(lines[0], "one and 1 more (three): 1 pulse is missing after 0.3 s");
  EXPECT_EQ(lines[1], "two: another thing");
}

TEST(PlausibilityTest, AClockThatDriftsAgainstTheTachoIsFoundWithItsRate) {
  constexpr double drift = 2e-3;
  const Recording rec = spoilt("steady_3", [](Recording& rec) {
    for (double& time : rec.pulses.time) time *= 1.0 + drift;
    rec.speed_rad_s /= 1.0 + drift;
  });
  EXPECT_TRUE(clockRemarks(cleanSet().recordings.at(cleanSet().indexOf("steady_3"))).empty());
  const auto remarks = clockRemarks(rec);
  ASSERT_EQ(remarks.size(), 1u);
  // the shaft turns faster than that tacho says: by the drift, to the noise of some hundredths of a radian
  const double ppm = std::stod(remarks[0].substr(remarks[0].find("samples by ") + 11));
  EXPECT_NEAR(ppm, 1e6 * drift, 0.05e6 * drift) << remarks[0];
}

TEST(PlausibilityTest, AClockThatDriftsLateIsFoundFromThereOn) {
  constexpr double drift = 4e-3;
  const Recording rec = spoilt("steady_3", [](Recording& rec) {
    const double from = 0.5 * rec.duration();
    for (double& time : rec.pulses.time) time += drift * std::max(0.0, time - from);
  });
  const auto remarks = clockRemarks(rec);
  ASSERT_EQ(remarks.size(), 1u);
  const double from = std::stod(remarks[0].substr(remarks[0].find(" rad from ") + 10));
  EXPECT_NEAR(from, 0.5 * rec.duration(), 0.08 * rec.duration()) << remarks[0];
  const double ppm = std::stod(remarks[0].substr(remarks[0].find("samples by ") + 11));
  EXPECT_NEAR(ppm, 1e6 * drift, 0.15e6 * drift) << remarks[0];
}

TEST(PlausibilityTest, AShaftThatSlowsDownIsNoClockThatDrifts) {
  // the harmonic goes with the pulses; past its resonance it lags behind, by another amount than a clock would
  const Recording rec = spoilt("steady_3", [](Recording& rec) {
    const double from = 0.5 * rec.duration();
    for (double& time : rec.pulses.time) time += 4e-3 * std::max(0.0, time - from);
    const ShaftAngle shaft(rec.pulses);
    for (long i = 0; i < rec.samples; ++i) {
      const double t = i / rec.run.sample_rate_hz, angle = shaft.angle(t) + 1.0 * std::max(0.0, t - from) / (rec.duration() - from);
      for (int end = 0; end < 2; ++end) {
        rec.measured[i * predicted_channels + 2 * end] = 1e-5 * std::cos(angle);
        rec.measured[i * predicted_channels + 2 * end + 1] = 1e-5 * std::sin(angle);
      }
    }
  });
  EXPECT_TRUE(clockRemarks(rec).empty()) << clockRemarks(rec)[0];
}

TEST(PlausibilityTest, WhatIsThereIsJudgedWhereOtherChannelsAreMissing) {
  const auto without = [](std::vector<int> channels, const std::function<void(Recording&)>& spoil) {
    return [=](Recording& rec) {
      spoil(rec);
      for (const int c : channels) {
        rec.noise[c] = 0.0;
        scaleColumn(rec, c, 0.0);
      }
    };
  };
  const auto swapped = [](Recording& rec) { swapColumns(rec, 0, 1); };
  const auto turned = [](Recording& rec) {
    for (double& i : rec.excitation.axis[0]) i *= -1.0;
  };
  for (const auto& missing : std::vector<std::vector<int>>{{3, 7}, {3}, {7}, {2, 3, 6, 7}}) {
    expectSaid(said(spoilt("steady_2", without(missing, swapped))), {"ax_um goes with the control current of ay_um", "swapped"});
    expectSaid(excitationRemarks(spoilt("chirp_1", without(missing, turned)), cleanSet().dataset), {"exc_ax_A has the wrong sign"});
    for (const char* id : {"steady_2", "chirp_1", "step_1"}) {
      const Recording rec = spoilt(id, without(missing, [](Recording&) {}));
      EXPECT_TRUE(said(rec).empty() && excitationRemarks(rec, cleanSet().dataset).empty() && clockRemarks(rec).empty()) << id;
    }
  }
  // its place is told by the current where the displacement of that place is missing
  expectSaid(said(spoilt("steady_2", without({1}, swapped))), {"ax_um goes with the control current iay_A", "another place"});
  expectSaid(excitationRemarks(spoilt("chirp_1",
                                      [](Recording& rec) {
                                        rec.noise.fill(0.0);
                                        for (auto& axis : rec.excitation.axis) axis.clear();
                                      }),
                               cleanSet().dataset),
             {"without an excitation current"});
}

TEST(ShaftWithoutTachoTest, ItsFirstHarmonicTellsSpeedAndAngle) {
  const Model& belief = cleanSet().dataset.belief;
  const Recording told = spoilt("steady_3", [](Recording&) {});
  for (const double wrong : {0.995, 1.0, 1.01}) {
    Recording rec = told;
    rec.pulses = {};
    rec.angle0_rad = 0.0;
    rec.speed_rad_s = wrong * told.speed_rad_s;
    ASSERT_TRUE(findShaft(rec, belief));
    EXPECT_NEAR(rec.speed_rad_s, told.speed_rad_s, 0.1 / told.duration());
    const double at = rec.first_turns_s;
    const double off = (rec.angle0_rad + rec.speed_rad_s * at) - (told.angle0_rad + told.speed_rad_s * at);
    EXPECT_NEAR(std::remainder(off, two_pi), 0.0, 0.2) << "the belief's own error of phase";
    EXPECT_GT(rec.angle_std_rad, 1.0);
  }
  Recording still = told;  // noise alone
  for (std::size_t i = 0; i < still.measured.size(); ++i)
    still.measured[i] = still.noise[i % predicted_channels] * (static_cast<double>(i * 7919 % 1009) / 504.5 - 1.0);
  EXPECT_FALSE(findShaft(still, belief));
}

TEST(PlausibilityTest, AComparisonGoesOnAndSaysSo) {
  // the same fault in the files: two columns have changed places
  const std::filesystem::path folder = cleanSet().dataset.folder + "_swapped";
  std::filesystem::copy(cleanSet().dataset.folder, folder, std::filesystem::copy_options::recursive);
  std::string text = readTextFile((folder / "dataset.yaml").string());
  const auto replace = [&](const std::string& from, const std::string& to) {
    const std::size_t at = text.find(from);
    ASSERT_NE(at, std::string::npos) << from;
    text.replace(at, from.size(), to);
  };
  replace("ax_um: {meaning: displacement, plane: a, axis: x", "ax_um: {meaning: displacement, plane: a, axis: ?");
  replace("ay_um: {meaning: displacement, plane: a, axis: y", "ay_um: {meaning: displacement, plane: a, axis: x");
  replace("axis: ?", "axis: y");
  std::ofstream((folder / "dataset.yaml").string()) << text;
  CompareOptions options;
  options.refit = false;
  const Dataset dataset = readDataset(folder.string());
  const Comparison out = compare(cleanSet().truth(), dataset, options);
  EXPECT_GT(out.errors.error, 3.0);
  EXPECT_TRUE(std::any_of(out.remarks.begin(), out.remarks.end(), [](const std::string& remark) {
    return remark.find("swapped") != std::string::npos;
  }));
  std::filesystem::remove_all(folder);
}

}  // namespace
}  // namespace amb_rotor
