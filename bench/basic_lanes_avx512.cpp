// The kernel written by hand in AVX-512 intrinsics, eight lanes (bench/hand_lanes.hpp). Items are machine-steps.
#include <benchmark/benchmark.h>
#if defined(__AVX512F__)
#include <immintrin.h>

#include "hand_lanes.hpp"

namespace amb_rotor {
namespace {

struct Avx512 {
  using V = __m512d;
  static constexpr int lanes = 8;
  static V set(double a) { return _mm512_set1_pd(a); }
  static V load(const double* a) { return _mm512_loadu_pd(a); }
  static V broadcast(const double* a) { return _mm512_set1_pd(*a); }
  static V add(V a, V b) { return _mm512_add_pd(a, b); }
  static V subtract(V a, V b) { return _mm512_sub_pd(a, b); }
  static V multiply(V a, V b) { return _mm512_mul_pd(a, b); }
  static V divide(V a, V b) { return _mm512_div_pd(a, b); }
  static V squareRoot(V a) { return _mm512_sqrt_pd(a); }
  static V maximum(V a, V b) { return _mm512_max_pd(a, b); }
  static V multiplyAdd(V a, V b, V c) { return _mm512_fmadd_pd(a, b, c); }
  static V subtractProduct(V a, V b, V c) { return _mm512_fnmadd_pd(a, b, c); }  ///< c - a b
  static double first(V a) { return _mm512_cvtsd_f64(a); }
};

void handKernel(benchmark::State& state) {
  if (!__builtin_cpu_supports("avx512f")) {
    state.SkipWithError("this processor has no AVX-512");
    return;
  }
  bench::runHand<Avx512>(state);
}
BENCHMARK(handKernel)->Name("basic_lanes/hand_avx512/threads:1")->UseRealTime();

}  // namespace
}  // namespace amb_rotor
#endif
