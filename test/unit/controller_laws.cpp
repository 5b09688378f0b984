// Controllers beside the plain PID: state space, integrator, decoupled motions, unbalance force rejection.
#include <gtest/gtest.h>

#include <random>

#include "../support/models.hpp"
#include "amb_rotor/machine/bearing_response.hpp"

namespace amb_rotor {
namespace {

using namespace testing_support;
using Complex = std::complex<double>;

/// The sampled PID without integrator as a b c d: W = (last signal, last derivative).
StateSpaceLaw pidLaw(const Model& model) {
  const auto& c = model.rig.controller;
  const double t = 1.0 / c.sample_rate_hz, p = std::exp(-two_pi * c.derivative_filter_hz * t);
  const double g = (1.0 - p) / t;
  return {2, 1, {0.0, 0.0, -g, p}, {1.0, g}, {-c.kd_A_s_per_m * g, c.kd_A_s_per_m * p},
          {c.kp_A_per_m + c.kd_A_s_per_m * g}};
}

Model inStateSpace(Model model) {
  model.control.type = ControllerType::state_space;
  model.control.main.law = pidLaw(model);
  model.rig.controller.kp_A_per_m = model.rig.controller.kd_A_s_per_m = 0.0;
  return model;
}

double apart(const Simulation& one, const Simulation& other) {
  EXPECT_EQ(one.trajectory.time_s.size(), other.trajectory.time_s.size());
  double most = 0.0;
  for (std::size_t a = 0; a < 4; ++a)
    for (std::size_t i = 0; i < one.trajectory.time_s.size(); ++i)
      most = std::max(most, std::fabs(one.trajectory.position_m[a][i] - other.trajectory.position_m[a][i]));
  return most;
}

Scenario pushed() { return from(constantSpeed(0.0, 0.03), {2e-5, -1e-5, 1e-4, 5e-5}, {}); }

TEST(ControllerLaws, StateSpaceOfThePidIsThePid) {
  const Model pid = levitated(), law = inStateSpace(levitated());
  const Simulation one = simulate(pid, pushed()), other = simulate(law, pushed());
  EXPECT_GT(largest(one.trajectory.current_A[0]), 0.1) << "it moves";
  // the same arithmetic in another order; the loop is stable and does not grow round-off of 1e-5 m
  EXPECT_LT(apart(one, other), 1e-15);
  const Machine<double> a({&pid}), b({&law});
  const auto k = equivalentBearings(a, 0.0, {80.0})[0][0], l = equivalentBearings(b, 0.0, {80.0})[0][0];
  EXPECT_NEAR(k.stiffness_N_per_m, l.stiffness_N_per_m, 1e-9 * k.stiffness_N_per_m);
  EXPECT_NEAR(k.damping_N_s_per_m, l.damping_N_s_per_m, 1e-9 * k.damping_N_s_per_m);
}

TEST(ControllerLaws, FourChannelsOfOneBlockEachAreTheSame) {
  Model four = inStateSpace(levitated());
  const StateSpaceLaw one = four.control.main.law;
  StateSpaceLaw& law = four.control.main.law;
  law = {8, 4, std::vector<double>(64), std::vector<double>(32), std::vector<double>(32), std::vector<double>(16)};
  for (std::size_t k = 0; k < 4; ++k) {
    for (std::size_t i = 0; i < 2; ++i) {
      for (std::size_t j = 0; j < 2; ++j) law.a[(2 * k + i) * 8 + 2 * k + j] = one.a[2 * i + j];
      law.b[(2 * k + i) * 4 + k] = one.b[i];
      law.c[k * 8 + 2 * k + i] = one.c[i];
    }
    law.d[k * 4 + k] = one.d[0];
  }
  EXPECT_LT(apart(simulate(inStateSpace(levitated()), pushed()), simulate(four, pushed())), 1e-15);
  law.d[1] += 100.0;  // from ay to ax
  EXPECT_GT(apart(simulate(inStateSpace(levitated()), pushed()), simulate(four, pushed())), 1e-9);
}

TEST(ControllerLaws, IntegratorAddsDIASampleAndTakesTheSagAway) {
  Model model = inStateSpace(levitated());
  model.control.main.integrator_gain_A_per_m = 50.0;  // the thesis's default
  const Machine<double> machine({&model});
  const Controller<double> controller = machine.controller();
  std::vector<double> memory(controller.memorySize(), 0.0);
  PidMemory<double> unused[4];
  const double signal[4] = {1e-5, 0.0, 0.0, 0.0};
  double command[4], first = 0.0;
  for (int n = 0; n < 200; ++n) {
    controller.sample(signal, 0.0, unused, memory.data(), command);
    if (n == 0) {
      EXPECT_EQ(command[0], -model.control.main.law.d[0] * 1e-5) << "a sample is added from the next one on";
    }
    if (n == 100) first = command[0];
  }
  // Y_k = Y_(k-1) + DI X_(k-1): 99 samples later 99 DI x more, against the displacement
  EXPECT_NEAR(command[0] - first, -99.0 * 50.0 * 1e-5, 1e-12);
  EXPECT_EQ(command[1], 0.0);
  // in the loop: a load is carried at the centre in the end. The slow pole is near -Ki DI fs/k = -47/s.
  model = with(model, "static_load", {0.0, -12.0});
  const auto run = simulate(model, from(constantSpeed(0.0, 0.5), {0, 0, 0, 0}, {}));
  EXPECT_GT(largest(run.trajectory.position_m[1]), 0.5 * 6.0 / 2e5) << "it sags at first";
  EXPECT_LT(std::fabs(run.trajectory.position_m[1].back()), 1e-3 * 6.0 / 2e5);
}

Model decoupled(Model model, double tilt_share) {
  auto& control = model.control;
  control.decoupled = true;
  control.tilt.kp_A_per_m = tilt_share * model.rig.controller.kp_A_per_m;
  control.tilt.kd_A_s_per_m = tilt_share * model.rig.controller.kd_A_s_per_m;
  return model;
}

TEST(ControllerLaws, DecoupledMotionsOfEqualGainsAreTheAxesWhereSensorsAreAtTheMagnets) {
  Model model = levitated();
  for (int e = 0; e < 2; ++e) model.rig.planes.sensor[e] = model.rig.planes.amb[e];
  EXPECT_LT(apart(simulate(model, pushed()), simulate(decoupled(model, 1.0), pushed())), 1e-15);
}

TEST(ControllerLaws, EachMotionHasItsOwnStiffnessWhereverTheSensorsAre) {
  // F at z: translation F/(2 (Ki kp - Ks)), tilt F z/(2 l^2 (Ki kp_r - Ks)), whatever the sensors' planes
  Model model = levitated();
  model.rig.planes.sensor[0] = -0.118;
  model.rig.planes.sensor[1] = 0.08;
  model = decoupled(model, 1.5);
  Scenario scenario = from(constantSpeed(0.0, 0.5), {0, 0, 0, 0}, {});
  Excitation force;
  force.amplitude = 4.0;
  force.plane_z_m = 0.05;
  scenario.excitations.push_back(force);
  const auto run = simulate(model, scenario);
  const double k = 19.0 * 13850.0 - 63333.0, kr = 1.5 * 19.0 * 13850.0 - 63333.0;
  const double x = run.trajectory.position_m[0].back(), b = run.trajectory.position_m[2].back();
  const double tilt = (b - x) / 0.198, centre = x + 0.118 * tilt;
  EXPECT_NEAR(centre, 4.0 / (2.0 * k), 1e-6 * 1e-5);
  EXPECT_NEAR(tilt, 4.0 * 0.05 / (2.0 * 0.096 * 0.096 * kr), 1e-6 * 5e-5);
}

/// The synchronous position of the centre and current of ax, steady, of a rotor with a central unbalance.
struct Synchronous {
  Complex position, current;
};
Synchronous turning(Model model, double hz) {
  for (int e = 0; e < 2; ++e) model.rig.planes.sensor[e] = model.rig.planes.amb[e];
  const auto run = simulate(withUnbalance(model, 5e-5), constantSpeed(hz, 1.0));
  const auto& t = run.trajectory;
  EXPECT_TRUE(t.contacts.empty());
  return {order(t.angle_rad, t.position_m[0], 1.0, 6000), order(t.angle_rad, t.current_A[0], 1.0, 6000)};
}

TEST(UnbalanceRejection, TakesTheCurrentAwayAndLeavesTheMagnetsPull) {
  const double w = two_pi * 110.0, m = 3.36, u = 5e-5, ks = 63333.0;
  Model model = levitated();
  const Synchronous before = turning(model, 110.0);
  model.control.unbalance_rejection = UnbalanceRejection{4.0, 0.0, 20.0, 0.0, 0.0};
  const Synchronous after = turning(model, 110.0);
  EXPECT_GT(std::abs(before.current), 0.1);
  EXPECT_LT(std::abs(after.current), 1e-4 * std::abs(before.current)) << "settles as exp(-t 12/s) from the run-in on";
  // with no current: -(m w^2 + 2 Ks) X = U w^2
  const Complex free = -u * w * w / (m * w * w + 2.0 * ks);
  EXPECT_LT(std::abs(after.position - free), 1e-4 * std::abs(free));
  const Synchronous slow = turning(model, 15.0);
  model.control.unbalance_rejection.reset();
  EXPECT_EQ(slow.current, turning(model, 15.0).current) << "off below its minimum speed";
}

TEST(UnbalanceRejection, CompensationLetsTheRotorTurnAboutItsInertiaAxis) {
  // X = -U/m at any speed: no synchronous force at all. From sample to force: delay, half a sample of the hold,
  // 1/(2 pi 2000) of the amplifier, 0.23 ms; what is left is the amplitude of hold and amplifier, (w/wa)^2/2 = 0.2 %
  // of Ks x, and the curvature of their phase, both below 1e-3 of m w^2 X.
  Model model = levitated();
  const double lead = 1e-4 + 0.5e-4 + 1.0 / (two_pi * 2000.0);
  model.control.unbalance_rejection = UnbalanceRejection{4.0, 0.0, 20.0, 63333.0 / 19.0, lead};
  for (const double hz : {90.0, 140.0}) {
    const Synchronous after = turning(model, hz);
    EXPECT_LT(std::abs(after.position + 5e-5 / 3.36), 1e-3 * 5e-5 / 3.36) << hz;
    EXPECT_GT(std::abs(after.current), 0.9 * 63333.0 / 19.0 * 5e-5 / 3.36) << "it is the current that does it";
  }
}

TEST(UnbalanceRejection, BelowTheRigidModesItDrivesTheRotorOutUnlessItsPhaseIsTurned) {
  // The notch is a resonator at the speed, closed through the loop: s = j W - pi b S exp(j phase) to first order in its
  // bandwidth b, with the sensitivity S = (m s^2 - 2 Ks)/(m s^2 - 2 Ks + 2 Ki G) of the translation at s = j W. S is
  // near -1 at 30 Hz, below the rigid modes of 55 and 74 Hz, so that phase 0 makes a motion grow that pi lets die.
  const double hz = 30.0, w = two_pi * hz, m = 3.36, ki = 19.0, ks = 63333.0, period = 1e-4, bandwidth = 0.5;
  Model model = levitated();
  for (int e = 0; e < 2; ++e) model.rig.planes.sensor[e] = model.rig.planes.amb[e];
  const auto& c = model.rig.controller;
  const Complex i(0.0, 1.0), back = std::exp(-i * w * period);
  const double pole = std::exp(-two_pi * c.derivative_filter_hz * period), amplifier = two_pi * 2000.0;
  const Complex law = c.kp_A_per_m + c.kd_A_s_per_m * (1.0 - pole) * (1.0 - back) / (period * (1.0 - pole * back));
  const Complex chain = std::exp(-i * w * c.delay_s) * (1.0 - back) / (i * w * period) / (1.0 + i * w / amplifier);
  const Complex open = -m * w * w - 2.0 * ks, sensitivity = open / (open + 2.0 * ki * law * chain);
  ASSERT_LT(sensitivity.real(), -0.5);
  for (const double phase : {0.0, pi}) {
    model.control.unbalance_rejection = UnbalanceRejection{bandwidth, phase, 20.0, 0.0, 0.0};
    const auto run = simulate(model, from(constantSpeed(hz, 2.0, 3000.0), {2e-6, 0.0, 0.0, 0.0}, {}));
    ASSERT_TRUE(run.trajectory.contacts.empty());
    const auto& t = run.trajectory;
    // what is at the speed, over three turns near 1 s and near 2 s: the levitated motion itself is long gone
    const auto turning = [&](std::size_t from) {
      const std::vector<double> angle(t.angle_rad.begin() + from, t.angle_rad.begin() + from + 300),
          x(t.position_m[0].begin() + from, t.position_m[0].begin() + from + 300);
      return std::abs(order(angle, x, 1.0, 0));
    };
    const double rate = std::log(turning(5600) / turning(2600));
    const double expected = -pi * bandwidth * (sensitivity * std::exp(i * phase)).real();
    EXPECT_NEAR(rate, expected, 0.03 * std::fabs(expected)) << "second order in the bandwidth, phase " << phase;
    EXPECT_EQ(rate > 0.0, phase == 0.0);
    EXPECT_GT(std::fabs(rate), 1.0);
  }
}

}  // namespace
}  // namespace amb_rotor
