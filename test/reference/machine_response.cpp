// Whole runs against closed forms: unbalance response (thesis 5.8 corrected), run-up, speed laws, power
// failures.
#include <gtest/gtest.h>

#include <complex>

#include "../support/models.hpp"
#include "amb_rotor/excitation/shaft_path.hpp"

namespace amb_rotor {
namespace {

using namespace testing_support;
using Complex = std::complex<double>;
const Complex i_unit(0.0, 1.0);

TEST(MachineResponse, UnbalanceAmplitudeAndPhase) {
  // 5.8 corrected: X = U W^2 exp(i p)/(k - m W^2 + i d W), amplitude U W^2/sqrt((k - m W^2)^2 + (d W)^2)
  const double k = 2.47e6, d = 100.0, moment = 3.36 * 1.0e-6, phase = 0.8;
  const Model model = withUnbalance(springMass(k, d), moment, phase);
  RunOptions options;
  options.settle_s = 2.0;  // the free motion dies with d/(2 m) = 15/s: exp(-30)
  for (double hz : {30.0, 100.0, 133.0, 136.5, 140.0, 250.0}) {
    const double w = radPerSecond(hz);
    const Complex expected = moment * w * w * std::polar(1.0, phase) / Complex(k - 3.36 * w * w, d * w);
    const auto run = simulate(model, constantSpeed(hz, 0.1), options);
    ASSERT_EQ(run.outcome.status, RunStatus::ok);
    ASSERT_TRUE(run.trajectory.contacts.empty());
    const auto& t = run.trajectory;
    const Complex x = order(t.angle_rad, t.displacement_m[0], 1.0, 0);
    const Complex y = order(t.angle_rad, t.displacement_m[1], 1.0, 0);
    // 1e-8 of a step, amplified by the resonance (28 times)
    EXPECT_LT(std::abs(x - expected), 1e-6 * std::abs(expected)) << hz;
    EXPECT_LT(std::abs(y + i_unit * x), 1e-6 * std::abs(expected)) << "circular, forward, " << hz;
  }
}

TEST(MachineResponse, BackwardSpinWhirlsBackward) {
  const auto run = simulate(withUnbalance(springMass(2.47e6, 2000.0), 1e-5), constantSpeed(-90.0, 0.1));
  const auto& t = run.trajectory;
  const auto whirl = whirlOrder(t.time_s, t.displacement_m[0], t.displacement_m[1], radPerSecond(90.0), 0);
  EXPECT_GT(std::abs(whirl.backward), 1e-7);
  EXPECT_LT(std::abs(whirl.forward), 1e-6 * std::abs(whirl.backward));
}

TEST(MachineResponse, RunUpThroughTheCriticalSpeed) {
  // m z'' + d z' + k z = U (W^2 - i W') exp(i t): integrated here by RK4 with its own angle
  const double m = 3.36, k = 2.47e6, d = 300.0, moment = 1e-5, rate = radPerSecond(250.0) / 0.5;
  Scenario scenario = from(constantSpeed(0.0, 0.5, 2000.0), {0.0, 0.0}, {0.0, 0.0});
  scenario.speed.type = SpeedType::ramp;
  scenario.speed.end_hz = 250.0;
  scenario.speed.duration_s = 0.5;
  const auto run = simulate(withUnbalance(springMass(k, d), moment), scenario);
  ASSERT_EQ(run.outcome.status, RunStatus::ok);
  const auto force = [&](double t) {
    const double w = rate * t;
    return moment * Complex(w * w, -rate) * std::polar(1.0, 0.5 * rate * t * t);
  };
  const auto acceleration = [&](double t, Complex z, Complex v) { return (force(t) - d * v - k * z) / m; };
  Complex z = 0.0, v = 0.0;
  const double h = 5e-6;
  double worst = 0.0, most = 0.0;
  for (std::size_t row = 0; row < run.trajectory.time_s.size(); ++row) {
    worst = std::max({worst, std::fabs(run.trajectory.displacement_m[0][row] - z.real()),
                      std::fabs(run.trajectory.displacement_m[1][row] - z.imag())});
    most = std::max(most, std::abs(z));
    for (int step = 0; step < 100; ++step) {
      const double t = row / 2000.0 + step * h;
      const Complex a1 = acceleration(t, z, v), v2 = v + 0.5 * h * a1;
      const Complex a2 = acceleration(t + 0.5 * h, z + 0.5 * h * v, v2), v3 = v + 0.5 * h * a2;
      const Complex a3 = acceleration(t + 0.5 * h, z + 0.5 * h * v2, v3), v4 = v + h * a3;
      const Complex a4 = acceleration(t + h, z + h * v3, v4);
      z += h / 6.0 * (v + 2.0 * v2 + 2.0 * v3 + v4);
      v += h / 6.0 * (a1 + 2.0 * a2 + 2.0 * a3 + a4);
    }
  }
  ASSERT_TRUE(run.trajectory.contacts.empty());
  EXPECT_GT(most, 2e-5) << "the resonance is passed";
  // RK4: (w h)^5 a step at 1570 rad/s is 3e-11; 1e5 steps
  EXPECT_LT(worst, 3e-6 * most);
}

TEST(MachineResponse, SpeedLawsFollowTheirIntegrals) {
  Scenario scenario = from(constantSpeed(100.0, 0.4, 1000.0), {0.0, 0.0}, {});
  scenario.speed.type = SpeedType::decay;  // thesis 4.3: W = W0/(1 + a t), angle W0/a ln(1 + a t)
  scenario.speed.decay_factor_per_s = 3.0;
  scenario.speed.start_s = 0.1;
  scenario.speed.initial_angle_rad = 0.4;
  auto run = simulate(springMass(), scenario);
  const double w0 = radPerSecond(100.0);
  for (std::size_t row = 0; row < run.trajectory.time_s.size(); ++row) {
    const double t = run.trajectory.time_s[row], s = std::max(0.0, t - 0.1);
    EXPECT_NEAR(run.trajectory.speed_rad_s[row], w0 / (1.0 + 3.0 * s), 1e-9);
    EXPECT_NEAR(run.trajectory.angle_rad[row], 0.4 + w0 * std::min(t, 0.1) + w0 / 3.0 * std::log1p(3.0 * s),
                1e-9);
  }
  scenario.speed.type = SpeedType::ramp;
  scenario.speed.end_hz = 40.0;
  scenario.speed.duration_s = 0.2;
  run = simulate(springMass(), scenario);
  const double w1 = radPerSecond(40.0), a = (w1 - w0) / 0.2;
  for (std::size_t row = 0; row < run.trajectory.time_s.size(); ++row) {
    const double t = run.trajectory.time_s[row], s = std::min(std::max(0.0, t - 0.1), 0.2);
    const double rest = std::max(0.0, t - 0.3);
    EXPECT_NEAR(run.trajectory.speed_rad_s[row], w0 + a * s, 1e-9);
    EXPECT_NEAR(run.trajectory.angle_rad[row],
                0.4 + w0 * std::min(t, 0.1) + w0 * s + 0.5 * a * s * s + w1 * rest, 1e-9);
  }
}

TEST(MachineResponse, ASpeedChangeWithinARampJumpsNeitherAngleNorSpeed) {
  Scenario scenario = constantSpeed(0.0, 1.0);
  scenario.speed.type = SpeedType::ramp;
  scenario.speed.end_hz = 100.0;
  scenario.speed.duration_s = 1.0;
  FaultEvent change;
  change.type = FaultType::speed_change;
  change.start_s = 0.5;
  change.ramp_s = 0.1;
  change.amount = 30.0;
  scenario.faults.push_back(change);
  const PiecewiseShaft path = shaftPath(scenario);
  for (double t = 1e-3; t < 1.2; t += 1e-3) {
    const ShaftInstant a = path.at(t - 1e-7), b = path.at(t + 1e-7);
    // the steepest slope is 200 Hz/s: 2.5e-4 rad/s over 0.2 us
    EXPECT_NEAR(a.speed, b.speed, 3e-4) << t;
    EXPECT_NEAR(b.angle - a.angle, 2e-7 * b.speed, 1e-9) << t;
  }
  EXPECT_NEAR(path.at(0.7).speed, radPerSecond(30.0), 1e-9);
  EXPECT_NEAR(path.at(1.2).speed, radPerSecond(30.0), 1e-9) << "the change ends the ramp";
}

TEST(MachineResponse, PowerFailureOfOneAxis) {
  const Model model = levitated();
  const Scenario free = from(constantSpeed(0.0, 0.012), {2e-5, 1e-5, 1e-4, 5e-5}, {});
  const double off = 0.0053;
  const auto whole = simulate(model, free), failed = simulate(model, bearingsOff(free, off, 0, 0));
  const auto& t = failed.trajectory;
  ASSERT_TRUE(t.contacts.empty());
  double at_failure = 0.0;
  for (std::size_t row = 0; row < t.time_s.size(); ++row) {
    const double since = t.time_s[row] - off;
    if (since < -1e-9) continue;
    EXPECT_EQ(t.bearing_force_N[0][row], 0.0);
    if (std::fabs(since) < 1e-9) at_failure = t.current_A[0][row];
    // the current dies away with the amplifier's lag, whatever the controller asks for
    EXPECT_NEAR(t.current_A[0][row], at_failure * std::exp(-two_pi * 2000.0 * std::max(since, 0.0)), 1e-12);
    EXPECT_NE(t.bearing_force_N[2][row], 0.0);
  }
  EXPECT_GT(std::fabs(at_failure), 1e-3);
  // the other plane shares the integrator's steps, not its forces
  for (std::size_t row = 0; row < t.time_s.size(); ++row)
    for (int axis : {1, 3})
      EXPECT_NEAR(t.displacement_m[axis][row], whole.trajectory.displacement_m[axis][row], 1e-11);
  EXPECT_GT(std::fabs(t.displacement_m[0].back() - whole.trajectory.displacement_m[0].back()), 1e-6);
}

TEST(MachineResponse, PowerFailureOfOneBearing) {
  // each bearing carries m g/2; when A fails, B's force stays for a moment: y'' = -g/2 and It r'' = z_b m g/2
  Model model = levitated();
  model.rig.gravity_m_s2 = 9.81;
  const auto run = simulate(model, bearingsOff(constantSpeed(0.0, 0.002, 1e5), 0.001, 0));
  const auto& t = run.trajectory;
  const std::size_t fail = 100, later = 120;  // 0.2 ms
  const double dt = t.time_s[later] - t.time_s[fail], half = 0.5 * dt * dt;
  const double fall_a = t.position_m[1][later] - t.position_m[1][fail];
  const double fall_b = t.position_m[3][later] - t.position_m[3][fail];
  const double tilt = 0.096 * 0.5 * 3.36 * 9.81 / 0.017;
  // the other bearing answers by k t^2/(12 It/z^2) of it, below 1 %
  EXPECT_NEAR(fall_a / half, -4.905 - 0.118 * tilt, 0.01 * 15.0);
  EXPECT_NEAR(fall_b / half, -4.905 + 0.118 * tilt, 0.01 * 15.0);
}

TEST(MachineResponse, PowerFailureOfAllIsAFreeFallOntoTheAuxiliaryBearing) {
  Model model = levitated();
  model.rig.gravity_m_s2 = 9.81;
  RunOptions options;
  const auto run = simulate(model, bearingsOff(constantSpeed(0.0, 0.02), 0.001), options);
  const auto& t = run.trajectory;
  const double y0 = t.position_m[1][10];
  EXPECT_NEAR(y0, -0.5 * 3.36 * 9.81 / netStiffness(model), 1e-9) << "sag on the net stiffness";
  ASSERT_FALSE(t.contacts.empty());
  const double touch = 0.001 + std::sqrt(2.0 * (0.2e-3 + y0) / 9.81);
  EXPECT_NEAR(t.contacts.front().from_s, touch, 1e-7);
  for (std::size_t row = 11; row < t.time_s.size() && t.time_s[row] < touch; ++row) {
    const double since = t.time_s[row] - 0.001;
    EXPECT_NEAR(t.position_m[1][row], y0 - 0.5 * 9.81 * since * since, 1e-10);
    EXPECT_NEAR(t.position_m[0][row], 0.0, 1e-15);
  }
}

TEST(MachineResponse, AFailureThatEndsBringsTheBearingBack) {
  Model model = levitated();
  Scenario scenario = from(constantSpeed(0.0, 0.02), {2e-5, 0.0, 0.0, 0.0}, {});
  scenario = bearingsOff(scenario, 0.002);
  scenario.faults.back().duration_s = 0.003;
  const auto run = simulate(model, scenario);
  const auto& t = run.trajectory;
  for (std::size_t row = 0; row < t.time_s.size(); ++row) {
    const bool off = t.time_s[row] > 0.002 - 1e-9 && t.time_s[row] < 0.005 - 1e-9;
    EXPECT_EQ(t.bearing_force_N[0][row] == 0.0, off) << t.time_s[row];
  }
}

TEST(MachineResponse, ARunWithSpinDragStartsSettledAtItsOwnAngle) {
  // the run-in must not leave the response behind the shaft: at t = 0 it is the response of the constant
  // speed
  const Model still = withUnbalance(springMass(2.47e6, 2000.0), 1e-5, 0.3);
  const Model slowed = with(still, "spin_drag", {0.5, 0.0});
  const auto a = simulate(still, constantSpeed(80.0, 0.001)),
             b = simulate(slowed, constantSpeed(80.0, 0.001));
  EXPECT_EQ(b.trajectory.angle_rad[0], 0.0);
  EXPECT_NEAR(b.trajectory.speed_rad_s[0], radPerSecond(80.0), 1e-12);
  // amplitude 1e-6 m
  EXPECT_NEAR(a.trajectory.displacement_m[0][0], b.trajectory.displacement_m[0][0], 1e-12);
  EXPECT_NEAR(a.trajectory.displacement_m[1][0], b.trajectory.displacement_m[1][0], 1e-12);
}

TEST(MachineResponse, ARunThatLeavesTheBearingIsATypedResult) {
  Model model = levitated();
  model.rig.controller.kp_A_per_m = -1e6;
  model.rig.auxiliary_bearing.stiffness_N_per_m = 1.0;  // nothing to hold it
  model.rig.amb.air_gap_m = 1.0;                        // and no magnet in the way
  const auto run = simulate(model, from(constantSpeed(0.0, 0.5), {1e-5, 0.0, 0.0, 0.0}, {}));
  EXPECT_EQ(run.outcome.status, RunStatus::diverged);
  EXPECT_FALSE(run.outcome.reason.empty());
  EXPECT_FALSE(run.trajectory.time_s.empty()) << "what was reached is kept";
}

}  // namespace
}  // namespace amb_rotor
