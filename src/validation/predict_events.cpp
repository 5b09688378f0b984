// Predictions of set-valued friction: one machine at a time, touch-down, lift-off, stick and slip located.
#include "amb_rotor/machine/event_stepper.hpp"
#include "amb_rotor/validation/predict_impl.hpp"

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

void predictByEvents(const Stretch& stretch, LaneJob* jobs, std::size_t count) {
  for (std::size_t k = 0; k < count; ++k) predictPack<double, LocatedEvents>(stretch, jobs + k, 1);
}

}  // namespace amb_rotor
