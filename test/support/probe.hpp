#pragma once
// Looks at a machine at one state.
#include <random>

#include "models.hpp"

namespace amb_rotor::testing_support {

struct Probe {
  Model model;
  Machine<double> machine;
  Inputs<double> in;
  std::vector<double> y, rate;
  Observation<double> seen;

  explicit Probe(const Model& m, Spin spin = Spin::prescribed)
      : model(m), machine({&model}, spin), y(machine.stateSize(), 0.0), rate(machine.stateSize(), 0.0) {
    machine.initialise(y.data());
  }
  Probe& look() {
    machine.observe(in, y.data(), rate.data(), seen);
    return *this;
  }
  /// Speed and angle of the shaft.
  Probe& turning(double speed, double angle = 0.0) {
    in.shaft = Shaft<double>::at(angle, speed, 0.0);
    return *this;
  }
  /// x_G, y_G, tilt b, tilt r and their rates, the order of a scenario, for a rigid beam.
  Probe& beam(const std::vector<double>& c) {
    const int place[8] = {0, 2, 1, 3, 4, 6, 5, 7};
    for (std::size_t i = 0; i < c.size(); ++i) y[place[i]] = c[i];
    return *this;
  }
};

/// Force that an effect adds, as force and moment: difference of the accelerations times the inertias of a
/// beam.
struct Wrench {
  Vec2<double> force, moment;
};
inline Wrench addedWrench(Probe& without, Probe& with) {
  without.look();
  with.look();
  const double m = with.model.rig.rotor.mass_kg, it = with.model.rig.rotor.transverse_inertia_kg_m2;
  const auto d = [&](int i) { return with.rate[i] - without.rate[i]; };
  return {{m * d(4), m * d(6)}, {it * d(5), it * d(7)}};
}

}  // namespace amb_rotor::testing_support
