#if defined(__AVX512F__) && defined(__AVX512VL__)
#include "contact_newton_kernel.hpp"
namespace amb_rotor {
ContactKernels contactKernelsAvx512() { return kernels_of_set; }
}  // namespace amb_rotor
#else  // not built for this architecture
#include "amb_rotor/integration/contact_newton.hpp"
namespace amb_rotor {
ContactKernels contactKernelsAvx512() { return {}; }
}  // namespace amb_rotor
#endif
