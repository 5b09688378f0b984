// Anti-alias filter and converters in the machine: closed forms, the loop, and nothing where they are off.
#include <gtest/gtest.h>

#include "../support/models.hpp"
#include "amb_rotor/machine/bearing_response.hpp"

namespace amb_rotor {
namespace {

using namespace testing_support;
using Complex = std::complex<double>;

Model filteredBy(Model model, double order, double corner_hz) {
  model.signal_chain.anti_alias = AntiAliasFilter{order, corner_hz};
  return model;
}

/// A sensor's step seen behind the filter, rotor at rest, at t after it.
double stepBehindFilter(double order, double corner_hz, double t) {
  Model model = filteredBy(levitated(), order, corner_hz);
  model.rig.controller.kp_A_per_m = model.rig.controller.kd_A_s_per_m = 0.0;
  model.rig.amb.displacement_stiffness_N_per_m = 0.0;
  Scenario scenario = from(constantSpeed(0.0, 0.01 + t), {0, 0, 0, 0}, {});
  FaultEvent step;
  step.type = FaultType::sensor_offset;
  step.start_s = 0.01;
  step.amount = 2e-5;
  scenario.faults.push_back(step);
  const auto run = simulate(model, scenario);
  EXPECT_EQ(run.outcome.status, RunStatus::ok);
  EXPECT_EQ(run.trajectory.displacement_m[0].back(), 2e-5) << "the sensor itself shows the step";
  const Machine<double> machine({&model});
  double signal[4] = {0, 0, 0, 0};
  machine.electrics().filtered(run.final_state.mechanics.data() + machine.electricsOffset(), signal);
  return signal[0];
}

TEST(AntiAliasFilter, StepsAsItsClosedForm) {
  const double w = two_pi * 300.0, r = std::sqrt(0.5);
  for (const double t : {2e-4, 1e-3, 3e-3}) {
    // integrated to a relative 1e-8 of 1e-3 (the absolute scale of these states), so 1e-11 m of 2e-5
    EXPECT_NEAR(stepBehindFilter(1.0, 300.0, t), 2e-5 * (1.0 - std::exp(-w * t)), 2e-11);
    const double second = 1.0 - std::exp(-r * w * t) * (std::cos(r * w * t) + std::sin(r * w * t));
    EXPECT_NEAR(stepBehindFilter(2.0, 300.0, t), 2e-5 * second, 2e-11);
  }
}

/// Complex displacement of the centre under a sine of 1 N at it.
Complex chainResponse(const Model& model, double frequency_hz) {
  Scenario scenario = constantSpeed(0.0, 0.6);
  Excitation force;
  force.waveform = Waveform::sine;
  force.amplitude = 1.0;
  force.start_hz = frequency_hz;
  scenario.excitations.push_back(force);
  const auto run = simulate(model, scenario);
  EXPECT_EQ(run.outcome.status, RunStatus::ok);
  std::vector<double> phase;
  for (const double t : run.trajectory.time_s) phase.push_back(two_pi * frequency_hz * t);
  return order(phase, run.trajectory.position_m[0], 1.0, 3000);
}

TEST(AntiAliasFilter, TheLoopHasTheResponseOfItsChain) {
  for (const double filter_order : {1.0, 2.0}) {
    Model model = filteredBy(levitated(), filter_order, 2500.0);
    model.rotor_model = RotorModel::rigid_mass;
    const Machine<double> machine({&model});
    for (const double f : {40.0, 200.0}) {
      const double w = two_pi * f;
      const EquivalentBearing b = equivalentBearings(machine, 0.0, {f})[0][0];
      const Complex stiffness = Complex(0.0, -1.0) / chainResponse(model, f);
      const Complex expected(2.0 * b.stiffness_N_per_m - 3.36 * w * w, 2.0 * w * b.damping_N_s_per_m);
      // as without a filter (bearing_equivalent_stiffness.cpp): images of the hold
      EXPECT_LT(std::abs(stiffness - expected), 2e-4 * std::abs(expected)) << f << " Hz, order " << filter_order;
    }
  }
  const Model slow = filteredBy(levitated(), 1.0, 300.0), fast = levitated();
  const Machine<double> a({&slow}), b({&fast});
  EXPECT_LT(equivalentBearings(a, 0.0, {60.0})[0][0].damping_N_s_per_m,
            equivalentBearings(b, 0.0, {60.0})[0][0].damping_N_s_per_m - 50.0)
      << "a slow filter costs damping";
}

TEST(SignalChain, CommandsAndSamplesAreOnTheirGrids) {
  Model model = levitated();
  model.signal_chain.ad = Converter{10.0, 0.3e-3};
  model.signal_chain.da = Converter{9.0, 4.0};
  const auto run = simulate(model, from(constantSpeed(0.0, 0.002), {3e-5, -1e-5, 1e-4, 0.0}, {}));
  const double signal_step = 0.6e-3 / 1024.0, current_step = 8.0 / 512.0;
  const auto& state = run.final_state;
  ASSERT_NE(state.command[0], 0.0);
  for (int a = 0; a < 4; ++a) {
    EXPECT_NEAR(std::remainder(state.command[a], current_step), 0.0, 1e-12);
    EXPECT_NEAR(std::remainder(state.controller[a].previous_signal, signal_step), 0.0, 1e-15);
  }
}

TEST(SignalChain, CoarseStepsKeepTheRotorInALimitCycleAndFineOnesDoNot) {
  // a step q of the AD is a play: without noise the loop hunts within some q of the centre
  double left[2];
  for (int fine = 0; fine < 2; ++fine) {
    Model model = levitated();
    model.signal_chain.ad = Converter{fine != 0 ? 24.0 : 9.0, 0.3e-3};
    const auto run = simulate(model, from(constantSpeed(0.0, 0.6), {3e-5, 0, 0, 0}, {}));
    ASSERT_EQ(run.outcome.status, RunStatus::ok);
    left[fine] = largest(run.trajectory.position_m[0], 5000);
  }
  const double q = 0.6e-3 / 512.0;
  EXPECT_GT(left[0], 0.05 * q);
  EXPECT_LT(left[0], 3.0 * q);
  EXPECT_LT(left[1], 1e-3 * left[0]);
}

TEST(SignalChain, AClippedSignalLosesTheRotor) {
  Model model = levitated();
  const Scenario scenario = from(constantSpeed(0.0, 0.05), {1e-4, 0, 0, 0}, {});
  EXPECT_TRUE(simulate(model, scenario).trajectory.contacts.empty());
  model.signal_chain.ad = Converter{14.0, 2e-5};  // 0.02 mm: Ki kp 2e-5 m is less than Ks 1e-4 m
  EXPECT_FALSE(simulate(model, scenario).trajectory.contacts.empty());
}

}  // namespace
}  // namespace amb_rotor
