// Magnets from their dimensions: slopes, the thesis's numbers, the machine's own force, faults by name.
#include <gtest/gtest.h>

#include "../support/probe.hpp"
#include "amb_rotor/model/magnet_dimensions.hpp"
#include "amb_rotor/model/model_hash.hpp"
#include "amb_rotor/model/model_reader.hpp"
#include "amb_rotor/model/model_writer.hpp"
#include "model_test_support.hpp"

namespace amb_rotor {
namespace {

using namespace testing_support;
using model_test::faultOf;
using model_test::faultsOf;
using model_test::replaced;

constexpr double mu0 = 4e-7 * pi;
const MagnetDimensions table_4_1{170.0, 225e-6, 22.5 * pi / 180.0};

TEST(MagnetDimensions, PullIsTheSlopeOfTheMagneticEnergy) {
  // W = L i^2/2, L = mu0 N^2 A/(2 g): a gap that opens by dx on the field's energy at constant current, F = -dW/dg
  const MagnetDimensions straight{350.0, 0.0016, 0.0};
  for (const double i : {1.0, 2.0})
    for (const double g : {0.2e-3, 0.5e-3}) {
      const auto energy = [&](double gap) { return 0.5 * i * i * mu0 * 350.0 * 350.0 * 0.0016 / (2.0 * gap); };
      const double h = 1e-4 * g;  // central differences: relative error 1e-8
      EXPECT_NEAR(straight.pull(i, g), -(energy(g + h) - energy(g - h)) / (2.0 * h), 1e-7 * straight.pull(i, g));
      // flux of a coil over its area: L i/(N A)
      EXPECT_NEAR(straight.fluxDensity(i, g), mu0 * 350.0 * i / (2.0 * g), 1e-12);
    }
  EXPECT_NEAR(straight.pull(2.0, 0.2e-3), 6157.5, 0.05) << "the corner of figure 3.9";
}

TEST(MagnetDimensions, StiffnessesAreTheSlopesOfTheForce) {
  const double i0 = 1.42, s0 = 0.75e-3, di = 1e-4, dx = 1e-7;  // 1e-4 of the scales: errors of 1e-8
  const double ki = (table_4_1.force(i0, s0, di, 0.0) - table_4_1.force(i0, s0, -di, 0.0)) / (2.0 * di);
  const double ks = (table_4_1.force(i0, s0, 0.0, dx) - table_4_1.force(i0, s0, 0.0, -dx)) / (2.0 * dx);
  EXPECT_NEAR(table_4_1.currentStiffness(i0, s0), ki, 1e-6 * ki);
  EXPECT_NEAR(table_4_1.displacementStiffness(i0, s0), ks, 1e-6 * ks);
  // a pole's share along the axis
  MagnetDimensions straight = table_4_1;
  straight.force_angle_rad = 0.0;
  EXPECT_NEAR(table_4_1.pull(1.0, s0) / straight.pull(1.0, s0), std::cos(pi / 8.0), 1e-12);
}

TEST(MagnetDimensions, NoBiasGivesBothStiffnessesOfTable41) {
  // printed to three digits, bias to two decimals: 0.5 %
  EXPECT_NEAR(table_4_1.currentStiffness(1.42, 0.75e-3), 19.0, 0.005 * 19.0);
  EXPECT_NEAR(table_4_1.displacementStiffness(1.49, 0.75e-3), 39.7e3, 0.005 * 39.7e3);
  EXPECT_GT(std::fabs(table_4_1.displacementStiffness(1.42, 0.75e-3) - 39.7e3), 0.05 * 39.7e3);
}

/// The text of a levitated model whose bearing is described by its magnets.
std::string byMagnets(const char* block = "magnet: {windings: 170.0, pole_area_m2: 2.25e-4, force_angle_rad: 0.3927}") {
  Model model = levitated();
  model.name = "magnets";
  model.rig.amb.bias_current_A = 1.42;
  std::string text = modelText(model, effectCatalogue());
  text = replaced(text, "current_stiffness_N_per_A: 19.0", block);
  const auto drop = [&](const std::string& key) {
    const std::size_t from = text.find(key);
    std::size_t to = text.find_first_of(",\n", from);
    if (text[to] == ',') to += 1;
    text.erase(from, to - from);
  };
  drop("displacement_stiffness_N_per_m: 63333.0");
  drop("bias_flux_density_T: 0.45");
  return text;
}

TEST(MagnetDimensions, FillTheModelFile) {
  const Model model = parseModel(byMagnets(), "m.yaml", effectCatalogue());
  const MagnetDimensions magnet{170.0, 2.25e-4, 0.3927};
  const auto& amb = model.rig.amb;
  EXPECT_DOUBLE_EQ(amb.current_stiffness_N_per_A, magnet.currentStiffness(1.42, 0.75e-3));
  EXPECT_DOUBLE_EQ(amb.displacement_stiffness_N_per_m, magnet.displacementStiffness(1.42, 0.75e-3));
  EXPECT_DOUBLE_EQ(amb.bias_flux_density_T, magnet.fluxDensity(1.42, 0.75e-3));
  // written as numbers, read back to the same machine
  const Model again = parseModel(modelText(model, effectCatalogue()), "m.yaml", effectCatalogue());
  EXPECT_EQ(modelHash(again, effectCatalogue()), modelHash(model, effectCatalogue()));
  // and the force of the machine with its gap law is that of the magnets (3.18), far from the centre too
  Probe probe(with(model, "magnetic_nonlinearity", {1.42, 0.75e-3}));
  for (const double i : {-0.9, 0.4, 1.2})
    for (const double x : {-2e-4, 1e-4}) {
      probe.beam({x, 0.0, 0.0, 0.0});
      probe.in.force_current[0] = {i, 0.0};
      probe.look();
      EXPECT_NEAR(probe.seen.bearing_force[0].x, magnet.force(1.42, 0.75e-3, i, x), 1e-9);
    }
}

TEST(MagnetDimensions, BadOnesAreRefusedByName) {
  const auto fault = [&](const char* block, const std::string& key) {
    const auto faults = faultsOf([&] { parseModel(byMagnets(block), "m.yaml", effectCatalogue()); });
    EXPECT_EQ(faults.size(), 1u) << key;
    faultOf(faults, "rig.amb." + key);
  };
  fault("magnet: {windings: 0.0, pole_area_m2: 2.25e-4, force_angle_rad: 0.3927}", "magnet.windings");
  fault("magnet: {windings: 170.0, pole_area_m2: -2.25e-4, force_angle_rad: 0.3927}", "magnet.pole_area_m2");
  fault("magnet: {windings: 170.0, pole_area_m2: 2.25e-4, force_angle_rad: 22.5}", "magnet.force_angle_rad");
  fault("magnet: {windings: 170.0, pole_area_m2: 2.25e-4}", "magnet.force_angle_rad");
  fault("magnet: {windings: 170.0, pole_area_m2: 2.25e-4, force_angle_rad: 0.3927}\n    current_stiffness_N_per_A: 19.0",
        "current_stiffness_N_per_A");
}

}  // namespace
}  // namespace amb_rotor
