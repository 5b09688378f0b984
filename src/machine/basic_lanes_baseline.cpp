#include "basic_lanes_kernel.hpp"

namespace amb_rotor {

// The instruction set that every processor of this architecture has (SSE2, NEON).
BasicKernelSet basicKernelsBaseline() { return lanes::kernelsOf<xsimd::batch<double>>(); }

}  // namespace amb_rotor
