// Data sets of modes, with table 4.2 of the thesis as the one that is there.
#include <unistd.h>

#include <cmath>
#include <filesystem>

#include "amb_rotor/common/units.hpp"
#include "amb_rotor/model/model_writer.hpp"
#include "amb_rotor/validation/modes_dataset.hpp"
#include "model_test_support.hpp"

namespace amb_rotor {
namespace {

namespace fs = std::filesystem;
using namespace model_test;

std::string tableFolder() { return std::string(AMB_ROTOR_SOURCE_DIR) + "/config/thesis/table_4_2"; }

TEST(DatasetModes, readsTableOfTheThesis) {
  const ModesDataset dataset = readModesDataset(tableFolder());
  EXPECT_EQ(dataset.conditions, std::vector<std::string>{"amb.stiffness_N_per_m"});
  EXPECT_EQ(dataset.mode_count, 2u);
  ASSERT_EQ(dataset.points.size(), 10u);
  int held_out = 0;
  double highest = 0.0;
  RunUse use_of_highest = RunUse::fit;
  for (const ModesPoint& point : dataset.points) {
    held_out += point.use == RunUse::validate;
    if (point.condition[0] > highest) use_of_highest = point.use;
    highest = std::max(highest, point.condition[0]);
    EXPECT_EQ(point.speed_hz, 0.0);
  }
  EXPECT_EQ(held_out, 5);
  EXPECT_EQ(highest, 7.2422e5);
  EXPECT_EQ(use_of_highest, RunUse::validate);
  EXPECT_EQ(dataset.points[0].frequency_hz, (std::vector<double>{84.7, 121.7}));
}

TEST(DatasetModes, beliefGivesTheCalculatedFrequenciesOfTheThesis) {
  // Undamped rigid beam between two equal springs: f1 = sqrt(2 k/m) / 2 pi, f2 = sqrt(2 k l^2/It) / 2 pi. The
  // table prints whole hertz; its f2 scatters about one lever arm by up to 0.7 Hz, so within 1.5 Hz.
  constexpr double tolerance_hz = 1.5;
  const double printed[5][2] = {{85, 117}, {89, 123}, {94, 128}, {98, 134}, {101, 139}};
  const ModesDataset dataset = readModesDataset(tableFolder());
  for (std::size_t i = 0; i < 5; ++i) {
    const Model model = modelAt(dataset.belief, dataset, dataset.points[i]);
    const double k = 2.0 * model.rig.amb.stiffness_N_per_m;
    const double arm = model.rig.planes.amb[1];
    EXPECT_NEAR(std::sqrt(k / model.rig.rotor.mass_kg) / two_pi, printed[i][0], tolerance_hz);
    EXPECT_NEAR(arm * std::sqrt(k / model.rig.rotor.transverse_inertia_kg_m2) / two_pi, printed[i][1],
                tolerance_hz);
  }
}

TEST(DatasetModes, theTwoKindsAreNotMixedUp) {
  EXPECT_TRUE(isModesDataset(tableFolder()));
  EXPECT_FALSE(isModesDataset(dataFolder() + "/dataset_tiny"));
  EXPECT_EQ(faultsOf([] { readDataset(tableFolder()); }).size(), 1u);
  EXPECT_FALSE(faultsOf([] { readModesDataset(dataFolder() + "/dataset_tiny"); }).empty());
}

TEST(DatasetModes, tellsAllFaultsAtOnce) {
  const fs::path folder =
      fs::path(testing::TempDir()) / ("amb_rotor_dataset_modes_" + std::to_string(::getpid()));
  fs::remove_all(folder);
  fs::create_directories(folder);
  fs::copy(tableFolder(), folder, fs::copy_options::recursive);
  const std::string file = (folder / "dataset.yaml").string();
  const std::string text = readTextFile(file);
  const auto faults = [&] { return faultsOf([&] { readModesDataset(folder.string()); }); };

  std::string spoilt = replaced(text, "conditions: [amb.stiffness_N_per_m]", "conditions: [amb.stiffness]");
  spoilt = replaced(spoilt, "count: 2 ", "count: 2.5 ");
  spoilt = replaced(spoilt, "id: gains_held_out", "id: gains_fit");
  spoilt = replaced(spoilt, "kind: modes, use: validate", "kind: chirp, use: validate");
  writeTextFile(file, spoilt);
  for (const char* key : {"modes.conditions.0", "modes.count", "runs.1.id", "runs.1.kind"})
    faultOf(faults(), key);
  EXPECT_EQ(faults().size(), 4u) << joined(faults());

  writeTextFile(file, text);
  const std::string header =
      "amb.stiffness_N_per_m,frequency_1_hz,frequency_1_std_hz,frequency_2_hz,frequency_2_std_hz,speed_hz\n";
  writeTextFile((folder / "runs/gains_fit.csv").string(), header + "-1,80,1,70,1,0\n1,80,0,90,1,-1\n");
  writeTextFile((folder / "runs/gains_held_out.csv").string(), "frequency_1_hz,color\n1,2\n");
  const auto found = faults();
  EXPECT_EQ(faultOf(found, "frequency_2_hz").line, 2);
  EXPECT_EQ(faultOf(found, "speed_hz").line, 3);
  faultOf(found, "color");
  EXPECT_EQ(found.size(), 4u + 4u + 1u) << joined(found);  // cells, missing columns, unknown column
  fs::remove_all(folder);
}

}  // namespace
}  // namespace amb_rotor
