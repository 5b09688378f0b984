#include "amb_rotor/machine/basic_lanes.hpp"

#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "amb_rotor/common/check.hpp"
#include "amb_rotor/common/units.hpp"
#include "basic_lanes_kernel.hpp"

namespace amb_rotor {
namespace {

constexpr double diverged_radius = 1e6;

bool runs(const std::string& set) {
#if defined(__x86_64__)
  if (set == "avx512") {
    return __builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512dq") &&
           __builtin_cpu_supports("avx512vl") && __builtin_cpu_supports("avx512bw") &&
           __builtin_cpu_supports("avx512cd") && basicKernelsAvx512().block_lanes > 0;
  }
  if (set == "avx2") {
    return __builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma") &&
           basicKernelsAvx2().block_lanes > 0;
  }
#endif
  return set == "baseline";
}

BasicKernelSet kernels(const std::string& set) {
  if (set == "avx512") return basicKernelsAvx512();
  if (set == "avx2") return basicKernelsAvx2();
  return basicKernelsBaseline();
}

std::vector<double> halfStepTable(int steps) {
  std::vector<double> table(static_cast<std::size_t>(4 * steps + 2));
  for (int i = 0; i <= 2 * steps; ++i) {
    const double phase = pi * i / steps;
    table[static_cast<std::size_t>(2 * i)] = std::cos(phase);
    table[static_cast<std::size_t>(2 * i + 1)] = std::sin(phase);
  }
  return table;
}

/// The columns of a run, padded to whole blocks by repeating the last machine.
struct Columns {
  std::size_t lanes;
  std::vector<double> coefficient[basic_coefficient_count], state[4], section[4];
  std::vector<double> contact, largest, smallest, swept, growth, step;

  Columns(const std::vector<BasicParameters<double>>& machines,
          const std::vector<BasicState<double>>& initial, const BasicLaneOptions& options,
          std::size_t block_lanes)
      : lanes((machines.size() + block_lanes - 1) / block_lanes * block_lanes) {
    for (auto& column : coefficient) column.resize(lanes);
    for (auto& column : state) column.resize(lanes);
    for (auto* column : {&contact, &largest, &smallest, &swept, &growth, &step}) column->resize(lanes);
    for (auto& column : section) column.resize(lanes * static_cast<std::size_t>(options.turns_kept));
    for (std::size_t lane = 0; lane < lanes; ++lane) {
      const std::size_t machine = std::min(lane, machines.size() - 1);
      const BasicParameters<double> p = rotatedToPhaseZero(machines[machine]);
      const double h = two_pi / (p.frequency_ratio * options.steps_per_turn);
      const BasicCoefficients<double> c = options.contact == BasicContact::linear
                                              ? basicCoefficients<LinearContact>(p, h)
                                              : basicCoefficients<HertzContact>(p, h);
      const double values[basic_coefficient_count] = {
          c.forcing,  c.damping,        c.stiffness,      c.contact,       c.contact_damping,
          c.friction, c.misalignment_x, c.misalignment_y, c.surface_speed, c.regularisation};
      for (int i = 0; i < basic_coefficient_count; ++i) coefficient[i][lane] = values[i];
      const BasicState<double>& given = initial[initial.size() == 1 ? 0 : machine];
      const BasicState<double> s = rotated(given, -machines[machine].unbalance_phase);
      const double columns[4] = {s.x, s.y, s.vx * h, s.vy * h};
      for (int i = 0; i < 4; ++i) state[i][lane] = columns[i];
      step[lane] = h;
    }
  }

  BasicState<double> stateAt(const std::vector<double>* columns, std::size_t row, std::size_t lane,
                             double phase) const {
    const std::size_t at = row * lanes + lane;
    return rotated({columns[0][at], columns[1][at], columns[2][at] / step[lane], columns[3][at] / step[lane]},
                   phase);
  }
};

bool escaped(const BasicState<double>& s) {
  const double size = std::abs(s.x) + std::abs(s.y);
  return !(size < diverged_radius) || !std::isfinite(s.vx + s.vy);
}

BasicLaneResult collect(const Columns& columns, const std::vector<BasicParameters<double>>& machines,
                        const BasicLaneOptions& options) {
  BasicLaneResult result;
  const std::size_t n = machines.size();
  const auto kept = static_cast<std::size_t>(options.turns_kept);
  const double kept_steps = static_cast<double>(kept) * options.steps_per_turn;
  result.machines = n;
  result.turns_kept = options.turns_kept;
  result.end.reserve(n);
  result.sections.reserve(n * kept);
  for (std::size_t i = 0; i < n; ++i) {
    const double phase = machines[i].unbalance_phase;
    result.end.push_back(columns.stateAt(columns.state, 0, i, phase));
    for (std::size_t t = 0; t < kept; ++t) {
      result.sections.push_back(columns.stateAt(columns.section, t, i, phase));
    }
    result.diverged.push_back(escaped(result.end.back()) ? 1 : 0);
    if (kept > 0) {
      result.contact_fraction.push_back(columns.contact[i] / kept_steps);
      result.max_radius.push_back(std::sqrt(columns.largest[i]));
      result.min_radius.push_back(std::sqrt(columns.smallest[i]));
      result.whirl.push_back(columns.swept[i] / (two_pi * static_cast<double>(kept)));
      if (options.lyapunov) result.lyapunov.push_back(columns.growth[i] / static_cast<double>(kept));
    }
  }
  return result;
}

void checkRun(const std::vector<BasicParameters<double>>& machines,
              const std::vector<BasicState<double>>& initial, const BasicLaneOptions& options) {
  std::vector<Fault> faults;
  const auto require = [&](bool holds, const char* key, const std::string& value, const char* rule) {
    if (!holds) faults.push_back({"", 0, key, value, rule});
  };
  require(!machines.empty(), "machines", "0", "at least one machine");
  require(initial.size() == 1 || initial.size() == machines.size(), "initial", std::to_string(initial.size()),
          "one initial state for all machines, or one for each");
  require(options.steps_per_turn >= 4, "steps_per_turn", std::to_string(options.steps_per_turn),
          "at least 4");
  require(options.turns_skipped >= 0, "turns_skipped", std::to_string(options.turns_skipped), "at least 0");
  require(options.turns_kept >= 0, "turns_kept", std::to_string(options.turns_kept), "at least 0");
  require(options.threads >= 0, "threads", std::to_string(options.threads), "at least 0");
  require(options.instruction_set.empty() || runs(options.instruction_set), "instruction_set",
          options.instruction_set, "baseline, avx2 or avx512, and one that this processor runs");
  if (!faults.empty()) throw InputError(std::move(faults));
}

}  // namespace

std::vector<std::string> basicInstructionSets() {
  std::vector<std::string> sets;
  for (const char* set : {"avx512", "avx2", "baseline"}) {
    if (runs(set)) sets.emplace_back(set);
  }
  return sets;
}

BasicLaneResult runBasicLanes(const std::vector<BasicParameters<double>>& machines,
                              const std::vector<BasicState<double>>& initial,
                              const BasicLaneOptions& options) {
  checkRun(machines, initial, options);
  checkBasicSteps(machines, options);
  const std::string set =
      options.instruction_set.empty() ? basicInstructionSets().front() : options.instruction_set;
  const BasicKernelSet chosen = kernels(set);
  Columns columns(machines, initial, options, chosen.block_lanes);
  const std::vector<double> table = halfStepTable(options.steps_per_turn);

  BasicLaneWork work{};
  for (int i = 0; i < basic_coefficient_count; ++i) work.coefficients[i] = columns.coefficient[i].data();
  for (int i = 0; i < 4; ++i) {
    work.state[i] = columns.state[i].data();
    work.section[i] = options.turns_kept > 0 ? columns.section[i].data() : nullptr;
  }
  work.contact_steps = columns.contact.data();
  work.largest = columns.largest.data();
  work.smallest = columns.smallest.data();
  work.swept = columns.swept.data();
  work.log_growth = columns.growth.data();
  work.step = columns.step.data();
  work.table = table.data();
  work.lanes = columns.lanes;
  work.steps_per_turn = options.steps_per_turn;
  work.turns_skipped = options.turns_skipped;
  work.turns_kept = options.turns_kept;

  const int contact = options.contact == BasicContact::linear ? 0 : 1;
  const int friction = options.friction == BasicFriction::spin ? 0 : 1;
  const BasicKernel kernel = chosen.kernel[contact][friction][options.lyapunov ? 1 : 0];
  const std::size_t blocks = columns.lanes / chosen.block_lanes;
  const auto runAll = [&] {
    tbb::parallel_for(std::size_t{0}, blocks,
                      [&](std::size_t block) { kernel(work, block * chosen.block_lanes); });
  };
  if (options.threads == 1) {
    for (std::size_t block = 0; block < blocks; ++block) kernel(work, block * chosen.block_lanes);
  } else if (options.threads > 1) {
    tbb::task_arena arena(options.threads);
    arena.execute(runAll);
  } else {
    runAll();
  }

  BasicLaneResult result = collect(columns, machines, options);
  result.machine_steps = static_cast<double>(machines.size()) * options.steps_per_turn *
                         (static_cast<double>(options.turns_skipped) + options.turns_kept);
  result.instruction_set = set;
  return result;
}

}  // namespace amb_rotor
