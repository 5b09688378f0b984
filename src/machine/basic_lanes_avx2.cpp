#include "basic_lanes_kernel.hpp"

namespace amb_rotor {

BasicKernelSet basicKernelsAvx2() {
#if defined(__AVX2__) && defined(__FMA__)
  return lanes::kernelsOf<xsimd::batch<double, xsimd::fma3<xsimd::avx2>>>();
#else
  return {};  // not built for this architecture
#endif
}

}  // namespace amb_rotor
