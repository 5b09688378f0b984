// Effects of the auxiliary bearing: misalignment, Hertz, mount, Stribeck friction, ring. Every test asserts
// contact.
#include <gtest/gtest.h>

#include "../support/probe.hpp"
#include "amb_rotor/machine/event_stepper.hpp"

namespace amb_rotor {
namespace {

using namespace testing_support;

constexpr double bearing_clearance = 0.2e-3, contact_stiffness = 3.38e7;

/// A mass that is pressed into its auxiliary bearings by a force along -y with no magnetic bearing, at rest.
Model pressed(double force, double damping = 3000.0) {
  Model model = springMass(0.0, 0.0);
  model.rig.auxiliary_bearing.damping_N_s_per_m = damping;
  return with(model, "static_load", {0.0, -force});
}

Simulation settled(const Model& model, double y0, double hz = 0.0, double duration = 0.3) {
  return simulate(model, from(constantSpeed(hz, duration, 1000.0), {0.0, y0}, {}));
}

TEST(EffectMisalignment, ContactAboutTheShiftedCentre) {
  const double ox = 3e-5, oy = -5e-5, force = 400.0;
  const Model model = with(pressed(force), "auxiliary_bearing_misalignment", {ox, oy, ox, oy});
  // pushed down at x = ox there is no side force: y = oy - bearing_clearance - F/(2 k)
  const auto run = simulate(model, from(constantSpeed(0.0, 0.3, 1000.0), {ox, oy - bearing_clearance}, {}));
  ASSERT_FALSE(run.trajectory.contacts.empty());
  EXPECT_NEAR(run.trajectory.aux_position_m[0].back(), ox, 1e-12);
  EXPECT_NEAR(run.trajectory.aux_position_m[1].back(),
              oy - bearing_clearance - force / (2 * contact_stiffness), 1e-11);
  EXPECT_NEAR(run.trajectory.normal_force_N[0].back(), 0.5 * force, 1e-4);
  // touch-down of a fall from the stator's centre happens at the shifted floor
  const auto fall =
      settled(with(pressed(3.36 * 9.81), "auxiliary_bearing_misalignment", {0.0, oy, 0.0, oy}), 0.0);
  ASSERT_FALSE(fall.trajectory.contacts.empty());
  EXPECT_NEAR(fall.trajectory.contacts[0].from_s, std::sqrt(2.0 * (bearing_clearance - oy) / 9.81), 1e-9);
}

TEST(EffectMisalignment, EachEndHasItsOwn) {
  Probe probe(with(springBeam(), "auxiliary_bearing_misalignment", {1e-5, 2e-5, -3e-5, 4e-5}));
  probe.look();
  EXPECT_NEAR(probe.seen.contact[0].centre.x, 1e-5, 1e-18);
  EXPECT_NEAR(probe.seen.contact[0].centre.y, 2e-5, 1e-18);
  EXPECT_NEAR(probe.seen.contact[1].centre.x, -3e-5, 1e-18);
  EXPECT_NEAR(probe.seen.contact[1].centre.y, 4e-5, 1e-18);
}

TEST(EffectHertz, StaticPenetration) {
  const double force = 400.0, stiffness = 2.4e9;
  const Model model = with(pressed(force), "hertzian_contact", {stiffness, 2.0});
  const auto run = settled(model, -bearing_clearance - 1e-6, 0.0, 1.0);
  ASSERT_FALSE(run.trajectory.contacts.empty());
  EXPECT_NEAR(run.trajectory.penetration_m[0].back(), std::pow(0.5 * force / stiffness, 2.0 / 3.0), 1e-9);
}

TEST(EffectHertz, RestitutionOfHuntAndCrossley) {
  // m v dv/dd = -K d^1.5 (1 + l v): from touch to lift-off  l v - ln(1 + l v) is equal at v_in and at -v_out
  for (double l : {0.0, 0.2, 2.0}) {
    const double v_in = 0.3;
    Model model = with(springMass(0.0, 0.0), "hertzian_contact", {2.4e9, l});
    const auto run = simulate(model, from(constantSpeed(0.0, 0.0018, 1e5), {0.0, -1.9e-4}, {0.0, -v_in}));
    ASSERT_EQ(run.trajectory.contacts.size(), 2u) << "one impact, both ends, " << l;
    const double v_out = run.final_state.mechanics[3];
    if (l == 0.0) {
      EXPECT_NEAR(v_out, v_in, 1e-7);
      continue;
    }
    const auto g = [&](double v) { return l * v - std::log1p(l * v); };
    double low = 0.0, high = v_in;
    for (int pass = 0; pass < 100; ++pass) {
      const double middle = 0.5 * (low + high);
      (g(-middle) < g(v_in) ? low : high) = middle;
    }
    EXPECT_NEAR(v_out, low, 1e-6 * v_in) << l;
    EXPECT_LT(v_out, v_in);
  }
}

TEST(EffectHertz, DurationOfAnUndampedImpact) {
  // N = K d^1.5: d_max = (5 m v^2/(4 K))^(2/5), T = 2 d_max/v times the integral of (1 - x^2.5)^(-1/2) over
  // 0..1, which is 1.4716375 (Hertz: T = 2.943275 d_max/v); both ends carry together, K = 2 * 2.4e9
  const double v = 0.3, k = 2 * 2.4e9, deepest = std::pow(5 * 3.36 * v * v / (4 * k), 0.4);
  const auto run = simulate(with(springMass(0.0, 0.0), "hertzian_contact", {2.4e9, 0.0}),
                            from(constantSpeed(0.0, 0.0018, 1e6), {0.0, -1.9e-4}, {0.0, -v}));
  ASSERT_GE(run.trajectory.contacts.size(), 1u);
  const auto& span = run.trajectory.contacts.front();
  EXPECT_NEAR(span.to_s - span.from_s, 2.943275 * deepest / v, 1e-5 * deepest / v);
  const auto& depth = run.trajectory.penetration_m[0];
  EXPECT_NEAR(*std::max_element(depth.begin(), depth.end()), deepest, 1e-4 * deepest);
}

TEST(EffectCompliantMount, SeriesStiffness) {
  const double force = 400.0, k2 = 5e6;
  const Model model = with(pressed(force), "compliant_mount", {k2, 2000.0, 0.07});
  const auto run = settled(model, -bearing_clearance, 0.0, 1.0);
  ASSERT_FALSE(run.trajectory.contacts.empty());
  const double one = 0.5 * force;
  EXPECT_NEAR(run.trajectory.aux_centre_m[1].back(), -one / k2, 1e-9);
  EXPECT_NEAR(run.trajectory.aux_position_m[1].back(),
              -bearing_clearance - one * (1 / k2 + 1 / contact_stiffness), 1e-9);
}

TEST(EffectCompliantMount, FreeRingRingsAtItsOwnFrequency) {
  // displaced by hand: m b'' = -k b - d b'
  Probe probe(with(springMass(), "compliant_mount", {5e6, 300.0, 0.07}));
  probe.y[4] = 1e-5, probe.y[7] = 0.2;
  probe.look();
  EXPECT_NEAR(probe.rate[6], -5e6 * 1e-5 / 0.07, 1e-9);
  EXPECT_NEAR(probe.rate[7], -300.0 * 0.2 / 0.07, 1e-9);
  EXPECT_NEAR(probe.rate[5], 0.2, 1e-15);
  // a misaligned mount rests where its bearing stands
  Model model = with(springMass(), "compliant_mount", {5e6, 300.0, 0.07});
  Probe shifted(with(model, "auxiliary_bearing_misalignment", {1e-5, 2e-5, 0.0, 0.0}));
  shifted.look();
  EXPECT_NEAR(shifted.y[4], 1e-5, 1e-18);
  for (int i = 4; i < 12; ++i) EXPECT_NEAR(shifted.rate[i], 0.0, 1e-9);
}

TEST(EffectFriction, StribeckCurve) {
  const double rest = 0.3, sliding = 0.08, vs = 1.5;
  const Model model = with(springMass(), "velocity_dependent_friction", {rest, sliding, vs});
  for (double speed : {-400.0, -50.0, 5.0, 80.0, 900.0}) {
    Probe probe(model);
    probe.y[0] = bearing_clearance + 1e-5;
    probe.turning(speed).look();
    const auto& c = probe.seen.contact[0];
    ASSERT_GT(c.normal_force, 300.0);
    const double v = 0.012 * speed, mu = sliding + (rest - sliding) * std::exp(-std::fabs(v) / vs);
    EXPECT_NEAR(c.friction_coefficient, mu, 1e-14);
    EXPECT_NEAR(c.friction_force, -mu * c.normal_force * std::tanh(v / 0.01), 1e-9);
    // on the +x side a positive spin carries the surface upwards: friction pushes the rotor down
    EXPECT_LT(c.force.y * speed, 0.0);
  }
}

TEST(EffectInnerRing, SpinsUpWithTheFrictionsTorqueUntilSlidingStops) {
  const double force = 40.0, mu = 0.1, inertia = 1e-4, drag = 0.004, arm = 0.012 + bearing_clearance,
               hz = 30.0;
  const Model model = with(pressed(force), "inner_ring_spin", {inertia, drag});
  const auto run = settled(model, -bearing_clearance - 0.5 * force / contact_stiffness, hz, 2.0);
  ASSERT_FALSE(run.trajectory.contacts.empty());
  const auto& t = run.trajectory;
  // while it slides, J w' = arm mu N - T tanh(w), N the force on the ring; integrated over the recorded N
  double expected = 0.0;
  std::size_t last = 0;
  for (std::size_t i = 1; i < t.time_s.size() && t.slip_m_s[0][i] > 0.2; ++i) {
    const double n = 0.5 * (t.normal_force_N[0][i] + t.normal_force_N[0][i - 1]);
    expected += 1e-3 * (arm * mu * n - drag * std::tanh(expected)) / inertia;
    last = i;
  }
  ASSERT_GT(last, 20u);
  EXPECT_NEAR(t.ring_speed_rad_s[0][last], expected, 0.02 * expected) << "trapezium of records of 1 ms";
  // at the end the surfaces run together but for the slip that carries the drag
  EXPECT_LT(std::fabs(t.slip_m_s[0].back()), 0.02);
  EXPECT_NEAR(t.ring_speed_rad_s[0].back(), 0.012 * radPerSecond(hz) / arm, 5.0);
}

TEST(EffectInnerRing, DragStopsARingThatTurnsFreely) {
  Probe probe(with(springMass(), "inner_ring_spin", {1e-5, 0.005}));
  probe.y[4] = 100.0, probe.y[5] = -0.5;
  probe.look();
  EXPECT_NEAR(probe.rate[4], -0.005 / 1e-5, 1e-9);
  EXPECT_NEAR(probe.rate[5], 0.005 * std::tanh(0.5) / 1e-5, 1e-9);
}

TEST(ContactGeometry, BouncingMassOfTheMachineAgainstTheClosedForm) {
  // free fall, then a half wave about the loaded rest of both ends' springs: first two touch-downs and
  // lift-offs
  Model model = springMass(0.0, 0.0);
  model.rig.gravity_m_s2 = 9.81;
  model.rig.auxiliary_bearing.damping_N_s_per_m = 0.0;
  const auto run = simulate(model, from(constantSpeed(0.0, 0.2, 1000.0), {0.0, 0.0}, {}));
  const double fall = std::sqrt(2 * bearing_clearance / 9.81), v = 9.81 * fall,
               w = std::sqrt(2 * contact_stiffness / 3.36);
  const double contact = 2 / w * (pi - std::atan(v * w / 9.81)), period = 2 * fall + contact;
  const auto& spans = run.trajectory.contacts;
  ASSERT_GE(spans.size(), 20u);
  for (std::size_t i = 0; i < spans.size(); ++i) {
    // ends touch together: spans come in pairs
    const double start = fall + (i / 2) * period;
    // 1e-8 of a step, 15 bounces of some 20 steps: a time that drifts by 3e-9 a bounce
    EXPECT_NEAR(spans[i].from_s, start, 6e-8) << i;
    if (i + 2 < spans.size()) {
      EXPECT_NEAR(spans[i].to_s, start + contact, 6e-8) << i;
    }
  }
  const double energy = 0.5 * 3.36 * v * v;
  const auto& y = run.final_state.mechanics;
  const double depth = std::max(0.0, -y[1] - bearing_clearance);
  EXPECT_NEAR(
      0.5 * 3.36 * y[3] * y[3] + 3.36 * 9.81 * (y[1] + bearing_clearance) + contact_stiffness * depth * depth,
      energy, 1e-6 * energy);
}

}  // namespace
}  // namespace amb_rotor
