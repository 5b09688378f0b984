// Predictions for one instruction set; chosen at run time in predict.cpp.
#include "amb_rotor/validation/predict_impl.hpp"

namespace amb_rotor {

void predictAvx2(const Stretch& stretch, LaneJob* jobs, std::size_t count) {
  predictLanes<Lanes<xsimd::fma3<xsimd::avx2>>>(stretch, jobs, count);
}

bool settleAvx2(const Stretch& stretch, LaneJob* jobs, std::size_t count, MachineState<double>* out) {
  return settlePack<Lanes<xsimd::fma3<xsimd::avx2>>>(stretch, jobs, count, out);
}

bool allLinearAvx2(const Stretch& stretch, LaneJob* jobs, std::size_t count) {
  return allLinear<Lanes<xsimd::fma3<xsimd::avx2>>>(stretch, jobs, count);
}

}  // namespace amb_rotor
