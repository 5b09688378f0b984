// How the cost grows with the number of machines, nodes of the shaft, modes, effects, and with the length of
// a run. A row is growth/QUANTITY; its counter `size` is how many.
#include <benchmark/benchmark.h>

#include <cmath>
#include <string>
#include <vector>

#include "amb_rotor/common/check.hpp"
#include "amb_rotor/common/units.hpp"
#include "amb_rotor/effects/catalogue.hpp"
#include "amb_rotor/machine/assembly.hpp"
#include "amb_rotor/machine/basic_lanes.hpp"
#include "amb_rotor/machine/machine.hpp"
#include "amb_rotor/machine/modal_stepper.hpp"
#include "amb_rotor/machine/model_loading.hpp"
#include "amb_rotor/machine/run.hpp"
#include "amb_rotor/model/model_reader.hpp"
#include "amb_rotor/model/model_rules.hpp"
#include "amb_rotor/rotor/flexible_rotor.hpp"
#include "amb_rotor/rotor/reduction.hpp"
#include "amb_rotor/rotor/rotor_geometry.hpp"

namespace amb_rotor {
namespace {

const std::string thesis = AMB_ROTOR_SOURCE_DIR "/config/thesis/";

/// One turn of 200 steps of n basic models in lanes, one core.
void machines(benchmark::State& state, std::size_t n) {
  std::vector<BasicParameters<double>> parameters(n);
  for (std::size_t i = 0; i < n; ++i) parameters[i].frequency_ratio = 0.9 + 0.5 * static_cast<double>(i) / n;
  BasicLaneOptions options;
  options.turns_skipped = 1;
  options.turns_kept = 0;
  options.threads = 1;
  const std::vector<BasicState<double>> start{{1.0, 0.0, 0.0, 0.0}};
  for (auto _ : state) benchmark::DoNotOptimize(runBasicLanes(parameters, start, options).machine_steps);
}

/// From a geometry of n nodes (the thesis's shaft, as long, of one diameter) to its modes: elements,
/// assembly, eigenvalue problem.
void nodes(benchmark::State& state, int n) {
  RotorGeometry geometry = loadRotorGeometry(thesis + "rotor.yaml");
  ShaftSection section = geometry.sections.front();
  section.length = geometry.length();
  geometry.sections = {section};
  geometry.rings.clear();
  geometry.max_element_length = section.length / (n - 1) * (1.0 + 1e-9);
  AMB_ROTOR_CHECK(FlexibleRotor(geometry).freedoms() == 2 * n, "the shaft is to have so many nodes");
  for (auto _ : state) benchmark::DoNotOptimize(allModes(FlexibleRotor(geometry)).modes);
}

/// 0.1 s of the levitated flexible rotor with n modes a plane, in modal coordinates.
void modes(benchmark::State& state, std::size_t n) {
  Model model = readModel(thesis + "flexible_model.yaml", effectCatalogue());
  fillFlexibleModes(model, 1e12);
  FlexibleModes& all = model.flexible;
  const std::size_t every = all.mass.size();
  AMB_ROTOR_CHECK(n <= every, "so many modes are not there");
  std::vector<double> gyroscopic, shape;
  for (std::size_t k = 0; k < n; ++k)
    for (std::size_t l = 0; l < n; ++l) gyroscopic.push_back(all.gyroscopic[k * every + l]);
  for (std::size_t i = 0; i < all.z_m.size(); ++i)
    for (std::size_t k = 0; k < n; ++k) shape.push_back(all.shape[i * every + k]);
  all.gyroscopic = gyroscopic;
  all.shape = shape;
  all.mass.resize(n);
  all.stiffness.resize(n);
  all.damping.resize(n);
  const Machine<double> machine({&model});
  Drive<double> drive;
  drive.speed = two_pi * 100.0;
  const Simulator<double> sim(machine, drive, 0.0);
  ModalStepper stepper(machine, 1e-8);
  const auto run = [&](double length_s) {
    MachineState<double> end = sim.atRest(0.0);
    AMB_ROTOR_CHECK(sim.run(end, length_s, stepper, [](const Record<double>&) {}), stepper.result().reason());
    return end.mechanics[0];
  };
  run(1e-3);  // reads the machine's equations
  for (auto _ : state) benchmark::DoNotOptimize(run(0.1));
  AMB_ROTOR_CHECK(stepper.reason().empty(), stepper.reason());
}

/// The first n effects of the catalogue that go together, on the levitated rigid beam.
Model withEffects(int n) {
  Model model = readModel(thesis + "levitation_model.yaml", effectCatalogue());
  model.effects.clear();
  for (const auto& schema : effectCatalogue().all()) {
    if (static_cast<int>(model.effects.size()) == n) return model;
    EffectSetting setting;
    setting.id = schema.id;
    for (const auto& parameter : schema.parameters) setting.values.push_back(parameter.typical);
    model.effects.push_back(setting);
    if (!checkModel(model, effectCatalogue()).empty()) model.effects.pop_back();
  }
  AMB_ROTOR_CHECK(static_cast<int>(model.effects.size()) == n, "so many effects do not go together");
  return model;
}
/// The rates of that machine, a thousand times.
void effects(benchmark::State& state, int n) {
  const Model model = withEffects(n);
  const Machine<double> machine({&model});
  std::vector<double> y(static_cast<std::size_t>(machine.stateSize()), 1e-6), rate(y);
  machine.initialise(y.data());
  Inputs<double> in;
  in.shaft = Shaft<double>::at(0.3, 400.0, 0.0);
  for (auto _ : state)
    for (int i = 0; i < 1000; ++i) {
      machine.derivatives(in, y.data(), rate.data());
      benchmark::DoNotOptimize(rate.data());
    }
  state.counters["states"] = machine.stateSize();
}

/// `amb simulate` of the levitated rigid beam, without reading and writing files.
void lengths(benchmark::State& state, double length_s) {
  const Model model = loadModel(thesis + "levitation_model.yaml");
  Scenario scenario;
  scenario.duration_s = length_s;
  scenario.record_rate_hz = 10000.0;
  scenario.speed.start_hz = 60.0;
  scenario.start_settled = false;
  scenario.initial_displacement_m = {2e-5, 0.0};
  for (auto _ : state) {
    const Simulation run = simulate(model, scenario);
    AMB_ROTOR_CHECK(run.outcome.status == RunStatus::ok, run.outcome.reason);
    benchmark::DoNotOptimize(run.trajectory.time_s.data());
  }
}

const bool registered = [] {
  const auto add = [](const char* what, double size, auto run) {
    benchmark::RegisterBenchmark((std::string("growth/") + what).c_str(), [=](benchmark::State& state) {
      state.counters["size"] = size;
      run(state);
    });
  };
  for (std::size_t n = 1; n <= 1000000; n *= 10)
    add("machines", static_cast<double>(n), [=](benchmark::State& s) { machines(s, n); });
  for (int n : {10, 20, 50, 100, 200, 500}) add("nodes", n, [=](benchmark::State& s) { nodes(s, n); });
  for (std::size_t n : {4u, 8u, 16u, 32u, 62u})
    add("modes", static_cast<double>(n), [=](benchmark::State& s) { modes(s, n); });
  for (int n : {0, 1, 2, 5, 10, 15, 20}) add("effects", n, [=](benchmark::State& s) { effects(s, n); });
  for (double t : {0.01, 0.1, 1.0, 10.0}) add("length", t, [=](benchmark::State& s) { lengths(s, t); });
  return true;
}();

}  // namespace
}  // namespace amb_rotor
