// A free spin with unbalance: the shaft's translation and its turning act on each other (excitation/unbalance.hpp).
#include <gtest/gtest.h>

#include <algorithm>
#include <complex>

#include "../support/models.hpp"

namespace amb_rotor {
namespace {

using namespace testing_support;
using Complex = std::complex<double>;

constexpr double spun_mass = 3.36, spun_inertia = 1e-3;

Scenario freeSpin(double hz, double duration_s, double record_rate_hz = 1000.0) {
  Scenario scenario = constantSpeed(hz, duration_s, record_rate_hz);
  scenario.speed.type = SpeedType::free;
  return scenario;
}

/// A shaft on springs with an unbalance, and a torque on it [N m] (spin_drag's, which is constant above 20 rad/s).
Model driven(double stiffness, double damping, double moment, double torque) {
  Model model = withUnbalance(springMass(stiffness, damping), moment);
  model.rig.rotor.polar_inertia_kg_m2 = spun_inertia;
  return with(model, "spin_drag", {0.0, -torque});
}

TEST(MachineFreeSpin, AFreeDiscTurnsAboutItsCentreOfGravity) {
  // No force from outside: the centre of gravity stays, and the drag's torque turns Ip - m e^2, the inertia about it.
  const double e = 0.01, torque = -0.02, w0 = radPerSecond(20.0);
  Model model = driven(0.0, 0.0, spun_mass * e, torque);
  model.rig.auxiliary_bearing.clearance_m = 1.0;
  const auto run = simulate(model, from(freeSpin(20.0, 0.5), {-e, 0.0}, {0.0, -e * w0}));
  ASSERT_EQ(run.outcome.status, RunStatus::ok) << run.outcome.reason;
  const auto& t = run.trajectory;
  const double about_centre = spun_inertia - spun_mass * e * e;
  for (std::size_t i = 0; i < t.time_s.size(); i += 50) {
    const double time = t.time_s[i];
    // the integrator's 1e-8 a step of every 2 ms, tanh(W) is 1 to 1e-16; without the reaction 34 % of the change
    EXPECT_NEAR(t.speed_rad_s[i], w0 + torque / about_centre * time, 1e-5 * w0);
    EXPECT_NEAR(t.aux_position_m[0][i], -e * std::cos(t.angle_rad[i]), 1e-5 * e);
    EXPECT_NEAR(t.aux_position_m[1][i], -e * std::sin(t.angle_rad[i]), 1e-5 * e);
  }
  EXPECT_LT(t.speed_rad_s.back(), 0.9 * w0);
}

TEST(MachineFreeSpin, AHeavySpotSwingsAsAPendulum) {
  // small swings about the lowest place: Ip a'' = -g U a; the springs give way by U^2 w^2/(k Ip) = 4e-6 of it
  const double moment = spun_mass * 0.01, swing = 0.02;
  Model model = driven(1e8, 2e4, moment, 0.0);
  model.rig.gravity_m_s2 = 9.81;
  const double w = std::sqrt(9.81 * moment / spun_inertia), period = two_pi / w;
  Scenario scenario = freeSpin(0.0, period, 1000.0);
  scenario.speed.initial_angle_rad = -0.5 * pi + swing;
  const auto run = simulate(model, scenario);
  ASSERT_EQ(run.outcome.status, RunStatus::ok) << run.outcome.reason;
  const auto& t = run.trajectory;
  for (std::size_t i = 0; i < t.time_s.size(); ++i)
    // the swing's square over 16 in the frequency, over a period
    EXPECT_NEAR(t.angle_rad[i] + 0.5 * pi, swing * std::cos(w * t.time_s[i]), swing * (two_pi * swing * swing / 16 + 1e-4));
}

TEST(MachineFreeSpin, InternalDampingDrivesTheWhirlFromTheSpin) {
  // Springs alone, above the threshold speed: what the whirl gains in angular momentum the spin loses, and the sum of their
  // energies falls, by the integral of d abs(v - W z x r)^2.
  const double stiffness = 2.47e6, d = 2000.0, w0 = radPerSecond(240.0), start = 1e-6;
  for (double unbalance : {0.0, 1e-5}) {
    Model model = with(withUnbalance(springMass(stiffness, 0.0), unbalance), "internal_damping", {d, 0.0});
    model.rig.rotor.polar_inertia_kg_m2 = spun_inertia;
    model.rig.auxiliary_bearing.clearance_m = 0.1;
    RunOptions options;
    options.relative_tolerance = 1e-10;
    const auto run = simulate(model, from(freeSpin(240.0, 0.04, 1e5), {start, 0.0}, {}), options);
    ASSERT_EQ(run.outcome.status, RunStatus::ok) << run.outcome.reason;
    const auto balanceOf = [&](const double* y, double& momentum, double& energy) {
      const double c = std::cos(y[4]), s = std::sin(y[4]), across = c * y[3] - s * y[2];
      momentum = spun_mass * (y[0] * y[3] - y[1] * y[2]) + spun_inertia * y[5] +
                 unbalance * (y[5] * (y[0] * c + y[1] * s) + across);
      energy = 0.5 * spun_mass * (y[2] * y[2] + y[3] * y[3]) + 0.5 * stiffness * (y[0] * y[0] + y[1] * y[1]) +
               0.5 * spun_inertia * y[5] * y[5] + unbalance * y[5] * across;
    };
    const double first[6] = {start, 0.0, 0.0, 0.0, 0.0, w0};
    const double* last = run.final_state.mechanics.data();
    double momentum[2], energy[2];
    balanceOf(first, momentum[0], energy[0]);
    balanceOf(last, momentum[1], energy[1]);
    const double slowed = w0 - last[5];
    EXPECT_GT(slowed, 1.0) << "the whirl has grown";
    EXPECT_NEAR(momentum[1], momentum[0], 1e-6 * spun_inertia * slowed);
    // the trapezoidal rule on 1e5 samples a second of a motion of 1500 rad/s: (h w)^2/12 = 2e-5 of it at most
    double lost = 0.0;
    const auto& t = run.trajectory;
    const auto &x = t.aux_position_m[0], &y = t.aux_position_m[1];
    for (std::size_t i = 1; i + 1 < t.time_s.size(); ++i) {
      const double vx = (x[i + 1] - x[i - 1]) * 0.5e5 + t.speed_rad_s[i] * y[i];
      const double vy = (y[i + 1] - y[i - 1]) * 0.5e5 - t.speed_rad_s[i] * x[i];
      lost += d * (vx * vx + vy * vy) * 1e-5;
    }
    EXPECT_NEAR(energy[0] - energy[1], lost, 2e-3 * lost);
  }
}

/// Torque that a whirl at constant speed takes from the shaft, d abs(X)^2 W with X = U W^2/(k - m W^2 + i d W).
double whirlTorque(double k, double d, double moment, double w) {
  const double radius = std::abs(moment * w * w / Complex(k - spun_mass * w * w, d * w));
  return d * radius * radius * w;
}

constexpr double spring = 2.47e6, damper = 2000.0, moment = 3.36e-4;

TEST(MachineFreeSpin, TheWhirlsLossesComeFromTheSpin) {
  Model model = driven(spring, damper, moment, 0.0);
  model.rig.rotor.polar_inertia_kg_m2 = 0.01;
  for (double hz : {60.0, 120.0, 200.0}) {
    const double w = radPerSecond(hz), span = 0.02;
    const auto run = simulate(model, freeSpin(hz, span));
    ASSERT_EQ(run.outcome.status, RunStatus::ok) << run.outcome.reason;
    ASSERT_TRUE(run.trajectory.contacts.empty());
    const double slowed = (run.trajectory.speed_rad_s.back() - w) / run.trajectory.time_s.back();
    // as the speed falls by 6e-5 of itself, the torque at resonance by Q = 1.4 times twice that
    EXPECT_NEAR(slowed, -whirlTorque(spring, damper, moment, w) / 0.01, 1e-3 * std::fabs(slowed)) << hz;
  }
}

TEST(MachineFreeSpin, AWeakDriveIsCaughtBelowTheCriticalSpeed) {
  // Sommerfeld's effect: the speed stays where the whirl takes all of the torque, unless that is above the most it takes
  const double critical = std::sqrt(spring / spun_mass), weak = 0.02, strong = 0.08;
  ASSERT_LT(weak, whirlTorque(spring, damper, moment, critical));
  ASSERT_GT(strong, 1.5 * whirlTorque(spring, damper, moment, critical));
  double low = radPerSecond(60.0), high = critical;
  while (high - low > 1e-9 * critical) {
    const double middle = 0.5 * (low + high);
    (whirlTorque(spring, damper, moment, middle) < weak ? low : high) = middle;
  }
  const auto lastSpeed = [&](double torque, double duration_s) {
    Model model = driven(spring, damper, moment, torque);
    model.rig.rotor.polar_inertia_kg_m2 = 1e-4;
    const auto run = simulate(model, freeSpin(90.0, duration_s));
    EXPECT_EQ(run.outcome.status, RunStatus::ok) << run.outcome.reason;
    EXPECT_TRUE(run.trajectory.contacts.empty());
    return run.trajectory.speed_rad_s.back();
  };
  EXPECT_NEAR(lastSpeed(weak, 10.0), low, 1e-4 * low);
  EXPECT_GT(lastSpeed(strong, 2.0), 1.5 * critical);
}

TEST(MachineFreeSpin, ABowedShaftIsAPendulum) {
  // On stiff springs the mass goes round with the bow: V = m g bow sin u, and the energy of motion is that of Ip + m bow^2.
  const double bow = 1e-3, swing = 0.02, stiffness = 2e7;
  Model model = with(springMass(stiffness, 0.0), "shaft_bow", {bow, bow, 0.0});
  model.rig.rotor.polar_inertia_kg_m2 = spun_inertia;
  model.rig.gravity_m_s2 = 9.81;
  model.rig.auxiliary_bearing.clearance_m = 0.1;
  const double w = std::sqrt(9.81 * spun_mass * bow / (spun_inertia + spun_mass * bow * bow)), start = -0.5 * pi + swing;
  Scenario scenario = from(freeSpin(0.0, two_pi / w, 100.0),
                           {bow * std::cos(start), bow * std::sin(start) - spun_mass * 9.81 / stiffness}, {});
  scenario.speed.initial_angle_rad = start;
  const auto run = simulate(model, scenario);
  ASSERT_EQ(run.outcome.status, RunStatus::ok) << run.outcome.reason;
  const auto& t = run.trajectory;
  for (std::size_t i = 0; i < t.time_s.size(); ++i)
    // the swing's square over 16 in the frequency, over a period; the mass swings on its springs by (w/w1)^2 = 5e-6
    EXPECT_NEAR(t.angle_rad[i] + 0.5 * pi, swing * std::cos(w * t.time_s[i]), swing * (two_pi * swing * swing / 16 + 1e-4));
}

/// Bow, crack and unbalance on springs; a bearing's axis may be off.
struct BentAndCracked {
  double spring = 2e5, bow[2] = {2e-4, -1e-4}, bow_phase = 0.4, depth = 0.0, crack_phase = 1.1, moment = 1e-4;
  double inertia[2] = {spun_mass, 0.017}, arm[2] = {-0.096, 0.096}, on[2] = {1.0, 1.0};  // on: of end a, axes x, y

  Model model() const {
    Model m = withUnbalance(springBeam(spring, 0.0), moment);
    m.rig.rotor.polar_inertia_kg_m2 = spun_inertia;
    m.rig.gravity_m_s2 = 9.81;
    m.rig.auxiliary_bearing.clearance_m = 0.1;
    m = with(m, "shaft_bow", {bow[0], bow[1], bow_phase});
    return depth > 0.0 ? with(m, "shaft_crack", {depth, crack_phase}) : m;
  }
  /// Of a state x, b, y, r, their rates, angle, speed.
  double energy(const std::vector<double>& y) const {
    const double angle = y[8], speed = y[9], c = std::cos(angle), s = std::sin(angle);
    double sum = 0.5 * spun_inertia * speed * speed + 9.81 * (spun_mass * y[2] + moment * s) +
                 moment * speed * (c * y[6] - s * y[4]);
    for (int k = 0; k < 4; ++k) sum += 0.5 * inertia[k % 2] * y[4 + k] * y[4 + k];
    for (int end = 0; end < 2; ++end) {
      const double x = (y[0] + arm[end] * y[1]) * (end == 0 ? on[0] : 1.0),
                   z = (y[2] + arm[end] * y[3]) * (end == 0 ? on[1] : 1.0);
      const double u = angle + crack_phase, along = x * std::cos(u) + z * std::sin(u);
      sum += spring * (0.5 * (x * x + z * z) -
                       bow[end] * (x * std::cos(angle + bow_phase) + z * std::sin(angle + bow_phase)) -
                       0.25 * depth * (1.0 + std::cos(u)) * along * along);
    }
    return sum;
  }
};

TEST(MachineFreeSpin, BowAndCrackKeepTheEnergy) {
  std::vector<BentAndCracked> cases(3);
  cases[0].depth = 0.4;
  cases[1].depth = 0.4;
  cases[1].bow[0] = cases[1].bow[1] = 0.0;
  cases[2].on[0] = 0.0;  // a bow has a potential in each axis
  for (const BentAndCracked& rotor : cases) {
    const double w0 = 60.0;
    Scenario scenario = from(freeSpin(w0 / two_pi, 0.2), {3e-4, -2e-4, 1e-3, 2e-3}, {0.05, -0.02, 0.3, 0.1});
    if (rotor.on[0] == 0.0) scenario = bearingsOff(scenario, 0.0, 0, 0);
    RunOptions options;
    options.relative_tolerance = 1e-11;
    const auto run = simulate(rotor.model(), scenario, options);
    ASSERT_EQ(run.outcome.status, RunStatus::ok) << run.outcome.reason;
    const auto& speed = run.trajectory.speed_rad_s;
    const auto range = std::minmax_element(speed.begin(), speed.end());
    const double moved = spun_inertia * w0 * (*range.second - *range.first);  // energy that went to and fro
    EXPECT_GT(moved, 2e-3 * spun_inertia * w0 * w0);
    const std::vector<double> first = {3e-4, 1e-3, -2e-4, 2e-3, 0.05, 0.3, -0.02, 0.1, 0.0, w0};
    // what the integrator leaves at 1e-11 in some thousand steps; without the torques it is of the size of `moved`
    EXPECT_NEAR(rotor.energy(run.final_state.mechanics), rotor.energy(first), 1e-6 * moved) << rotor.depth;
  }
}

TEST(MachineFreeSpin, TooLittleInertiaIsRefusedByName) {
  const Model model = withUnbalance(springMass(), spun_mass * 0.02);  // m e^2 = 1.344e-3
  for (double inertia : {0.0, 1e-3, 1.4e-3}) {
    Model tried = model;
    tried.rig.rotor.polar_inertia_kg_m2 = inertia;
    std::string said;
    try {
      const Machine<double> machine({&tried}, Spin::free);
    } catch (const InputError& error) {
      said = error.faults().front().text();
    }
    if (inertia == 0.0) {
      EXPECT_NE(said.find("needs rotor.polar_inertia_kg_m2 > 0"), std::string::npos) << said;
    }
    if (inertia == 1e-3) {
      EXPECT_NE(said.find("must be above 0.001344"), std::string::npos) << said;
    }
    if (inertia == 1.4e-3) {
      EXPECT_EQ(said, "");
    }
  }
}

}  // namespace
}  // namespace amb_rotor
