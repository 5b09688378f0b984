// What is wrong with a recording's channels is found, named, and nothing is said of good ones.
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <functional>

#include "../support/made_sets.hpp"
#include "amb_rotor/common/units.hpp"
#include "amb_rotor/validation/compare.hpp"
#include "amb_rotor/validation/plausibility.hpp"

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
