#pragma once
// Compiled once an instruction set, in channel_products_<set>.cpp. In an unnamed namespace, so that none of it is shared:
// tiles of four columns by three, whose sums stay in registers over a block's instants.
#include <algorithm>
#include <xsimd/xsimd.hpp>

#include "amb_rotor/validation/channel_products.hpp"

namespace amb_rotor {
namespace {

using Channels = xsimd::batch<double>;
constexpr int channel_width = static_cast<int>(Channels::size);
static_assert(predicted_channels % channel_width == 0, "a pack holds channels of one instant");

template <int A, int B>
void addTile(const double* a, const double* b, long stride, long instants, int columns, double* sums) {
  for (int h = 0; h < predicted_channels; h += channel_width) {
    Channels sum[A][B];
#pragma GCC unroll 8
    for (int m = 0; m < A; ++m)
#pragma GCC unroll 8
      for (int n = 0; n < B; ++n) sum[m][n] = Channels(0.0);
    for (long i = h; i < instants * predicted_channels; i += predicted_channels) {
      Channels right[B];
#pragma GCC unroll 8
      for (int n = 0; n < B; ++n) right[n] = Channels::load_unaligned(b + n * stride + i);
#pragma GCC unroll 8
      for (int m = 0; m < A; ++m) {
        const Channels left = Channels::load_unaligned(a + m * stride + i);
#pragma GCC unroll 8
        for (int n = 0; n < B; ++n) sum[m][n] = xsimd::fma(left, right[n], sum[m][n]);
      }
    }
#pragma GCC unroll 8
    for (int m = 0; m < A; ++m)
#pragma GCC unroll 8
      for (int n = 0; n < B; ++n) {
        double* at = sums + (static_cast<long>(m) * columns + n) * predicted_channels + h;
        (Channels::load_unaligned(at) + sum[m][n]).store_unaligned(at);
      }
  }
}

using Tile = void (*)(const double*, const double*, long, long, int, double*);
constexpr Tile tiles[4][3] = {{addTile<1, 1>, addTile<1, 2>, addTile<1, 3>},
                              {addTile<2, 1>, addTile<2, 2>, addTile<2, 3>},
                              {addTile<3, 1>, addTile<3, 2>, addTile<3, 3>},
                              {addTile<4, 1>, addTile<4, 2>, addTile<4, 3>}};

void addProductsOfSet(const double* x, long stride, long instants, int columns, double* sums) {
  for (int k = 0; k < columns; k += 4) {
    const int high = std::min(4, columns - k);
    for (int l = 0; l < k + high; l += 3) {
      const int wide = std::min(3, columns - l);
      tiles[high - 1][wide - 1](x + k * stride, x + l * stride, stride, instants, columns,
                                sums + (static_cast<long>(k) * columns + l) * predicted_channels);
    }
  }
}

}  // namespace
}  // namespace amb_rotor
