#pragma once
// The basic model's Runge-Kutta steps written by hand for one instruction set: the floor that the generic right-hand side is
// held to. Centred bearing only: it does less work than the lanes (no misalignment, no turned axes).
// I: the intrinsics of the set, each under a name of its own (basic_lanes_avx2.cpp, basic_lanes_avx512.cpp).
#include <benchmark/benchmark.h>

#include <cmath>
#include <vector>

#include "amb_rotor/common/units.hpp"

namespace amb_rotor::bench {

constexpr int steps_per_turn = 200;
constexpr int turns = 100;
constexpr int machines = 256;
constexpr int packs = 4;  // 4 packs hide the latency of square root and division

template <class I>
struct Hand {
  typename I::V f[packs], d[packs], k[packs], c[packs], m[packs], x[packs], y[packs], vx[packs], vy[packs];
};

template <class I, class V = typename I::V>
inline __attribute__((always_inline)) void force(const Hand<I>& h, int i, V cosine, V sine,
                                                 V x, V y, V vx, V vy, V& ax,
                                                 V& ay) {
  const V one = I::set(1.0);
  const V square = I::multiplyAdd(x, x, I::multiply(y, y));
  const V r = I::squareRoot(I::maximum(square, one));
  const V n = I::multiply(h.c[i], I::subtract(one, I::divide(one, r)));
  const V tx = I::subtractProduct(h.m[i], y, x);
  const V ty = I::multiplyAdd(h.m[i], x, y);
  ax = I::multiply(h.f[i], cosine);
  ay = I::multiply(h.f[i], sine);
  ax = I::subtractProduct(h.d[i], vx, ax);
  ay = I::subtractProduct(h.d[i], vy, ay);
  ax = I::subtractProduct(h.k[i], x, ax);
  ay = I::subtractProduct(h.k[i], y, ay);
  ax = I::subtractProduct(n, tx, ax);
  ay = I::subtractProduct(n, ty, ay);
}

template <class I, class V = typename I::V>
void handBlock(Hand<I>& h, const double* table, int steps) {
  const V half = I::set(0.5), quarter = I::set(0.25), two = I::set(2.0),
                sixth = I::set(1.0 / 6.0);
  for (int s = 0; s < steps; ++s, table += 4) {
    const V c0 = I::broadcast(table), s0 = I::broadcast(table + 1);
    const V c1 = I::broadcast(table + 2), s1 = I::broadcast(table + 3);
    const V c2 = I::broadcast(table + 4), s2 = I::broadcast(table + 5);
    V ax[packs], ay[packs], qx[packs], qy[packs], wx[packs], wy[packs], px[packs], py[packs], tx[packs],
        ty[packs];
    for (int i = 0; i < packs; ++i) force<I>(h, i, c0, s0, h.x[i], h.y[i], h.vx[i], h.vy[i], ax[i], ay[i]);
    for (int i = 0; i < packs; ++i) {
      qx[i] = I::multiplyAdd(half, h.vx[i], h.x[i]);
      qy[i] = I::multiplyAdd(half, h.vy[i], h.y[i]);
      force<I>(h, i, c1, s1, qx[i], qy[i], I::multiplyAdd(half, ax[i], h.vx[i]),
            I::multiplyAdd(half, ay[i], h.vy[i]), tx[i], ty[i]);
      qx[i] = I::multiplyAdd(quarter, ax[i], qx[i]);
      qy[i] = I::multiplyAdd(quarter, ay[i], qy[i]);
      wx[i] = I::multiplyAdd(half, tx[i], h.vx[i]);
      wy[i] = I::multiplyAdd(half, ty[i], h.vy[i]);
      px[i] = I::add(ax[i], tx[i]);
      py[i] = I::add(ay[i], ty[i]);
    }
    for (int i = 0; i < packs; ++i) {
      V bx, by;
      force<I>(h, i, c1, s1, qx[i], qy[i], wx[i], wy[i], bx, by);
      qx[i] = I::multiplyAdd(half, tx[i], I::add(h.x[i], h.vx[i]));
      qy[i] = I::multiplyAdd(half, ty[i], I::add(h.y[i], h.vy[i]));
      wx[i] = I::add(h.vx[i], bx);
      wy[i] = I::add(h.vy[i], by);
      px[i] = I::add(px[i], bx);
      py[i] = I::add(py[i], by);
      tx[i] = I::add(tx[i], bx);
      ty[i] = I::add(ty[i], by);
    }
    for (int i = 0; i < packs; ++i) {
      V bx, by;
      force<I>(h, i, c2, s2, qx[i], qy[i], wx[i], wy[i], bx, by);
      h.x[i] = I::multiplyAdd(sixth, px[i], I::add(h.x[i], h.vx[i]));
      h.y[i] = I::multiplyAdd(sixth, py[i], I::add(h.y[i], h.vy[i]));
      h.vx[i] = I::multiplyAdd(sixth, I::multiplyAdd(two, tx[i], I::add(ax[i], bx)), h.vx[i]);
      h.vy[i] = I::multiplyAdd(sixth, I::multiplyAdd(two, ty[i], I::add(ay[i], by)), h.vy[i]);
    }
  }
}

template <class I>
void runHand(benchmark::State& state) {
  std::vector<double> table;
  for (int i = 0; i <= 2 * steps_per_turn; ++i) {
    table.push_back(std::cos(pi * i / steps_per_turn));
    table.push_back(std::sin(pi * i / steps_per_turn));
  }
  constexpr int lanes = I::lanes;
  for (auto _ : state) {
    for (int first = 0; first < machines; first += lanes * packs) {
      Hand<I> h;
      for (int i = 0; i < packs; ++i) {
        double f[lanes], d[lanes], k[lanes], c[lanes];
        for (int lane = 0; lane < lanes; ++lane) {
          const double eta = 0.9 + 0.5 * (first + lanes * i + lane) / machines;
          const double step = two_pi / (eta * steps_per_turn);
          f[lane] = step * step * eta * eta * 0.0973;
          d[lane] = step * 0.0347;
          k[lane] = step * step;
          c[lane] = step * step * 13.68;
        }
        h.f[i] = I::load(f);
        h.d[i] = I::load(d);
        h.k[i] = I::load(k);
        h.c[i] = I::load(c);
        h.m[i] = I::set(0.015);
        h.x[i] = I::set(1.0);
        h.y[i] = h.vx[i] = h.vy[i] = I::set(0.0);
      }
      for (int t = 0; t < turns; ++t) handBlock<I>(h, table.data(), steps_per_turn);
      double sum = I::first(I::add(h.x[0], h.y[packs - 1]));
      benchmark::DoNotOptimize(sum);
    }
  }
  state.SetItemsProcessed(state.iterations() * machines * turns * steps_per_turn);
}

}  // namespace amb_rotor::bench
