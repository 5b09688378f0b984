// The lane stepper (double and lanes of the baseline instruction set) against the event-accurate stepper.
#include <gtest/gtest.h>

#include "../support/probe.hpp"
#include "amb_rotor/excitation/shaft_path.hpp"
#include "amb_rotor/machine/event_stepper.hpp"
#include "amb_rotor/machine/lane_stepper.hpp"
#include "amb_rotor/machine/machine_impl.hpp"
#include "amb_rotor/machine/model_loading.hpp"

namespace amb_rotor {

using BaselineLanes = xsimd::batch<double>;
template class Machine<BaselineLanes>;

namespace {

using namespace testing_support;

constexpr double machine_clearance = 0.2e-3;

struct Rows {
  std::vector<double> signal[4], current[4], contact_a;
  long touching = 0;
};

template <class S, class Stepper>
Rows runWith(const std::vector<const Model*>& models, std::size_t lane, const Scenario& scenario,
             Stepper&& make) {
  const Schedule schedule(scenario.excitations, scenario.faults);
  const PiecewiseShaft path = shaftPath(scenario);
  const Machine<S> machine(models, spinOf(*models[0], scenario), {schedule.forcePlanes(), schedule.unbalances()});
  Drive<S> drive;
  drive.path = &path;
  drive.schedule = &schedule;
  const Simulator<S> sim(machine, drive, scenario.record_rate_hz);
  MachineState<S> state = sim.atRest(0.0);
  const int n = machine.rotor().modes();
  for (std::size_t i = 0; i < scenario.initial_displacement_m.size(); ++i)
    state.mechanics[(i % 2) * n + i / 2] = S(scenario.initial_displacement_m[i]);
  for (std::size_t i = 0; i < scenario.initial_velocity_m_s.size(); ++i)
    state.mechanics[2 * n + (i % 2) * n + i / 2] = S(scenario.initial_velocity_m_s[i]);
  Rows rows;
  auto stepper = make(machine);
  EXPECT_TRUE(sim.run(state, scenario.duration_s, stepper, [&](const Record<S>& seen) {
    for (int a = 0; a < 4; ++a) {
      rows.signal[a].push_back(laneValue(seen.signal[a], lane));
      rows.current[a].push_back(laneValue(seen.state->current[a], lane));
    }
    S penetration = S(0.0), rate = S(0.0);
    machine.approach(0, seen.state->mechanics.data(), penetration, rate);
    if (laneValue(penetration, lane) > 0.0) ++rows.touching;
    rows.contact_a.push_back(laneValue(penetration, lane));
  }));
  return rows;
}

Rows byEvents(const Model& model, const Scenario& scenario) {
  return runWith<double>({&model}, 0, scenario, [](const Machine<double>& m) { return EventStepper(m); });
}
template <class S>
Rows byLanes(const std::vector<const Model*>& models, std::size_t lane, const Scenario& scenario,
             double step) {
  return runWith<S>(models, lane, scenario,
                    [&](const Machine<S>& m) { return LaneStepper<S>(m, step, step); });
}

double apart(const Rows& a, const Rows& b) {
  double most = 0.0;
  for (int axis = 0; axis < 4; ++axis)
    for (std::size_t i = 0; i < a.signal[axis].size(); ++i)
      most = std::max(most, std::fabs(a.signal[axis][i] - b.signal[axis][i]));
  return most;
}

/// Levitation under everything that the schedule can do without contact.
Scenario levitation() {
  Scenario scenario = from(constantSpeed(90.0, 0.05), {1e-5, 0.0, 1e-4, -5e-5}, {});
  Excitation force;
  force.waveform = Waveform::step;
  force.amplitude = 6.0;
  force.plane_z_m = 0.03;
  force.start_s = 0.0101;
  force.duration_s = 0.01;
  scenario.excitations.push_back(force);
  force.waveform = Waveform::impulse;
  force.amplitude = 20.0;
  force.direction_rad = 1.0;
  force.start_s = 0.025;
  force.duration_s = 0.004;
  scenario.excitations.push_back(force);
  scenario.excitations.push_back(currentPulse(0.2, 0.03, 0.005));
  return scenario;
}

Model heavy() { return withUnbalance(levitated(), 3e-5, 0.5, 0.02); }

TEST(MachineLanes, LevitationEqualsTheEventStepper) {
  const Model model = heavy();
  const Rows reference = byEvents(model, levitation());
  ASSERT_EQ(reference.touching, 0);
  // RK4 of 50 us: (w h)^5/120 a step at 2000 rad/s; asked for: 1e-6 of the clearance
  EXPECT_LT(apart(reference, byLanes<double>({&model}, 0, levitation(), 5e-5)), 1e-6 * machine_clearance);
  EXPECT_LT(apart(reference, byLanes<BaselineLanes>({&model}, 0, levitation(), 5e-5)),
            1e-6 * machine_clearance);
}

TEST(MachineLanes, EffectsOfEveryPortEqualTheEventStepper) {
  std::vector<Model> models;
  for (const char* id :
       {"sensor_runout", "sensor_axis_rotation", "shaft_bow", "shaft_crack", "stiffness_anisotropy",
        "cross_coupled_stiffness", "internal_damping", "foundation_resonance", "magnetic_nonlinearity",
        "magnetic_saturation", "eddy_current_lag", "control_delay", "gyroscopic_coupling",
        "motor_magnetic_pull", "current_saturation", "amplifier_lag"})
    models.push_back(with(heavy(), id, typicalValues(id)));
  for (const Model& model : models) {
    const Rows reference = byEvents(model, levitation());
    ASSERT_EQ(reference.touching, 0) << model.effects[0].id;
    // the fastest of the eddy-current lags is over within the first stage behind each command: order 1 there
    const double bound = model.effects[0].id == "eddy_current_lag" ? 2e-6 : 1e-6;
    EXPECT_LT(apart(reference, byLanes<BaselineLanes>({&model}, 0, levitation(), 2.5e-5)),
              bound * machine_clearance)
        << model.effects[0].id;
  }
}

/// Everything that a controller, a signal chain and coils may have, but the steps of the converters.
Model equipped() {
  Model model = heavy();
  auto& control = model.control;
  control.main.sections = {{SectionType::lead_lag, {400.0, 1500.0}}, {SectionType::notch, {2971.0, 0.02, 0.2}}};
  control.decoupled = true;
  control.tilt = control.main;
  control.tilt.kp_A_per_m = 13000.0;
  control.tilt.kd_A_s_per_m = 15.0;
  control.unbalance_rejection = UnbalanceRejection{3.0, 0.2, 20.0, 2000.0, 2e-4};
  model.signal_chain.anti_alias = AntiAliasFilter{2.0, 3000.0};
  model.coil = CoilCircuit{3.0, 0.02, 60.0};
  return model;
}

TEST(MachineLanes, ControllersFiltersAndCoilsEqualTheEventStepper) {
  const Model model = equipped();
  const Rows reference = byEvents(model, levitation());
  ASSERT_EQ(reference.touching, 0);
  ASSERT_GT(largest(reference.current[0]), 0.1);
  // RK4 of 10 us of a filter and an amplifier of 2e4 rad/s: (w h)^5/120 = 3e-6 of what changes in a step
  EXPECT_LT(apart(reference, byLanes<BaselineLanes>({&model}, 0, levitation(), 1e-5)),
            1e-5 * machine_clearance);
  EXPECT_GT(apart(reference, byEvents(heavy(), levitation())), 1e-3 * machine_clearance)
      << "it is another machine";
}

TEST(MachineLanes, LanesOfDifferentOptionsAreRefused) {
  const Model a = equipped();
  Model b = equipped();
  b.control.tilt.kp_A_per_m = 13001.0;
  EXPECT_THROW((Machine<BaselineLanes>({&a, &b})), InvariantError);
}

TEST(MachineLanes, EachLaneIsItsOwnMachine) {
  ASSERT_GE(ScalarTraits<BaselineLanes>::lanes, 2u);
  const Model a = heavy();
  Model b = heavy();
  b.rig.rotor.mass_kg = 3.8;
  b.rig.amb.displacement_stiffness_N_per_m = 5e4;
  b.rig.unbalance[0].phase_rad = -1.0;
  for (std::size_t lane = 0; lane < 2; ++lane) {
    const Rows reference = byEvents(lane == 0 ? a : b, levitation());
    EXPECT_LT(apart(reference, byLanes<BaselineLanes>({&a, &b}, lane, levitation(), 5e-5)),
              1e-6 * machine_clearance);
  }
}

TEST(MachineLanes, ShortRubEqualsTheEventStepper) {
  // one impact and its rebound: the masks find touch-down to a fraction of a step
  Model model = levitated();
  Scenario scenario = from(constantSpeed(40.0, 0.02), {0.0, 0.0, 0.0, 0.0}, {});
  Excitation impact;
  impact.waveform = Waveform::impulse;
  impact.amplitude = 400.0;
  impact.direction_rad = 0.4;
  impact.start_s = 0.001;
  impact.duration_s = 0.003;
  scenario.excitations.push_back(impact);
  const Rows reference = byEvents(model, scenario);
  ASSERT_GT(reference.touching, 2);
  const Rows lanes = byLanes<BaselineLanes>({&model}, 0, scenario, 2e-6);
  EXPECT_LT(apart(reference, lanes), 1e-3 * machine_clearance);
  EXPECT_NEAR(lanes.touching, reference.touching, 1);
  // halving the step twice must at least halve the difference: order 1 or better through contact
  const Rows finer = byLanes<BaselineLanes>({&model}, 0, scenario, 0.5e-6);
  EXPECT_LT(apart(reference, finer), 0.5 * apart(reference, lanes));
}

TEST(MachineLanes, EveryEffectOfTheCatalogueIsThatOfTheEventStepper) {
  // Through an impact with sliding, in steps of 1 us: touch-down is met to 1/64 of a step, the friction's kink at v = 0 to
  // a step, and the impact of 600 N makes more of both. The lanes have what an effect does to 5 % of it; most to 1 %.
  Scenario scenario = eventful();
  scenario.duration_s = 0.016;
  const Rows without = byEvents(eventfulModel(), scenario);
  ASSERT_GT(without.touching, 2);
  int tried = 0;
  for (const auto& schema : effectCatalogue().all()) {
    const Model model = with(eventfulModel(), schema.id, typicalValues(schema.id));
    const Rows reference = byEvents(model, scenario);
    const Rows lanes = byLanes<BaselineLanes>({&model}, 0, scenario, 1e-6);
    EXPECT_LT(apart(reference, lanes), 2e-3 * machine_clearance) << schema.id;
    if (schema.id == "spin_drag") continue;  // acts on the speed: HeldSpeedOfARunInIsKept
    EXPECT_LT(apart(reference, lanes), 0.05 * apart(reference, without)) << schema.id;
    ++tried;
  }
  EXPECT_GE(tried, 28);
}

TEST(MachineLanes, HeldSpeedOfARunInIsKept) {
  // spin_drag makes the speed a state; a run-in keeps it all the same
  const Model model = with(heavy(), "spin_drag", {0.5, 0.0});
  const Machine<BaselineLanes> machine({&model}, Spin::drag);
  Drive<BaselineLanes> drive;
  drive.speed = BaselineLanes(300.0);
  for (bool hold : {true, false}) {
    drive.hold_speed = hold;
    const Simulator<BaselineLanes> sim(machine, drive, 1000.0);
    MachineState<BaselineLanes> state = sim.atRest(0.0);
    LaneStepper<BaselineLanes> stepper(machine, 5e-5, 5e-5);
    ASSERT_TRUE(sim.run(state, 0.1, stepper, [](const Record<BaselineLanes>&) {}));
    // RK4 of a slow exponential: to rounding
    EXPECT_NEAR(laneValue(state.mechanics.back(), 0), hold ? 300.0 : 300.0 * std::exp(-0.05), 1e-9);
  }
}

TEST(MachineLanes, AFreeSpinFeelsTheUnbalanceInEveryLane) {
  std::vector<Model> models;
  std::vector<const Model*> lanes;
  for (std::size_t lane = 0; lane < ScalarTraits<BaselineLanes>::lanes; ++lane) {
    Model model = withUnbalance(withUnbalance(springBeam(2e5, 150.0), 1e-3 * (lane + 1.0), 0.4, 0.03), 5e-4, 2.0, -0.05);
    model.rig.rotor.polar_inertia_kg_m2 = 1e-3 * (1.0 + 0.5 * lane);
    model.rig.gravity_m_s2 = 9.81;
    model = with(model, "internal_damping", {30.0, 0.02});
    models.push_back(with(model, "shaft_flexibility", typicalValues("shaft_flexibility")));
  }
  for (const Model& model : models) lanes.push_back(&model);
  const Machine<BaselineLanes> together(lanes, Spin::free);
  const int n = together.stateSize();
  std::vector<double> state(n);
  for (int i = 0; i < n; ++i) state[i] = (i < together.coordinates() ? 1e-5 : 1e-2) * std::sin(1.0 + 7.0 * i);
  state[n - 1] = 80.0;
  std::vector<BaselineLanes> packed(state.begin(), state.end()), rates(n, BaselineLanes(0.0));
  together.derivatives(Inputs<BaselineLanes>(), packed.data(), rates.data());
  for (std::size_t lane = 0; lane < models.size(); ++lane) {
    Probe one(models[lane], Spin::free);
    one.y = state;
    one.look();
    for (int i = 0; i < n; ++i)
      EXPECT_NEAR(laneValue(rates[i], lane), one.rate[i], 1e-12 * (1.0 + std::fabs(one.rate[i]))) << i;
    EXPECT_GT(std::fabs(one.rate[n - 1]), 1.0) << "the unbalance acts on the spin";
    EXPECT_EQ(one.seen.shaft.acceleration, one.rate[n - 1]);
    one.machine.observe(one.in, one.y.data(), nullptr, one.seen);
    EXPECT_EQ(one.seen.shaft.acceleration, one.rate[n - 1]) << "also where only looked at";
  }
}

TEST(MachineLanes, ForcesEndAtTheirInstantAlsoInALongStep) {
  // a step force that ends with a step must not leak into the last stage of RK4
  const Model model = levitated();
  Scenario scenario = from(constantSpeed(0.0, 0.01), {0.0, 0.0, 0.0, 0.0}, {});
  Excitation force;
  force.waveform = Waveform::step;
  force.amplitude = 10.0;
  force.start_s = 0.001;
  force.duration_s = 0.002;
  scenario.excitations.push_back(force);
  // a leak into one stage of six would be F h/(6 m), 5e-5 m/s, and show as 1e-7 m; the amplifier's lag leaves
  // 3e-10 m
  EXPECT_LT(apart(byEvents(model, scenario), byLanes<double>({&model}, 0, scenario, 1e-4)), 1e-9);
}

TEST(MachineLanes, AFlexibleRotorHasThePlanesOfEachLane) {
  Model near = loadModel(AMB_ROTOR_SOURCE_DIR "/config/thesis/flexible_model.yaml");
  near.effects.push_back({"motor_magnetic_pull", {1e5, -0.1}});
  Model far = near;
  far.effects[0].values[1] = 0.1;
  far.rig.planes.amb[1] = 0.08;
  const std::vector<const Model*> models{&near, &far};
  const Machine<BaselineLanes> lanes(models);
  for (std::size_t lane = 0; lane < models.size(); ++lane) {
    const Machine<double> alone({models[lane]});
    ASSERT_EQ(alone.rotor().planes(), lanes.rotor().planes());
    for (int p = 0; p < alone.rotor().planes(); ++p)
      for (int k = 0; k < alone.rotor().modes(); ++k)
        EXPECT_EQ(laneValue(lanes.rotor().shape(p, k), lane), alone.rotor().shape(p, k)) << lane << " " << p << " " << k;
  }
}

}  // namespace
}  // namespace amb_rotor
