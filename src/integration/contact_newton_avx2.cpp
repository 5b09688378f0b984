#if defined(__AVX2__) && defined(__FMA__)
#include "contact_newton_kernel.hpp"
namespace amb_rotor {
ContactKernels contactKernelsAvx2() { return kernels_of_set; }
}  // namespace amb_rotor
#else  // not built for this architecture
#include "amb_rotor/integration/contact_newton.hpp"
namespace amb_rotor {
ContactKernels contactKernelsAvx2() { return {}; }
}  // namespace amb_rotor
#endif
