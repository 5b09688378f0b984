// Contact and friction of the assembled machine: symmetry, signs, passivity, action and reaction. Each state
// is chosen in contact, and asserted to be.
#include <gtest/gtest.h>

#include <random>

#include "../support/models.hpp"

namespace amb_rotor {
namespace {

using namespace testing_support;

/// A rigid mass with all that a contact can have.
Model everything(bool hertz) {
  Model model = springMass(2.47e6, 100.0);
  if (hertz) model = with(model, "hertzian_contact", {2.4e9, 0.5});
  model = with(model, "compliant_mount", {5e6, 300.0, 0.07});
  model = with(model, "velocity_dependent_friction", {0.3, 0.1, 0.5});
  model = with(model, "inner_ring_spin", {1e-5, 0.002});
  return model;
}

Vec2<double> turned(const Vec2<double>& a, double angle) {
  return {a.x * std::cos(angle) - a.y * std::sin(angle), a.x * std::sin(angle) + a.y * std::cos(angle)};
}

/// State of everything(): rotor, its velocity, mount positions and velocities of both ends, ring speeds.
std::vector<double> stateOf(const Machine<double>& machine, Vec2<double> position, Vec2<double> velocity,
                            Vec2<double> mount, Vec2<double> mount_velocity, double ring, double angle) {
  std::vector<double> y(machine.stateSize(), 0.0);
  const Vec2<double> p = turned(position, angle), v = turned(velocity, angle), b = turned(mount, angle),
                     w = turned(mount_velocity, angle);
  y[0] = p.x, y[1] = p.y, y[2] = v.x, y[3] = v.y;
  for (int end = 0; end < 2; ++end) {
    y[4 + 4 * end] = b.x, y[5 + 4 * end] = b.y, y[6 + 4 * end] = w.x, y[7 + 4 * end] = w.y;
    y[12 + end] = ring;
  }
  return y;
}

class Contacts : public ::testing::TestWithParam<bool> {};

TEST_P(Contacts, ForceAndRatesTurnWithTheFrame) {
  const Model model = everything(GetParam());
  const Machine<double> machine({&model});
  ASSERT_EQ(machine.stateSize(), 14);
  Inputs<double> in;
  in.shaft = Shaft<double>::at(0.0, 300.0, 0.0);
  Observation<double> reference;
  std::vector<double> rate0(14), rate(14);
  const auto state = [&](double angle) {
    return stateOf(machine, {2.5e-4, 0.4e-4}, {0.03, 0.2}, {0.2e-4, -0.1e-4}, {0.01, 0.02}, 70.0, angle);
  };
  machine.observe(in, state(0.0).data(), rate0.data(), reference);
  ASSERT_GT(reference.contact[0].normal_force, 100.0);
  for (int step = 1; step < 64; ++step) {
    const double angle = two_pi * step / 64;
    Observation<double> seen;
    machine.observe(in, state(angle).data(), rate.data(), seen);
    const Vec2<double> expected = turned(reference.contact[1].force, angle);
    const double size = reference.contact[1].normal_force;
    // rounding only: positions of 1e-4 m with a stiffness of 1e7 N/m
    EXPECT_NEAR(seen.contact[1].force.x, expected.x, 1e-11 * size);
    EXPECT_NEAR(seen.contact[1].force.y, expected.y, 1e-11 * size);
    for (int i : {2, 6, 10}) {  // accelerations of rotor and mounts
      const Vec2<double> a = turned({rate0[i], rate0[i + 1]}, angle);
      EXPECT_NEAR(rate[i], a.x, 1e-10 * std::hypot(a.x, a.y));
      EXPECT_NEAR(rate[i + 1], a.y, 1e-10 * std::hypot(a.x, a.y));
    }
    EXPECT_NEAR(rate[12], rate0[12], 1e-10 * std::fabs(rate0[12]));
  }
}

TEST_P(Contacts, FrictionIsAtRightAnglesAndNeverDrives) {
  const Model model = everything(GetParam());
  const Machine<double> machine({&model});
  std::mt19937 random(7);
  std::uniform_real_distribution<double> unit(-1.0, 1.0);
  int touching = 0;
  for (int trial = 0; trial < 2000; ++trial) {
    Inputs<double> in;
    in.shaft = Shaft<double>::at(0.0, 400.0 * unit(random), 0.0);
    const Vec2<double> r = turned({2.2e-4 + 0.3e-4 * unit(random), 0.0}, pi * unit(random));
    const auto y = stateOf(machine, r, {0.5 * unit(random), 0.5 * unit(random)}, {1e-5 * unit(random), 0.0},
                           {0.1 * unit(random), 0.1 * unit(random)}, 300.0 * unit(random), 0.0);
    Observation<double> seen;
    machine.observe(in, y.data(), nullptr, seen);
    const auto& c = seen.contact[0];
    ASSERT_GE(c.normal_force, 0.0) << "never pulls";
    if (c.penetration <= 0.0) {
      ASSERT_EQ(c.force.x, 0.0);
      ASSERT_EQ(c.force.y, 0.0);
      continue;
    }
    if (c.normal_force == 0.0) continue;
    ++touching;
    const Vec2<double> tangent = {-c.normal.y, c.normal.x};
    const double scale = c.normal_force;
    // the force is N along -n and the friction along t, nothing else
    ASSERT_NEAR(c.force.dot(c.normal), -c.normal_force, 1e-12 * scale);
    ASSERT_NEAR(c.force.dot(tangent), c.friction_force, 1e-12 * scale);
    // sliding speed of the surfaces, written out again
    const Vec2<double> relative = {y[2] - y[6], y[3] - y[7]};
    // the rotor's surface is its radius and the distance of the centres from the ring's centre
    const double arm = 0.012 + 0.2e-3 + c.penetration;
    const double slip = 0.012 * in.shaft.speed + tangent.dot(relative) - arm * y[12];
    ASSERT_NEAR(c.slip, slip, 1e-12 * (1.0 + std::fabs(slip)));
    const double mu = 0.1 + 0.2 * std::exp(-std::fabs(slip) / 0.5);
    ASSERT_NEAR(c.friction_force, -mu * c.normal_force * std::tanh(slip / 0.01), 1e-10 * scale);
    ASSERT_LE(c.friction_force * c.slip, 0.0) << "friction takes power";
  }
  EXPECT_GT(touching, 500);
}

TEST_P(Contacts, DampingActsOnTheNormalVelocityOnly) {
  const Model model = everything(GetParam());
  const Machine<double> machine({&model});
  Inputs<double> in;
  const auto normal = [&](double radial, double tangential, double angle) {
    const auto y = stateOf(machine, {2.3e-4, 0.0}, {radial, tangential}, {}, {}, 0.0, angle);
    Observation<double> seen;
    machine.observe(in, y.data(), nullptr, seen);
    EXPECT_GT(seen.contact[0].penetration, 2.9e-5);
    return seen.contact[0].normal_force;
  };
  const double d = 0.3e-4, rest = GetParam() ? 2.4e9 * d * std::sqrt(d) : 3.38e7 * d;
  for (double angle : {0.0, 0.7, 2.0, -2.5}) {
    const double tolerance = 1e-9 * rest;  // d is a difference of numbers ten times larger
    EXPECT_NEAR(normal(0.0, 0.0, angle), rest, tolerance);
    EXPECT_NEAR(normal(0.0, 5.0, angle), rest, tolerance) << "tangential velocity makes no normal force";
    EXPECT_NEAR(normal(0.1, -3.0, angle), GetParam() ? rest * 1.05 : rest + 30.0, tolerance);
    EXPECT_NEAR(normal(-0.1, 3.0, angle), GetParam() ? rest * 0.95 : rest - 30.0, tolerance);
    EXPECT_EQ(normal(-10.0, 0.0, angle), 0.0) << "cut off, not pulling";
  }
}

INSTANTIATE_TEST_SUITE_P(ContactProperty, Contacts, ::testing::Values(false, true),
                         [](const auto& info) { return info.param ? "Hertz" : "Linear"; });

TEST(ContactProperty, ActionIsReactionAcrossMountAndFoundation) {
  // rotor, two mounts, foundation: momentum changes only by gravity and load on the rotor and the foundation's own
  // spring, not by what stands between rotor and stator
  Model model = everything(false);
  model.rig.gravity_m_s2 = 9.81;
  const double mass = 30.0, hz = 50.0, ratio = 0.03, w = radPerSecond(hz);
  model = with(model, "foundation_resonance", {mass, hz, ratio});
  model = with(model, "motor_magnetic_pull", {3e5, 0.0});
  model = with(model, "cross_coupled_stiffness", {2e5, 100.0, 1.0, 0.0});
  model = with(model, "internal_damping", {300.0, 0.0});
  const double load[2] = {30.0, -20.0};
  model = with(model, "static_load", {load[0], load[1]});
  const Machine<double> machine({&model});
  std::mt19937 random(3);
  std::uniform_real_distribution<double> unit(-1.0, 1.0);
  const int n = machine.stateSize();
  ASSERT_EQ(n, 18);
  // the effects' states follow the order in which they act: foundation, mount, ring
  const int stator = 4, mount = 8;
  int touching = 0;
  for (int trial = 0; trial < 200; ++trial) {
    std::vector<double> y(n), rate(n);
    for (int i : {0, 1}) y[i] = 3e-4 * unit(random);
    for (int i = 2; i < 4; ++i) y[i] = 0.3 * unit(random);
    for (int i : {stator, stator + 1, mount, mount + 1, mount + 4, mount + 5}) y[i] = 2e-5 * unit(random);
    for (int i : {stator + 2, stator + 3, mount + 2, mount + 3, mount + 6, mount + 7})
      y[i] = 0.1 * unit(random);
    Inputs<double> in;
    in.shaft = Shaft<double>::at(0.0, 300.0, 0.0);
    Observation<double> seen;
    machine.observe(in, y.data(), rate.data(), seen);
    touching += seen.contact[0].normal_force > 0.0;
    for (int axis = 0; axis < 2; ++axis) {
      const double gained = 3.36 * rate[2 + axis] + 0.07 * (rate[mount + 2 + axis] + rate[mount + 6 + axis]) +
                            mass * rate[stator + 2 + axis];
      const double outside = load[axis] + (axis == 1 ? -3.36 * 9.81 : 0.0) - mass * w * w * y[stator + axis] -
                             2.0 * ratio * w * mass * y[stator + 2 + axis];
      const double scale = 2.47e6 * 3e-4 + 3.38e7 * 1e-4;
      ASSERT_NEAR(gained, outside, 1e-11 * scale);
    }
  }
  EXPECT_GT(touching, 50);
}

}  // namespace
}  // namespace amb_rotor
