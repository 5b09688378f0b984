#include "amb_rotor/validation/predict.hpp"

namespace amb_rotor {

void predictBaseline(const Stretch& stretch, LaneJob* jobs, std::size_t count);
void predictAvx2(const Stretch& stretch, LaneJob* jobs, std::size_t count);
void predictAvx512(const Stretch& stretch, LaneJob* jobs, std::size_t count);

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

void predict(const Stretch& stretch, std::vector<LaneJob>& jobs) {
  if (!jobs.empty()) choice().run(stretch, jobs.data(), jobs.size());
}

int predictionLanes() { return choice().lanes; }
const char* predictionInstructionSet() { return choice().name; }

int mechanicsSize(const Model& model, Spin spin) { return Machine<double>({&model}, spin).stateSize(); }

}  // namespace amb_rotor
