#pragma once
// The lanes' inner loop, instantiated once an instruction set in basic_lanes_<set>.cpp. Those files are
// compiled with other flags than the rest: only plain arrays and templates that depend on the instruction
// set may appear here (an inline function shared with other files would be linked in one version only, and
// that could be the one this processor cannot run).
#include <cstddef>
#include <type_traits>

#include "amb_rotor/machine/basic_model.hpp"

namespace amb_rotor {

constexpr int basic_coefficient_count = 10;
constexpr int basic_packs = 4;  ///< interleaved packs a block

constexpr int basic_tangent_turns = 40;  ///< turns before the record that a tangent is followed

/// One call of a kernel. Columns have one entry a lane; lanes are a multiple of the block's.
struct BasicLaneWork {
  const double* coefficients[basic_coefficient_count];  ///< in step units, order of BasicCoefficients
  double* state[4];                                     ///< x, y, vx, vy in step units; in and out
  double* section[4];     ///< the same at the end of each kept turn: [turn * lanes + lane]; may be null
  double* contact_steps;  ///< out
  double* largest;        ///< out: largest and smallest squared distance from the bearing's centre
  double* smallest;
  double* swept;        ///< out: angle about the bearing's centre [rad]
  double* log_growth;   ///< out: sum of the logarithms of the tangent's growth; null: not wanted
  const double* step;   ///< length of a step [1/w_n], for the norm of a tangent
  const double* table;  ///< cosine and sine of the phase at every half step of a turn, interleaved
  std::size_t lanes;
  int steps_per_turn, turns_skipped, turns_kept;
};

using BasicKernel = void (*)(const BasicLaneWork& work, std::size_t first_lane);

/// The kernels of one instruction set: [contact][friction][with tangent].
struct BasicKernelSet {
  std::size_t block_lanes;  ///< lanes a call
  BasicKernel kernel[2][2][2];
};

BasicKernelSet basicKernelsBaseline();
BasicKernelSet basicKernelsAvx2();
BasicKernelSet basicKernelsAvx512();

namespace lanes {

template <class S, class T, int packs>
struct Block {
  BasicCoefficients<S> c[packs];
  T x[packs], y[packs], vx[packs], vy[packs];
};

template <class Model, bool recorded, class S, class T, int packs, class Sums>
inline __attribute__((always_inline)) void turn(Block<S, T, packs>& b, const double* table, int steps,
                                                Sums* sums) {
  T a1x[packs], a1y[packs], qx[packs], qy[packs], wx[packs], wy[packs], sx[packs], sy[packs], tx[packs],
      ty[packs];
  const S half(0.5), quarter(0.25), sixth(1.0 / 6.0), two(2.0);
  for (int i = 0; i < steps; ++i, table += 4) {
    const S c0(table[0]), s0(table[1]), c1(table[2]), s1(table[3]), c2(table[4]), s2(table[5]);
    for (int k = 0; k < packs; ++k) {
      if constexpr (recorded) sums->take(k, b);
      Model::acceleration(b.c[k], b.c[k].forcing * c0, b.c[k].forcing * s0, b.x[k], b.y[k], b.vx[k], b.vy[k],
                          a1x[k], a1y[k]);
    }
    for (int k = 0; k < packs; ++k) {
      T a2x, a2y;
      qx[k] = b.x[k] + half * b.vx[k];
      qy[k] = b.y[k] + half * b.vy[k];
      Model::acceleration(b.c[k], b.c[k].forcing * c1, b.c[k].forcing * s1, qx[k], qy[k],
                          b.vx[k] + half * a1x[k], b.vy[k] + half * a1y[k], a2x, a2y);
      qx[k] = qx[k] + quarter * a1x[k];
      qy[k] = qy[k] + quarter * a1y[k];
      wx[k] = b.vx[k] + half * a2x;
      wy[k] = b.vy[k] + half * a2y;
      sx[k] = a1x[k] + a2x;  // a1 + a2, later + a3
      sy[k] = a1y[k] + a2y;
      tx[k] = a2x;  // a2, later a2 + a3
      ty[k] = a2y;
    }
    for (int k = 0; k < packs; ++k) {
      T a3x, a3y;
      Model::acceleration(b.c[k], b.c[k].forcing * c1, b.c[k].forcing * s1, qx[k], qy[k], wx[k], wy[k], a3x,
                          a3y);
      qx[k] = b.x[k] + b.vx[k] + half * tx[k];
      qy[k] = b.y[k] + b.vy[k] + half * ty[k];
      wx[k] = b.vx[k] + a3x;
      wy[k] = b.vy[k] + a3y;
      sx[k] = sx[k] + a3x;
      sy[k] = sy[k] + a3y;
      tx[k] = tx[k] + a3x;
      ty[k] = ty[k] + a3y;
    }
    for (int k = 0; k < packs; ++k) {
      T a4x, a4y;
      Model::acceleration(b.c[k], b.c[k].forcing * c2, b.c[k].forcing * s2, qx[k], qy[k], wx[k], wy[k], a4x,
                          a4y);
      b.x[k] = b.x[k] + b.vx[k] + sixth * sx[k];
      b.y[k] = b.y[k] + b.vy[k] + sixth * sy[k];
      b.vx[k] = b.vx[k] + sixth * (a1x[k] + two * tx[k] + a4x);
      b.vy[k] = b.vy[k] + sixth * (a1y[k] + two * ty[k] + a4y);
    }
  }
}

/// What is summed over the recorded turns.
template <class S, int packs>
struct RunningSums {
  S contact[packs], largest[packs], smallest[packs], swept[packs];

  template <class T>
  inline __attribute__((always_inline)) void take(int k, const Block<S, T, packs>& b) {
    const S u = valueOf(b.x[k]) - b.c[k].misalignment_x;
    const S v = valueOf(b.y[k]) - b.c[k].misalignment_y;
    const S square = u * u + v * v;
    contact[k] = contact[k] + select(square > S(1.0), S(1.0), S(0.0));
    largest[k] = maximum(largest[k], square);
    smallest[k] = minimum(smallest[k], square);
    // Angle swept about the bearing's centre: rate u v' - v u' over r^2, for a distance that cannot vanish.
    swept[k] = swept[k] + (u * valueOf(b.vy[k]) - v * valueOf(b.vx[k])) / maximum(square, S(1e-6));
  }
};

template <class S, int packs>
inline void divideTangent(Block<S, Tangent<S>, packs>& b, int k, const S& step, S& log_growth) {
  const S rate = S(1.0) / step;
  const S dvx = b.vx[k].slope * rate, dvy = b.vy[k].slope * rate;
  const S square = b.x[k].slope * b.x[k].slope + b.y[k].slope * b.y[k].slope + dvx * dvx + dvy * dvy;
  const S norm = squareRoot(square);
  log_growth = log_growth + logarithm(norm);
  const S scale = S(1.0) / norm;
  b.x[k].slope = b.x[k].slope * scale;
  b.y[k].slope = b.y[k].slope * scale;
  b.vx[k].slope = b.vx[k].slope * scale;
  b.vy[k].slope = b.vy[k].slope * scale;
}

template <class S>
inline S loaded(const double* column) {
  if constexpr (ScalarTraits<S>::lanes == 1) {
    return S(*column);
  } else {
    return S::load_unaligned(column);
  }
}
template <class S>
inline void store(const S& value, double* column) {
  if constexpr (ScalarTraits<S>::lanes == 1) {
    *column = value;
  } else {
    value.store_unaligned(column);
  }
}

template <class S, class T, int packs>
inline void storeSection(const Block<S, T, packs>& b, double* const* columns, std::size_t at) {
  constexpr std::size_t width = ScalarTraits<S>::lanes;
  for (int k = 0; k < packs; ++k) {
    store(valueOf(b.x[k]), columns[0] + at + k * width);
    store(valueOf(b.y[k]), columns[1] + at + k * width);
    store(valueOf(b.vx[k]), columns[2] + at + k * width);
    store(valueOf(b.vy[k]), columns[3] + at + k * width);
  }
}

/// The recorded turns, with T = S, or Tangent<S> for the growth of a small difference.
template <class Model, class S, class T, int packs>
inline void recordTurns(const BasicLaneWork& work, std::size_t first, Block<S, T, packs>& b) {
  constexpr bool tangent = !std::is_same_v<S, T>;
  constexpr std::size_t width = ScalarTraits<S>::lanes;
  RunningSums<S, packs> sums;
  S growth[packs];
  for (int k = 0; k < packs; ++k) {
    sums.contact[k] = S(0.0);
    sums.largest[k] = S(0.0);
    sums.smallest[k] = S(1e300);
    sums.swept[k] = S(0.0);
    growth[k] = S(0.0);
  }
  for (int t = 0; t < work.turns_kept; ++t) {
    turn<Model, true>(b, work.table, work.steps_per_turn, &sums);
    if constexpr (tangent) {
      for (int k = 0; k < packs; ++k)
        divideTangent(b, k, loaded<S>(work.step + first + k * width), growth[k]);
    }
    storeSection(b, work.section, static_cast<std::size_t>(t) * work.lanes + first);
  }
  storeSection(b, work.state, first);
  for (int k = 0; k < packs; ++k) {
    const std::size_t at = first + k * width;
    store(sums.contact[k], work.contact_steps + at);
    store(sums.largest[k], work.largest + at);
    store(sums.smallest[k], work.smallest + at);
    store(sums.swept[k], work.swept + at);
    if constexpr (tangent) store(growth[k], work.log_growth + at);
  }
}

template <class Model, class S, bool tangent>
void runBlock(const BasicLaneWork& work, std::size_t first) {
  constexpr int packs = basic_packs;
  constexpr std::size_t width = ScalarTraits<S>::lanes;
  Block<S, S, packs> b;
  for (int k = 0; k < packs; ++k) {
    const std::size_t at = first + k * width;
    S* field[basic_coefficient_count] = {
        &b.c[k].forcing,         &b.c[k].damping,       &b.c[k].stiffness,      &b.c[k].contact,
        &b.c[k].contact_damping, &b.c[k].friction,      &b.c[k].misalignment_x, &b.c[k].misalignment_y,
        &b.c[k].surface_speed,   &b.c[k].regularisation};
    for (int i = 0; i < basic_coefficient_count; ++i) *field[i] = loaded<S>(work.coefficients[i] + at);
    S* state[4] = {&b.x[k], &b.y[k], &b.vx[k], &b.vy[k]};
    for (int i = 0; i < 4; ++i) *state[i] = loaded<S>(work.state[i] + at);
  }
  using Sums = RunningSums<S, packs>;
  // Before the record a tangent only has to turn towards the direction of fastest growth: a few turns do.
  int alone = work.turns_skipped;
  if constexpr (tangent)
    alone = work.turns_skipped > basic_tangent_turns ? work.turns_skipped - basic_tangent_turns : 0;
  for (int t = 0; t < alone; ++t)
    turn<Model, false>(b, work.table, work.steps_per_turn, static_cast<Sums*>(nullptr));
  if constexpr (!tangent) {
    recordTurns<Model>(work, first, b);
  } else {
    Block<S, Tangent<S>, packs> with;
    for (int k = 0; k < packs; ++k) {
      with.c[k] = b.c[k];
      with.x[k] = {b.x[k], S(0.6)};
      with.y[k] = {b.y[k], S(0.8)};
      with.vx[k] = {b.vx[k], S(0.0)};
      with.vy[k] = {b.vy[k], S(0.0)};
    }
    S ignored(0.0);
    for (int t = alone; t < work.turns_skipped; ++t) {
      turn<Model, false>(with, work.table, work.steps_per_turn, static_cast<Sums*>(nullptr));
      for (int k = 0; k < packs; ++k)
        divideTangent(with, k, loaded<S>(work.step + first + k * width), ignored);
    }
    recordTurns<Model>(work, first, with);
  }
}

template <class S>
BasicKernelSet kernelsOf() {
  using LinearSpin = BasicModel<LinearContact, SpinFriction>;
  using LinearSliding = BasicModel<LinearContact, SlidingFriction>;
  using HertzSpin = BasicModel<HertzContact, SpinFriction>;
  using HertzSliding = BasicModel<HertzContact, SlidingFriction>;
  return {basic_packs * ScalarTraits<S>::lanes,
          {{{runBlock<LinearSpin, S, false>, runBlock<LinearSpin, S, true>},
            {runBlock<LinearSliding, S, false>, runBlock<LinearSliding, S, true>}},
           {{runBlock<HertzSpin, S, false>, runBlock<HertzSpin, S, true>},
            {runBlock<HertzSliding, S, false>, runBlock<HertzSliding, S, true>}}}};
}

}  // namespace lanes
}  // namespace amb_rotor
