#include "plain_law.hpp"

namespace amb_rotor {

PlainForces plainForces() {
#if defined(__x86_64__)
  if (__builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512vl") &&
      plainForcesAvx512() != nullptr)
    return plainForcesAvx512();
  if (__builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma") && plainForcesAvx2() != nullptr)
    return plainForcesAvx2();
#endif
  return plainForcesBaseline();
}

}  // namespace amb_rotor
