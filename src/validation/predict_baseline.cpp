// Predictions for one instruction set; chosen at run time in predict.cpp.
#include "amb_rotor/validation/predict_impl.hpp"

namespace amb_rotor {

void predictBaseline(const Stretch& stretch, LaneJob* jobs, std::size_t count) {
  predictLanes<Lanes<xsimd::sse2>>(stretch, jobs, count);
}

bool settleBaseline(const Stretch& stretch, LaneJob* jobs, std::size_t count, MachineState<double>* out) {
  return settlePack<Lanes<xsimd::sse2>>(stretch, jobs, count, out);
}

bool allLinearBaseline(const Stretch& stretch, LaneJob* jobs, std::size_t count) {
  return allLinear<Lanes<xsimd::sse2>>(stretch, jobs, count);
}

}  // namespace amb_rotor
