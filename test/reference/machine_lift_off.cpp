// A rotor that lies in its auxiliary bearings at rest and is lifted off: where it lies, what current it takes, where it
// ends. A vertical rotor, which no weight brings down.
#include <gtest/gtest.h>

#include "../support/models.hpp"

namespace amb_rotor {
namespace {

using namespace testing_support;

constexpr double weight = 3.36 * 9.81, lift_clearance = 0.2e-3, seat_stiffness = 3.38e7;
constexpr double seat_height = -lift_clearance - 0.5 * weight / seat_stiffness;  // each end carries half of the weight
constexpr double power_s = 0.05;

Model lying() {
  Model model = levitated();
  model.rig.gravity_m_s2 = 9.81;
  model.rig.auxiliary_bearing.damping_N_s_per_m = 3000.0;
  return model;
}

/// Lies for 50 ms with the power off, then it is switched on.
Simulation switchedOn(const Model& model, double duration) {
  Scenario scenario = bearingsOff(from(constantSpeed(0.0, duration), {0.0, seat_height, 0.0, 0.0}, {}), 0.0);
  scenario.faults.back().duration_s = power_s;
  return simulate(model, scenario);
}

TEST(MachineLiftOff, LiesStillUntilThePowerComesAndEndsAtTheSagOfItsStiffness) {
  const Model model = lying();
  const auto run = switchedOn(model, 0.6);
  ASSERT_EQ(run.outcome.status, RunStatus::ok) << run.outcome.reason;
  const auto& t = run.trajectory;
  const std::size_t power = static_cast<std::size_t>(power_s * 1e4);
  for (std::size_t i = 0; i < power; ++i) {
    ASSERT_NEAR(t.aux_position_m[1][i], seat_height, 1e-12) << t.time_s[i];
    ASSERT_NEAR(t.normal_force_N[0][i], 0.5 * weight, 1e-4);
    ASSERT_EQ(t.bearing_force_N[1][i], 0.0);
  }
  ASSERT_EQ(t.contacts.size(), 2u) << "both ends touched from the start and left once";
  for (const auto& span : t.contacts) {
    EXPECT_EQ(span.from_s, 0.0);
    EXPECT_GT(span.to_s, power_s);
    EXPECT_LT(span.to_s, power_s + 0.01);
  }
  // behind it: -m g/(2 (Ki kp - Ks)), the damped motion is over
  EXPECT_NEAR(t.position_m[1].back(), -0.5 * weight / netStiffness(model), 1e-9);
  EXPECT_NEAR(t.position_m[3].back(), -0.5 * weight / netStiffness(model), 1e-9);
}

TEST(MachineLiftOff, AnIntegratorBringsItToTheCentre) {
  Model model = lying();
  model.rig.controller.ki_A_per_m_s = 2e5;
  const auto run = switchedOn(model, 2.0);
  ASSERT_EQ(run.outcome.status, RunStatus::ok);
  EXPECT_LT(run.trajectory.contacts.back().to_s, 0.2);
  EXPECT_NEAR(run.trajectory.position_m[1].back(), 0.0, 1e-3 * lift_clearance);
}

TEST(MachineLiftOff, TakesTheCurrentOfWeightAndPullOffCentre) {
  // where it lies a bearing has to bear half of the weight and Ks times the height: Ki i = m g/2 - Ks seat_height
  const Model model = lying();
  const auto& amb = model.rig.amb;
  const double needed =
      (0.5 * weight - amb.displacement_stiffness_N_per_m * seat_height) / amb.current_stiffness_N_per_A;
  ASSERT_GT(needed, 1.0);
  ASSERT_GT(-model.rig.controller.kp_A_per_m * seat_height, 1.1 * needed) << "the controller asks for more";
  for (const double share : {0.98, 1.02}) {
    Model limited = model;
    limited.rig.amb.max_current_A = amb.bias_current_A + share * needed;  // a coil's: bias and control current
    const auto run = switchedOn(limited, 0.6);
    ASSERT_EQ(run.outcome.status, RunStatus::ok);
    const double end = run.trajectory.aux_position_m[1].back();
    if (share < 1.0) {
      EXPECT_LT(end, -lift_clearance) << "stays where it lies";
      EXPECT_NEAR(run.trajectory.normal_force_N[0].back(), 0.02 * needed * amb.current_stiffness_N_per_A, 1e-3 * weight);
    } else {
      EXPECT_NEAR(run.trajectory.position_m[1].back(), -0.5 * weight / netStiffness(model), 1e-9);
    }
  }
}

TEST(MachineLiftOff, AVerticalRotorFliesOnUntilItTouches) {
  // no weight across the shaft: after the power has failed it keeps its velocity
  Model model = springBeam(0.0, 0.0);
  model.rig.gravity_m_s2 = 0.0;
  const double vx = 0.003, vy = -0.004;
  const auto run = simulate(model, from(constantSpeed(0.0, 0.06, 1000.0), {0.0, 0.0, 0.0, 0.0}, {vx, vy, 0.0, 0.0}));
  ASSERT_FALSE(run.trajectory.contacts.empty());
  EXPECT_NEAR(run.trajectory.contacts[0].from_s, lift_clearance / std::hypot(vx, vy), 1e-9);
  const auto& t = run.trajectory;
  for (std::size_t i = 0; t.time_s[i] < run.trajectory.contacts[0].from_s; ++i) {
    ASSERT_NEAR(t.aux_position_m[0][i], vx * t.time_s[i], 1e-12);
    ASSERT_NEAR(t.aux_position_m[1][i], vy * t.time_s[i], 1e-12);
  }
}

}  // namespace
}  // namespace amb_rotor
