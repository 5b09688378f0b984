// The thesis's flexible rotor (31 nodes, 62 modes a plane, none left out) on its sampled magnetic bearings,
// and the same rotor with 24 modes (12 a plane) rubbing, in modal coordinates (machine/modal_stepper.hpp).
// And what `amb simulate` makes of the first of them: settled, recorded at every sample.
// Counters: simulated seconds a second, steps, and the error of the ends' places over the clearance against
// the event stepper over a shorter run.
#include <benchmark/benchmark.h>

#include <cmath>
#include <string>

#include "amb_rotor/common/check.hpp"
#include "amb_rotor/effects/catalogue.hpp"
#include "amb_rotor/machine/assembly.hpp"
#include "amb_rotor/machine/modal_stepper.hpp"
#include "amb_rotor/machine/model_loading.hpp"
#include "amb_rotor/machine/run.hpp"
#include "amb_rotor/model/model_reader.hpp"

namespace amb_rotor {
namespace {

/// @param modes  a plane; 0: all
Model rotor(std::size_t modes, double moment_kg_m) {
  Model model = readModel(AMB_ROTOR_SOURCE_DIR "/config/thesis/flexible_model.yaml", effectCatalogue());
  fillFlexibleModes(model, 1e12);
  model.rig.unbalance[0].moment_kg_m = moment_kg_m;
  FlexibleModes& all = model.flexible;
  const std::size_t n = all.mass.size();
  if (modes == 0 || modes >= n) return model;
  std::vector<double> gyroscopic, shape;
  for (std::size_t k = 0; k < modes; ++k)
    for (std::size_t l = 0; l < modes; ++l) gyroscopic.push_back(all.gyroscopic[k * n + l]);
  for (std::size_t i = 0; i < all.z_m.size(); ++i)
    for (std::size_t k = 0; k < modes; ++k) shape.push_back(all.shape[i * n + k]);
  all.gyroscopic = gyroscopic;
  all.shape = shape;
  all.mass.resize(modes);
  all.stiffness.resize(modes);
  all.damping.resize(modes);
  return model;
}

struct Setting {
  Model model;
  Machine<double> machine;
  Drive<double> drive;
  Setting(std::size_t modes, double moment, double speed_hz)
      : model(rotor(modes, moment)), machine({&model}) {
    drive.speed = two_pi * speed_hz;
  }
  template <class Stepper>
  MachineState<double> run(double length_s, Stepper& stepper) const {
    const Simulator<double> sim(machine, drive, 0.0);
    MachineState<double> state = sim.atRest(0.0);
    AMB_ROTOR_CHECK(sim.run(state, length_s, stepper, [](const Record<double>&) {}),
                    stepper.result().reason());
    return state;
  }
  double error(const MachineState<double>& a, const MachineState<double>& b) const {
    double most = 0.0;
    for (int e = 0; e < 2; ++e) {
      const Vec2<double> d = machine.rotor().at(plane_aux + e, a.mechanics.data()) -
                             machine.rotor().at(plane_aux + e, b.mechanics.data());
      most = std::max(most, std::hypot(d.x, d.y));
    }
    return most / machine.rig().auxiliary_bearing.clearance_m;
  }
};

void levitated(benchmark::State& state) {
  constexpr double length_s = 0.1, compared_s = 4e-4;
  const Setting setting(0, 1e-5, 100.0);
  ModalStepper stepper(setting.machine, 1e-9);
  setting.run(compared_s, stepper);  // reads the machine's equations, once a machine
  for (auto _ : state) {
    auto end = setting.run(length_s, stepper);
    benchmark::DoNotOptimize(end.mechanics.data());
  }
  AMB_ROTOR_CHECK(stepper.reason().empty(), stepper.reason());
  state.counters["times_real_time"] =
      benchmark::Counter(length_s, benchmark::Counter::kIsIterationInvariantRate);
  EventStepper exact(setting.machine, 1e-10);
  state.counters["error"] = setting.error(setting.run(compared_s, stepper), setting.run(compared_s, exact));
  state.counters["modes"] = 2.0 * setting.machine.rotor().modes();
}
BENCHMARK(levitated)->Name("levitated_unreduced");

/// The same rotor through simulate(), which `amb simulate` calls: the machine is read, run in for 0.1 s and recorded.
void simulated(benchmark::State& state) {
  const Model model = rotor(0, 1e-5);
  Scenario scenario;
  scenario.duration_s = 2.0;
  scenario.record_rate_hz = 5000.0;
  scenario.speed.start_hz = 100.0;
  RunOptions options;
  options.settle_s = 0.1;
  for (auto _ : state) {
    const Simulation run = simulate(model, scenario, options);
    AMB_ROTOR_CHECK(run.outcome.path == "modal coordinates", run.outcome.path);
    benchmark::DoNotOptimize(run.trajectory.time_s.data());
  }
  state.counters["times_real_time"] =
      benchmark::Counter(scenario.duration_s, benchmark::Counter::kIsIterationInvariantRate);
  state.counters["modes"] = 2.0 * static_cast<double>(model.flexible.mass.size());
}
BENCHMARK(simulated)->Name("amb_simulate_unreduced");

void rubbing(benchmark::State& state) {
  constexpr double length_s = 0.1, compared_s = 0.01;
  const Setting setting(12, 1.5e-3, 110.0);
  ModalStepper stepper(setting.machine, 1e-6);
  setting.run(1e-3, stepper);
  long steps = 0, events = 0;
  for (auto _ : state) {
    const auto before = stepper.statistics();
    auto end = setting.run(length_s, stepper);
    benchmark::DoNotOptimize(end.mechanics.data());
    const auto after = stepper.statistics();
    steps = after.steps - before.steps;
    events = after.events - before.events;
  }
  AMB_ROTOR_CHECK(stepper.reason().empty(), stepper.reason());
  AMB_ROTOR_CHECK(events > 0, "it is to rub");
  state.counters["times_real_time"] =
      benchmark::Counter(length_s, benchmark::Counter::kIsIterationInvariantRate);
  state.counters["steps"] = static_cast<double>(steps);
  state.counters["events"] = static_cast<double>(events);
  state.SetItemsProcessed(state.iterations() * steps);
  EventStepper exact(setting.machine, 1e-10);
  state.counters["error"] = setting.error(setting.run(compared_s, stepper), setting.run(compared_s, exact));
  state.counters["modes"] = 2.0 * setting.machine.rotor().modes();
}
BENCHMARK(rubbing)->Name("rubbing_24_modes");

}  // namespace
}  // namespace amb_rotor
