#include "amb_rotor/machine/event_stepper.hpp"

#include <cmath>

#include "amb_rotor/machine/set_valued_friction.hpp"

namespace amb_rotor {

/// The machine between two instants, as an integrator sees it.
class EventStepper::System final : public HybridSystem {
 public:
  explicit System(const Machine<double>& machine)
      : machine_(machine),
        sliding_(machine),
        lag_work_() {}

  int size() const override { return machine_.stateSize(); }
  /// Contact of each end; with set-valued friction the sliding of each end, too.
  int guards() const override { return 2 + sliding_.guards(); }

  void begin(const Simulator<double>& sim, double from, MachineState<double>& state,
             const Simulator<double>::Held& held) {
    sim_ = &sim;
    from_ = from;
    state_ = &state;
    held_ = &held;
    lag_work_ = state.lag;
    Inputs<double> in;
    if (sliding_.guards() > 0) inputs(from, in);
    sliding_.begin(in, state.mechanics.data(), state);
  }

  void inputs(double time, Inputs<double>& in) const {
    if (machine_.spin() == Spin::prescribed) in.shaft = sim_->drive().shaft(time);
    in.shaft.time = time;
    in.hold_speed = sim_->drive().hold_speed;
    in.bearing_on[0] = held_->bearing_on[0];
    in.bearing_on[1] = held_->bearing_on[1];
    sim_->electricInputs(time, from_, *held_, in);
    const auto& track = sim_->track();
    double current[4];
    std::copy(state_->current, state_->current + 4, current);
    if (!track.lags()) {
      const double decay = track.amplifier().decay(time - from_);
      for (int a = 0; a < 4; ++a) current[a] = held_->target[a] + (current[a] - held_->target[a]) * decay;
      track.forceCurrent(current, nullptr, in.force_current);
    } else {
      std::copy(state_->lag.begin(), state_->lag.end(), lag_work_.begin());
      track.move(track.decay(time - from_), held_->target, current, lag_work_.data());
      track.forceCurrent(current, lag_work_.data(), in.force_current);
    }
    const Schedule* schedule = sim_->drive().schedule;
    if (schedule != nullptr) {
      schedule->forces(time, from_, forces_);
      schedule->unbalanceFactors(time, from_, factors_);
      in.extra_force = forces_.data();
      in.extra_unbalance = factors_.data();
    }
    in.contact_mode = state_->contact_mode;
  }

  void derivatives(double time, const double* y, double* rate) const override {
    Inputs<double> in;
    inputs(time, in);
    double force[2];
    sliding_.complete(in, y, force);
    machine_.derivatives(in, y, rate);
  }

  void guardValues(double time, const double* y, double* guard) const override {
    for (int end = 0; end < 2; ++end) {
      const double inside = machine_.contactGuard(end, y);
      guard[end] = state_->contact_mode[end] != 0 ? inside : -inside;
    }
    if (sliding_.guards() == 0) return;
    Inputs<double> in;
    inputs(time, in);
    sliding_.guardValues(in, y, guard + 2);
  }

  void onEvent(int guard, double time, double* y) override {
    Inputs<double> in;
    if (sliding_.guards() > 0) inputs(time, in);
    if (guard >= 2) return sliding_.onGuard(guard - 2, in, y);
    const int end = guard;
    state_->contact_mode[end] = 1 - state_->contact_mode[end];
    sliding_.onContact(end, in, y);
    if (observer) observer(end, state_->contact_mode[end] != 0, time, y);
  }

  std::function<void(int, bool, double, const double*)> observer;

 private:
  const Machine<double>& machine_;
  SlidingModes sliding_;
  const Simulator<double>* sim_ = nullptr;
  MachineState<double>* state_ = nullptr;
  const Simulator<double>::Held* held_ = nullptr;
  double from_ = 0.0;
  mutable std::vector<double> lag_work_;
  mutable std::vector<Vec2<double>> forces_;
  mutable std::vector<double> factors_;
};

EventStepper::EventStepper(const Machine<double>& machine, double relative_tolerance)
    : system_(std::make_unique<System>(machine)) {
  IntegratorOptions options;
  options.relative_tolerance = relative_tolerance;
  options.absolute.assign(machine.stateSize(), 1e-3);
  const int coordinates = machine.coordinates();
  for (int i = 0; i < coordinates; ++i) {
    options.absolute[i] = 1e-5;
    options.absolute[coordinates + i] = 1e-2;
  }
  integrator_ = std::make_unique<EventIntegrator>(*system_, options);
}

EventStepper::~EventStepper() = default;

void EventStepper::setContactObserver(std::function<void(int, bool, double, const double*)> observer) {
  system_->observer = std::move(observer);
}

bool EventStepper::advance(const Simulator<double>& sim, double from, double to, MachineState<double>& state,
                           const Simulator<double>::Held& held) {
  system_->begin(sim, from, state, held);
  integrator_->restart();  // the commands' jump is a kink of the motion
  result_ = integrator_->advance(from, to, state.mechanics.data());
  if (result_.status != IntegrationStatus::ok) return false;
  const auto& track = sim.track();
  track.move(track.decay(to - from), held.target, state.current, state.lag.data());
  sim.readCoils(state);
  return true;
}

}  // namespace amb_rotor
