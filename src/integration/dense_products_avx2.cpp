// Products of a full matrix with a vector: sums of 4, 8 or 32 rows stay in registers over all columns.
#include "amb_rotor/integration/dense_products.hpp"

#if defined(__AVX2__) && defined(__FMA__)
#include <immintrin.h>
#endif

namespace amb_rotor {

#if defined(__AVX2__) && defined(__FMA__)
namespace {

constexpr int wide = 8;  ///< packs of 4 rows

/// Few rows: four columns at a time hide the latency of the sums.
template <int packs>
void few(const double* at, Eigen::Index rows, Eigen::Index columns, const double* x, double* y, bool add) {
  __m256d sum[4][packs];
#pragma GCC unroll 8
  for (int k = 0; k < 4; ++k)
#pragma GCC unroll 8
    for (int i = 0; i < packs; ++i) sum[k][i] = _mm256_setzero_pd();
  Eigen::Index c = 0;
  for (; c + 4 <= columns; c += 4)
#pragma GCC unroll 8
    for (int k = 0; k < 4; ++k, at += rows)
#pragma GCC unroll 8
      for (int i = 0; i < packs; ++i)
        sum[k][i] = _mm256_fmadd_pd(_mm256_loadu_pd(at + 4 * i), _mm256_set1_pd(x[c + k]), sum[k][i]);
  for (; c < columns; ++c, at += rows)
#pragma GCC unroll 8
    for (int i = 0; i < packs; ++i)
      sum[0][i] = _mm256_fmadd_pd(_mm256_loadu_pd(at + 4 * i), _mm256_set1_pd(x[c]), sum[0][i]);
#pragma GCC unroll 8
  for (int i = 0; i < packs; ++i) {
    const __m256d all =
        _mm256_add_pd(_mm256_add_pd(sum[0][i], sum[1][i]), _mm256_add_pd(sum[2][i], sum[3][i]));
    _mm256_storeu_pd(y + 4 * i, add ? _mm256_add_pd(_mm256_loadu_pd(y + 4 * i), all) : all);
  }
}

void avx2Product(const double* a, Eigen::Index rows, Eigen::Index columns, const double* x, double* y,
                 bool add) {
  Eigen::Index r = 0;
  for (; r + 4 * wide <= rows; r += 4 * wide) {
    __m256d sum[wide];
#pragma GCC unroll 8
    for (int i = 0; i < wide; ++i) sum[i] = add ? _mm256_loadu_pd(y + r + 4 * i) : _mm256_setzero_pd();
    const double* at = a + r;
    for (Eigen::Index c = 0; c < columns; ++c, at += rows) {
      const __m256d value = _mm256_set1_pd(x[c]);
#pragma GCC unroll 8
      for (int i = 0; i < wide; ++i) sum[i] = _mm256_fmadd_pd(_mm256_loadu_pd(at + 4 * i), value, sum[i]);
    }
#pragma GCC unroll 8
    for (int i = 0; i < wide; ++i) _mm256_storeu_pd(y + r + 4 * i, sum[i]);
  }
  for (; r + 8 <= rows; r += 8) few<2>(a + r, rows, columns, x, y + r, add);
  for (; r + 4 <= rows; r += 4) few<1>(a + r, rows, columns, x, y + r, add);
  for (; r < rows; ++r) {
    double sum = add ? y[r] : 0.0;
    for (Eigen::Index c = 0; c < columns; ++c) sum += a[c * rows + r] * x[c];
    y[r] = sum;
  }
}

}  // namespace

DenseProduct denseProductAvx2() { return avx2Product; }
#else
DenseProduct denseProductAvx2() { return nullptr; }
#endif

}  // namespace amb_rotor
