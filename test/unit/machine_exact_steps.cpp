// Exact steps of linear machines (double and lanes) against the event-accurate stepper, and who may take them.
#include <gtest/gtest.h>

#include "../support/probe.hpp"
#include "amb_rotor/excitation/shaft_path.hpp"
#include "amb_rotor/machine/event_stepper.hpp"
#include "amb_rotor/machine/exact_stepper.hpp"
#include "amb_rotor/machine/machine_impl.hpp"

namespace amb_rotor {
namespace {

using namespace testing_support;
using ExactLanes = xsimd::batch<double>;

/// Signals and currents, row by row.
using Seen = std::vector<double>;

Scenario pulses() {
  Scenario scenario = from(constantSpeed(90.0, 0.05), {}, {});
  scenario.excitations.push_back(currentPulse(0.2, 0.03, 0.0051));
  return scenario;
}

/// From 10 um beside the centre, each lane at its own speed, under a pulse of current that ends between samples.
template <class S, class Make>
Seen runPulses(const std::vector<const Model*>& models, std::size_t lane, const std::vector<double>& speeds_hz, Make&& make,
               const ShaftPath* path = nullptr) {
  const Scenario scenario = pulses();
  const Schedule schedule(scenario.excitations, scenario.faults);
  const Machine<S> machine(models);
  Drive<S> drive;
  drive.schedule = &schedule;
  drive.path = path;
  for (std::size_t l = 0; l < ScalarTraits<S>::lanes; ++l) {
    setLane(drive.angle0, l, 0.7);
    setLane(drive.speed, l, two_pi * speeds_hz[std::min(l, speeds_hz.size() - 1)]);
  }
  const Simulator<S> sim(machine, drive, 3000.0);  // records lie between samples
  MachineState<S> state = sim.atRest(0.0);
  state.mechanics[0] = S(1e-5);
  Seen rows;
  auto stepper = make(machine);
  EXPECT_TRUE(sim.run(state, 0.06, stepper, [&](const Record<S>& seen) {
    for (int a = 0; a < 4; ++a) rows.push_back(laneValue(seen.signal[a], lane));
    for (int a = 0; a < 4; ++a) rows.push_back(1e-4 * laneValue(seen.state->current[a], lane));
  }));
  return rows;
}

Seen referenceOf(const Model& model, double speed_hz) {
  return runPulses<double>({&model}, 0, {speed_hz}, [](const Machine<double>& m) { return EventStepper(m, 1e-10); });
}

/// The steps of Runge and Kutta are so coarse that whoever took them would be seen.
template <class S>
ExactStepper<S> exact(const Machine<S>& machine) {
  return ExactStepper<S>(machine, 1.0, 1.0);
}

double furthest(const Seen& a, const Seen& b) {
  double most = a.size() == b.size() ? 0.0 : 1e300;
  for (std::size_t i = 0; i < a.size(); ++i) most = std::max(most, std::fabs(a[i] - b[i]));
  return most;
}

Model unbalanced() {
  Model model = withUnbalance(levitated(), 3e-5, 0.5, 0.02);
  model.rig.controller.delay_s = 1.37e-4;
  return model;
}

const char* const linear_effects[] = {
    "sensor_runout",         "sensor_axis_rotation", "sensor_gain_error", "shaft_bow",
    "stiffness_anisotropy",  "cross_coupled_stiffness", "internal_damping", "foundation_resonance",
    "eddy_current_lag",      "gyroscopic_coupling",  "motor_magnetic_pull", "amplifier_lag",
    "couple_unbalance",      "static_load",          "shaft_flexibility", "compliant_mount"};

bool takesExactSteps(const Model& model) {
  Drive<double> drive;
  drive.speed = 500.0;
  return ExactStepper<double>::takes(Machine<double>({&model}), drive);
}

TEST(ExactStepper, EveryLinearEffectEqualsTheEventStepper) {
  // the reference has 1e-10 of what changes in a step, over 0.06 s of decaying modes; 1 pm is 5e-9 of the clearance
  constexpr double allowed_m = 1e-12;
  for (const char* id : linear_effects) {
    const Model model = with(unbalanced(), id, typicalValues(id));
    ASSERT_TRUE(takesExactSteps(model)) << id;
    const Seen reference = referenceOf(model, 90.0);
    EXPECT_LT(furthest(reference, runPulses<double>({&model}, 0, {90.0}, exact<double>)), allowed_m) << id;
  }
}

TEST(ExactStepper, EachLaneIsItsOwnMachineAtItsOwnSpeed) {
  const Model a = with(unbalanced(), "gyroscopic_coupling", typicalValues("gyroscopic_coupling"));
  Model b = a;
  b.rig.rotor.mass_kg = 3.8;
  b.rig.amb.displacement_stiffness_N_per_m = 5e4;
  b.rig.amb.amplifier_bandwidth_hz = 900.0;
  for (std::size_t lane = 0; lane < 2; ++lane)
    EXPECT_LT(furthest(referenceOf(lane == 0 ? a : b, lane == 0 ? 90.0 : 130.0),
                       runPulses<ExactLanes>({&a, &b}, lane, {90.0, 130.0}, exact<ExactLanes>)),
              1e-12);
}

TEST(ExactStepper, AChangingSpeedIsFollowed) {
  // 80 to 120 Hz at 4200 rad/s^2: within a step of 100 us the speed changes by 0.4 rad/s, to both sides of its middle: an
  // angle of 5e-6 of the orbit's 20 um, and next to nothing from interpolation; 1.3e-10 was seen
  PiecewiseShaft path(0.7, two_pi * 80.0);
  path.rampTo(0.0, two_pi * 120.0, 0.06);
  for (const char* id : {"gyroscopic_coupling", "shaft_bow", "eddy_current_lag", "internal_damping", "couple_unbalance"}) {
    const Model model = with(unbalanced(), id, typicalValues(id));
    const Seen reference =
        runPulses<double>({&model}, 0, {0.0}, [](const Machine<double>& m) { return EventStepper(m, 1e-10); }, &path);
    EXPECT_LT(furthest(reference, runPulses<ExactLanes>({&model}, 1, {0.0}, exact<ExactLanes>, &path)), 2e-10) << id;
    EXPECT_GT(furthest(reference, referenceOf(model, 80.0)), 1e-6) << "it is another run";
  }
}

TEST(ExactStepper, OnlyLinearMachinesAreTaken) {
  for (const char* id : {"shaft_crack", "magnetic_nonlinearity", "magnetic_saturation", "spin_drag"}) {
    const Model model = with(unbalanced(), id, typicalValues(id));
    Drive<double> drive;
    drive.speed = 500.0;
    const Spin spin = std::string(id) == "spin_drag" ? Spin::drag : Spin::prescribed;
    EXPECT_FALSE(ExactStepper<double>::takes(Machine<double>({&model}, spin), drive)) << id;
  }
  // what acts in contact alone does not matter out of it
  EXPECT_TRUE(takesExactSteps(with(unbalanced(), "hertzian_contact", typicalValues("hertzian_contact"))));
}

TEST(ExactStepper, WhatItDoesNotTakeGoesByRungeAndKutta) {
  const Model model = with(unbalanced(), "magnetic_saturation", typicalValues("magnetic_saturation"));
  const auto fixed = [](const Machine<double>& m) { return LaneStepper<double>(m, 5e-5, 5e-5); };
  const auto either = [](const Machine<double>& m) { return ExactStepper<double>(m, 5e-5, 5e-5); };
  EXPECT_EQ(runPulses<double>({&model}, 0, {90.0}, fixed), runPulses<double>({&model}, 0, {90.0}, either));
}

TEST(ExactStepper, NearContactTheContactActs) {
  // thrown against the auxiliary bearing: the steps next to it are those of the lanes, touch-down and rebound included
  const Model model = unbalanced();
  const Machine<double> machine({&model});
  Drive<double> drive;
  drive.speed = 300.0;
  const Simulator<double> sim(machine, drive, 10000.0);
  std::vector<double> paths[2];
  int touching = 0;
  for (const bool exactly : {false, true}) {
    MachineState<double> state = sim.atRest(0.0);
    state.mechanics[2 * machine.rotor().modes()] = 0.25;  // m/s
    LaneStepper<double> fixed(machine, 1e-5, 1e-6);
    ExactStepper<double> exact(machine, 1.0, 1e-6);
    const auto sink = [&](const Record<double>& seen) {
      double penetration, rate;
      machine.approach(0, seen.state->mechanics.data(), penetration, rate);
      touching += penetration > 0.0;
      paths[exactly].push_back(seen.signal[0]);
    };
    ASSERT_TRUE(exactly ? sim.run(state, 0.01, exact, sink) : sim.run(state, 0.01, fixed, sink));
  }
  ASSERT_GT(touching, 2);
  EXPECT_LT(furthest(paths[0], paths[1]), 1e-10);  // RK4 of 10 us out of contact: 1e-12 a step
}

}  // namespace
}  // namespace amb_rotor
