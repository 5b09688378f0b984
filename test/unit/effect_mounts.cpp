// Mounts of the auxiliary bearing from dimensions, the fractional mount, the tilted bearing; effects that a
// model's structure refuses; runs that diverge by tilting.
#include <gtest/gtest.h>

#include <complex>

#include "../support/probe.hpp"
#include "amb_rotor/effects/fractional_mount.hpp"
#include "amb_rotor/model/model_hash.hpp"
#include "amb_rotor/model/model_reader.hpp"
#include "amb_rotor/model/model_rules.hpp"
#include "amb_rotor/model/model_writer.hpp"
#include "amb_rotor/model/mount_dimensions.hpp"
#include "amb_rotor/model/overrides.hpp"
#include "model_test_support.hpp"

namespace amb_rotor {
namespace {

using namespace testing_support;
using Complex = std::complex<double>;
using model_test::faultOf;
using model_test::faultsOf;
using model_test::replaced;

TEST(MountDimensions, ToleranceRingOfTheThesis) {
  // table 3.2: 12 mm wide, 0.4 mm thick, pitch 5 mm, spring steel; printed to three digits
  const ToleranceRing ring{200e9, 0.012, 0.4e-3, 5e-3, 1.0 / 3.0};
  EXPECT_NEAR(ring.waveStiffness(), 5.90e6, 0.005e6);
  EXPECT_NEAR(ring.stiffness(), 1.97e6, 0.005e6);
}

TEST(MountDimensions, ORingFromLindleysCurve) {
  // the slope of F = E d l (1.25 c^1.5 + 50 c^6) by differences, summed around the ring's circumference
  const ORing ring{5e6, 0.045, 3e-3, 0.15, 2.0};
  const auto force = [&](double c) {  // on a metre of the cord
    return ring.youngs_modulus_Pa * ring.cord_diameter_m * (1.25 * std::pow(c, 1.5) + 50.0 * std::pow(c, 6));
  };
  double sum = 0.0;
  const int parts = 3600;
  const double u = 1e-8;  // 1e-5 of the squeeze: the curve is straight there
  for (int i = 0; i < parts; ++i) {
    const double angle = two_pi * (i + 0.5) / parts,
                 c = ring.squeeze + u * std::cos(angle) / ring.cord_diameter_m;
    sum += force(c) * std::cos(angle) * 0.5 * ring.mean_diameter_m * two_pi / parts;
  }
  EXPECT_NEAR(ring.stiffness(), 2.0 * sum / u, 1e-6 * ring.stiffness())
      << "two cords; round-off of the difference";
}

const char* const by_dimensions =
    "effects:\n  - effect: compliant_mount\n    tolerance_ring: {youngs_modulus_Pa: 2.0e11, width_m: 0.012, "
    "thickness_m: 0.4e-3, wave_pitch_m: 5.0e-3, ring_share: 0.5, loss_factor: 0.1, loss_frequency_hz: "
    "100.0}\n"
    "    mass_kg: 0.07\n";

std::string modelWith(const std::string& effects) {
  Model model = springMass();
  model.name = "mounts";
  return replaced(modelText(model, effectCatalogue()), "effects: []\n", effects);
}

TEST(MountDimensions, FillTheModelFilesCompliantMount) {
  const Model model = parseModel(modelWith(by_dimensions), "m.yaml", effectCatalogue());
  ASSERT_EQ(model.effects.size(), 1u);
  const double k = 0.5 * 4.8 * 2e11 * 0.012 * std::pow(0.08, 3);
  EXPECT_DOUBLE_EQ(model.effects[0].values[0], k);
  // Im K/Re K = w d/k at the stated frequency is the loss factor
  EXPECT_DOUBLE_EQ(two_pi * 100.0 * model.effects[0].values[1] / k, 0.1);
  EXPECT_DOUBLE_EQ(model.effects[0].values[2], 0.07);
  // written as numbers, read back to the same machine
  const Model again = parseModel(modelText(model, effectCatalogue()), "m.yaml", effectCatalogue());
  EXPECT_EQ(modelHash(again, effectCatalogue()), modelHash(model, effectCatalogue()));
}

TEST(MountDimensions, BadOnesAreRefusedByName) {
  const std::string text = modelWith(by_dimensions);
  const auto fault = [&](const std::string& from, const std::string& to, const std::string& key) {
    const auto faults = faultsOf([&] { parseModel(replaced(text, from, to), "m.yaml", effectCatalogue()); });
    faultOf(faults, "effects.0." + key);
  };
  fault("thickness_m: 0.4e-3", "thickness_m: 6.0e-3", "tolerance_ring.thickness_m");
  fault("loss_factor: 0.1", "loss_factor: -0.1", "tolerance_ring.loss_factor");
  fault("width_m: 0.012", "width_m: 0.0", "tolerance_ring.width_m");
  fault("ring_share: 0.5, ", "", "tolerance_ring.ring_share");
  fault("width_m", "with_m", "tolerance_ring.with_m");
  fault("    mass_kg: 0.07\n", "    mass_kg: 0.07\n    parameters: {}\n", "parameters");
}

/// Stiffness of a fractional mount at a frequency by its own state equations: the steady answer of the
/// branches.
Complex measuredStiffness(const std::vector<double>& p, double hz) {
  const effects::FractionalMount::Physics<double> mount(p);
  const int n = mount.stateSize();
  const Complex s(0.0, two_pi * hz);
  // the equations are linear: columns by unit states; the mount's displacement is forced to exp(s t)
  const auto rates = [&](const std::vector<double>& state) {
    std::vector<double> rate(n, 0.0);
    const Vec2<double> force =
        mount.mountRates(0, {0.0, 0.0}, {0.0, 0.0}, {0.0, 0.0}, state.data(), rate.data());
    rate.push_back(force.x);
    return rate;
  };
  std::vector<double> unit(n, 0.0);
  unit[0] = 1.0;
  const auto by_place = rates(unit);
  unit[0] = 0.0, unit[2] = 1.0;
  const auto by_speed = rates(unit);
  Complex force = by_place[n] + s * by_speed[n];
  for (int j = 0; j < effects::FractionalMount::branches; ++j) {
    std::vector<double> branch(n, 0.0);
    branch[8 + j] = 1.0;
    const auto by_branch = rates(branch);
    const Complex z = by_place[8 + j] / (s - by_branch[8 + j]);  // z' = r x - r z
    force += by_branch[n] * z;
  }
  return force;
}

TEST(EffectFractionalMount, StiffnessOverTheBandIsThatOfTheLaw) {
  double worst = 0.0;
  for (double a : {0.1, 0.25, 0.5, 0.75, 0.9})
    for (double time : {1e-5, 1e-3, 0.1})
      for (double hz = 1.0; hz <= 1000.1; hz *= std::pow(10.0, 0.05)) {
        const Complex law = 2e6 * (1.0 + std::pow(Complex(0.0, two_pi * hz * time), a));
        worst = std::max(worst, std::abs(measuredStiffness({2e6, time, a, 0.07}, hz) - law) / std::abs(law));
      }
  EXPECT_LT(worst, 4e-3) << "as the header states";
  EXPECT_GT(worst, 1e-4) << "a fit, not the law itself: the measurement sees the difference";
}

TEST(EffectFractionalMount, CreepsToWhereItsSpringSays) {
  Model model = springMass(0.0, 0.0);
  model.rig.auxiliary_bearing.damping_N_s_per_m = 3000.0;
  const double down = 400.0;
  model = with(model, "static_load", {0.0, -down});
  const auto run = simulate(with(model, "fractional_mount", {2e6, 1e-4, 0.5, 0.07}),
                            from(constantSpeed(0.0, 1.5, 1000.0), {0.0, -0.2e-3}, {}));
  ASSERT_EQ(run.outcome.status, RunStatus::ok) << run.outcome.reason;
  ASSERT_GT(run.trajectory.normal_force_N[0].back(), 0.0);
  // creeps towards F/k: what the slowest branches still hold, a (T/t)^a/Gamma(1 - a) of the spring, is under
  // 1 %
  EXPECT_NEAR(run.trajectory.aux_centre_m[1].back(), -0.5 * down / 2e6, 0.015 * 1e-4);
  EXPECT_GT(run.trajectory.aux_centre_m[1].back(), -0.5 * down / 2e6) << "creep comes from above";
}

TEST(EffectTilt, TheClearanceShrinksInThePlaneOfTheLean) {
  const double slope = 2e-3, width = 0.012, shrink = 0.5 * width * slope;
  const Model model = with(springMass(), "auxiliary_bearing_tilt", {slope, 0.0, 0.0, 0.0, width});
  for (int quarter = 0; quarter < 4; ++quarter) {
    Probe probe(model);
    const double out = 0.2e-3 + 20e-6;
    probe.y[0] = out * std::cos(0.5 * pi * quarter), probe.y[1] = out * std::sin(0.5 * pi * quarter);
    probe.look();
    ASSERT_GT(probe.seen.contact[0].normal_force, 0.0);
    // in x the edge is nearer by w s/2; in y its centre lies aside by as much: sqrt(r^2 + shrink^2)
    const double expected = quarter % 2 == 0 ? out + shrink : std::hypot(out, shrink);
    EXPECT_NEAR(probe.seen.contact[0].penetration, expected - 0.2e-3, 1e-15) << quarter;
    EXPECT_NEAR(probe.seen.contact[1].penetration, 20e-6, 1e-15) << "end B stands straight";
    EXPECT_NEAR(probe.machine.contactGuard(0, probe.y.data()), probe.seen.contact[0].penetration, 1e-9)
        << "guard and force see one geometry";
  }
}

TEST(EffectTilt, PenetrationIsContinuousWhereTheEdgeChanges) {
  const Model model = with(springMass(), "auxiliary_bearing_tilt", {2e-3, 0.0, 0.0, 0.0, 0.012});
  double depth[2];
  for (int side = 0; side < 2; ++side) {
    Probe probe(model);
    probe.y[0] = side == 0 ? -1e-12 : 1e-12, probe.y[1] = 0.22e-3;
    probe.look();
    depth[side] = probe.seen.contact[0].penetration;
    EXPECT_EQ(probe.seen.contact[0].centre.x > 0.0, side == 0) << "the farther edge";
  }
  EXPECT_NEAR(depth[0], depth[1], 1e-12);
}

TEST(ModelStructure, GyroscopicCouplingNeedsARigidBeam) {
  Model model = with(springBeam(), "gyroscopic_coupling", {0.001});
  model.name = "beam";
  EXPECT_TRUE(checkModel(model, effectCatalogue()).empty());
  const auto faults = faultsOf([&] { applyOverride(model, "rotor.model=rigid_mass", effectCatalogue()); });
  EXPECT_NE(faultOf(faults, "effects.gyroscopic_coupling").rule.find("rigid_mass"), std::string::npos);
  model.rotor_model = RotorModel::flexible;
  model.rotor_geometry = "rotor.yaml";
  EXPECT_NE(
      faultOf(checkModel(model, effectCatalogue()), "effects.gyroscopic_coupling").rule.find("flexible"),
      std::string::npos);
}

TEST(ModelStructure, ABendingModeBesideTheRigidOnesNeedsARigidBeam) {
  Model model = with(springBeam(), "shaft_flexibility", typicalValues("shaft_flexibility"));
  model.name = "bending";
  EXPECT_TRUE(checkModel(model, effectCatalogue()).empty());
  const auto faults = faultsOf([&] { applyOverride(model, "rotor.model=rigid_mass", effectCatalogue()); });
  EXPECT_NE(faultOf(faults, "effects.shaft_flexibility").rule.find("rigid_mass"), std::string::npos);
  model.rotor_model = RotorModel::flexible;
  model.rotor_geometry = "rotor.yaml";
  EXPECT_NE(faultOf(checkModel(model, effectCatalogue()), "effects.shaft_flexibility").rule.find("from its geometry"),
            std::string::npos);
}

TEST(ModelStructure, OneMountOnly) {
  const Model model = with(with(springMass(), "compliant_mount", typicalValues("compliant_mount")),
                           "fractional_mount", typicalValues("fractional_mount"));
  faultOf(checkModel(model, effectCatalogue()), "effects.fractional_mount");
}

TEST(ModelStructure, FrictionLawIsReadWrittenAndHashed) {
  Model model = springMass();
  model.name = "stick";
  const std::string plain = modelText(model, effectCatalogue());
  EXPECT_EQ(plain.find("friction_law"), std::string::npos) << "files without the key stay as they are";
  const std::string text =
      replaced(plain, "    mount: rigid", "    friction_law: set_valued\n    mount: rigid");
  const Model read = parseModel(text, "m.yaml", effectCatalogue());
  EXPECT_EQ(read.friction_law, FrictionLaw::set_valued);
  EXPECT_EQ(modelText(read, effectCatalogue()), text);
  EXPECT_NE(modelHash(read, effectCatalogue()), modelHash(model, effectCatalogue()));
  const Model said = parseModel(replaced(text, "set_valued", "regularised"), "m.yaml", effectCatalogue());
  EXPECT_EQ(modelHash(said, effectCatalogue()), modelHash(model, effectCatalogue()));
  faultOf(faultsOf([&] { parseModel(replaced(text, "set_valued", "sticky"), "m.yaml", effectCatalogue()); }),
          "rig.auxiliary_bearing.friction_law");
}

TEST(RunDivergence, AConicalModeThatLeavesTheCentreAtRest) {
  // Sensors near the middle: Ki kp - Ks > 0 holds the translation, Ki kp z_sensor - Ks z_amb < 0 does not
  // hold the tilt.
  Model model = levitated();
  model.rig.planes.sensor[0] = -0.02, model.rig.planes.sensor[1] = 0.02;
  const auto& amb = model.rig.amb;
  const double feedback = amb.current_stiffness_N_per_A * model.rig.controller.kp_A_per_m;
  ASSERT_GT(feedback, amb.displacement_stiffness_N_per_m);
  ASSERT_LT(feedback * 0.02, amb.displacement_stiffness_N_per_m * 0.096);
  model.rig.auxiliary_bearing.stiffness_N_per_m = 1.0;  // nothing in the way, nor a magnet
  model.rig.amb.air_gap_m = 1.0;
  model.rig.auxiliary_bearing.damping_N_s_per_m = 0.0;
  const auto run = simulate(model, from(constantSpeed(0.0, 2.0, 1000.0), {0.0, 0.0, 1e-6, 0.0}, {}));
  double centre = 0.0, end = 0.0;
  const auto& t = run.trajectory;
  for (std::size_t i = 0; i < t.time_s.size(); ++i) {
    centre = std::max(centre, 0.5 * std::fabs(t.position_m[0][i] + t.position_m[2][i]));
    end = std::max(end, std::fabs(t.aux_position_m[0][i]));
  }
  EXPECT_LT(centre, 1e-6 * end) << "the centre of gravity stays: round-off alone moves it";
  EXPECT_EQ(run.outcome.status, RunStatus::diverged);
  EXPECT_LT(run.outcome.time_s, 1.9) << "and the run ends early";
}

}  // namespace
}  // namespace amb_rotor
