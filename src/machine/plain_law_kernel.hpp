#pragma once
// Compiled once an instruction set, in plain_law_<set>.cpp. In an unnamed namespace, so that none of it is
// shared: packs of four nodes, which the compiler makes of what the set has.
#include <cmath>
#if defined(__AVX__)
#include <immintrin.h>
#endif

#include "plain_law.hpp"

namespace amb_rotor {
namespace {

typedef double Four __attribute__((vector_size(32)));
typedef double FourAt __attribute__((vector_size(32), aligned(8), may_alias));

const FourAt& at(const double* p) { return *reinterpret_cast<const FourAt*>(p); }
FourAt& at(double* p) { return *reinterpret_cast<FourAt*>(p); }

void takeRoot(Four& a) {
#if defined(__AVX__)
  a = _mm256_sqrt_pd(a);
#else
  for (int i = 0; i < 4; ++i) a[i] = std::sqrt(a[i]);
#endif
}

/// tanh, which is a sign but where the end hardly slides.
void takeFriction(Four& a) {
  const Four none = {}, size = a < none ? -a : a;
  if (size[0] > PlainLaw::saturated && size[1] > PlainLaw::saturated && size[2] > PlainLaw::saturated &&
      size[3] > PlainLaw::saturated) {
    a = a < none ? none - 1.0 : none + 1.0;
    return;
  }
  for (int i = 0; i < 4; ++i) a[i] = std::tanh(a[i]);
}

void forcesOfSet(const PlainLaw& law, int first, int count, const double* w, double* u, ContactNodes& nodes) {
  const Four none = {};
  for (int e = first; e < first + count; ++e) {
    const double* seen = w + LinearFlow::row(4 * e, 0);
    const Four x = at(seen), y = at(seen + 4), vx = at(seen + 8), vy = at(seen + 12);
    Four distance = x * x + y * y + 1e-30;
    takeRoot(distance);
    const Four inverse = 1.0 / distance, nx = x * inverse, ny = y * inverse;
    const Four depth = distance - law.clearance, rate = nx * vx + ny * vy;
    Four force, margin, slope, damping;
    if (law.hertz) {
      const Four inside = depth > none ? depth : none, factor = 1.0 + law.damping * rate;
      Four root = inside;
      takeRoot(root);
      const Four elastic = law.stiffness * inside * root;
      force = elastic * factor;
      margin = 1e-3 * factor;
      slope = 1.5 * law.stiffness * root * factor;
      damping = elastic * law.damping;
    } else {
      force = law.stiffness * depth + law.damping * rate;
      margin = force * law.compliance;
      slope = none + law.stiffness;
      damping = none + law.damping;
    }
    Four share = (law.surface_speed + nx * vy - ny * vx) * (1.0 / friction_regularisation_m_s);
    takeFriction(share);
    const Four tangential = -law.friction * force * share;
    const int k = 4 * e;
    at(nodes.force + k) = force;
    at(nodes.slope + k) = slope;
    at(nodes.damping + k) = damping;
    at(nodes.x + k) = nx;
    at(nodes.y + k) = ny;
    at(nodes.guard + k) = margin < depth ? margin : depth;
    at(u + 2 * k) = -force * nx - tangential * ny;
    at(u + 2 * k + 4) = tangential * nx - force * ny;
  }
}

}  // namespace
}  // namespace amb_rotor
