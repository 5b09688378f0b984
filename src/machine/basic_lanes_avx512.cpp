#include "basic_lanes_kernel.hpp"

namespace amb_rotor {

BasicKernelSet basicKernelsAvx512() {
#if defined(__AVX512F__) && defined(__AVX512DQ__)
  return lanes::kernelsOf<xsimd::batch<double, xsimd::avx512dq>>();
#else
  return {};  // not built for this architecture
#endif
}

}  // namespace amb_rotor
