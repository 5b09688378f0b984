// The lanes of the basic model beside a kernel written by hand in AVX2 intrinsics: the floor that the
// generic right-hand side is held to. Items are machine-steps (one Runge-Kutta step of one machine).
#include <benchmark/benchmark.h>
#if defined(__AVX2__) && defined(__FMA__)
#include <immintrin.h>
#endif

#include <string>
#include <vector>

#include "amb_rotor/machine/basic_lanes.hpp"
#include "hand_lanes.hpp"

namespace amb_rotor {
namespace {

using bench::machines;
using bench::steps_per_turn;
using bench::turns;

std::vector<BasicParameters<double>> sweep() {
  std::vector<BasicParameters<double>> all(machines);
  for (int i = 0; i < machines; ++i)
    all[static_cast<std::size_t>(i)].frequency_ratio = 0.9 + 0.5 * i / machines;
  return all;
}

void lanesKernel(benchmark::State& state, const std::string& set, int threads) {
  const auto all = sweep();
  BasicLaneOptions options;
  options.steps_per_turn = steps_per_turn;
  options.turns_skipped = turns;
  options.turns_kept = 0;
  options.instruction_set = set;
  options.threads = threads;
  for (auto _ : state) {
    auto result = runBasicLanes(all, {{1.0, 0.0, 0.0, 0.0}}, options);
    benchmark::DoNotOptimize(result.end.data());
  }
  state.SetItemsProcessed(state.iterations() * machines * turns * steps_per_turn);
}

#if defined(__AVX2__) && defined(__FMA__)
/// Four lanes in AVX2.
struct Avx2 {
  using V = __m256d;
  static constexpr int lanes = 4;
  static V set(double a) { return _mm256_set1_pd(a); }
  static V load(const double* a) { return _mm256_loadu_pd(a); }
  static V broadcast(const double* a) { return _mm256_broadcast_sd(a); }
  static V add(V a, V b) { return _mm256_add_pd(a, b); }
  static V subtract(V a, V b) { return _mm256_sub_pd(a, b); }
  static V multiply(V a, V b) { return _mm256_mul_pd(a, b); }
  static V divide(V a, V b) { return _mm256_div_pd(a, b); }
  static V squareRoot(V a) { return _mm256_sqrt_pd(a); }
  static V maximum(V a, V b) { return _mm256_max_pd(a, b); }
  static V multiplyAdd(V a, V b, V c) { return _mm256_fmadd_pd(a, b, c); }
  static V subtractProduct(V a, V b, V c) { return _mm256_fnmadd_pd(a, b, c); }  ///< c - a b
  static double first(V a) { return _mm256_cvtsd_f64(a); }
};

void handKernel(benchmark::State& state) {
  if (!__builtin_cpu_supports("avx2") || !__builtin_cpu_supports("fma")) {
    state.SkipWithError("this processor has no AVX2");
    return;
  }
  bench::runHand<Avx2>(state);
}
BENCHMARK(handKernel)->Name("basic_lanes/hand_avx2/threads:1")->UseRealTime();
#endif

const bool registered = [] {
  for (const std::string& set : basicInstructionSets()) {
    for (int threads : {1, 2}) {
      benchmark::RegisterBenchmark(
          ("basic_lanes/" + set + "/threads:" + std::to_string(threads)).c_str(),
          [set, threads](benchmark::State& state) { lanesKernel(state, set, threads); })
          ->UseRealTime();
    }
  }
  return true;
}();

}  // namespace
}  // namespace amb_rotor
