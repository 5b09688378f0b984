#include "plain_law_kernel.hpp"

namespace amb_rotor {

// The instruction set that every processor of this architecture has (SSE2, NEON).
PlainForces plainForcesBaseline() { return forcesOfSet; }

}  // namespace amb_rotor
