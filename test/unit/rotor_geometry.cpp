#include "amb_rotor/rotor/rotor_geometry.hpp"

#include <gtest/gtest.h>

#include <cstdio>
#include <fstream>
#include <set>
#include <string>

namespace amb_rotor {
namespace {

class RotorGeometryFile : public ::testing::Test {
 protected:
  std::string path_ = ::testing::TempDir() + "rotor_" +
                      ::testing::UnitTest::GetInstance()->current_test_info()->name() + ".yaml";

  ~RotorGeometryFile() override { std::remove(path_.c_str()); }

  void write(const std::string& text) { std::ofstream(path_) << text; }

  std::vector<Fault> faults(const std::string& text) {
    write(text);
    try {
      loadRotorGeometry(path_);
    } catch (const InputError& error) {
      return error.faults();
    }
    return {};
  }
};

const char kGood[] =
    "format: amb-rotor-geometry/1\n"
    "name: a shaft\n"
    "theory: euler_bernoulli\n"
    "max_element_length_m: 0.01\n"
    "materials:\n"
    "  steel: {density_kg_per_m3: 7850, youngs_modulus_Pa: 206e9, poisson_ratio: 0.3}\n"
    "  stack: {density_kg_per_m3: 7650, youngs_modulus_Pa: 0, poisson_ratio: 0.3}\n"
    "sections:\n"
    "  - {length_m: 0.1, outer_diameter_m: 0.02, material: steel}\n"
    "  - {length_m: 0.2, outer_diameter_m: 0.03, outer_diameter_end_m: 0.02, inner_diameter_m: 0.005, "
    "material: steel}\n"
    "rings:\n"
    "  - {from_m: 0.02, to_m: 0.05, inner_diameter_m: 0.02, outer_diameter_m: 0.04, material: stack}\n"
    "discs:\n"
    "  - {at_m: 0.1, mass_kg: 0.5, polar_inertia_kg_m2: 1e-4, transverse_inertia_kg_m2: 6e-5}\n"
    "damping: {stiffness_proportional_s: 1e-7, modal_ratios: [0.001, 0.002]}\n";

TEST_F(RotorGeometryFile, ReadsAllThatIsWritten) {
  write(kGood);
  const RotorGeometry geometry = loadRotorGeometry(path_);
  EXPECT_EQ(geometry.name, "a shaft");
  EXPECT_EQ(geometry.theory, BeamTheory::euler_bernoulli);
  ASSERT_EQ(geometry.sections.size(), 2u);
  EXPECT_EQ(geometry.sections[0].outer_diameter_right, 0.02);
  EXPECT_EQ(geometry.sections[1].outer_diameter_right, 0.02);
  EXPECT_EQ(geometry.sections[1].inner_diameter_right, 0.005);
  EXPECT_EQ(geometry.sections[1].material.youngs_modulus, 206e9);
  ASSERT_EQ(geometry.rings.size(), 1u);
  EXPECT_EQ(geometry.rings[0].material.density, 7650.0);
  ASSERT_EQ(geometry.discs.size(), 1u);
  EXPECT_EQ(geometry.discs[0].mass, 0.5);
  EXPECT_EQ(geometry.damping.modal_ratios.size(), 2u);
  EXPECT_DOUBLE_EQ(geometry.length(), 0.3);
}

TEST_F(RotorGeometryFile, ReportsAllFaultsAtOnceWithLineAndKey) {
  const std::vector<Fault> found = faults(
      "format: amb-rotor-geometry/1\n"
      "theory: rayleigh\n"
      "max_element_length_m: -0.01\n"
      "colour: red\n"
      "materials:\n"
      "  steel: {density_kg_per_m3: -7850, youngs_modulus_Pa: 206e9, poisson_ratio: 0.3}\n"
      "sections:\n"
      "  - {length_m: 0.1, outer_diameter_m: 0.02, material: brass}\n"
      "  - {length_m: abc, outer_diameter_m: 0.02, inner_diameter_m: 0.03, material: steel}\n"
      "  - {length_m: 0.1, length_m: 0.1, outer_diameter_m: 0.02, material: steel}\n"
      "discs:\n"
      "  - {at_m: -0.9, mass_kg: .nan, polar_inertia_kg_m2: 3e-4, transverse_inertia_kg_m2: 1e-4}\n"
      "  - {at_m: 0.1, mass_kg: 1, polar_inertia_kg_m2: 1e-4}\n");
  std::set<std::string> seen;
  for (const Fault& fault : found) seen.insert(std::to_string(fault.line) + " " + fault.key);
  for (const char* expected :
       {"2 theory", "3 max_element_length_m", "4 colour", "6 materials.steel.density_kg_per_m3",
        "8 sections[0].material", "9 sections[1].length_m", "9 sections[1].inner_diameter_m",
        "10 sections[2].length_m", "12 discs[0].at_m", "12 discs[0].mass_kg",
        "12 discs[0].polar_inertia_kg_m2", "13 discs[1].transverse_inertia_kg_m2"}) {
    EXPECT_EQ(seen.count(expected), 1u) << expected;
  }
  for (const Fault& fault : found) EXPECT_EQ(fault.file, path_);
}

TEST_F(RotorGeometryFile, ReportsNoFaultTwice) {
  std::string text = kGood;
  text.replace(text.find("length_m: 0.1"), 13, "length_m: -1 ");
  const std::vector<Fault> found = faults(text);
  std::set<std::string> keys;
  for (const Fault& fault : found) EXPECT_TRUE(keys.insert(fault.key).second) << fault.text();
  EXPECT_EQ(keys.count("sections[0].length_m"), 1u);
}

TEST_F(RotorGeometryFile, RefusesWhatCannotBeBuilt) {
  const auto changed = [](const std::string& from, const std::string& to) {
    std::string text = kGood;
    text.replace(text.find(from), from.size(), to);
    return text;
  };
  EXPECT_TRUE(faults(kGood).empty());
  EXPECT_FALSE(faults(changed("to_m: 0.05", "to_m: 0.35")).empty()) << "ring beyond the shaft";
  EXPECT_FALSE(faults(changed("inner_diameter_m: 0.02,", "inner_diameter_m: 0.01,")).empty()) << "overlap";
  EXPECT_FALSE(faults(changed("material: steel", "material: stack")).empty()) << "section without modulus";
  EXPECT_FALSE(faults(changed("[0.001, 0.002]", "[0.001, 1.2]")).empty()) << "damping ratio";
  EXPECT_FALSE(faults(changed("max_element_length_m: 0.01", "max_element_length_m: 1e-9")).empty());
  EXPECT_FALSE(faults(changed("amb-rotor-geometry/1", "amb-rotor-geometry/2")).empty());
  EXPECT_FALSE(faults("sections: [1, 2").empty()) << "no YAML";
  EXPECT_THROW(loadRotorGeometry(path_ + ".none"), InputError);
}

}  // namespace
}  // namespace amb_rotor
