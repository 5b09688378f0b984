// Levitated runs against an independent model in discrete time (support/linear_levitation.hpp): sampled PID
// on sensors beside the magnets, any delay, amplifier lag, current limit, step, impulse and chirp of force
// and current.
#include <gtest/gtest.h>

#include "../support/linear_levitation.hpp"
#include "../support/models.hpp"

namespace amb_rotor {
namespace {

using namespace testing_support;

// The machine integrates at 1e-8 of 1e-5 m a step, some 1e3 steps: errors of 1e-11 m (1e-6 of the motion)
// and, through kp and kd (kd (1-a)/T = 1e5 A/m), of 1e-6 A. The matrix exponential is exact to rounding.
constexpr double position_tolerance = 2e-11;
constexpr double current_tolerance = 4e-6;

Excitation excite(Excitation::Kind kind, Waveform form, double amplitude, double start, double duration) {
  Excitation e;
  e.kind = kind;
  e.waveform = form;
  e.amplitude = amplitude;
  e.start_s = start;
  e.duration_s = duration;
  return e;
}

void expectEqual(const Model& model, const Scenario& scenario, double position = position_tolerance,
                 double current = current_tolerance) {
  const Simulation run = simulate(model, scenario);
  ASSERT_EQ(run.outcome.status, RunStatus::ok) << run.outcome.reason;
  ASSERT_TRUE(run.trajectory.contacts.empty()) << "the linear model knows no contact";
  LinearLevitation linear(model, radPerSecond(scenario.speed.start_hz));
  const auto rows = linear.run(scenario);
  ASSERT_EQ(rows.size(), run.trajectory.time_s.size());
  double moved = 0.0;
  for (std::size_t i = 0; i < rows.size(); ++i)
    for (int a = 0; a < 4; ++a) {
      ASSERT_NEAR(run.trajectory.displacement_m[a][i], rows[i].signal[a], position)
          << "axis " << a << " t " << rows[i].time;
      ASSERT_NEAR(run.trajectory.current_A[a][i], rows[i].current[a], current)
          << "axis " << a << " t " << rows[i].time;
      moved = std::max(moved, std::fabs(rows[i].signal[a]));
    }
  EXPECT_GT(moved, 1e-6) << "nothing moved: the test shows nothing";
}

Scenario atRest(double hz, double duration, double rate = 10000.0) {
  return from(constantSpeed(hz, duration, rate), {0.0, 0.0, 0.0, 0.0}, {0.0, 0.0, 0.0, 0.0});
}

TEST(MachineLevitation, FreeMotionForManyDelays) {
  // none, within a sample, a whole one, between, several at once under way
  for (double delay : {0.0, 0.37e-4, 1e-4, 1.63e-4}) {
    Model model = levitated();
    model.rig.controller.delay_s = delay;
    expectEqual(model, from(atRest(0.0, 0.03), {2e-5, -1e-5, 1e-4, 5e-5}, {1e-3, 2e-3, 0.02, -0.03}));
  }
}

TEST(MachineLevitation, RecordsBetweenSamples) {
  Model model = levitated();
  model.rig.controller.delay_s = 0.7e-4;
  expectEqual(model, from(atRest(0.0, 0.02, 7000.0), {2e-5, -1e-5, 1e-4, 5e-5}, {}));
}

TEST(MachineLevitation, IntegratorUnderGravity) {
  Model model = levitated();
  model.rig.controller.ki_A_per_m_s = 2e5;
  model.rig.gravity_m_s2 = 9.81;
  expectEqual(model, atRest(0.0, 0.05));
}

TEST(MachineLevitation, UnbalanceWithGyroscopicMoment) {
  Model model = withUnbalance(withUnbalance(levitated(), 4e-5, 0.7, 0.02), 2e-5, -2.0, -0.09);
  model.rig.rotor.polar_inertia_kg_m2 = 0.012;
  expectEqual(model, atRest(120.0, 0.05));
}

TEST(MachineLevitation, ForceStepAndImpulse) {
  const Model model = levitated();
  Scenario scenario = atRest(0.0, 0.05);
  auto step = excite(Excitation::Kind::force, Waveform::step, 8.0, 0.1 * 0.03, 0.2 * 0.03);
  step.plane_z_m = 0.05;
  step.direction_rad = 0.6;
  scenario.excitations.push_back(step);
  expectEqual(model, scenario);

  scenario = atRest(0.0, 0.05);
  auto impulse = excite(Excitation::Kind::force, Waveform::impulse, 60.0, 0.0123, 0.004);
  impulse.plane_z_m = -0.07;
  impulse.direction_rad = -2.0;
  scenario.excitations.push_back(impulse);
  // the reference holds the half sine over 10 us: relative error (pi h/T)^2/24 = 3e-6 of 2e-4 m
  expectEqual(model, scenario, 2e-9, 2e-4);
}

TEST(MachineLevitation, ForceChirp) {
  const Model model = levitated();
  Scenario scenario = atRest(0.0, 0.08);
  auto chirp = excite(Excitation::Kind::force, Waveform::chirp, 6.0, 0.004, 0.07);
  chirp.start_hz = 20.0;
  chirp.end_hz = 400.0;
  chirp.plane_z_m = 0.04;
  chirp.direction_rad = 1.0;
  scenario.excitations.push_back(chirp);
  // held over 10 us: (w h)^2/24 = 3e-5 of the motion at 400 Hz, which is below 1e-4 m
  expectEqual(model, scenario, 3e-9, 3e-4);
}

TEST(MachineLevitation, CurrentStepWhoseEndIsNotASample) {
  // 0.01 + 0.02 is not 0.03 in floating point: the end must not slip by a sample
  for (const auto& span :
       std::vector<std::pair<double, double>>{{0.01, 0.02}, {0.1 * 0.1, 0.7 * 0.03}, {0.00512, 0.01333}}) {
    const Model model = levitated();
    Scenario scenario = atRest(0.0, 0.045);
    auto step = excite(Excitation::Kind::current, Waveform::step, 0.4, span.first, span.second);
    step.end = 1;
    step.axis = 1;
    scenario.excitations.push_back(step);
    expectEqual(model, scenario);
  }
}

TEST(MachineLevitation, CurrentStepEndsOnItsSample) {
  // every start and duration that a person would write in milliseconds
  const Model model = levitated();
  for (int start = 1; start <= 9; start += 2)
    for (int length = 1; length <= 9; length += 2) {
      Scenario scenario = atRest(0.0, 0.02);
      scenario.excitations.push_back(
          excite(Excitation::Kind::current, Waveform::step, 0.3, start * 1e-3, length / 1000.0));
      expectEqual(model, scenario);
    }
}

TEST(MachineLevitation, CurrentChirpHeldFromInstantToInstant) {
  // delay, samples and records on one grid: the excitation is held over it (10 kHz)
  const Model model = levitated();
  Scenario scenario = atRest(0.0, 0.06);
  auto chirp = excite(Excitation::Kind::current, Waveform::chirp, 0.3, 0.0, 0.06);
  chirp.start_hz = 30.0;
  chirp.end_hz = 300.0;
  scenario.excitations.push_back(chirp);
  expectEqual(model, scenario);
}

TEST(MachineLevitation, CurrentLimit) {
  // 4 A asked of an axis, 2.5 A given: both coils stay within 0 and 5 A
  Model model = levitated();
  model.rig.amb.max_current_A = 4.2;  // the tighter of 2.5 and 1.7
  Scenario scenario = atRest(0.0, 0.004);
  scenario.excitations.push_back(excite(Excitation::Kind::current, Waveform::step, 4.0, 0.0, 0.002));
  expectEqual(model, scenario);
  const Simulation run = simulate(model, scenario);
  EXPECT_LE(largest(run.trajectory.current_A[0]), 1.7);
  EXPECT_GT(largest(run.trajectory.current_A[0]), 1.699);
  // closed form of the approach: 1.7 (1 - exp(-2 pi f t)) while the command stays beyond the limit
  EXPECT_NEAR(run.trajectory.current_A[0][2], 1.7 * (1.0 - std::exp(-two_pi * 2000.0 * 2e-4)), 1e-12);
}

TEST(MachineLevitation, WithoutControlTheNegativeStiffnessGrows) {
  // x = x0 cosh(w t), w^2 = 2 Ks/m; tilting w^2 = Ks (za^2 + zb^2)/It
  Model model = levitated();
  model.rig.controller.kp_A_per_m = 0.0;
  model.rig.controller.kd_A_s_per_m = 0.0;
  const double x0 = 1e-7, tilt0 = 1e-6;
  const auto run = simulate(model, from(atRest(0.0, 0.02), {x0, 0.0, 0.0, tilt0}, {}));
  const double w = std::sqrt(2.0 * 63333.0 / 3.36), wt = std::sqrt(2.0 * 63333.0 * 0.096 * 0.096 / 0.017);
  const auto& t = run.trajectory;
  ASSERT_EQ(run.outcome.status, RunStatus::ok);
  ASSERT_GT(t.time_s.size(), 190u);
  for (std::size_t i = 0; i < t.time_s.size(); ++i) {
    // errors of a step grow with the motion: relative to it
    const double x = x0 * std::cosh(w * t.time_s[i]), r = tilt0 * std::cosh(wt * t.time_s[i]);
    EXPECT_NEAR(0.5 * (t.position_m[0][i] + t.position_m[2][i]), x, 1e-6 * x);
    EXPECT_NEAR((t.position_m[3][i] - t.position_m[1][i]) / 0.236, r, 1e-6 * r);
  }
}

TEST(MachineLevitation, TheSignOfTheNetStiffnessDecides) {
  // Ki kp just above Ks holds (slowly), just below falls to the auxiliary bearing
  for (double share : {0.9, 1.1}) {
    Model model = levitated();
    model.rig.controller.kp_A_per_m = share * 63333.0 / 19.0;
    const auto run = simulate(model, from(atRest(0.0, 1.0, 1000.0), {1e-6, 0.0, 0.0, 0.0}, {}));
    ASSERT_EQ(run.outcome.status, RunStatus::ok);
    EXPECT_EQ(run.trajectory.contacts.empty(), share > 1.0);
  }
}

}  // namespace
}  // namespace amb_rotor
