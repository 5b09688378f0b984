#include "amb_rotor/integration/contact_newton.hpp"

namespace amb_rotor {
namespace {

ContactKernels bestKernels() {
#if defined(__x86_64__)
  if (__builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512vl") &&
      contactKernelsAvx512().change != nullptr)
    return contactKernelsAvx512();
  if (__builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma") &&
      contactKernelsAvx2().change != nullptr)
    return contactKernelsAvx2();
#endif
  return contactKernelsBaseline();
}

}  // namespace

const ContactKernels& contactKernels() {
  static const ContactKernels kernels = bestKernels();
  return kernels;
}

}  // namespace amb_rotor
