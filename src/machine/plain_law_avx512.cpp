#if defined(__AVX512F__) && defined(__AVX512VL__)
#include "plain_law_kernel.hpp"
namespace amb_rotor {
PlainForces plainForcesAvx512() { return forcesOfSet; }
}  // namespace amb_rotor
#else  // not built for this architecture
#include "plain_law.hpp"
namespace amb_rotor {
PlainForces plainForcesAvx512() { return nullptr; }
}  // namespace amb_rotor
#endif
