// The lanes of the basic model beside a kernel written by hand in AVX2 intrinsics: the floor that the
// generic right-hand side is held to. Items are machine-steps (one Runge-Kutta step of one machine).
#include <benchmark/benchmark.h>
#if defined(__AVX2__) && defined(__FMA__)
#include <immintrin.h>
#endif

#include <cmath>
#include <string>
#include <vector>

#include "amb_rotor/common/units.hpp"
#include "amb_rotor/machine/basic_lanes.hpp"

namespace amb_rotor {
namespace {

constexpr int steps_per_turn = 200;
constexpr int turns = 100;
constexpr int machines = 256;

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
constexpr int packs = 4;  // 4 packs of 4 lanes hide the latency of square root and division

struct Hand {
  __m256d f[packs], d[packs], k[packs], c[packs], m[packs], x[packs], y[packs], vx[packs], vy[packs];
};

inline __attribute__((always_inline)) void force(const Hand& h, int i, __m256d cosine, __m256d sine,
                                                 __m256d x, __m256d y, __m256d vx, __m256d vy, __m256d& ax,
                                                 __m256d& ay) {
  const __m256d one = _mm256_set1_pd(1.0);
  const __m256d square = _mm256_fmadd_pd(x, x, _mm256_mul_pd(y, y));
  const __m256d r = _mm256_sqrt_pd(_mm256_max_pd(square, one));
  const __m256d n = _mm256_mul_pd(h.c[i], _mm256_sub_pd(one, _mm256_div_pd(one, r)));
  const __m256d tx = _mm256_fnmadd_pd(h.m[i], y, x);
  const __m256d ty = _mm256_fmadd_pd(h.m[i], x, y);
  ax = _mm256_mul_pd(h.f[i], cosine);
  ay = _mm256_mul_pd(h.f[i], sine);
  ax = _mm256_fnmadd_pd(h.d[i], vx, ax);
  ay = _mm256_fnmadd_pd(h.d[i], vy, ay);
  ax = _mm256_fnmadd_pd(h.k[i], x, ax);
  ay = _mm256_fnmadd_pd(h.k[i], y, ay);
  ax = _mm256_fnmadd_pd(n, tx, ax);
  ay = _mm256_fnmadd_pd(n, ty, ay);
}

void handBlock(Hand& h, const double* table, int steps) {
  const __m256d half = _mm256_set1_pd(0.5), quarter = _mm256_set1_pd(0.25), two = _mm256_set1_pd(2.0),
                sixth = _mm256_set1_pd(1.0 / 6.0);
  for (int s = 0; s < steps; ++s, table += 4) {
    const __m256d c0 = _mm256_broadcast_sd(table), s0 = _mm256_broadcast_sd(table + 1);
    const __m256d c1 = _mm256_broadcast_sd(table + 2), s1 = _mm256_broadcast_sd(table + 3);
    const __m256d c2 = _mm256_broadcast_sd(table + 4), s2 = _mm256_broadcast_sd(table + 5);
    __m256d ax[packs], ay[packs], qx[packs], qy[packs], wx[packs], wy[packs], px[packs], py[packs], tx[packs],
        ty[packs];
    for (int i = 0; i < packs; ++i) force(h, i, c0, s0, h.x[i], h.y[i], h.vx[i], h.vy[i], ax[i], ay[i]);
    for (int i = 0; i < packs; ++i) {
      qx[i] = _mm256_fmadd_pd(half, h.vx[i], h.x[i]);
      qy[i] = _mm256_fmadd_pd(half, h.vy[i], h.y[i]);
      force(h, i, c1, s1, qx[i], qy[i], _mm256_fmadd_pd(half, ax[i], h.vx[i]),
            _mm256_fmadd_pd(half, ay[i], h.vy[i]), tx[i], ty[i]);
      qx[i] = _mm256_fmadd_pd(quarter, ax[i], qx[i]);
      qy[i] = _mm256_fmadd_pd(quarter, ay[i], qy[i]);
      wx[i] = _mm256_fmadd_pd(half, tx[i], h.vx[i]);
      wy[i] = _mm256_fmadd_pd(half, ty[i], h.vy[i]);
      px[i] = _mm256_add_pd(ax[i], tx[i]);
      py[i] = _mm256_add_pd(ay[i], ty[i]);
    }
    for (int i = 0; i < packs; ++i) {
      __m256d bx, by;
      force(h, i, c1, s1, qx[i], qy[i], wx[i], wy[i], bx, by);
      qx[i] = _mm256_fmadd_pd(half, tx[i], _mm256_add_pd(h.x[i], h.vx[i]));
      qy[i] = _mm256_fmadd_pd(half, ty[i], _mm256_add_pd(h.y[i], h.vy[i]));
      wx[i] = _mm256_add_pd(h.vx[i], bx);
      wy[i] = _mm256_add_pd(h.vy[i], by);
      px[i] = _mm256_add_pd(px[i], bx);
      py[i] = _mm256_add_pd(py[i], by);
      tx[i] = _mm256_add_pd(tx[i], bx);
      ty[i] = _mm256_add_pd(ty[i], by);
    }
    for (int i = 0; i < packs; ++i) {
      __m256d bx, by;
      force(h, i, c2, s2, qx[i], qy[i], wx[i], wy[i], bx, by);
      h.x[i] = _mm256_fmadd_pd(sixth, px[i], _mm256_add_pd(h.x[i], h.vx[i]));
      h.y[i] = _mm256_fmadd_pd(sixth, py[i], _mm256_add_pd(h.y[i], h.vy[i]));
      h.vx[i] = _mm256_fmadd_pd(sixth, _mm256_fmadd_pd(two, tx[i], _mm256_add_pd(ax[i], bx)), h.vx[i]);
      h.vy[i] = _mm256_fmadd_pd(sixth, _mm256_fmadd_pd(two, ty[i], _mm256_add_pd(ay[i], by)), h.vy[i]);
    }
  }
}

/// Centred bearing only: it does less work than the lanes (no misalignment, no turned axes).
void handKernel(benchmark::State& state) {
  if (!__builtin_cpu_supports("avx2") || !__builtin_cpu_supports("fma")) {
    state.SkipWithError("this processor has no AVX2");
    return;
  }
  std::vector<double> table;
  for (int i = 0; i <= 2 * steps_per_turn; ++i) {
    table.push_back(std::cos(pi * i / steps_per_turn));
    table.push_back(std::sin(pi * i / steps_per_turn));
  }
  for (auto _ : state) {
    for (int first = 0; first < machines; first += 4 * packs) {
      Hand h;
      for (int i = 0; i < packs; ++i) {
        alignas(32) double f[4], d[4], k[4], c[4];
        for (int lane = 0; lane < 4; ++lane) {
          const double eta = 0.9 + 0.5 * (first + 4 * i + lane) / machines;
          const double step = two_pi / (eta * steps_per_turn);
          f[lane] = step * step * eta * eta * 0.0973;
          d[lane] = step * 0.0347;
          k[lane] = step * step;
          c[lane] = step * step * 13.68;
        }
        h.f[i] = _mm256_load_pd(f);
        h.d[i] = _mm256_load_pd(d);
        h.k[i] = _mm256_load_pd(k);
        h.c[i] = _mm256_load_pd(c);
        h.m[i] = _mm256_set1_pd(0.015);
        h.x[i] = _mm256_set1_pd(1.0);
        h.y[i] = h.vx[i] = h.vy[i] = _mm256_setzero_pd();
      }
      for (int t = 0; t < turns; ++t) handBlock(h, table.data(), steps_per_turn);
      double sum = _mm256_cvtsd_f64(_mm256_add_pd(h.x[0], h.y[3]));
      benchmark::DoNotOptimize(sum);
    }
  }
  state.SetItemsProcessed(state.iterations() * machines * turns * steps_per_turn);
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
