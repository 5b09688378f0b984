#if defined(__AVX2__) && defined(__FMA__)
#include "plain_law_kernel.hpp"
namespace amb_rotor {
PlainForces plainForcesAvx2() { return forcesOfSet; }
}  // namespace amb_rotor
#else  // not built for this architecture
#include "plain_law.hpp"
namespace amb_rotor {
PlainForces plainForcesAvx2() { return nullptr; }
}  // namespace amb_rotor
#endif
