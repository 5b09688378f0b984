#include "amb_rotor/validation/predict.hpp"

#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <atomic>
#include <map>
#include <utility>

namespace amb_rotor {

void predictBaseline(const Stretch& stretch, LaneJob* jobs, std::size_t count);
void predictAvx2(const Stretch& stretch, LaneJob* jobs, std::size_t count);
void predictAvx512(const Stretch& stretch, LaneJob* jobs, std::size_t count);
bool settleBaseline(const Stretch& stretch, LaneJob* jobs, std::size_t count, MachineState<double>* out);
bool settleAvx2(const Stretch& stretch, LaneJob* jobs, std::size_t count, MachineState<double>* out);
bool settleAvx512(const Stretch& stretch, LaneJob* jobs, std::size_t count, MachineState<double>* out);
bool allLinearBaseline(const Stretch& stretch, LaneJob* jobs, std::size_t count);
bool allLinearAvx2(const Stretch& stretch, LaneJob* jobs, std::size_t count);
bool allLinearAvx512(const Stretch& stretch, LaneJob* jobs, std::size_t count);
void predictByEvents(const Stretch& stretch, LaneJob& job);

namespace {

/// Of an instruction set. `run` and `settle` take a pack at most.
struct Choice {
  void (*run)(const Stretch&, LaneJob*, std::size_t);
  bool (*linear)(const Stretch&, LaneJob*, std::size_t);
  bool (*settle)(const Stretch&, LaneJob*, std::size_t, MachineState<double>*);
  int lanes;
  const char* name;
};

const Choice& choice() {
  static const Choice chosen = [] {
    __builtin_cpu_init();
    if (__builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512dq"))
      return Choice{predictAvx512, allLinearAvx512, settleAvx512, 8, "AVX-512"};
    if (__builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma"))
      return Choice{predictAvx2, allLinearAvx2, settleAvx2, 4, "AVX2"};
    return Choice{predictBaseline, allLinearBaseline, settleBaseline, 2, "SSE2"};
  }();
  return chosen;
}

}  // namespace

namespace {

/// Calls  part(first job, how many)  for all jobs in parts of `width`, beside each other; whether all returned true. A thread that waits
/// for others' parts takes no other work meanwhile: it would be a run's, and these parts' caller waits for them.
template <class Part>
bool inParts(std::size_t count, std::size_t width, const Part& part) {
  if (count <= width) return count == 0 || part(std::size_t{0}, count);
  std::atomic<bool> all{true};
  tbb::this_task_arena::isolate([&] {
    tbb::parallel_for(std::size_t{0}, (count + width - 1) / width, [&](std::size_t k) {
      const std::size_t first = k * width;
      if (!part(first, std::min(width, count - first))) all = false;
    });
  });
  return all;
}

std::size_t packWidth() { return static_cast<std::size_t>(choice().lanes); }

/// What the lanes of a pack must share: the controller's instants.
std::pair<double, double> controllerInstants(const Model& model) {
  double delay = model.rig.controller.delay_s;
  for (const auto& effect : model.effects)
    if (effect.id == "control_delay") delay = effect.values[0];
  return {model.rig.controller.sample_rate_hz, delay};
}

/// Whether a stretch is long enough that reading the machines' equations costs less than it saves.
bool worthReading(const Stretch& stretch, const std::vector<LaneJob>& jobs) {
  constexpr double least_s = 0.05;
  const double run_in = !jobs.empty() && jobs[0].start == nullptr ? stretch.settle_s + stretch.calm_s : 0.0;
  return (stretch.last - stretch.first) / stretch.record_rate_hz + run_in >= least_s;
}

/// Whether a run-in takes longer than finding its end in closed form (measured: as long as 0.2 s of it).
bool worthSolving(const Stretch& stretch, const std::vector<LaneJob>& jobs) {
  constexpr double least_s = 0.3;
  const bool runs_in = !jobs.empty() && jobs[0].start == nullptr && jobs[0].settle_from == nullptr;
  return runs_in && stretch.settle_s + stretch.calm_s >= least_s;
}

/// Where all machines settle, the motion that each does settle in; none where one does not.
std::vector<std::vector<MachineState<double>>> settledMotions(const Stretch& stretch, std::vector<std::vector<LaneJob>>& groups) {
  std::vector<std::vector<MachineState<double>>> out;
  for (auto& group : groups) {
    out.emplace_back(group.size());
    const auto settle = [&](std::size_t first, std::size_t size) {
      return choice().settle(stretch, group.data() + first, size, out.back().data() + first);
    };
    if (!inParts(group.size(), packWidth(), settle)) return {};
  }
  return out;
}

void predictOnce(const Stretch& given, std::vector<LaneJob>& jobs) {
  Stretch stretch = given;
  if (stretch.by_events) {
    inParts(jobs.size(), 1, [&](std::size_t k, std::size_t) {
      predictByEvents(stretch, jobs[k]);
      return true;
    });
    return;
  }
  if (!jobs.empty() && jobs[0].model->friction_law == FrictionLaw::set_valued) {
    std::vector<Model> regularised;  // nothing touches, or it is far off anyway
    std::vector<const Model*> own;
    for (const LaneJob& job : jobs) {
      own.push_back(job.model);
      regularised.push_back(*job.model);
      regularised.back().friction_law = FrictionLaw::regularised;
    }
    for (std::size_t i = 0; i < jobs.size(); ++i) jobs[i].model = &regularised[i];
    predictOnce(stretch, jobs);
    for (std::size_t i = 0; i < jobs.size(); ++i) jobs[i].model = own[i];
    return;
  }
  // one way for all: differences between lanes are what a fit lives on
  stretch.exact = worthReading(stretch, jobs) && choice().linear(stretch, jobs.data(), jobs.size());
  std::map<std::pair<double, double>, std::vector<std::size_t>> indices;
  for (std::size_t i = 0; i < jobs.size(); ++i) indices[controllerInstants(*jobs[i].model)].push_back(i);
  std::vector<std::vector<LaneJob>> groups;
  for (const auto& group : indices) {
    groups.emplace_back();
    for (std::size_t i : group.second) groups.back().push_back(jobs[i]);
  }
  std::vector<std::vector<MachineState<double>>> settled;
  if (stretch.exact && worthSolving(stretch, jobs)) settled = settledMotions(stretch, groups);
  auto group = groups.begin();
  for (const auto& of_group : indices) {
    for (std::size_t k = 0; k < group->size() && !settled.empty(); ++k)
      (*group)[k].start = &settled[group - groups.begin()][k];
    inParts(group->size(), packWidth(), [&](std::size_t first, std::size_t size) {
      choice().run(stretch, group->data() + first, size);
      return true;
    });
    for (std::size_t k = 0; k < group->size(); ++k) jobs[of_group.second[k]].finite = (*group)[k].finite;
    ++group;
  }
}

}  // namespace

void predict(const Stretch& stretch, std::vector<LaneJob>& jobs) {
  predictOnce(stretch, jobs);
  const bool finite = std::all_of(jobs.begin(), jobs.end(), [](const LaneJob& job) { return job.finite; });
  if (finite || jobs[0].start != nullptr || stretch.calm_s == 0.0) return;
  Stretch at_once = stretch;  // currents that saturate leave a motion more than one place to settle, or none
  at_once.calm_s = 0.0;
  predictOnce(at_once, jobs);
}

bool predictsExactly(const Stretch& stretch, const Model& model) {
  LaneJob job;
  job.model = &model;
  return choice().linear(stretch, &job, 1);
}

int predictionLanes() { return choice().lanes; }
const char* predictionInstructionSet() { return choice().name; }

int mechanicsSize(const Model& model, Spin spin) { return Machine<double>({&model}, spin).stateSize(); }

}  // namespace amb_rotor
