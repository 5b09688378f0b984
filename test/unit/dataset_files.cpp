// Data sets: description, tables, every fault of a table once; tutorial sets where they are at hand.
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <iomanip>
#include <sstream>

#include "amb_rotor/model/model_writer.hpp"
#include "amb_rotor/model/remarks.hpp"
#include "amb_rotor/validation/coordinates.hpp"
#include "amb_rotor/validation/dataset.hpp"
#include "amb_rotor/validation/recording.hpp"
#include "amb_rotor/validation/table.hpp"
#include "model_test_support.hpp"

namespace amb_rotor {
namespace {

namespace fs = std::filesystem;
using namespace model_test;

std::string tinyFolder() { return dataFolder() + "/dataset_tiny"; }
std::string tinyText() { return readTextFile(tinyFolder() + "/dataset.yaml"); }

/// A copy of the tiny data set that a test may spoil.
class DatasetCopy : public testing::Test {
 protected:
  void SetUp() override {
    std::string name = testing::UnitTest::GetInstance()->current_test_info()->name();
    std::replace(name.begin(), name.end(), '/', '_');
    folder_ = fs::path(testing::TempDir()) / ("amb_rotor_" + name + "_" + std::to_string(::getpid()));
    fs::remove_all(folder_);
    fs::create_directories(folder_);
    fs::copy(tinyFolder(), folder_, fs::copy_options::recursive);
  }
  void TearDown() override { fs::remove_all(folder_); }

  void describe(const std::string& text) { writeTextFile((folder_ / "dataset.yaml").string(), text); }
  void table(const std::string& text) { writeTextFile((folder_ / "runs/one.csv").string(), text); }
  std::vector<Fault> datasetFaults() {
    return faultsOf([&] { readDataset(folder_.string()); });
  }
  std::vector<Fault> runFaults(std::size_t run = 0) {
    const Dataset dataset = readDataset(folder_.string());
    return faultsOf([&] { readRun(dataset, dataset.runs.at(run)); });
  }
  /// The faults of a table with the tiny set's header and these lines.
  std::vector<Fault> rowFaults(const std::string& rows) {
    table("t_s,tacho,ax_um,by_mm,iax_mA,exc_bx_A\n" + rows);
    return runFaults();
  }

  fs::path folder_;
};

TEST_F(DatasetCopy, remarksAndFaultsOfItsRigHaveFileAndLine) {
  const std::string from = "stiffness_N_per_m: 3.38e7", to = "stiffness_N_per_m: 33.8";
  describe(replaced(tinyText(), from, to));
  const Dataset dataset = readDataset(folder_.string());
  const Fault remark = faultOf(remarksOn(dataset.belief), "rig.auxiliary_bearing.contact.stiffness_N_per_m");
  EXPECT_EQ(remark.file, (folder_ / "dataset.yaml").string());
  EXPECT_EQ(remark.line, lineOf(replaced(tinyText(), from, to), to)) << remark.text();
  EXPECT_EQ(remark.value, "33.8");
  // what a fit makes of it is not written there
  const FitSpace space(dataset.belief, {});
  EXPECT_EQ(faultOf(remarksOn(space.model(space.start())), remark.key).file, "");
}

TEST_F(DatasetCopy, aSpeedThatNoRotorHasIsRefused) {
  describe(replaced(tinyText(), "speed: {type: constant, hz: 0.0}", "speed: {type: constant, hz: 1.0e6}"));
  EXPECT_NE(faultOf(datasetFaults(), "runs.0.speed.hz").rule.find("at most 20000.0 Hz"), std::string::npos);
}

/// 172.048 Hz by a tacho of 64 levels: over eight turns of 58.125 samples it shows 172.043 Hz to a part in a million, and no scatter.
TEST_F(DatasetCopy, aClockIsBelievedAsFarAsAllPulsesScatter) {
  constexpr double hz = 172.048, first_s = 0.003, ramp_s = 2e-4;
  const std::string faster = replaced(tinyText(), "kind: step, sample_rate_hz: 1000.0", "kind: steady, sample_rate_hz: 10000.0");
  describe(replaced(faster, "speed: {type: constant, hz: 0.0}", "speed: {type: constant, hz: 172.27}"));
  std::ostringstream rows;
  rows << "t_s,tacho,ax_um,by_mm,iax_mA,exc_bx_A\n" << std::setprecision(9);
  for (int i = 0; i < 8000; ++i) {
    const double time = i * 1e-4, into = std::remainder(time - first_s, 1.0 / hz);  // from the pulse next to it
    const double value = into < 1e-3 ? std::clamp(0.5 + into / ramp_s, 0.0, 1.0) : 0.0;
    rows << time << ',' << std::round(64.0 * value) / 64.0 << ",0,0,0,0\n";
  }
  table(rows.str());
  const Dataset dataset = readDataset(folder_.string());
  const Recording rec = prepareRecording(dataset, dataset.runs.at(0));
  EXPECT_NEAR(rec.speed_rad_s / (2.0 * M_PI), hz, 3.0 * rec.speed_std_rad_s / (2.0 * M_PI));
  EXPECT_LT(rec.speed_std_rad_s / (2.0 * M_PI * hz), 1e-4);  // edges known to some 1 us, over 46 ms
}

TEST_F(DatasetCopy, aRunWithoutEventsHasNone) {
  describe(replaced(tinyText(), "events: [], ", ""));
  EXPECT_TRUE(datasetFaults().empty());
  EXPECT_TRUE(readDataset(folder_.string()).runs[0].events.empty());
}

TEST(DatasetFiles, readsTheDescription) {
  const Dataset dataset = readDataset(tinyFolder());
  EXPECT_EQ(dataset.name, "tiny");
  EXPECT_EQ(dataset.belief.rotor_model, RotorModel::rigid_beam);
  EXPECT_EQ(dataset.belief.rig.gravity_m_s2, 9.81);
  EXPECT_TRUE(dataset.belief.effects.empty());
  const Channel* ax = dataset.findChannel(ChannelMeaning::displacement, 0);
  ASSERT_NE(ax, nullptr);
  EXPECT_EQ(ax->unit_factor, 1e-6);
  EXPECT_DOUBLE_EQ(ax->noise_rms, 0.3e-6);
  EXPECT_DOUBLE_EQ(ax->noise(), std::sqrt(0.3 * 0.3 + 0.25 * 0.25 / 12.0) * 1e-6);
  const Channel* by = dataset.findChannel(ChannelMeaning::displacement, 3);
  ASSERT_NE(by, nullptr);
  EXPECT_EQ(by->unit_factor, 1e-3);
  EXPECT_DOUBLE_EQ(by->noise(), 0.4e-6);  // its noise is in um, its cells in mm
  EXPECT_EQ(dataset.findChannel(ChannelMeaning::displacement, 1), nullptr);
  EXPECT_EQ(dataset.findChannel(ChannelMeaning::tacho)->threshold, 0.5);
  ASSERT_EQ(dataset.runs.size(), 2u);
  const auto* two = dataset.findRun("two");
  ASSERT_NE(two, nullptr);
  EXPECT_EQ(two->kind, RunKind::drop);
  EXPECT_TRUE(two->holdsContact());
  EXPECT_TRUE(two->speed_from_tacho);
  EXPECT_EQ(two->use, RunUse::validate);
  ASSERT_EQ(two->events.size(), 1u);
  EXPECT_FALSE(two->events[0].amb_on);
  ASSERT_EQ(two->unbalance.size(), 1u);
  EXPECT_EQ(two->unbalance[0].plane_z_m, 0.1);
  EXPECT_EQ(readDataset(tinyFolder() + "/dataset.yaml").folder, tinyFolder());
}

TEST(DatasetFiles, readsPlainAndCompressedTables) {
  const Dataset dataset = readDataset(tinyFolder());
  const RunTable one = readRun(dataset, dataset.runs[0]);
  EXPECT_EQ(one.time_s, (std::vector<double>{0.0, 0.001, 0.002}));
  EXPECT_EQ(one.tacho, (std::vector<double>{0.0, 1.0, 0.0}));
  ASSERT_EQ(one.displacement_m[0].size(), 3u);
  EXPECT_DOUBLE_EQ(one.displacement_m[0][2], -7.25e-6);
  EXPECT_DOUBLE_EQ(one.displacement_m[3][1], 3e-6);
  EXPECT_DOUBLE_EQ(one.current_A[0][1], -0.01);
  EXPECT_DOUBLE_EQ(one.excitation_A[2][2], -0.5);
  EXPECT_TRUE(one.displacement_m[1].empty());
  const RunTable two = readRun(dataset, dataset.runs[1]);  // other order of columns, CRLF
  EXPECT_DOUBLE_EQ(two.displacement_m[0][2], 5e-6);
  EXPECT_EQ(two.tacho[0], 1.0);
}

TEST_F(DatasetCopy, truthIsNeverRead) {
  writeTextFile((folder_ / "truth.yaml").string(), "[not, a, map");
  EXPECT_TRUE(datasetFaults().empty());
}

TEST_F(DatasetCopy, tellsAllFaultsOfTheDescriptionAtOnce) {
  std::string text = replaced(tinyText(), "mass_kg: 3.36", "mass_kg: 0");
  text = replaced(text, "meaning: displacement, plane: a", "meaning: displacement, plane: c");
  text = replaced(text, "noise_rms_um: 0.4, ", "noise_rms_V: 0.4, ");
  text = replaced(text, "iax_mA:", "iax_mN:");
  text = replaced(text, "file: runs/one.csv", "file: runs/none.csv");
  text = replaced(text, "kind: drop", "kind: dropped");
  text = replaced(text, "type: amb_off", "type: amb_of");
  text = replaced(text, "use: validate", "use: validation");
  text = replaced(text, "moment_kg_m: 1.0e-5", "moment_kg_m: -1.0e-5");
  describe(text);
  const auto faults = datasetFaults();
  for (const char* key :
       {"rig.rotor.mass_kg", "channels.ax_um.plane", "channels.by_mm.noise_rms_V", "channels.iax_mN",
        "runs.0.file", "runs.1.kind", "runs.1.events.0.type", "runs.1.use", "runs.1.unbalance.0.moment_kg_m"})
    EXPECT_GT(faultOf(faults, key).line, 0) << key;
  EXPECT_EQ(faults.size(), 9u) << joined(faults);
}

struct DatasetChange {
  const char* from;
  const char* to;
  const char* key;
};

void PrintTo(const DatasetChange& change, std::ostream* stream) {
  *stream << change.from << " -> " << change.to;
}

class DatasetRule : public DatasetCopy, public testing::WithParamInterface<DatasetChange> {};

TEST_P(DatasetRule, isNamed) {
  describe(replaced(tinyText(), GetParam().from, GetParam().to));
  const auto faults = datasetFaults();
  ASSERT_EQ(faults.size(), 1u) << joined(faults);
  EXPECT_EQ(faults[0].key, GetParam().key) << joined(faults);
  EXPECT_GT(faults[0].line, 0);
}

INSTANTIATE_TEST_SUITE_P(
    All, DatasetRule,
    testing::Values(
        DatasetChange{"format: amb-dataset/1", "format: amb-model/1", "format"},
        DatasetChange{"friction_coefficient: 0.1", "friction_coefficient: 3",
                      "rig.auxiliary_bearing.friction_coefficient"},
        DatasetChange{"meaning: excitation current", "meaning: excitation", "channels.exc_bx_A.meaning"},
        DatasetChange{", threshold: 0.5", "", "channels.tacho.threshold"},
        DatasetChange{"noise_rms_um: 0.4, ", "", "channels.by_mm.noise_rms_um"},
        DatasetChange{"noise_rms_um: 0.4, ", "noise_rms_um: 0, ", "channels.by_mm.noise_rms"},
        DatasetChange{"noise_rms_um: 0.3, ", "noise_rms_um: -0.3, ", "channels.ax_um.noise_rms_um"},
        DatasetChange{"plane: b, axis: y", "plane: a, axis: x", "channels.by_mm"},
        DatasetChange{"axis: x}\nruns", "axis: x, gain: 1}\nruns", "channels.exc_bx_A.gain"},
        DatasetChange{"- id: two", "- id: one", "runs.1.id"},
        DatasetChange{"file: runs/two.csv.gz", "file: /runs/two.csv.gz", "runs.1.file"},
        DatasetChange{"file: runs/two.csv.gz", "file: runs/../runs/one.csv", "runs.1.file"},
        DatasetChange{"sample_rate_hz: 1000.0, speed", "sample_rate_hz: 0, speed", "runs.0.sample_rate_hz"},
        DatasetChange{"type: constant, hz: 0.0", "type: constant, hz: -1", "runs.0.speed.hz"},
        DatasetChange{"type: constant, hz: 0.0", "type: constant", "runs.0.speed.hz"},
        DatasetChange{"  tacho: {meaning: one pulse a turn, threshold: 0.5}\n", "", "runs.1.speed.type"},
        DatasetChange{"time_s: 0.001", "time_s: -0.001", "runs.1.events.0.time_s"},
        DatasetChange{"[{time_s: 0.001, type: amb_off}",
                      "[{time_s: 0.001, type: amb_off}, {time_s: 0, type: amb_on}",
                      "runs.1.events.1.time_s"}));

TEST_F(DatasetCopy, columnsAreNamedWhereMissingUnknownOrDouble) {
  table("t_s,tacho,ax_um,ax_um,by_parsec,exc_bx_A,temperature\n0,0,0,0,0,0,0\n0.001,0,0,0,0,0,0\n");
  const auto faults = runFaults();
  EXPECT_EQ(faults.size(), 5u) << joined(faults);
  EXPECT_NE(faultOf(faults, "by_mm").rule.find("missing"), std::string::npos);
  EXPECT_NE(faultOf(faults, "iax_mA").rule.find("missing"), std::string::npos);
  EXPECT_NE(faultOf(faults, "by_parsec").rule.find("unit parsec is not known"), std::string::npos);
  EXPECT_NE(faultOf(faults, "ax_um").rule.find("twice"), std::string::npos);
  faultOf(faults, "temperature");
  table("time,tacho,ax_um,by_mm,iax_mA,exc_bx_A\n0,0,0,0,0,0\n");
  EXPECT_NE(faultOf(runFaults(), "t_s").rule.find("missing"), std::string::npos);
}

TEST_F(DatasetCopy, aFileOfTwoRunsNamesBoth) {
  describe(replaced(tinyText(), "runs/two.csv.gz", "runs/one.csv"));
  const auto faults = datasetFaults();
  EXPECT_NE(faultOf(faults, "runs.1.file").rule.find("the file of run one too"), std::string::npos) << joined(faults);
}

TEST_F(DatasetCopy, aTableOfAnotherFormatIsOneFaultThatNamesIt) {
  struct Case {
    std::string text, said;
  };
  const std::string names = "t_s,tacho,ax_um,by_mm,iax_mA,exc_bx_A\n";
  const auto with = [](std::string text, char from, char to) {
    std::replace(text.begin(), text.end(), from, to);
    return text;
  };
  const std::string rows = "0,0.5,0,0,0,0\n0.001,0,0,0,0,0\n0.002,x,0,0,0,0\n";
  const std::string utf16("\xff\xfet\0_\0s\0", 8);
  const std::string decimals = with(with(rows, ',', ';'), '.', ',');
  const std::vector<Case> cases = {
      {with(names + rows, ',', ';'), "by semicolons; a table is comma separated, with decimal points: tr ';' ',' <"},
      {with(names, ',', ';') + decimals, "and the numbers have decimal commas; a table is comma separated, with decimal points: tr ',;' '.,' <"},
      {with(names + rows, ',', '\t'), "by tabs; a table is comma separated, with decimal points: tr '\\t' ',' <"},
      {with(names + rows, ',', ' '), "by blanks"},
      {names + "0,001,0,5,0,0,0,0\n0,002,0,5,0,0,0,0\n", "8 cells of digits only for 6 names: decimal commas"},
      {"\"t_s\",\"tacho\"\n" + rows, "quotation marks"},
      {std::string("\xff\xfet\0_\0s\0", 8), "UTF-16"},
      {"\x1f\x8b,", "gzip-compressed"},
      {"# of June\n" + names + rows, "the first line is a comment"},
      {rows, "the first line holds numbers"}};
  for (const Case& one : cases) {
    table(one.text);
    const auto faults = runFaults();
    EXPECT_EQ(faults.size(), 1u) << joined(faults);
    EXPECT_NE(faults[0].rule.find(one.said), std::string::npos) << joined(faults);
  }
}

TEST_F(DatasetCopy, badCellsAndTimeAreNamedWithTheirLines) {
  const auto cells =
      rowFaults("0,0,0,0,0,0\n0.001,0,x,0,nan,0\n0.002,0,,0,0,inf\n0.003,0,1,2,3\n0.004,0,0,0,0,0,0\n");
  ASSERT_EQ(cells.size(), 6u) << joined(cells);
  EXPECT_EQ(faultOf(cells, "iax_mA").line, 3);
  EXPECT_EQ(faultOf(cells, "iax_mA").value, "nan");
  EXPECT_EQ(faultOf(cells, "exc_bx_A").line, 4);
  EXPECT_EQ(cells[1].line, 3);
  EXPECT_EQ(cells[4].line, 5);
  EXPECT_NE(cells[4].rule.find("5 cells, the header 6"), std::string::npos);
  EXPECT_EQ(cells[5].line, 6);
  const auto back =
      rowFaults("0,0,0,0,0,0\n0.001,0,0,0,0,0\n0.001,0,0,0,0,0\n0.002,0,0,0,0,0\n0.003,0,0,0,0,0\n");
  ASSERT_EQ(back.size(), 1u) << joined(back);
  EXPECT_EQ(back[0].line, 4);
  EXPECT_NE(back[0].rule.find("must rise"), std::string::npos);
  const auto gap = rowFaults("0,0,0,0,0,0\n0.001,0,0,0,0,0\n0.002,0,0,0,0,0\n0.005,0,0,0,0,0\n");
  ASSERT_EQ(gap.size(), 1u) << joined(gap);
  EXPECT_EQ(gap[0].line, 5);
  EXPECT_NE(gap[0].rule.find("2.0 samples are missing"), std::string::npos);
}

TEST_F(DatasetCopy, wrongSampleRateIsOneFault) {
  std::string rows;
  for (int i = 0; i < 50; ++i) rows += std::to_string(i * 0.0005) + ",0,0,0,0,0\n";
  const auto faults = rowFaults(rows);
  ASSERT_EQ(faults.size(), 1u) << joined(faults);
  EXPECT_NE(faults[0].rule.find("sample_rate_hz"), std::string::npos);
}

TEST_F(DatasetCopy, roundedTimesAreNoFault) {
  // 1/30000 s printed with 6 decimals: steps of 33 and 34 us.
  describe(replaced(tinyText(), "sample_rate_hz: 1000.0, speed", "sample_rate_hz: 30000.0, speed"));
  std::string rows;
  for (int i = 0; i < 3000; ++i) rows += std::to_string(i / 30000.0) + ",0,0,0,0,0\n";
  const auto faults = rowFaults(rows);
  EXPECT_TRUE(faults.empty()) << joined(faults);
}

TEST_F(DatasetCopy, emptyAndCutFilesAreFaults) {
  table("");
  EXPECT_EQ(runFaults().size(), 1u);
  EXPECT_EQ(rowFaults("").size(), 1u);
  EXPECT_EQ(rowFaults("0,0,0,0,0,0\n").size(), 1u);
  const auto cut = rowFaults("0,0,0,0,0,0\n0.001,0,0,0,0,0\n0.002,0,0");
  ASSERT_EQ(cut.size(), 1u) << joined(cut);
  EXPECT_NE(cut[0].rule.find("ends in the middle of a line"), std::string::npos);
}

TEST_F(DatasetCopy, cutDamagedAndPlainGzFilesAreFaults) {
  const std::string file = (folder_ / "runs/two.csv.gz").string();
  const std::string whole = readTextFile(file);
  writeTextFile(file, whole.substr(0, whole.size() - 10));
  auto faults = runFaults(1);
  ASSERT_EQ(faults.size(), 1u) << joined(faults);
  EXPECT_NE(faults[0].rule.find("cut off or damaged"), std::string::npos);
  std::string damaged = whole;
  damaged[damaged.size() - 6] = static_cast<char>(damaged[damaged.size() - 6] ^ 1);  // in the checksum
  writeTextFile(file, damaged);
  EXPECT_EQ(runFaults(1).size(), 1u);
  writeTextFile(file, "t_s\n0\n");
  EXPECT_NE(joined(runFaults(1)).find("not compressed"), std::string::npos);
  writeTextFile(file, "");
  EXPECT_NE(joined(runFaults(1)).find("empty"), std::string::npos);
}

TEST_F(DatasetCopy, aBagIsPointedToConvert) {
  writeTextFile((folder_ / "runs/one.bag").string(), "#ROSBAG V2.0\n");
  describe(replaced(tinyText(), "runs/one.csv", "runs/one.bag"));
  EXPECT_NE(joined(runFaults()).find("amb convert"), std::string::npos);
}

TEST_F(DatasetCopy, anEventBehindTheEndIsAFault) {
  describe(replaced(tinyText(), "time_s: 0.001", "time_s: 0.5"));
  EXPECT_NE(joined(runFaults(1)).find("after the end"), std::string::npos);
}

TEST_F(DatasetCopy, manyBadCellsAreCounted) {
  std::string rows;
  for (int i = 0; i < 1000; ++i) rows += "x,0,0,0,0,0\n";
  const auto faults = rowFaults(rows);
  EXPECT_EQ(faults.size(), max_cell_faults + 1);
  EXPECT_NE(joined(faults).find("and 980 more"), std::string::npos);
}

TEST(DatasetTutorial, allSetsReadFast) {
  const fs::path folder = fs::path(AMB_ROTOR_SOURCE_DIR) / "../shared/data/tutorial";
  if (!fs::is_directory(folder)) GTEST_SKIP() << "no tutorial sets at " << folder;
  for (const auto& entry : fs::directory_iterator(folder)) {
    const auto begin = std::chrono::steady_clock::now();
    const Dataset dataset = readDataset(entry.path().string());
    EXPECT_GE(dataset.runs.size(), 12u);
    for (const auto& run : dataset.runs) {
      const RunTable table = readRun(dataset, run);
      EXPECT_GT(table.time_s.size(), 1000u);
      for (int i = 0; i < 4; ++i) {
        EXPECT_EQ(table.displacement_m[i].size(), table.time_s.size());
        EXPECT_EQ(table.current_A[i].size(), table.time_s.size());
        EXPECT_EQ(table.excitation_A[i].size(), table.time_s.size());
      }
    }
    const std::chrono::duration<double> taken = std::chrono::steady_clock::now() - begin;
    // It takes about 0.1 s on an idle core; the bound leaves room for sanitizers and a loaded machine.
    EXPECT_LT(taken.count(), 5.0) << entry.path();
  }
}

}  // namespace
}  // namespace amb_rotor
