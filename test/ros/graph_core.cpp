// The graph's plant and partners without topics, step by step in one process, against the machine: what the
// protocol alone does to the motion.
#include <gtest/gtest.h>

#include "../support/models.hpp"
#include "amb_rotor/effects/catalogue.hpp"
#include "amb_rotor/model/model_reader.hpp"
#include "amb_rotor/model/overrides.hpp"
#include "amb_rotor/model/scenario_reader.hpp"
#include "amb_rotor/ros/partners.hpp"
#include "amb_rotor/ros/plant_core.hpp"
#include "comparison.hpp"

namespace amb_rotor {
namespace {

using namespace testing;

const std::string thesis = std::string(AMB_ROTOR_SOURCE_DIR) + "/config/thesis/";

Model thesisModel(const std::vector<EffectSetting>& effects = {}) {
  Model model = readModel(thesis + "levitation_model.yaml", effectCatalogue());
  model.effects = effects;
  return model;
}

struct GraphRun {
  Recording recording;
  std::vector<RotorState> states;
  std::uint64_t steps = 0;
};

/// @param respawn_at  step at which all partners are made anew; 0: never
GraphRun runGraph(const Model& model, const Scenario& scenario, double contact_step,
                  std::uint64_t respawn_at = 0) {
  PlantCore plant(model, scenario, 1);
  auto control = std::make_unique<ControllerPartner>(model);
  auto contact = std::make_unique<ContactPartner>(model, contact_step);
  auto injector = std::make_unique<InjectorPartner>(model, scenario);
  GraphRun run;
  run.recording.clearance = model.rig.auxiliary_bearing.clearance_m;
  std::vector<std::string> refused;
  for (;;) {
    const RotorState state = plant.state();
    if (respawn_at > 0 && state.step == respawn_at) {
      control = std::make_unique<ControllerPartner>(model);
      contact = std::make_unique<ContactPartner>(model, contact_step);
      injector = std::make_unique<InjectorPartner>(model, scenario);
    }
    const ContactForces forces = contact->answer(state);
    append(run.recording, state, forces);
    run.states.push_back(state);
    run.steps = state.step;
    if (plant.finished()) return run;
    EXPECT_TRUE(plant.advance(control->answer(state), forces, injector->answer(state, {}, refused)))
        << plant.reason();
    if (plant.reason() != "") return run;
  }
}

void compare(const Model& model, const Scenario& scenario, double contact_step, double settled_from,
             bool contact) {
  const GraphRun graph = runGraph(model, scenario, contact_step);
  const Simulation machine = simulate(model, scenario);
  ASSERT_EQ(machine.outcome.status, RunStatus::ok) << machine.outcome.reason;
  std::printf("%llu steps\n", static_cast<unsigned long long>(graph.steps));
  expectEqual(graph.recording, recordingOf(machine), model.rig.auxiliary_bearing.clearance_m,
              model.rig.auxiliary_bearing.rotor_radius_m, settled_from, contact);
}

constexpr double contact_step = 1e-5;  // [s], the node's default

TEST(GraphCore, LevitationEqualsMachine) {
  compare(thesisModel(), readScenario(thesis + "levitation.yaml"), contact_step, 0.0, false);
}

TEST(GraphCore, OverloadEqualsMachine) {
  compare(thesisModel(), readScenario(thesis + "overload.yaml"), contact_step, 0.3, true);
}

TEST(GraphCore, DropEqualsMachine) {
  compare(thesisModel(), readScenario(thesis + "drop.yaml"), contact_step, 0.1, true);
}

TEST(GraphCore, HertzianContactEqualsMachine) {
  compare(thesisModel({{"hertzian_contact", {2.4e9, 5.0}}}), readScenario(thesis + "overload.yaml"),
          contact_step, 0.3, true);
}

TEST(GraphCore, MountAndRingEqualMachine) {
  const std::vector<double> mount = {5e6, 300.0, 0.07}, ring = {1e-5, 0.005};
  compare(thesisModel({{"compliant_mount", mount}, {"inner_ring_spin", ring}}),
          readScenario(thesis + "overload.yaml"), contact_step, 0.15, true);
}

TEST(GraphCore, SetValuedFrictionEqualsMachine) {
  // a slow drop of a tilting rotor with rings: it slides, rolls and sticks
  Model model = thesisModel({{"inner_ring_spin", {1e-4, 0.001}}});
  model.friction_law = FrictionLaw::set_valued;
  model.rig.auxiliary_bearing.friction_coefficient = 0.2;
  Scenario scenario = testing_support::bearingsOff(testing_support::constantSpeed(10.0, 0.2, 5000.0), 0.01);
  scenario.speed.type = SpeedType::free;
  compare(model, scenario, contact_step, 0.05, true);
  const GraphRun run = runGraph(model, scenario, contact_step), again = runGraph(model, scenario, contact_step, 501);
  // the law is linear, so the answers are the machine's own equations: what is left are the integrators' steps
  EXPECT_LT(largestDifference(run.recording, recordingOf(simulate(model, scenario)), run.recording.time.size(),
                              model.rig.auxiliary_bearing.clearance_m), 1e-4);
  long sticking = 0, sliding = 0;
  for (std::size_t i = 0; i < run.states.size(); ++i) {
    const RotorState& state = run.states[i];
    EXPECT_EQ(state.mechanics, again.states[i].mechanics) << "respawned partners, step " << i;
    for (int end = 0; end < 2; ++end) {
      sticking += state.sliding[end] == 0;
      sliding += std::abs(state.sliding[end]) == 1;
    }
  }
  EXPECT_GT(sticking, 50);
  EXPECT_GT(sliding, 50);
}

TEST(GraphCore, AStickingRotorHoldsAgainstAForce) {
  // pressed into the bearings and pushed by less than they hold: x'' = 0, so friction is minus the push, half at each end
  Model model = testing_support::springMass(0.0, 0.0);
  model.friction_law = FrictionLaw::set_valued;
  model.rig.auxiliary_bearing.friction_coefficient = 0.2;
  model.rig.auxiliary_bearing.damping_N_s_per_m = 3000.0;
  const double down = 400.0, push = 40.0;
  model = testing_support::with(model, "static_load", {0.0, -down});
  const double seat = -model.rig.auxiliary_bearing.clearance_m - 0.5 * down / model.rig.auxiliary_bearing.stiffness_N_per_m;
  Scenario scenario = testing_support::from(testing_support::constantSpeed(0.0, 0.05, 1000.0), {0.0, seat}, {});
  Excitation force;
  force.waveform = Waveform::step;
  force.amplitude = push;
  force.start_s = 0.01;
  scenario.excitations.push_back(force);
  const GraphRun graph = runGraph(model, scenario, contact_step);
  EXPECT_LT(std::fabs(graph.states.back().mechanics[0]), 1e-10);
  EXPECT_NEAR(graph.states.back().stick_force[0], -0.5 * push, 1e-4);
}

TEST(GraphCore, AFreeSpinWithUnbalanceEqualsMachine) {
  Model model = testing_support::withUnbalance(thesisModel({{"spin_drag", {0.05, 0.0}}}), 8e-5, 1.0, -0.05);
  Scenario scenario = readScenario(thesis + "levitation.yaml");
  scenario.speed.type = SpeedType::free;
  scenario.faults.clear();
  FaultEvent blade;
  blade.type = FaultType::unbalance_step;
  blade.amount = 3e-5;
  blade.start_s = 0.05;
  scenario.faults.push_back(blade);
  scenario.duration_s = 0.3;
  const GraphRun graph = runGraph(model, scenario, contact_step);
  const Simulation machine = simulate(model, scenario);
  expectEqual(graph.recording, recordingOf(machine), 3e-4, 0.01, 0.0, false);
  const double speed = machine.final_state.mechanics.back();
  EXPECT_NEAR(graph.states.back().mechanics.back(), speed, 1e-7 * speed);
  EXPECT_GT(std::fabs(speed - radPerSecond(60.0) * std::exp(-0.05 * 0.3)), 3e-3) << "the unbalance acts on the spin";
  // one that is too great for the rotor's inertia is refused when it comes, and the run goes on
  InjectorPartner injector(model, scenario);
  std::vector<std::string> refused;
  blade.amount = 0.07;  // U^2/m = 1.46e-3 kg m2
  const Injection answer = injector.answer(graph.states.front(), {faultMessage(blade)}, refused);
  ASSERT_EQ(refused.size(), 1U);
  EXPECT_NE(refused[0].find("polar_inertia_kg_m2"), std::string::npos) << refused[0];
  EXPECT_TRUE(answer.faults.empty());
}

TEST(GraphCore, EveryEffectOfTheCatalogueEqualsMachine) {
  // through an impact with sliding
  Scenario scenario = testing_support::eventful();
  scenario.duration_s = 0.016;
  const Model bare = testing_support::eventfulModel();
  const Recording without = recordingOf(simulate(bare, scenario));
  ASSERT_LT(firstContact(without), without.time.size());
  int tried = 0;
  for (const auto& schema : effectCatalogue().all()) {
    const Model model = testing_support::with(bare, schema.id, testing_support::typicalValues(schema.id));
    const Recording graph = runGraph(model, scenario, contact_step).recording;
    const Recording machine = recordingOf(simulate(model, scenario));
    ASSERT_EQ(graph.time.size(), machine.time.size()) << schema.id;
    const double difference = largestDifference(graph, machine, machine.time.size(), bare.rig.auxiliary_bearing.clearance_m);
    const double done = largestDifference(machine, without, machine.time.size(), bare.rig.auxiliary_bearing.clearance_m);
    // what it does is there to a thousandth (Stribeck: the coefficient of the contact step's begin); 1e-6: the
    // integrators' own, multiplied by the impact
    EXPECT_LT(difference, 1e-3 * done + 1e-6) << schema.id;
    ++tried;
  }
  EXPECT_GE(tried, 28);
}

/// How a run ends in process and in the graph that leaves by tilting: sensors near the middle hold the translation, not the
/// tilt; the centre of gravity stays where it is.
void endsAlike(double air_gap_m, RunStatus status, double latest_s) {
  Model model = testing_support::levitated();
  model.rig.planes.sensor[0] = -0.02, model.rig.planes.sensor[1] = 0.02;
  model.rig.auxiliary_bearing.stiffness_N_per_m = 1.0;  // nothing in the way
  model.rig.auxiliary_bearing.damping_N_s_per_m = 0.0;
  model.rig.amb.air_gap_m = air_gap_m;
  Scenario scenario = testing_support::from(testing_support::constantSpeed(0.0, 2.0, 1000.0), {0.0, 0.0, 1e-6, 0.0}, {});
  const Simulation machine = simulate(model, scenario);
  ASSERT_EQ(machine.outcome.status, status) << machine.outcome.reason;
  PlantCore plant(model, scenario, 1);
  const ControllerPartner control(model);
  const ContactPartner contact(model, contact_step);
  InjectorPartner injector(model, scenario);
  std::vector<std::string> refused;
  bool goes_on = true;
  while (goes_on && !plant.finished()) {
    const RotorState state = plant.state();
    goes_on = plant.advance(control.answer(state), contact.answer(state), injector.answer(state, {}, refused));
  }
  EXPECT_TRUE(plant.diverged());
  const auto words = [](const std::string& reason) { return reason.substr(0, reason.find(':')); };  // behind it are numbers
  EXPECT_EQ(words(plant.reason()), words(machine.outcome.reason));
  EXPECT_LE(plant.state().time, machine.outcome.time_s + 1e-9);
  EXPECT_GT(plant.state().time, machine.outcome.time_s - latest_s);
  EXPECT_LT(std::fabs(plant.state().centre_x), 1e-3 * std::fabs(plant.state().amb_position.ax));
}

TEST(GraphCore, ARunThatLeavesByTiltingEndsAsInProcess) {
  // the graph looks at every step, a run in process at every record and ends with a slice of its length
  endsAlike(1.0, RunStatus::diverged, 0.011);
}

TEST(GraphCore, ARotorThatReachesAMagnetEndsTheRunAsInProcess) {
  endsAlike(0.75e-3, RunStatus::magnet_hit, 1.1e-4);  // at an instant: a sample of the controller
}

TEST(GraphCore, FaultsAndExcitationsEqualMachine) {
  Scenario scenario = readScenario(thesis + "levitation.yaml");
  const auto fault = [&](FaultType type, double start, double ramp, double duration, double amount) {
    FaultEvent event;
    event.type = type;
    event.start_s = start;
    event.ramp_s = ramp;
    event.duration_s = duration;
    event.amount = amount;
    scenario.faults.push_back(event);
  };
  fault(FaultType::sensor_offset, 0.0, 0.0, 0.05, 1e-5);
  fault(FaultType::unbalance_step, 0.2, 0.02, 0.1, 5e-5);
  fault(FaultType::force_impulse, 0.30005, 0.0, 0.003, 40.0);
  fault(FaultType::speed_change, 0.4, 0.05, 0.0, 80.0);
  Excitation chirp;
  chirp.kind = Excitation::Kind::current;
  chirp.waveform = Waveform::chirp;
  chirp.amplitude = 0.1;
  chirp.start_s = 0.25;
  chirp.duration_s = 0.2;
  chirp.start_hz = 20.0;
  chirp.end_hz = 300.0;
  scenario.excitations.push_back(chirp);
  const GraphRun graph = runGraph(thesisModel(), scenario, contact_step);
  const Recording machine = recordingOf(simulate(thesisModel(), scenario));
  expectEqual(graph.recording, machine, 3e-4, 0.01, 0.0, false);
  for (std::size_t i = 0; i < machine.angle.size(); ++i)
    ASSERT_NEAR(graph.recording.angle[i], machine.angle[i], 1e-9) << "at " << machine.time[i] << " s";
}

/// A controller with a memory of its own, filters of the signals, converters of fine steps, coils.
Model equippedModel() {
  Model model = thesisModel();
  auto& control = model.control;
  control.main.sections = {{SectionType::lead_lag, {400.0, 1500.0}}};
  control.decoupled = true;
  control.tilt = control.main;
  control.tilt.kp_A_per_m = 30000.0;
  control.tilt.kd_A_s_per_m = 30.0;
  // 60 Hz lie below the critical speeds: the loop's sensitivity is negative there, the correction is turned by pi
  control.unbalance_rejection = UnbalanceRejection{3.0, 3.14159, 10.0, 1000.0, 3e-4};
  model.signal_chain.anti_alias = AntiAliasFilter{2.0, 2500.0};
  model.signal_chain.ad = Converter{30.0, 1e-3};
  model.signal_chain.da = Converter{30.0, 5.0};
  model.coil = CoilCircuit{3.0, 0.02, 120.0};
  return model;
}

TEST(GraphCore, ControllerFiltersAndCoilsEqualMachine) {
  const Model model = equippedModel();
  Scenario scenario = readScenario(thesis + "levitation.yaml");
  FaultEvent offset;
  offset.type = FaultType::sensor_offset;
  offset.start_s = 0.1;
  offset.ramp_s = 0.01;
  offset.amount = 1e-5;
  scenario.faults.push_back(offset);
  compare(model, scenario, contact_step, 0.0, false);
  const GraphRun run = runGraph(model, scenario, contact_step);
  EXPECT_FALSE(run.states.back().control_state.empty());
  EXPECT_GT(largestDifference(run.recording, recordingOf(simulate(thesisModel(), scenario)),
                              run.recording.time.size(), 3e-4),
            displacement_tolerance)
      << "it is another machine";
}

TEST(GraphCore, RespawnedControllersRememberNothingOfTheirOwn) {
  Scenario scenario = readScenario(thesis + "levitation.yaml");
  scenario.duration_s = 0.1;
  const GraphRun one = runGraph(equippedModel(), scenario, contact_step);
  const GraphRun two = runGraph(equippedModel(), scenario, contact_step, 301);
  ASSERT_EQ(one.states.size(), two.states.size());
  for (std::size_t i = 0; i < one.states.size(); ++i)
    ASSERT_EQ(one.states[i].mechanics, two.states[i].mechanics) << "step " << i;
}

TEST(GraphCore, RespawnedPartnersChangeNothing) {
  Scenario scenario = readScenario(thesis + "overload.yaml");
  scenario.duration_s = 0.2;
  const GraphRun one = runGraph(thesisModel(), scenario, contact_step);
  const GraphRun two = runGraph(thesisModel(), scenario, contact_step, 1501);
  ASSERT_EQ(one.states.size(), two.states.size());
  for (std::size_t i = 0; i < one.states.size(); ++i)
    ASSERT_EQ(one.states[i].mechanics, two.states[i].mechanics) << "step " << i;
}

TEST(GraphCore, TheComparisonSeesAnotherMachine) {
  Scenario scenario = readScenario(thesis + "levitation.yaml");
  Model other = thesisModel();
  applyOverride(other, "rig.controller.kp_A_per_m=33000", effectCatalogue());
  const Recording graph = runGraph(other, scenario, contact_step).recording;
  const Recording machine = recordingOf(simulate(thesisModel(), scenario));
  EXPECT_GT(largestDifference(graph, machine, machine.time.size(), 3e-4), displacement_tolerance / 5);
}

}  // namespace
}  // namespace amb_rotor

int main(int argc, char** argv) {
  ::testing::InitGoogleTest(&argc, argv);
  return RUN_ALL_TESTS();
}
