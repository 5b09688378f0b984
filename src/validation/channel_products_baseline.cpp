#include "channel_products_kernel.hpp"

namespace amb_rotor {

// The instruction set that every processor of this architecture has (SSE2, NEON).
AddProducts addProductsBaseline() { return addProductsOfSet; }

}  // namespace amb_rotor
