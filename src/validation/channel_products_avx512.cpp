#if defined(__AVX512F__) && defined(__AVX512DQ__)
#include "channel_products_kernel.hpp"
namespace amb_rotor {
AddProducts addProductsAvx512() { return addProductsOfSet; }
}  // namespace amb_rotor
#else  // not built for this architecture
#include "amb_rotor/validation/channel_products.hpp"
namespace amb_rotor {
AddProducts addProductsAvx512() { return nullptr; }
}  // namespace amb_rotor
#endif
