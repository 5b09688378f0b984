// Effects that push the rotor or shape it: unbalance, bow, load, stiffness, damping, pull, crack, gyroscopic
// moment, bending, foundation, drag. Steady responses against complex linear algebra, motions against their
// exact roots.
#include <gtest/gtest.h>

#include <complex>

#include "../support/probe.hpp"
#include "amb_rotor/common/linear_algebra.hpp"

namespace amb_rotor {
namespace {

using namespace testing_support;
using Complex = std::complex<double>;
const Complex j(0.0, 1.0);
constexpr double m = 3.36, it = 0.017, za = 0.096;
// 1e-8 of a step and some thousand steps, of motions of 1e-5 m
constexpr double run_tolerance = 1e-6;

/// Steady 1X amplitudes of x and y at sensor a.
std::pair<Complex, Complex> oneX(const Model& model, double hz, int axis = 0) {
  const auto run = simulate(model, constantSpeed(hz, 10.0 / hz));
  EXPECT_EQ(run.outcome.status, RunStatus::ok);
  EXPECT_TRUE(run.trajectory.contacts.empty());
  const auto& t = run.trajectory;
  return {order(t.angle_rad, t.displacement_m[axis], 1.0, 0),
          order(t.angle_rad, t.displacement_m[axis + 1], 1.0, 0)};
}

/// A motion z = z0 exp(s t) of a plane coordinate (0: centre, 2: tilt) started exactly, and its error at the
/// end.
void expectExactMode(const Model& model, double hz, Complex s, int coordinate, double duration,
                     const char* what) {
  const Complex z0(2e-6, -1e-6), v0 = s * z0;
  std::vector<double> position(4, 0.0), velocity(4, 0.0);
  position[coordinate] = z0.real(), position[coordinate + 1] = z0.imag();
  velocity[coordinate] = v0.real(), velocity[coordinate + 1] = v0.imag();
  const auto run = simulate(model, from(constantSpeed(hz, duration), position, velocity));
  ASSERT_TRUE(run.trajectory.contacts.empty()) << what;
  const auto& t = run.trajectory;
  const Complex expected = z0 * std::exp(s * t.time_s.back());
  const double arm = coordinate == 0 ? 0.5 : 0.5 / 0.118;
  const double sign = coordinate == 0 ? 1.0 : -1.0;
  const Complex z(arm * (t.position_m[2].back() + sign * t.position_m[0].back()),
                  arm * (t.position_m[3].back() + sign * t.position_m[1].back()));
  EXPECT_LT(std::abs(z - expected), 1e-5 * std::abs(expected)) << what;
}

TEST(EffectCoupleUnbalance, TranslationAndTiltOfASecondPlane) {
  const double k = 2e5, d = 150.0, u = 2e-5, p = 0.6, z = 0.07;
  for (double hz : {30.0, 90.0}) {
    const double w = radPerSecond(hz);
    const Complex x = u * w * w * std::polar(1.0, p) / Complex(2 * k - m * w * w, 2 * d * w);
    const Complex b =
        z * u * w * w * std::polar(1.0, p) / Complex(2 * k * za * za - it * w * w, 2 * d * za * za * w);
    const auto seen = oneX(with(springBeam(k, d), "couple_unbalance", {u, p, z}), hz);
    EXPECT_LT(std::abs(seen.first - (x - 0.118 * b)), run_tolerance * std::abs(x)) << hz;
    EXPECT_LT(std::abs(seen.second + j * (x - 0.118 * b)), run_tolerance * std::abs(x)) << hz;
  }
}

TEST(EffectGyroscopic, UnbalanceTiltStiffensAndFrequenciesSplit) {
  // forward: It b'' - i Ip W b' + k b, so unbalance at z sees (It - Ip) W^2
  const double k = 2e5, d = 150.0, u = 2e-5, ip = 0.012, hz = 70.0, w = radPerSecond(hz);
  const Complex x = u * w * w / Complex(2 * k - m * w * w, 2 * d * w);
  const Complex b = 0.07 * u * w * w / Complex(2 * k * za * za - (it - ip) * w * w, 2 * d * za * za * w);
  Model model = with(springBeam(k, d), "couple_unbalance", {u, 0.0, 0.07});
  const auto seen = oneX(with(model, "gyroscopic_coupling", {ip}), hz);
  EXPECT_LT(std::abs(seen.first - (x - 0.118 * b)), run_tolerance * std::abs(x));
  // free: w = +- Ip W/(2 It) + sqrt(w0^2 + (Ip W/(2 It))^2), the faster one with the spin
  const double w0 = std::sqrt(2 * k * za * za / it), half = 0.5 * ip * w / it, root = std::hypot(w0, half);
  const Model free = with(springBeam(k, 0.0), "gyroscopic_coupling", {ip});
  expectExactMode(free, hz, Complex(0.0, root + half), 2, 0.05, "forward");
  expectExactMode(free, hz, Complex(0.0, half - root), 2, 0.05, "backward");
}

TEST(EffectShaftBow, OneXOfTheBowThatDoesNotGrowWithSpeedSquared) {
  const double k = 2e5, d = 150.0, bow = 4e-6, p = -0.7;
  const Model model = with(springBeam(k, d), "shaft_bow", {bow, bow, p});
  for (double hz : {3.0, 40.0}) {
    const double w = radPerSecond(hz);
    const Complex x = 2 * k * bow * std::polar(1.0, p) / Complex(2 * k - m * w * w, 2 * d * w);
    const auto seen = oneX(model, hz);
    EXPECT_LT(std::abs(seen.first - x), run_tolerance * std::abs(x)) << hz;
  }
  // at a slow roll the rotor turns about its bow: the displacement is the bow itself
  EXPECT_NEAR(std::abs(oneX(model, 3.0).first), bow, 0.005 * bow);
}

TEST(EffectStaticLoad, Deflection) {
  const Model model = with(springBeam(2e5, 500.0), "static_load", {8.0, -4.0});
  const auto run = simulate(model, constantSpeed(0.0, 0.001));
  EXPECT_NEAR(run.trajectory.displacement_m[0][0], 8.0 / 4e5, 1e-11);
  EXPECT_NEAR(run.trajectory.displacement_m[3][0], -4.0 / 4e5, 1e-11);
}

TEST(EffectStiffnessAnisotropy, EllipseAndBackwardWhirlBetweenTheCriticalSpeeds) {
  const double k = 2e5, d = 10.0, u = 4e-6, e = 0.2;
  const Model model = with(withUnbalance(springBeam(k, d), u), "stiffness_anisotropy", {e});
  const double hz = std::sqrt(2 * k / m) / two_pi, w = radPerSecond(hz);
  const Complex x = u * w * w / Complex(2 * k * (1 + e / 2) - m * w * w, 2 * d * w);
  const Complex y = -j * u * w * w / Complex(2 * k * (1 - e / 2) - m * w * w, 2 * d * w);
  RunOptions options;
  options.settle_s = 6.0;  // d/m = 3/s: exp(-18)
  const auto run = simulate(model, constantSpeed(hz, 10.0 / hz), options);
  const auto& t = run.trajectory;
  ASSERT_TRUE(t.contacts.empty());
  const Complex sx = order(t.angle_rad, t.displacement_m[0], 1.0, 0),
                sy = order(t.angle_rad, t.displacement_m[1], 1.0, 0);
  EXPECT_LT(std::abs(sx - x), 1e-5 * std::abs(x));
  EXPECT_LT(std::abs(sy - y), 1e-5 * std::abs(x));
  const auto whirl = whirlOrder(t.angle_rad, t.displacement_m[0], t.displacement_m[1], 1.0, 0);
  EXPECT_GT(std::abs(whirl.backward), 3.0 * std::abs(whirl.forward)) << "between the two critical speeds";
}

TEST(EffectCrossCoupling, ExactRootsAndOnsetAtCTimesW) {
  // m z'' + 2 d z' + (2 k - i q) z = 0 is marginal at q = 2 d w, w^2 = 2 k/m
  const double k = 2e5, d = 30.0, w = std::sqrt(2 * k / m), hz = 80.0;
  for (double share : {0.9, 1.0, 1.1}) {
    const double q = share * 2 * d * w;
    const Complex s = (-2 * d + std::sqrt(Complex(4 * d * d - 8 * m * k, 4 * m * q))) / (2 * m);
    const Complex growing =
        s.imag() > 0.0 ? s : (-2 * d - std::sqrt(Complex(4 * d * d - 8 * m * k, 4 * m * q))) / (2 * m);
    if (share < 1.0) {
      EXPECT_LT(growing.real(), 0.0);
    }
    if (share > 1.0) {
      EXPECT_GT(growing.real(), 0.0);
    }
    if (share == 1.0) {
      EXPECT_NEAR(growing.real(), 0.0, 1e-9);
    }
    const Model model = with(springBeam(k, d), "cross_coupled_stiffness", {q, hz, 1.0, 0.0});
    expectExactMode(model, hz, growing, 0, 0.2, "forward");
    // half the speed, exponent 2: a quarter of it; the other spin: the mirror image
    const Model slower = with(springBeam(k, d), "cross_coupled_stiffness", {4.0 * q, 2.0 * hz, 2.0, 0.0});
    expectExactMode(slower, hz, growing, 0, 0.2, "slower");
    expectExactMode(model, -hz, std::conj(growing), 0, 0.2, "backward");
  }
  Probe still(with(springBeam(), "cross_coupled_stiffness", {1e5, 100.0, 1.0, 0.0})), none(springBeam());
  for (Probe* p : {&still, &none}) p->beam({1e-5, 2e-5, 0.0, 0.0}).turning(0.0);
  EXPECT_NEAR(addedWrench(none, still).force.x, 0.0, 1e-9) << "nothing at standstill";
}

TEST(EffectInternalDamping, ThresholdSpeed) {
  // m z'' + c z' + d (z' - i W z) + k z = 0: marginal at W = w (1 + c/d)
  const double k = 2e5, c = 20.0, d = 60.0, w = std::sqrt(2 * k / m), threshold = w * (1 + 2 * c / d);
  for (double share : {0.0, 0.95, 1.0, 1.05}) {
    const double speed = share * threshold;
    const Complex root = std::sqrt(Complex((2 * c + d) * (2 * c + d) - 8 * m * k, 4 * m * d * speed));
    Complex s = (-(2 * c + d) + root) / (2 * m);
    if (s.imag() < 0.0) s = (-(2 * c + d) - root) / (2 * m);
    if (share < 1.0) {
      EXPECT_LT(s.real(), 0.0);
    }
    if (share == 1.0) {
      EXPECT_NEAR(s.real(), 0.0, 1e-9);
    }
    if (share > 1.0) {
      EXPECT_GT(s.real(), 0.0);
    }
    expectExactMode(with(springBeam(k, c), "internal_damping", {d, 0.0}), speed / two_pi, s, 0, 0.1,
                    "internal");
  }
}

TEST(EffectMotorPull, NegativeStiffnessAtItsPlane) {
  const double k = 2e5, pull = 5e4;
  expectExactMode(with(springBeam(k, 0.0), "motor_magnetic_pull", {pull, 0.0}), 0.0,
                  Complex(0.0, std::sqrt((2 * k - pull) / m)), 0, 0.1, "pull");
  Probe with_pull(with(springBeam(), "motor_magnetic_pull", {pull, 0.05})), without(springBeam());
  for (Probe* p : {&with_pull, &without}) p->beam({1e-5, -2e-5, 1e-4, 3e-4});
  const Wrench added = addedWrench(without, with_pull);
  const double x = 1e-5 + 0.05 * 1e-4, y = -2e-5 + 0.05 * 3e-4;
  EXPECT_NEAR(added.force.x, pull * x, 1e-9);
  EXPECT_NEAR(added.force.y, pull * y, 1e-9);
  EXPECT_NEAR(added.moment.x, 0.05 * pull * x, 1e-9);
  EXPECT_NEAR(added.moment.y, 0.05 * pull * y, 1e-9);
}

TEST(EffectShaftCrack, ForceAsWritten) {
  const double h = 0.1, p = 0.4, angle = 1.3, u = angle + p;
  Probe cracked(with(levitated(), "shaft_crack", {h, p})), whole(levitated());
  for (Probe* probe : {&cracked, &whole}) probe->beam({1e-5, -2e-5, 1e-4, 2e-4}).turning(50.0, angle);
  const double k = netStiffness(levitated());
  Vec2<double> force, moment;
  for (double z : {-za, za}) {
    const double along = (1e-5 + z * 1e-4) * std::cos(u) + (-2e-5 + z * 2e-4) * std::sin(u);
    const double size = h * k * 0.5 * (1.0 + std::cos(u)) * along;
    force += Vec2<double>{size * std::cos(u), size * std::sin(u)};
    moment += Vec2<double>{z * size * std::cos(u), z * size * std::sin(u)};
  }
  const Wrench added = addedWrench(whole, cracked);
  EXPECT_NEAR(added.force.x, force.x, 1e-11);
  EXPECT_NEAR(added.force.y, force.y, 1e-11);
  EXPECT_NEAR(added.moment.x, moment.x, 1e-11);
  EXPECT_NEAR(added.moment.y, moment.y, 1e-11);
}

TEST(EffectShaftCrack, TwoXPeaksAtHalfTheCriticalSpeed) {
  Model model = springBeam(2e5, 60.0);
  model.rig.gravity_m_s2 = 9.81;
  const double critical = std::sqrt(4e5 / m) / two_pi;
  double peak = 0.0, beside = 0.0;
  for (double share : {0.42, 0.5, 0.58}) {
    const double hz = share * critical;
    RunOptions options;
    options.settle_s = 1.0;
    const auto run = simulate(with(model, "shaft_crack", {0.02, 0.0}), constantSpeed(hz, 10.0 / hz), options);
    const auto& t = run.trajectory;
    const auto whirl = whirlOrder(t.angle_rad, t.displacement_m[0], t.displacement_m[1], 2.0, 0);
    // first order: F = h k/2 (1 + cos u) n (n.p), p = -i s: n (n.p) = (p + conj(p) exp(2 i u))/2, so the
    // forward 2X of both bearings together is 2 h k/4 conj(p) = i h k s/2
    const double w = radPerSecond(hz), s = m * 9.81 / 4e5;
    const Complex expected = j * 0.5 * 0.02 * 2e5 * s / Complex(4e5 - 4 * m * w * w, 2 * 60.0 * 2 * w);
    EXPECT_LT(std::abs(whirl.forward - expected), 0.08 * std::abs(expected))
        << share << " (second order in h)";
    (share == 0.5 ? peak : beside) = std::max(share == 0.5 ? peak : beside, std::abs(whirl.forward));
  }
  EXPECT_GT(peak, 2.0 * beside);
}

TEST(EffectShaftFlexibility, ResponseOfThreeModesAPlane) {
  // rigid translation, tilt and a bending mode of modal mass m, coupled by the bearings at their shapes
  const double k = 2e5, d = 300.0, hz = 60.0, damping = 0.02, u = 2e-5, phase = 0.3;
  const double amb[2] = {0.6, 0.8}, sensor[2] = {0.9, 1.1}, unbalance = -0.7, bending = radPerSecond(hz);
  Model model = withUnbalance(springBeam(k, d), u, phase, 0.02);
  model = with(model, "shaft_flexibility",
               {hz, damping, amb[0], amb[1], sensor[0], sensor[1], 1.2, 1.3, unbalance});
  const double z[2] = {-za, za};
  for (double speed : {25.0, 55.0, 120.0}) {
    const double w = radPerSecond(speed);
    Eigen::Matrix3cd dynamic = Eigen::Matrix3cd::Zero();
    const double mass[3] = {m, it, m};
    for (int i = 0; i < 3; ++i) dynamic(i, i) = -mass[i] * w * w;
    dynamic(2, 2) += m * Complex(bending * bending, 2 * damping * bending * w);
    for (int end = 0; end < 2; ++end) {
      const Eigen::Vector3d shape(1.0, z[end], amb[end]);
      dynamic += Complex(k, d * w) * (shape * shape.transpose()).cast<Complex>();
    }
    const Eigen::Vector3cd q =
        solveLu(Eigen::MatrixXcd(dynamic),
                Eigen::VectorXcd(u * w * w * std::polar(1.0, phase) * Eigen::Vector3cd(1.0, 0.02, unbalance)));
    const Complex x = q(0) - 0.118 * q(1) + sensor[0] * q(2);
    const auto seen = oneX(model, speed);
    EXPECT_LT(std::abs(seen.first - x), 5e-6 * std::abs(x)) << speed;
  }
}

TEST(EffectShaftFlexibility, AUniformWeightDoesNotBendAFreeMode) {
  Model model = springBeam(2e5, 300.0);
  model.rig.gravity_m_s2 = 9.81;
  model.rig.unbalance.emplace_back();
  Probe probe(with(model, "shaft_flexibility", {60.0, 0.02, 0.7, 0.7, 0.7, 0.7, 0.7, 0.7, -0.7}));
  probe.look();
  // coordinates: three of x, three of y; only the translation falls
  EXPECT_NEAR(probe.rate[9], -9.81, 1e-12);
  EXPECT_NEAR(probe.rate[10], 0.0, 1e-12);
  EXPECT_NEAR(probe.rate[11], 0.0, 1e-12);
}

TEST(EffectFoundation, TwoMassResponseAndAntiresonance) {
  const double k = 2e5, d = 150.0, mf = 12.0, hz = 40.0, ratio = 0.02, wf = radPerSecond(hz), u = 4e-5;
  const Model model = with(withUnbalance(springBeam(k, d), u), "foundation_resonance", {mf, hz, ratio});
  const auto response = [&](double w) {
    Eigen::Matrix2cd dynamic;
    const Complex spring(2 * k, 2 * d * w);
    dynamic << spring - m * w * w, -spring, -spring,
        spring + mf * Complex(wf * wf - w * w, 2 * ratio * wf * w);
    return Eigen::Vector2cd(solveLu(Eigen::MatrixXcd(dynamic), Eigen::VectorXcd(Eigen::Vector2cd(u * w * w, 0.0))));
  };
  for (double speed : {20.0, 35.0, 75.0}) {
    RunOptions options;
    options.settle_s = 4.0;  // the slower mode decays with some 5/s: exp(-20)
    const auto run = simulate(model, constantSpeed(speed, 10.0 / speed), options);
    ASSERT_TRUE(run.trajectory.contacts.empty());
    const auto& t = run.trajectory;
    const auto expected = response(radPerSecond(speed));
    const Complex relative = order(t.angle_rad, t.displacement_m[0], 1.0, 0);
    const Complex absolute = order(t.angle_rad, t.aux_position_m[0], 1.0, 0);
    EXPECT_LT(std::abs(relative - (expected(0) - expected(1))), 1e-4 * std::abs(relative)) << speed;
    EXPECT_LT(std::abs(absolute - expected(0)), 1e-4 * std::abs(relative)) << speed;
  }
  // the antiresonance of the relative response lies at the foundation's own frequency: D22 - D21 = mf (wf^2 -
  // w^2)
  const double at = std::abs(response(wf)(0) - response(wf)(1));
  const double below = std::abs(response(0.8 * wf)(0) - response(0.8 * wf)(1));
  EXPECT_LT(at, 0.25 * below) << "what is left is its damping";
  RunOptions options;
  options.settle_s = 4.0;
  const auto run = simulate(model, constantSpeed(hz, 0.25), options);
  const Complex seen = order(run.trajectory.angle_rad, run.trajectory.displacement_m[0], 1.0, 0);
  EXPECT_NEAR(std::abs(seen), at, 1e-4 * below);
}

TEST(EffectSpinDrag, SpeedInClosedForm) {
  Model model = springBeam();
  model.rig.rotor.polar_inertia_kg_m2 = 1e-3;
  const double decay = 0.8, torque = 0.05, w0 = radPerSecond(120.0), offset = torque / 1e-3 / decay;
  const auto run = simulate(with(model, "spin_drag", {decay, torque}), constantSpeed(120.0, 0.5, 1000.0));
  for (std::size_t i = 0; i < run.trajectory.time_s.size(); ++i)
    EXPECT_NEAR(run.trajectory.speed_rad_s[i],
                (w0 + offset) * std::exp(-decay * run.trajectory.time_s[i]) - offset, 1e-7 * w0);
  // without a polar inertia the torque has nothing to act on
  const auto light =
      simulate(with(springBeam(), "spin_drag", {decay, torque}), constantSpeed(120.0, 0.5, 1000.0));
  EXPECT_NEAR(light.trajectory.speed_rad_s.back(), w0 * std::exp(-decay * 0.5), 1e-7 * w0);
  // a drive that changes the speed is not slowed down
  Scenario driven = constantSpeed(120.0, 0.1, 1000.0);
  driven.speed.type = SpeedType::ramp;
  driven.speed.end_hz = 100.0;
  driven.speed.duration_s = 0.1;
  const auto ramp = simulate(with(model, "spin_drag", {decay, torque}), driven);
  EXPECT_NEAR(ramp.trajectory.speed_rad_s.back(), radPerSecond(100.0), 1e-9);
}

}  // namespace
}  // namespace amb_rotor
