#include "amb_rotor/validation/predict.hpp"

#include <algorithm>
#include <map>
#include <utility>

namespace amb_rotor {

void predictBaseline(const Stretch& stretch, LaneJob* jobs, std::size_t count);
void predictAvx2(const Stretch& stretch, LaneJob* jobs, std::size_t count);
void predictAvx512(const Stretch& stretch, LaneJob* jobs, std::size_t count);
bool allLinearBaseline(const Stretch& stretch, LaneJob* jobs, std::size_t count);
bool allLinearAvx2(const Stretch& stretch, LaneJob* jobs, std::size_t count);
bool allLinearAvx512(const Stretch& stretch, LaneJob* jobs, std::size_t count);
void predictByEvents(const Stretch& stretch, LaneJob* jobs, std::size_t count);

namespace {

struct Choice {
  void (*run)(const Stretch&, LaneJob*, std::size_t);
  bool (*linear)(const Stretch&, LaneJob*, std::size_t);
  int lanes;
  const char* name;
};

const Choice& choice() {
  static const Choice chosen = [] {
    __builtin_cpu_init();
    if (__builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512dq"))
      return Choice{predictAvx512, allLinearAvx512, 8, "AVX-512"};
    if (__builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma"))
      return Choice{predictAvx2, allLinearAvx2, 4, "AVX2"};
    return Choice{predictBaseline, allLinearBaseline, 2, "SSE2"};
  }();
  return chosen;
}

}  // namespace

namespace {

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

void predictOnce(const Stretch& given, std::vector<LaneJob>& jobs) {
  Stretch stretch = given;
  if (stretch.by_events) return predictByEvents(stretch, jobs.data(), jobs.size());
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
  std::map<std::pair<double, double>, std::vector<std::size_t>> groups;
  for (std::size_t i = 0; i < jobs.size(); ++i) groups[controllerInstants(*jobs[i].model)].push_back(i);
  if (groups.size() == 1) {
    choice().run(stretch, jobs.data(), jobs.size());
    return;
  }
  for (const auto& group : groups) {
    std::vector<LaneJob> own;
    for (std::size_t i : group.second) own.push_back(jobs[i]);
    choice().run(stretch, own.data(), own.size());
    for (std::size_t k = 0; k < own.size(); ++k) jobs[group.second[k]].finite = own[k].finite;
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
