#include "contact_newton_kernel.hpp"

namespace amb_rotor {

// The instruction set that every processor of this architecture has (SSE2, NEON).
ContactKernels contactKernelsBaseline() { return kernels_of_set; }

}  // namespace amb_rotor
