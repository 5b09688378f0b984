#pragma once
// Small hybrid systems for tests of the integrator.
#include <cmath>
#include <functional>

#include "amb_rotor/integration/event_integrator.hpp"

namespace amb_rotor::testing_support {

/// A mass above a floor at x = 0:  x'' = -gravity - w^2 x - cubic x^3 - (in contact) (k x + c x').
/// Contact is carried while x < 0 and the floor pushes.
struct FloorBounce final : HybridSystem {
  double gravity = 9.81, square = 0.0, cubic = 0.0, stiffness = 4e4, damping = 0.0;
  int mode = 0;
  long touches = 0;

  int size() const override { return 2; }
  int guards() const override { return 1; }
  void derivatives(double, const double* y, double* rate) const override {
    rate[0] = y[1];
    rate[1] = -gravity - square * y[0] - cubic * y[0] * y[0] * y[0];
    if (mode == 1) rate[1] -= stiffness * y[0] + damping * y[1];
  }
  void guardValues(double, const double* y, double* guard) const override {
    const double inside = std::min(-y[0], -y[0] - damping / stiffness * y[1]);
    guard[0] = mode == 1 ? inside : -inside;
  }
  void onEvent(int, double, double*) override {
    mode = 1 - mode;
    touches += mode;
  }
  double energy(const double* y) const {
    const double depth = std::min(y[0], 0.0);
    return 0.5 * y[1] * y[1] + gravity * y[0] + 0.5 * square * y[0] * y[0] +
           0.25 * cubic * y[0] * y[0] * y[0] * y[0] + 0.5 * stiffness * depth * depth;
  }
};

/// Any smooth system by its right-hand side.
struct Smooth final : HybridSystem {
  int states;
  std::function<void(double, const double*, double*)> rates;
  Smooth(int n, std::function<void(double, const double*, double*)> f) : states(n), rates(std::move(f)) {}
  int size() const override { return states; }
  void derivatives(double time, const double* y, double* rate) const override { rates(time, y, rate); }
};

}  // namespace amb_rotor::testing_support
