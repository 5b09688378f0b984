// Set-valued friction: stick without creep, its located beginning and end, and dry whirl on both sides of
// rolling. Every test asserts contact.
#include <gtest/gtest.h>

#include <complex>

#include "../support/models.hpp"
#include "amb_rotor/machine/lane_stepper.hpp"

namespace amb_rotor {
namespace {

using namespace testing_support;
using Complex = std::complex<double>;

constexpr double bearing_clearance = 0.2e-3, contact_stiffness = 3.38e7, shaft_radius = 0.012,
                 rotor_mass = 3.36;

Model setValued(Model model) {
  model.friction_law = FrictionLaw::set_valued;
  return model;
}

/// A mass pressed down into its auxiliary bearings, free of the magnetic ones, and pulled sideways.
Model pressed(double down, double sideways, double friction) {
  Model model = springMass(0.0, 0.0);
  model.rig.auxiliary_bearing.damping_N_s_per_m = 3000.0;
  model.rig.auxiliary_bearing.friction_coefficient = friction;
  return with(model, "static_load", {sideways, -down});
}

double seat(double down) { return -bearing_clearance - down / (2.0 * contact_stiffness); }

TEST(ContactStick, BelowTheFrictionsLimitNothingMoves) {
  const double down = 400.0, mu = 0.2;
  const Model model = pressed(down, 0.5 * mu * down, mu);
  const Scenario scenario = from(constantSpeed(0.0, 0.2, 1000.0), {0.0, seat(down)}, {});
  const auto stuck = simulate(setValued(model), scenario);
  ASSERT_EQ(stuck.outcome.status, RunStatus::ok) << stuck.outcome.reason;
  ASSERT_GT(stuck.trajectory.normal_force_N[0].back(), 0.0);
  // sideways force over both ends; the tangential speed that the integrator lets pass is 1e-10 m/s
  EXPECT_NEAR(stuck.trajectory.friction_force_N[0].back(), -0.25 * mu * down, 1e-4);
  EXPECT_LT(std::fabs(stuck.final_state.mechanics[0]), 1e-10);
  EXPECT_EQ(stuck.final_state.sliding[0], 0);
  // the regularised law creeps until the wall's slope carries the force: x = bearing_clearance * 0.1
  const auto crept = simulate(model, scenario);
  EXPECT_GT(crept.final_state.mechanics[0], 1e-5);
}

TEST(ContactStick, APushThatBeginsLaterIsHeldAndRecorded) {
  // x'' = 0: friction is minus the push, half of it at each end, in the record of the instant, too
  const double down = 400.0, push = 40.0;
  Scenario scenario = from(constantSpeed(0.0, 0.05, 1000.0), {0.0, seat(down)}, {});
  Excitation force;
  force.waveform = Waveform::step;
  force.amplitude = push;
  force.start_s = 0.01;
  scenario.excitations.push_back(force);
  const auto run = simulate(setValued(pressed(down, 0.0, 0.2)), scenario);
  ASSERT_EQ(run.outcome.status, RunStatus::ok) << run.outcome.reason;
  ASSERT_GT(run.trajectory.normal_force_N[0].back(), 0.0);
  EXPECT_LT(std::fabs(run.final_state.mechanics[0]), 1e-10);
  EXPECT_NEAR(run.trajectory.friction_force_N[0].front(), 0.0, 1e-4);
  EXPECT_NEAR(run.trajectory.friction_force_N[0].back(), -0.5 * push, 1e-4);
}

TEST(ContactStick, AboveTheLimitItSlides) {
  const double down = 400.0, mu = 0.2;
  const auto run = simulate(setValued(pressed(down, 1.5 * mu * down, mu)),
                            from(constantSpeed(0.0, 2e-3, 1e5), {0.0, seat(down)}, {}));
  ASSERT_EQ(run.outcome.status, RunStatus::ok) << run.outcome.reason;
  const auto& t = run.trajectory;
  ASSERT_GT(t.normal_force_N[0].back(), 0.0);
  EXPECT_NEAR(t.friction_force_N[0][100], -mu * t.normal_force_N[0][100], 1e-9 * down);
  // x'' = a - w^2 x, a = (1.5 - 1) mu F/m, w^2 = F/(m rho): x = a/w^2 (1 - cos w t), after 1 ms; N rises by m
  // v^2/rho, 0.6 % of F, which is 2 % of the net force
  const double a = 0.5 * mu * down / rotor_mass, w = std::sqrt(down / (rotor_mass * -seat(down)));
  EXPECT_NEAR(t.aux_position_m[0][100], a / (w * w) * (1.0 - std::cos(w * 1e-3)), 0.02 * 6e-6);
}

TEST(ContactStick, SlidingComesToRestWhenTheClosedFormSays) {
  // at the bottom of the bearing, rho = bearing_clearance + depth: rho f'' = -(F/m) sin f -+ mu N/m. For
  // small f
  //   x'' = -w^2 x - a, w^2 = F/(m rho), a = mu F/m:  at rest at t = atan(v0 w/a)/w
  const double down = 400.0, mu = 0.2, v0 = 0.01;
  const auto run = simulate(setValued(pressed(down, 0.0, mu)),
                            from(constantSpeed(0.0, 1e-3, 1e6), {0.0, seat(down)}, {v0, 0.0}));
  ASSERT_EQ(run.outcome.status, RunStatus::ok) << run.outcome.reason;
  const auto& t = run.trajectory;
  ASSERT_GT(t.slip_m_s[0].front(), 0.9 * v0) << "it must slide first; t = (1, 0) at the bottom";
  std::size_t i = 0;
  while (i < t.time_s.size() && std::fabs(t.slip_m_s[0][i]) > 1e-6) ++i;
  ASSERT_LT(i, t.time_s.size()) << "it must come to rest";
  const double w = std::sqrt(down / (rotor_mass * -seat(down))), a = mu * down / rotor_mass;
  // recorded every 1e-6 s; the normal force rises by m v^2/rho, 0.4 % of F, as it slides
  EXPECT_NEAR(t.time_s[i], std::atan(v0 * w / a) / w, 2e-6 + 0.003 * v0 / a);
  // and stays: x/rho = 1 % of slope is less than mu. Along the normal, which leans by as much, the depth
  // recovers the 2e-8 m of m v^2/rho
  EXPECT_EQ(run.final_state.sliding[0], 0);
  EXPECT_EQ(run.final_state.sliding[1], 0);
  EXPECT_NEAR(t.aux_position_m[0].back(), t.aux_position_m[0][i], 4e-10);
}

// ---- dry whirl of a mass in two auxiliary bearings on compliant mounts, no magnetic bearing, no gravity
constexpr double mount_stiffness = 2e6, mount_damping = 150.0, mount_mass = 0.07;

Model whirling(double friction) {
  Model model = springMass(0.0, 0.0);
  model.rig.auxiliary_bearing.damping_N_s_per_m = 3000.0;
  model.rig.auxiliary_bearing.friction_coefficient = friction;
  return with(model, "compliant_mount", {mount_stiffness, mount_damping, mount_mass});
}

/// Circular whirl z = r exp(i w t), w < 0, with the friction ratio f = F/N along t = i n: half the mass at
/// each end,
///   z = N (1 + i f) 2/(m w^2), b = N (1 + i f)/K2, K2 = k2 - m2 w^2 + i w d2, n = (z - b)/|z - b| = 1
/// so that 2/(m w^2) - 1/K2 times 1 + i f is real.
Complex flexibility(double w) {
  return 2.0 / (rotor_mass * w * w) - 1.0 / Complex(mount_stiffness - mount_mass * w * w, w * mount_damping);
}
double frictionRatio(double w) { return -flexibility(w).imag() / flexibility(w).real(); }
/// Distance of the centres at a whirl: the clearance and the penetration N/kc.
double distance(double w) {
  const double per_force = (Complex(1.0, frictionRatio(w)) * flexibility(w)).real();
  return bearing_clearance / (1.0 - 1.0 / (contact_stiffness * per_force));
}

struct Whirled {
  double rate, slip, ratio, distance;
};

Whirled whirl(const Model& model, double hz, double start_rate) {
  const auto run = simulate(model, from(constantSpeed(hz, 0.5, 5000.0), {bearing_clearance + 5e-6, 0.0},
                                        {0.0, start_rate * bearing_clearance}));
  EXPECT_EQ(run.outcome.status, RunStatus::ok) << run.outcome.reason;
  const auto& t = run.trajectory;
  double turned = 0.0, last = 0.0, seconds = 0.0;
  Whirled out{0.0, 0.0, 0.0, 0.0};
  for (std::size_t i = 2000; i < t.time_s.size(); ++i) {
    const double x = t.aux_position_m[0][i] - t.aux_centre_m[0][i],
                 y = t.aux_position_m[1][i] - t.aux_centre_m[1][i];
    const double angle = std::atan2(y, x);
    if (i > 2000) turned += std::remainder(angle - last, 2 * pi), seconds += t.time_s[i] - t.time_s[i - 1];
    last = angle;
    EXPECT_GT(t.normal_force_N[0][i], 0.0) << "contact must last";
    out.slip = std::max(out.slip, std::fabs(t.slip_m_s[0][i]));
    out.ratio = t.friction_force_N[0][i] / t.normal_force_N[0][i];
    out.distance = std::hypot(x, y);
  }
  out.rate = turned / seconds;
  return out;
}

TEST(ContactStick, DryWhirlRollsAtLowSpin) {
  const double hz = 1.0, mu = 0.15, spin = radPerSecond(hz);
  const Whirled w = whirl(setValued(whirling(mu)), hz, -350.0);
  // rolling: R W = -w (distance of the centres), which is the clearance and a penetration of some nm
  EXPECT_NEAR(w.rate, -shaft_radius * spin / w.distance, 1e-5 * std::fabs(w.rate));
  EXPECT_NEAR(w.rate, -shaft_radius * spin / bearing_clearance, 1e-2 * std::fabs(w.rate)) << "-R W/Cs";
  EXPECT_LT(w.slip, 1e-6) << "sticks";
  // the friction that rolling needs, from the closed form of the circular motion; below mu
  EXPECT_NEAR(std::fabs(w.ratio), std::fabs(frictionRatio(w.rate)), 1e-3 * mu);
  EXPECT_LT(std::fabs(w.ratio), mu);
  EXPECT_NEAR(w.distance, distance(w.rate), 1e-4 * bearing_clearance);
}

TEST(ContactStick, DryWhirlSlipsAndLocksAtHighSpin) {
  const double mu = 0.15;
  // where the friction ratio of the circular motion is mu
  double low = -100.0, high = -1080.0;
  for (int pass = 0; pass < 100; ++pass) {
    const double middle = 0.5 * (low + high);
    (std::fabs(frictionRatio(middle)) < mu ? low : high) = middle;
  }
  const double lock = low, coupled = std::sqrt(2.0 * mount_stiffness / rotor_mass);
  // near the frequency of the rotor on its mounts (1091 rad/s), below it by what damps
  ASSERT_GT(-lock, 0.8 * coupled);
  ASSERT_LT(-lock, coupled);
  for (double hz : {20.0, 40.0}) {
    const Whirled w = whirl(setValued(whirling(mu)), hz, -900.0);
    EXPECT_NEAR(w.rate, lock, 1e-4 * coupled) << "the same whatever the spin, " << hz;
    EXPECT_NEAR(std::fabs(w.ratio), mu, 1e-6);
    EXPECT_NEAR(w.slip, shaft_radius * radPerSecond(hz) + w.rate * w.distance, 1e-3)
        << "slides with the spin";
    EXPECT_GT(w.slip, 0.5);
    EXPECT_LT(std::fabs(w.rate), 0.7 * shaft_radius * radPerSecond(hz) / bearing_clearance)
        << "far from rolling";
  }
}

TEST(ContactStick, FrictionAndSlipObeyTheLawThroughADrop) {
  // at every record of a drop of a tilting rotor with a ring: |F| <= mu N, and F = -+ mu N wherever it slides
  Model model = springBeam(2e5, 150.0);
  model.rig.gravity_m_s2 = 9.81;
  model.rig.rotor.polar_inertia_kg_m2 = 0.001;
  model.rig.auxiliary_bearing.damping_N_s_per_m = 2000.0;
  const double mu = model.rig.auxiliary_bearing.friction_coefficient = 0.2;
  model = with(with(model, "inner_ring_spin", {1e-4, 0.001}), "auxiliary_bearing_misalignment",
               {1e-5, 0.0, -2e-5, 1e-5});
  Scenario scenario = bearingsOff(constantSpeed(10.0, 0.4, 1e4), 0.01);
  scenario.speed.type = SpeedType::free;
  const auto run = simulate(setValued(model), scenario);
  ASSERT_EQ(run.outcome.status, RunStatus::ok) << run.outcome.reason;
  const auto& t = run.trajectory;
  int sticking = 0, sliding = 0;
  for (int end = 0; end < 2; ++end)
    for (std::size_t i = 0; i < t.time_s.size(); ++i) {
      const double n = t.normal_force_N[end][i], f = t.friction_force_N[end][i], v = t.slip_m_s[end][i];
      if (n <= 0.0) continue;
      // the guard of the limit is located to the integrator's tolerance
      EXPECT_LE(std::fabs(f), mu * n * (1.0 + 1e-6) + 1e-4) << t.time_s[i];
      if (std::fabs(v) > 1e-6) {
        ++sliding;
        EXPECT_NEAR(f, v > 0.0 ? -mu * n : mu * n, 1e-9 * (1.0 + n)) << t.time_s[i];
      } else {
        ++sticking;
      }
    }
  EXPECT_GT(sticking, 50);
  EXPECT_GT(sliding, 50);
}

TEST(ContactStick, LanesRefuseItByName) {
  const Model model = setValued(springMass());
  const Machine<double> machine({&model});
  try {
    const LaneStepper<double> stepper(machine, 1e-5, 1e-5);
    FAIL() << "lanes have no stick";
  } catch (const InputError& error) {
    EXPECT_EQ(error.faults().front().key, "rig.auxiliary_bearing.friction_law");
  }
}

}  // namespace
}  // namespace amb_rotor
