#pragma once
// Compiled once an instruction set, in contact_newton_<set>.cpp. In an unnamed namespace, so that none of it
// is shared: packs of four nodes, which the compiler makes of what the set has.
#include "amb_rotor/integration/contact_newton.hpp"

namespace amb_rotor {
namespace {

typedef double Four __attribute__((vector_size(32)));
typedef double FourAt __attribute__((vector_size(32), aligned(8), may_alias));

constexpr int nodes = ContactNodes::nodes, per_end = 4, rows = per_end * ContactNodes::most;
static_assert(nodes == 4, "packs are of four");

const FourAt& at(const double* p) { return *reinterpret_cast<const FourAt*>(p); }
FourAt& at(double* p) { return *reinterpret_cast<FourAt*>(p); }

double change(int first, int ends, const double* w, const double* before, double length, double speed) {
  const Four none = {};
  Four most = none;
  const double scale[] = {1.0 / length, 1.0 / speed};
  for (int r = first * per_end; r < (first + ends) * per_end; ++r) {
    const Four moved = (at(w + r * nodes) - at(before + r * nodes)) * scale[r % per_end / 2];
    const Four size = moved < none ? -moved : moved;
    most = most < size ? size : most;
  }
  const double left = most[0] < most[1] ? most[1] : most[0], right = most[2] < most[3] ? most[3] : most[2];
  return left < right ? right : left;
}

/// The inverse of a matrix near 1, in its place (Gauss and Jordan, without pivoting). A row is one run of
/// numbers without exceptions: its pivot's column is what the row that is subtracted has there, 1 more than
/// what is to stay.
template <int ends>
void invert(Four (&a)[nodes * ends][ends]) {
  constexpr int count = nodes * ends;
#pragma GCC unroll 8
  for (int p = 0; p < count; ++p) {
    const double inverse = 1.0 / a[p][p / nodes][p % nodes];
    Four row[ends];
    for (int e = 0; e < ends; ++e) row[e] = a[p][e] * inverse;
    a[p][0] = row[0];
    if (ends > 1) a[p][ends - 1] = row[ends - 1];
    a[p][p / nodes][p % nodes] = inverse;
    row[p / nodes][p % nodes] = 1.0 + inverse;
#pragma GCC unroll 8
    for (int k = 0; k < count; ++k) {
      if (k == p) continue;
      const double factor = a[k][p / nodes][p % nodes];
      for (int e = 0; e < ends; ++e) a[k][e] -= factor * row[e];
    }
  }
}

template <int ends>
void lineariseEnds(int first, const double* forced, const ContactNodes& n, const double* evaluated,
                   double (*inverse)[ContactNodes::most]) {
  Four weight[ends][per_end], matrix[nodes * ends][ends];
  double direction[ends][2][nodes];
  for (int e = 0; e < ends; ++e) {
    const int i = (first + e) * nodes;
    const Four x = at(n.x + i), y = at(n.y + i), slope = at(n.slope + i), damping = at(n.damping + i);
    weight[e][0] = slope * x;
    weight[e][1] = slope * y;
    weight[e][2] = damping * x;
    weight[e][3] = damping * y;
    const Four force = at(n.force + i), none = {};
    const Four share = -1.0 / force;  // where there is no force yet, along the normal
    at(direction[e][0]) = force == none ? x : at(evaluated + 2 * i) * share;
    at(direction[e][1]) = force == none ? y : at(evaluated + 2 * i + nodes) * share;
  }
  for (int l = 0; l < nodes * ends; ++l) {
    const int by = l / nodes, node = l % nodes;
    const double ex = direction[by][0][node], ey = direction[by][1][node];
    const double* by_x = forced + LinearFlow::column(2 * (first + by), node) * rows;
    const double* by_y = forced + LinearFlow::column(2 * (first + by) + 1, node) * rows;
    for (int e = 0; e < ends; ++e) {
      const int r = LinearFlow::row((first + e) * per_end, 0);
      Four sum = {};
      for (int o = 0; o < per_end; ++o)
        sum += weight[e][o] * (ex * at(by_x + r + o * nodes) + ey * at(by_y + r + o * nodes));
      matrix[l][e] = sum;
    }
    matrix[l][by][node] += 1.0;
  }
  // the matrix is near 1 where the step suits the contact; where it is not, the passes do not contract
  invert<ends>(matrix);
  for (int l = 0; l < nodes * ends; ++l)
    for (int e = 0; e < ends; ++e) at(inverse[l] + e * nodes) = matrix[l][e];
}

template <int ends>
void correctEnds(int first, const ContactNodes& n, const double* evaluated,
                 const double (*inverse)[ContactNodes::most], double* u) {
  double plain[ends][nodes];  // the fixed point's step
  for (int e = 0; e < ends; ++e) {
    const int i = (first + e) * nodes;
    at(plain[e]) = at(n.force + i) + at(u + 2 * i) * at(n.x + i) + at(u + 2 * i + nodes) * at(n.y + i);
  }
  Four moved[ends] = {};
  for (int l = 0; l < nodes * ends; ++l)
    for (int e = 0; e < ends; ++e) moved[e] += plain[l / nodes][l % nodes] * at(inverse[l] + e * nodes);
  for (int e = 0; e < ends; ++e) {
    const int i = (first + e) * nodes;
    const Four force = at(n.force + i), none = {}, beyond = moved[e] - at(plain[e]), share = beyond / force;
    const Four x = at(evaluated + 2 * i), y = at(evaluated + 2 * i + nodes);
    at(u + 2 * i) = x + (force == none ? -beyond * at(n.x + i) : share * x);
    at(u + 2 * i + nodes) = y + (force == none ? -beyond * at(n.y + i) : share * y);
  }
}

void linearise(int first, int ends, const double* forced, const ContactNodes& n, const double* evaluated,
               double (*inverse)[ContactNodes::most]) {
  (ends == 1 ? lineariseEnds<1> : lineariseEnds<2>)(first, forced, n, evaluated, inverse);
}

void correct(int first, int ends, const ContactNodes& n, const double* evaluated,
             const double (*inverse)[ContactNodes::most], double* u) {
  (ends == 1 ? correctEnds<1> : correctEnds<2>)(first, n, evaluated, inverse, u);
}

constexpr ContactKernels kernels_of_set = {change, linearise, correct};

}  // namespace
}  // namespace amb_rotor
