// Predictions for one instruction set; chosen at run time in predict.cpp.
#include "amb_rotor/validation/predict_impl.hpp"

namespace amb_rotor {

void predictAvx512(const Stretch& stretch, LaneJob* jobs, std::size_t count) {
  predictLanes<Lanes<xsimd::avx512dq>>(stretch, jobs, count);
}

bool settleAvx512(const Stretch& stretch, LaneJob* jobs, std::size_t count, MachineState<double>* out) {
  return settlePack<Lanes<xsimd::avx512dq>>(stretch, jobs, count, out);
}

bool allLinearAvx512(const Stretch& stretch, LaneJob* jobs, std::size_t count) {
  return allLinear<Lanes<xsimd::avx512dq>>(stretch, jobs, count);
}

}  // namespace amb_rotor
