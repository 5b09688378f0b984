#pragma once
// What drives a machine through a run: shaft, excitation, faults, sensor errors. Shared by all lanes but for
// what carries a Scalar.
#include <vector>

#include "amb_rotor/common/scalar.hpp"
#include "amb_rotor/common/shaft.hpp"
#include "amb_rotor/excitation/schedule.hpp"
#include "amb_rotor/excitation/shaft_path.hpp"

namespace amb_rotor {

/// Excitation currents as recorded: value m holds from m/rate until the next.
struct HeldExcitation {
  double rate_hz = 0.0;
  std::vector<double> axis[4];  ///< ax, ay, bx, by [A]; empty: none

  double at(int a, double time) const {
    if (axis[a].empty()) return 0.0;
    const long i = static_cast<long>(time * rate_hz + 1e-6);
    return i < 0 || i >= static_cast<long>(axis[a].size()) ? 0.0 : axis[a][i];
  }
};

template <class S>
struct Drive {
  const ShaftPath* path = nullptr;   ///< null: angle0 + speed t, a value for each lane
  S angle0 = S(0.0), speed = S(0.0);         ///< [rad], [rad/s]
  bool turned = false;               ///< beside a path: they are added to its angle and speed
  bool hold_speed = false;           ///< where the spin is a state: the drive keeps it (run-in)
  const HeldExcitation* excitation = nullptr;
  std::vector<const HeldExcitation*> lane_excitation;  ///< in its place for the values, a lane each, all of its rate; empty: none
  const Schedule* schedule = nullptr;
  S sensor_offset[4] = {S(0.0), S(0.0), S(0.0), S(0.0)};  ///< [m]
  S sensor_drift[4] = {S(0.0), S(0.0), S(0.0), S(0.0)};   ///< [m/s], from t = 0

  /// Recorded excitation current of an axis [A].
  S excited(int axis, double time) const {
    if (lane_excitation.empty()) return S(excitation != nullptr ? excitation->at(axis, time) : 0.0);
    S out = S(0.0);
    for (std::size_t l = 0; l < lane_excitation.size(); ++l) setLane(out, l, lane_excitation[l]->at(axis, time));
    return out;
  }

  Shaft<S> shaft(double time) const {
    Shaft<S> shaft;
    if (path != nullptr) {
      const ShaftInstant now = path->at(time);
      if (turned) {
        shaft = Shaft<S>::at(S(now.angle) + angle0 + speed * S(time), S(now.speed) + speed, S(now.acceleration));
        shaft.time = time;
        return shaft;
      }
      shaft.angle = S(now.angle);
      shaft.cosine = S(std::cos(now.angle));
      shaft.sine = S(std::sin(now.angle));
      shaft.speed = S(now.speed);
      shaft.acceleration = S(now.acceleration);
    } else {
      shaft = Shaft<S>::at(angle0 + speed * S(time), speed, S(0.0));
    }
    shaft.time = time;
    return shaft;
  }
};

}  // namespace amb_rotor
