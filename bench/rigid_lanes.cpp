// The complete rigid-beam machine in lanes, all of them rubbing: 4 freedoms, 4 amplifiers, sampled PID, contact at both ends,
// Runge-Kutta steps of 5 us. Items are machine-steps of that length; what a step in which an end touches or leaves is divided
// into comes on top. One thread; the instruction set is the widest that there is.
#include <benchmark/benchmark.h>

#include <vector>

#include "amb_rotor/common/check.hpp"
#include "amb_rotor/common/units.hpp"
#include "amb_rotor/machine/machine.hpp"
#include "amb_rotor/validation/predict.hpp"

namespace amb_rotor {
namespace {

constexpr int machines = 64;
constexpr double record_rate_hz = 10000.0, length_s = 0.1, step_s = 5e-6;

/// A rotor of 3.4 kg whose unbalance holds it against its auxiliary bearings.
Model rubbing(int number) {
  Model model;
  model.rotor_model = RotorModel::rigid_beam;
  model.amb_model = AmbModel::linear;
  Rig<double>& rig = model.rig;
  rig.rotor.mass_kg = 3.36;
  rig.rotor.transverse_inertia_kg_m2 = 0.017;
  for (int end = 0; end < 2; ++end) {
    const double side = end == 0 ? -1.0 : 1.0;
    rig.planes.amb[end] = side * 0.096;
    rig.planes.sensor[end] = side * 0.118;
    rig.planes.aux[end] = side * 0.140;
  }
  rig.amb.current_stiffness_N_per_A = 19.0;
  rig.amb.displacement_stiffness_N_per_m = 63333.0;
  rig.amb.bias_current_A = 2.5;
  rig.amb.air_gap_m = 0.75e-3;
  rig.amb.amplifier_bandwidth_hz = 2000.0;
  rig.amb.max_current_A = 5.0;
  rig.controller.sample_rate_hz = 10000.0;
  rig.controller.kp_A_per_m = 13850.0;
  rig.controller.kd_A_s_per_m = 16.0;
  rig.controller.derivative_filter_hz = 2000.0;
  rig.controller.delay_s = 1e-4;
  rig.auxiliary_bearing.clearance_m = 0.2e-3;
  rig.auxiliary_bearing.rotor_radius_m = 0.012;
  rig.auxiliary_bearing.stiffness_N_per_m = 3.38e7;
  rig.auxiliary_bearing.damping_N_s_per_m = 3000.0;
  rig.auxiliary_bearing.friction_coefficient = 0.02;
  rig.unbalance = {{0.0, (4.0 + 2.0 * number / machines) * 1e-3, 0.0}};
  return model;
}

void rub(benchmark::State& state) {
  std::vector<Model> models;
  for (int k = 0; k < machines; ++k) models.push_back(rubbing(k));
  Stretch stretch;
  stretch.record_rate_hz = record_rate_hz;
  stretch.last = static_cast<long>(length_s * record_rate_hz);
  stretch.largest_step_s = stretch.contact_step_s = step_s;
  stretch.settle_s = 0.2;
  const std::size_t rows = static_cast<std::size_t>(stretch.last) * predicted_channels;
  std::vector<double> out(rows * machines);
  std::vector<MachineState<double>> begin(machines);
  std::vector<LaneJob> jobs(machines);
  for (int k = 0; k < machines; ++k) {
    jobs[k].model = &models[k];
    jobs[k].speed_rad_s = two_pi * 120.0;
    jobs[k].out = out.data() + k * rows;
    jobs[k].begin = &begin[k];
  }
  predict(stretch, jobs);  // finds the states to start from, in contact
  double touching = 0.0;
  for (int k = 0; k < machines; ++k) {
    jobs[k].start = &begin[k];
    jobs[k].begin = nullptr;
    AMB_ROTOR_CHECK(jobs[k].finite, "the run stays finite");
    const double* row = jobs[k].out + rows - predicted_channels;  // the sensors lie 0.118/0.140 of the way out
    touching += std::hypot(row[0], row[1]) > 0.118 / 0.140 * 0.2e-3;
  }
  for (auto _ : state) {
    predict(stretch, jobs);
    benchmark::DoNotOptimize(out.data());
  }
  state.counters["touching"] = touching / machines;
  state.SetItemsProcessed(static_cast<long>(state.iterations() * machines * (length_s / step_s)));
  state.SetLabel(predictionInstructionSet());
}
BENCHMARK(rub)->Name("rigid_lanes/rub")->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace amb_rotor
