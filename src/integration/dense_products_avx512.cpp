// Products of a full matrix with a vector: sums of up to 48 rows stay in registers over all columns; of few rows
// several columns go side by side, which hides the latency of the sums. The last rows are masked.
#include "amb_rotor/integration/dense_products.hpp"

#if defined(__AVX512F__)
#include <immintrin.h>
#endif

namespace amb_rotor {

#if defined(__AVX512F__)
namespace {

constexpr int widest = 6;  ///< packs of 8 rows
constexpr int chains = 8;  ///< sums under way that keep both units busy: four cycles of latency each

/// @param last  mask of the rows of the last pack
template <int packs>
void strip(const double* at, Eigen::Index rows, Eigen::Index columns, const double* x, double* y, __mmask8 last,
           bool add) {
  constexpr int side_by_side = (chains + packs - 1) / packs;
  __m512d sum[side_by_side][packs];
#pragma GCC unroll 8
  for (int k = 0; k < side_by_side; ++k)
#pragma GCC unroll 8
    for (int i = 0; i < packs; ++i) sum[k][i] = _mm512_setzero_pd();
  const auto column = [&](__m512d* into, double value) {
    const __m512d factor = _mm512_set1_pd(value);
#pragma GCC unroll 8
    for (int i = 0; i + 1 < packs; ++i) into[i] = _mm512_fmadd_pd(_mm512_loadu_pd(at + 8 * i), factor, into[i]);
    into[packs - 1] = _mm512_fmadd_pd(_mm512_maskz_loadu_pd(last, at + 8 * (packs - 1)), factor, into[packs - 1]);
    at += rows;
  };
  Eigen::Index c = 0;
  for (; c + side_by_side <= columns; c += side_by_side)
#pragma GCC unroll 8
    for (int k = 0; k < side_by_side; ++k) column(sum[k], x[c + k]);
  for (; c < columns; ++c) column(sum[0], x[c]);
#pragma GCC unroll 8
  for (int i = 0; i < packs; ++i) {
    const __mmask8 mask = i + 1 < packs ? __mmask8(0xff) : last;
    __m512d all = add ? _mm512_maskz_loadu_pd(mask, y + 8 * i) : _mm512_setzero_pd();
#pragma GCC unroll 8
    for (int k = 0; k < side_by_side; ++k) all = _mm512_add_pd(all, sum[k][i]);
    _mm512_mask_storeu_pd(y + 8 * i, mask, all);
  }
}

void avx512Product(const double* a, Eigen::Index rows, Eigen::Index columns, const double* x, double* y, bool add) {
  using Strip = void (*)(const double*, Eigen::Index, Eigen::Index, const double*, double*, __mmask8, bool);
  static constexpr Strip strips[widest] = {strip<1>, strip<2>, strip<3>, strip<4>, strip<5>, strip<6>};
  for (Eigen::Index r = 0; r < rows; r += 8 * widest) {
    const Eigen::Index left = rows - r, packs = left >= 8 * widest ? widest : (left + 7) / 8;
    const Eigen::Index in_last = left - 8 * (packs - 1);
    strips[packs - 1](a + r, rows, columns, x, y + r, static_cast<__mmask8>(in_last >= 8 ? 0xff : (1 << in_last) - 1),
                      add);
  }
}

}  // namespace

DenseProduct denseProductAvx512() { return avx512Product; }
#else
DenseProduct denseProductAvx512() { return nullptr; }
#endif

}  // namespace amb_rotor
