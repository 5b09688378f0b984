// Coils behind a limited voltage: closed forms of current and slew, energy from the amplifier to the rotor, the loop.
#include <gtest/gtest.h>

#include "../support/models.hpp"
#include "../support/probe.hpp"
#include "amb_rotor/machine/bearing_response.hpp"

namespace amb_rotor {
namespace {

using namespace testing_support;
using Complex = std::complex<double>;

/// The integrator keeps currents of some A to a relative 1e-8 a step [A].
constexpr double integrated = 5e-8;
constexpr double resistance = 3.0, inductance = 0.02, voltage = 40.0;

Model coiled(Model model, double limit = voltage) {
  model.coil = CoilCircuit{resistance, inductance, limit};
  return model;
}

/// No controller, no Ks: the current's step alone drives it.
Model driven(double limit) {
  Model model = coiled(levitated(), limit);
  model.rotor_model = RotorModel::rigid_mass;
  model.rig.controller.kp_A_per_m = model.rig.controller.kd_A_s_per_m = 0.0;
  model.rig.amb.displacement_stiffness_N_per_m = 0.0;
  return model;
}

Scenario stepped(double amount_A, double duration_s, double record_rate_hz) {
  Scenario scenario = from(constantSpeed(0.0, duration_s, record_rate_hz), {0, 0}, {});
  Excitation step;
  step.kind = Excitation::Kind::current;
  step.amplitude = amount_A;
  scenario.excitations.push_back(step);
  return scenario;
}

TEST(Coil, SlewsWithVoltageOverInductanceAndRestsAtVoltageOverResistance) {
  // a rotor of 1e9 kg stands still; 2.5 A are asked of a coil to which 7.2 V above its bias never give them
  Model model = driven(resistance * 2.5 + 7.2);
  model.rig.rotor.mass_kg = 1e9;
  const double rest = 7.2, rate = resistance / inductance;
  const auto run = simulate(model, stepped(2.5, 0.02, 20000.0));
  const auto& t = run.trajectory;
  // v stays at its limit while R i + a L (c - i) > 7.2 V, that is below 2.5 A, and 7.2 V/3 ohm are 2.4 A
  for (std::size_t k = 0; k < t.time_s.size(); ++k)
    ASSERT_NEAR(t.current_A[0][k], rest / resistance * (1.0 - std::exp(-rate * t.time_s[k])), integrated) << t.time_s[k];
  // slew of the first 50 us: V/L, less half of the drop R i that has grown by then
  EXPECT_NEAR(t.current_A[0][1] / t.time_s[1], rest / inductance * (1.0 - 0.5 * rate * t.time_s[1]), 1e-3 * 360.0);
  EXPECT_EQ(t.current_A[1].back(), 0.0);
}

TEST(Coil, WithoutTheLimitItIsTheLagAndTheMotion) {
  // standing rotor: i = c (1 - exp(-a t)) as amplifier.hpp has it
  Model still = driven(1e6);
  still.rig.rotor.mass_kg = 1e9;
  const double a = two_pi * 2000.0;
  const auto run = simulate(still, stepped(1.0, 1e-3, 20000.0));
  for (std::size_t k = 0; k < run.trajectory.time_s.size(); ++k)
    ASSERT_NEAR(run.trajectory.current_A[0][k], 1.0 - std::exp(-a * run.trajectory.time_s[k]), integrated);
  // moving with v, no command: i' = -a i - Ki v/(2 L)
  Probe probe(coiled(levitated(), 1e6));
  probe.beam({0, 0, 0, 0, 0.1, 0, 0, 0});
  probe.look();
  const auto place = static_cast<std::size_t>(probe.machine.electricsOffset());
  EXPECT_NEAR(probe.rate[place], -19.0 * 0.1 / (2.0 * inductance), 1e-9);
  EXPECT_EQ(probe.rate[place + 1], 0.0);
}

TEST(Coil, EnergyFromTheAmplifierIsHeatFieldAndWork) {
  // of all coils: sum 2 v i dt = 2 R i^2 dt + L i^2 + Ki i x' dt, with the limit reached on the way; and the work is
  // the rotor's kinetic energy. Trapezoids at 1 MHz: relative (h a)^2/12 of the current's rise, 1e-5.
  const Model model = driven(resistance * 2.5 + 20.0);
  const auto run = simulate(model, stepped(1.5, 4e-3, 1e6));
  ASSERT_EQ(run.outcome.status, RunStatus::ok);
  const Machine<double> machine({&model});
  const auto& t = run.trajectory;
  double electric = 0.0, heat = 0.0, work = 0.0;
  bool limited = false, free = false;
  for (std::size_t k = 1; k < t.time_s.size(); ++k)
    for (const std::size_t axis : {0u, 2u}) {
      const double h = t.time_s[k] - t.time_s[k - 1];
      const auto power = [&](std::size_t i) {
        const double command = axis == 0 ? 1.5 : 0.0, current = t.current_A[axis][i];
        const double v = machine.electrics().coil().voltage(command, current);
        limited = limited || v >= 20.0;
        free = free || (command > 0.0 && v < 19.0);
        return 2.0 * v * current;
      };
      const double before = t.current_A[axis][k - 1], after = t.current_A[axis][k];
      electric += 0.5 * h * (power(k - 1) + power(k));
      heat += 0.5 * h * 2.0 * resistance * (before * before + after * after);
      work += 0.5 * (t.bearing_force_N[axis][k - 1] + t.bearing_force_N[axis][k]) *
              (t.position_m[axis][k] - t.position_m[axis][k - 1]);
    }
  EXPECT_TRUE(limited && free);
  double field = 0.0;
  for (const std::size_t axis : {0u, 2u}) field += inductance * t.current_A[axis].back() * t.current_A[axis].back();
  EXPECT_GT(work, 1e-3 * electric) << "the rotor was moved";
  EXPECT_NEAR(electric, heat + field + work, 1e-5 * electric);
  const double v = run.final_state.mechanics[2];
  EXPECT_NEAR(work, 0.5 * 3.36 * v * v, 1e-5 * work);
}

TEST(Coil, TheLoopHasTheResponseOfItsChain) {
  Model model = coiled(levitated(), 1e6);
  model.rotor_model = RotorModel::rigid_mass;
  const Machine<double> machine({&model});
  for (const double f : {40.0, 200.0}) {
    const double w = two_pi * f;
    Scenario scenario = constantSpeed(0.0, 0.6);
    Excitation force;
    force.waveform = Waveform::sine;
    force.amplitude = 1.0;
    force.start_hz = f;
    scenario.excitations.push_back(force);
    const auto run = simulate(model, scenario);
    std::vector<double> phase;
    for (const double t : run.trajectory.time_s) phase.push_back(w * t);
    const Complex stiffness = Complex(0.0, -1.0) / order(phase, run.trajectory.position_m[0], 1.0, 3000);
    const EquivalentBearing b = equivalentBearings(machine, 0.0, {f})[0][0];
    const Complex expected(2.0 * b.stiffness_N_per_m - 3.36 * w * w, 2.0 * w * b.damping_N_s_per_m);
    EXPECT_LT(std::abs(stiffness - expected), 2e-4 * std::abs(expected)) << f;  // images of the hold
    Model plain = model;
    plain.coil.reset();
    const Machine<double> without({&plain});
    EXPECT_GT(std::fabs(equivalentBearings(without, 0.0, {f})[0][0].stiffness_N_per_m - b.stiffness_N_per_m), 1.0)
        << "the motional voltage is seen";
  }
}

TEST(Coil, ALowVoltageLosesARotorThatAHighOneCarries) {
  const Scenario scenario = from(constantSpeed(0.0, 0.1), {1.2e-4, 0, 0, 0}, {});
  EXPECT_TRUE(simulate(coiled(levitated(), 120.0), scenario).trajectory.contacts.empty());
  EXPECT_FALSE(simulate(coiled(levitated(), resistance * 2.5 + 1.0), scenario).trajectory.contacts.empty());
}

}  // namespace
}  // namespace amb_rotor
