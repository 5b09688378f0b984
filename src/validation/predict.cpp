#include "amb_rotor/validation/predict.hpp"

#include <map>
#include <utility>

namespace amb_rotor {

void predictBaseline(const Stretch& stretch, LaneJob* jobs, std::size_t count);
void predictAvx2(const Stretch& stretch, LaneJob* jobs, std::size_t count);
void predictAvx512(const Stretch& stretch, LaneJob* jobs, std::size_t count);
void predictByEvents(const Stretch& stretch, LaneJob* jobs, std::size_t count);

namespace {

struct Choice {
  void (*run)(const Stretch&, LaneJob*, std::size_t);
  int lanes;
  const char* name;
};

const Choice& choice() {
  static const Choice chosen = [] {
    __builtin_cpu_init();
    if (__builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512dq")) return Choice{predictAvx512, 8, "AVX-512"};
    if (__builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma")) return Choice{predictAvx2, 4, "AVX2"};
    return Choice{predictBaseline, 2, "SSE2"};
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

}  // namespace

void predict(const Stretch& stretch, std::vector<LaneJob>& jobs) {
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
    predict(stretch, jobs);
    for (std::size_t i = 0; i < jobs.size(); ++i) jobs[i].model = own[i];
    return;
  }
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

int predictionLanes() { return choice().lanes; }
const char* predictionInstructionSet() { return choice().name; }

int mechanicsSize(const Model& model, Spin spin) { return Machine<double>({&model}, spin).stateSize(); }

}  // namespace amb_rotor
