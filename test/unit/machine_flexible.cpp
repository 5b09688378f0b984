// A flexible rotor in the machine: its modes are those of the finite elements, its slow motion that of a rigid beam.
#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <sstream>

#include "amb_rotor/common/linear_algebra.hpp"
#include "amb_rotor/common/units.hpp"
#include "amb_rotor/effects/catalogue.hpp"
#include "amb_rotor/machine/assembly.hpp"
#include "amb_rotor/machine/machine.hpp"
#include "amb_rotor/machine/model_loading.hpp"
#include "amb_rotor/model/overrides.hpp"
#include "amb_rotor/model/yaml_document.hpp"
#include "amb_rotor/rotor/flexible_rotor.hpp"
#include "amb_rotor/rotor/reduction.hpp"
#include "amb_rotor/rotor/rotor_geometry.hpp"

namespace amb_rotor {
namespace {

const std::string geometry = std::string(AMB_ROTOR_SOURCE_DIR) + "/config/thesis/rotor.yaml";
constexpr double stiffness = 5.96e5, arm = 0.096;

Model supported() {
  Model model;
  model.rotor_model = RotorModel::flexible;
  model.amb_model = AmbModel::equivalent;
  model.rotor_geometry = geometry;
  model.rig.rotor.mass_kg = 3.36;
  model.rig.rotor.transverse_inertia_kg_m2 = 0.017;
  model.rig.amb.stiffness_N_per_m = stiffness;
  model.rig.planes.amb[0] = -arm;
  model.rig.planes.amb[1] = arm;
  model.rig.planes.sensor[0] = model.rig.planes.aux[0] = -0.12;
  model.rig.planes.sensor[1] = model.rig.planes.aux[1] = 0.12;
  model.rig.auxiliary_bearing.clearance_m = 3e-4;
  model.rig.auxiliary_bearing.stiffness_N_per_m = 3e7;
  return model;
}

/// Natural frequencies [Hz] of one plane from the machine's own derivatives, rising.
std::vector<double> machineFrequencies(const Model& model) {
  const Machine<double> machine({&model});
  const int n = machine.rotor().modes(), size = machine.stateSize();
  Eigen::MatrixXd k(n, n);
  std::vector<double> state(size, 0.0), rate(size, 0.0);
  const Inputs<double> in;
  for (int j = 0; j < n; ++j) {
    std::fill(state.begin(), state.end(), 0.0);
    state[j] = 1e-9;  // linear: no contact
    machine.derivatives(in, state.data(), rate.data());
    for (int i = 0; i < n; ++i) k(i, j) = -rate[2 * n + i] / 1e-9;
  }
  const Eigen::VectorXcd squares = generalEigenvalues(k);
  std::vector<double> out;
  for (const auto& s : squares) out.push_back(std::sqrt(std::max(0.0, s.real())) / two_pi);
  std::sort(out.begin(), out.end());
  return out;
}

/// Deflection at a plane under a force of 1 N there, the rotor on its bearings, from the machine's own derivatives [m].
double staticDeflection(const Model& model, int plane) {
  const Machine<double> machine({&model});
  const int n = machine.rotor().modes();
  std::vector<double> state(machine.stateSize(), 0.0), rate(machine.stateSize(), 0.0);
  Eigen::MatrixXd k(n, n);
  const Inputs<double> in;
  for (int j = 0; j < n; ++j) {
    std::fill(state.begin(), state.end(), 0.0);
    state[j] = 1e-9;
    machine.derivatives(in, state.data(), rate.data());
    for (int i = 0; i < n; ++i) k(i, j) = -rate[2 * n + i] / 1e-9;
  }
  Eigen::VectorXd force(n), shape(n);
  for (int i = 0; i < n; ++i) {
    shape[i] = machine.rotor().shape(plane, i);
    force[i] = shape[i] / machine.rotor().mass(i);
  }
  return shape.dot(solveFullPivoting(k, force));
}

TEST(FlexibleMachineTest, KeepsWhatTheModelFileAsksFor) {
  Model full = supported();
  fillFlexibleModes(full, 1e6);  // all there is room for
  Model modal = supported();
  modal.reduction = {RotorReduction::Method::modal, 5};
  fillFlexibleModes(modal);
  ASSERT_EQ(modal.flexible.mass.size(), 5u);
  Model held = supported();
  held.reduction = {RotorReduction::Method::craig_bampton, 2};
  fillFlexibleModes(held);
  ASSERT_EQ(held.flexible.mass.size(), 6u);  // four planes (sensors and auxiliary bearings share theirs), two modes

  Model balanced = supported();
  balanced.reduction = {RotorReduction::Method::balanced, 6};
  fillFlexibleModes(balanced);
  ASSERT_EQ(balanced.flexible.mass.size(), 6u);

  // the lowest three frequencies on the bearings come from above (Rayleigh), by what the modes left out would yield:
  // 1.2 % at most here
  const auto exact = machineFrequencies(full), few = machineFrequencies(modal), planes = machineFrequencies(held),
             seen = machineFrequencies(balanced);
  for (int k = 0; k < 3; ++k) {
    EXPECT_NEAR(few[k] / exact[k], 1.0, 0.02) << k;
    EXPECT_NEAR(planes[k] / exact[k], 1.0, 0.02) << k;
    EXPECT_NEAR(seen[k] / exact[k], 1.0, 0.02) << k;
    EXPECT_GE(few[k], exact[k] * (1.0 - 1e-6));
    EXPECT_GE(planes[k], exact[k] * (1.0 - 1e-6));
    EXPECT_GE(seen[k], exact[k] * (1.0 - 1e-6));
  }
  // a static force at a kept plane: exact with Craig-Bampton but for the round-off of the stiff modes, not with three
  // bending modes
  for (const int plane : {0, 2, 4}) {
    const double right = staticDeflection(full, plane);
    EXPECT_NEAR(staticDeflection(held, plane) / right, 1.0, 1e-10) << plane;
  }
  // at the bearings equilibrium alone decides; outside them the shaft bends
  const double right = staticDeflection(full, 2), off = std::fabs(staticDeflection(modal, 2) / right - 1.0);
  EXPECT_GT(off, 10.0 * std::fabs(staticDeflection(held, 2) / right - 1.0));
  EXPECT_GT(off, 1e-5);
}

TEST(FlexibleMachineTest, ModesAreThoseOfTheFiniteElements) {
  Model model = supported();
  fillFlexibleModes(model, 1e5);
  const FlexibleRotor rotor(loadRotorGeometry(geometry));
  const auto expected = planarFrequencies(rotor, {{-arm, stiffness}, {arm, stiffness}});
  const auto own = machineFrequencies(model);
  ASSERT_GE(own.size(), 4u);
  // the modes above 100 kHz that are left out move the low ones by less than 1e-5
  for (int k = 0; k < 3; ++k) EXPECT_NEAR(own[k] / (expected[k] / two_pi), 1.0, 1e-5) << k;
}

TEST(FlexibleMachineTest, ShapesAreThoseOfTheFiniteElementsAtEveryPlace) {
  // places at nodes, near them and between them, the ends of the shaft among them
  constexpr double highest_hz = 1e5;
  constexpr int places = 211;  // of no common measure with the elements
  constexpr double round_off = 1e-10;  // of a shape of size 1 with some hundred terms
  const FlexibleRotor rotor(loadRotorGeometry(geometry));
  const ReducedRotor all = allModes(rotor);
  for (const auto& reduction : {RotorReduction{}, RotorReduction{RotorReduction::Method::craig_bampton, 4}}) {
    const bool modal = reduction.method == RotorReduction::Method::by_frequency;
    const ReducedRotor kept = modal ? all : reduceCraigBampton(rotor, keptPlanes(supported()), reduction.modes);
    Model model = supported();
    model.reduction = reduction;
    fillFlexibleModes(model, highest_hz);
    double furthest = 0.0, fault = 0.0;
    for (int i = 0; i <= places; ++i) {
      const double z = rotor.left() + (rotor.right() - rotor.left()) * i / places;
      model.rig.planes.aux[1] = z;
      const Machine<double> machine({&model});
      const int n = machine.rotor().modes();
      ASSERT_GT(n, 6);
      const Eigen::VectorXd expected = kept.shape(z);
      for (int k = 0; k < n; ++k) {
        const double size = std::sqrt(machine.rotor().mass(k)), own = machine.rotor().shape(plane_aux + 1, k);
        fault = std::max(fault, std::fabs(own - size * expected[k]));
        furthest = std::max(furthest, std::fabs(own));
      }
    }
    EXPECT_LT(fault, round_off * furthest) << static_cast<int>(reduction.method);
  }
}

TEST(FlexibleMachineTest, FirstTwoCoordinatesAreThoseOfARigidBeam) {
  Model model = supported();
  fillFlexibleModes(model);
  EXPECT_NEAR(model.flexible.mass[0], 3.36, 0.0336);
  EXPECT_NEAR(model.flexible.mass[1], 0.017, 0.00017);
  const std::size_t n = model.flexible.mass.size();
  for (std::size_t i = 0; i < model.flexible.z_m.size(); i += 50) {
    EXPECT_NEAR(model.flexible.shape[i * n], 1.0, 1e-9);
    EXPECT_NEAR(model.flexible.shape[i * n + 1], model.flexible.z_m[i], 1e-9);
  }
}

TEST(FlexibleMachineTest, DampingInProportionToTheMassBrakesRigidMotionsToo) {
  const auto folder = std::filesystem::temp_directory_path() / ("amb_rotor_flexible_" + std::to_string(::getpid()));
  std::filesystem::create_directories(folder);
  std::stringstream text;
  text << std::ifstream(geometry).rdbuf();
  std::string shaft = text.str();
  const std::string key = "modal_ratios: [0.002]";
  ASSERT_NE(shaft.find(key), std::string::npos);
  shaft.replace(shaft.find(key), key.size(), "mass_proportional_per_s: 7.0");
  std::ofstream(folder / "rotor.yaml") << shaft;
  Model model = supported();
  model.rotor_geometry = (folder / "rotor.yaml").string();
  fillFlexibleModes(model);
  for (std::size_t k = 0; k < model.flexible.mass.size(); ++k)
    EXPECT_NEAR(model.flexible.damping[k] / model.flexible.mass[k], 7.0, 1e-6) << k;
  std::filesystem::remove_all(folder);
}

TEST(FlexibleMachineTest, WhatActsBesideTheShaftIsRefused) {
  const auto refused = [](Model model, const std::string& word) {
    try {
      fillFlexibleModes(model);
    } catch (const InputError& error) {
      EXPECT_NE(std::string(error.what()).find(word), std::string::npos) << error.what();
      return true;
    }
    return false;
  };
  Model model = supported();
  EXPECT_FALSE(refused(model, ""));
  model.rig.planes.aux[0] = -0.3;
  EXPECT_TRUE(refused(model, "rig.planes.aux.a"));
  model = supported();
  model.rig.unbalance.push_back({0.9, 1e-5, 0.0});
  EXPECT_TRUE(refused(model, "rig.unbalance.0.plane_z_m"));
  model = supported();
  model.effects.push_back({"internal_damping", {10.0, 0.5}});
  EXPECT_TRUE(refused(model, "effects.internal_damping.z_m"));
  model = supported();
  model.rig.rotor.transverse_inertia_kg_m2 = 0.1;
  EXPECT_TRUE(refused(model, "rig.rotor.transverse_inertia_kg_m2"));
  model = supported();  // one body has one polar inertia: that of its gyroscopic matrix, also where it spins freely
  model.rig.rotor.polar_inertia_kg_m2 = 0.02;
  EXPECT_TRUE(refused(model, "rig.rotor.polar_inertia_kg_m2"));
}

/// A model file of the thesis's flexible rotor with other words in it, read; its faults.
std::vector<Fault> faultsOfFile(const std::vector<std::pair<std::string, std::string>>& changes, std::string& text) {
  const std::string thesis = std::string(AMB_ROTOR_SOURCE_DIR) + "/config/thesis/";
  text = readTextFile(thesis + "flexible_model.yaml");
  for (const auto& [from, to] : changes) {
    EXPECT_NE(text.find(from), std::string::npos) << from;
    text.replace(text.find(from), from.size(), to);
  }
  const auto folder = std::filesystem::temp_directory_path() / ("amb_rotor_shaft_" + std::to_string(::getpid()));
  std::filesystem::create_directories(folder);
  std::filesystem::copy_file(thesis + "rotor.yaml", folder / "rotor.yaml", std::filesystem::copy_options::overwrite_existing);
  const std::string path = (folder / "model.yaml").string();
  std::ofstream(path) << text;
  std::vector<Fault> faults;
  try {
    loadModel(path);
  } catch (const InputError& error) {
    faults = error.faults();
  }
  std::filesystem::remove_all(folder);
  for (const Fault& fault : faults) EXPECT_EQ(fault.file, path) << fault.text();
  return faults;
}

int lineIn(const std::string& text, const std::string& word) {
  const auto end = text.begin() + static_cast<std::ptrdiff_t>(text.find(word));
  return 1 + static_cast<int>(std::count(text.begin(), end, '\n'));
}

TEST(FlexibleMachineTest, WhatContradictsTheShaftIsToldWithFileAndLine) {
  std::string text;
  EXPECT_TRUE(faultsOfFile({}, text).empty());
  const auto faults = faultsOfFile({{"b: 0.140}", "b: 0.30}"},
                                    {"plane_z_m: 0.0,", "plane_z_m: -900e-3,"},
                                    {"mass_kg: 3.36 ", "mass_kg: 3.50 "},
                                    {"effects: []", "effects:\n  - {effect: internal_damping, parameters: {damping_N_s_per_m: 1, z_m: 0.5}}"}},
                                   text);
  const std::vector<std::array<std::string, 3>> expected = {{"rig.rotor.mass_kg", "3.50", "mass_kg: 3.50"},
                                                            {"rig.planes.aux.b", "0.30", "b: 0.30"},
                                                            {"rig.unbalance.0.plane_z_m", "-900e-3", "plane_z_m: -900e-3"},
                                                            {"effects.internal_damping.z_m", "0.5", "z_m: 0.5"}};
  ASSERT_EQ(faults.size(), expected.size());
  for (std::size_t i = 0; i < expected.size(); ++i) {
    EXPECT_EQ(faults[i].key, expected[i][0]);
    EXPECT_EQ(faults[i].value, expected[i][1]) << "as it is written";
    EXPECT_EQ(faults[i].line, lineIn(text, expected[i][2])) << faults[i].text();
  }
}

TEST(FlexibleMachineTest, AReductionThatDoesNotFitIsToldWithFileAndLine) {
  std::string text;
  const auto faults = faultsOfFile({{"geometry: rotor.yaml}", "geometry: rotor.yaml, reduction: {method: craig_bampton, modes: 64}}"}}, text);
  ASSERT_EQ(faults.size(), 1u);
  EXPECT_EQ(faults[0].key, "rotor.reduction.modes");
  EXPECT_EQ(faults[0].line, lineIn(text, "modes: 64"));
}

TEST(FlexibleMachineTest, AnOverrideCannotContradictTheGeometryEither) {
  Model model = supported();
  model.rig.auxiliary_bearing.rotor_radius_m = 0.01;
  fillFlexibleModes(model);
  EXPECT_NO_THROW(applyOverride(model, "rig.rotor.mass_kg=3.37", effectCatalogue()));
  EXPECT_THROW(applyOverride(model, "rig.rotor.mass_kg=4", effectCatalogue()), InputError);
  EXPECT_THROW(applyOverride(model, "rig.planes.sensor.b=0.5", effectCatalogue()), InputError);
}

TEST(FlexibleMachineTest, AMassThatContradictsTheGeometryIsRefused) {
  Model model = supported();
  model.rig.rotor.mass_kg = 5.0;
  EXPECT_THROW(fillFlexibleModes(model), InputError);
}

}  // namespace
}  // namespace amb_rotor
