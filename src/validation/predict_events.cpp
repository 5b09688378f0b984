// Predictions of set-valued friction: one machine at a time, touch-down, lift-off, stick and slip located.
#include <algorithm>
#include <cmath>

#include "amb_rotor/machine/event_stepper.hpp"
#include "amb_rotor/validation/predict_impl.hpp"
#include "amb_rotor/validation/stretches.hpp"

namespace amb_rotor {

namespace {

/// The tolerance of fits: an error of 1e-12 m a step, against differences of starts of 2e-9 m.
constexpr double prediction_tolerance = 1e-7;

struct LocatedEvents {
  using Stepper = EventStepper;
  static Stepper make(const Machine<double>& machine, double, double) {
    return EventStepper(machine, prediction_tolerance);
  }
  /// A fit has moved the state: what touches and what sticks follows from where it is now.
  static void begin(const Machine<double>& machine, MachineState<double>& state) {
    for (int end = 0; end < 2; ++end) {
      state.contact_mode[end] = machine.contactGuard(end, state.mechanics.data()) > 0.0 ? 1 : 0;
      state.sliding[end] = sliding_unset;
    }
  }
};

}  // namespace

bool slidesThroughout(const Recording& rec, const Model& model, long first, long last) {
  // tanh(v/v0) is 1 from 0.2 m/s on. The rest is for mounts, which follow the rotor or ring at what friction gives their
  // small mass, and for starts that a fit has yet to find.
  constexpr double far_from_stick_m_s = 1.0, of_whirl = 3.0;
  for (const auto& effect : model.effects)
    if (effect.id == "inner_ring_spin") return false;
  if (std::any_of(rec.noise.begin(), rec.noise.begin() + 4, [](double noise) { return noise <= 0.0; })) return false;
  double whirl = 0.0;
  for (long i = std::max(1L, first - 1); i < std::min(rec.samples - 1, last + 1); ++i) {
    const double *after = &rec.measured[(i + 1) * predicted_channels], *before = &rec.measured[(i - 1) * predicted_channels];
    double moved[4];
    for (int c = 0; c < 4; ++c) moved[c] = after[c] - before[c];
    for (const double z : model.rig.planes.aux)
      whirl = std::max(whirl, 0.5 * rec.run.sample_rate_hz * radiusAt(moved, model, z));
  }
  const double rate = rec.run.sample_rate_hz;
  const double slowest = std::min(std::fabs(shaftAt(rec, model, static_cast<double>(first) / rate).speed),
                                  std::fabs(shaftAt(rec, model, static_cast<double>(last) / rate).speed));
  return model.rig.auxiliary_bearing.rotor_radius_m * slowest > of_whirl * whirl + far_from_stick_m_s;
}

void predictByEvents(const Stretch& stretch, LaneJob& job) { predictPack<double, LocatedEvents>(stretch, &job, 1); }

}  // namespace amb_rotor
