#if defined(__AVX2__) && defined(__FMA__)
#include "channel_products_kernel.hpp"
namespace amb_rotor {
AddProducts addProductsAvx2() { return addProductsOfSet; }
}  // namespace amb_rotor
#else  // not built for this architecture
#include "amb_rotor/validation/channel_products.hpp"
namespace amb_rotor {
AddProducts addProductsAvx2() { return nullptr; }
}  // namespace amb_rotor
#endif
