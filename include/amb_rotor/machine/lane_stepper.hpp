#pragma once
// Fixed-step Runge-Kutta 4 for lanes (and double): contact by masks. A step in which an end of a lane touches or
// leaves is taken again in four parts, the part with the change again, and once more, so that the jump of the contact
// force is met to 1/64 of a step (or 2.5 us); all other steps only need to resolve the smooth motion. The event-accurate
// stepper is the reference.
// Set-valued friction is not here: whether an end sticks is a mode of its own, with events of its own, in every lane. A
// model with friction_law set_valued is refused by name; predictions take such windows by events (validation/predict.hpp).
#include <algorithm>
#include <cmath>

#include "amb_rotor/machine/set_valued_friction.hpp"
#include "amb_rotor/machine/simulator.hpp"

namespace amb_rotor {

template <class S>
class LaneStepper {
 public:
  /// @param largest_step_s  of the integration between instants
  /// @param contact_step_s  the same where an end of a lane is in contact or about to be; 0: contact is left out
  LaneStepper(const Machine<S>& machine, double largest_step_s, double contact_step_s)
      : largest_(largest_step_s), contact_(contact_step_s) {
    refuseSetValuedFriction(machine.frictionLaw(), "lanes");
    const int n = machine.stateSize();
    for (auto* buffer : {&k1_, &k2_, &k3_, &k4_, &work_}) buffer->assign(n, S(0.0));
  }

  bool advance(const Simulator<S>& sim, double from, double to, MachineState<S>& state,
               const typename Simulator<S>::Held& held) {
    const Machine<S>& machine = sim.machine();
    const bool near = couldTouch(machine, state, to - from);
    const double largest = near ? contact_ : largest_;
    const int steps = std::max(1, static_cast<int>(std::ceil((to - from) / largest - 1e-6)));
    const double h = (to - from) / steps;
    Inputs<S> in;
    in.far_from_contact = !near;
    if (!(contact_ > 0.0)) in.contact_mode = untouched;
    in.hold_speed = sim.drive().hold_speed;
    since_ = from;
    sim.electricInputs(from, since_, held, in);
    in.bearing_on[0] = held.bearing_on[0];
    in.bearing_on[1] = held.bearing_on[1];
    if (machine.spin() == Spin::prescribed) in.shaft = sim.drive().shaft(from);
    sim.track().forceCurrent(state.current, state.lag.data(), in.force_current);
    if (!near) {
      for (int step = 0; step < steps; ++step) runStep(sim, from + step * h, h, state, held, in);
      sim.readCoils(state);
      return true;
    }
    now_.step_s = 0.0;
    for (int step = 0; step < steps; ++step) stepThroughContact(sim, from + step * h, h, 0, state, held, in);
    sim.readCoils(state);
    return true;
  }

  /// nearContact, where contact is not left out.
  bool couldTouch(const Machine<S>& machine, const MachineState<S>& state, double dt) const {
    return contact_ > 0.0 && nearContact(machine, state, dt);
  }

  /// Whether an end of a lane could touch within dt [s] at one and a half times its present approach speed.
  static bool nearContact(const Machine<S>& machine, const MachineState<S>& state, double dt) {
    for (int end = 0; end < 2; ++end) {
      S penetration, rate;
      machine.approach(end, state.mechanics.data(), penetration, rate);
      if (any(penetration + magnitude(rate) * S(1.5 * dt) + S(1e-6) > S(0.0))) return true;
    }
    return false;
  }

  /// What is left of the currents' differences after dt [s], kept for the next step of the same length.
  const typename CurrentTrack<S>::Decay& decayOf(const CurrentTrack<S>& track, double dt) {
    for (auto& cached : cache_)
      if (std::fabs(cached.dt - dt) < 1e-14) return cached;
    auto& slot = cache_[next_++ % kept_decays];
    slot = track.decay(dt);
    return slot;
  }

 private:
  /// Parts into which a step with a touch-down or lift-off is divided, and how often; a step as short as `finest_s`
  /// stays as it is.
  static constexpr int parts = 4, refinements = 3;
  static constexpr double finest_s = 2.5e-6;
  static constexpr int untouched[2] = {0, 0};

  /// machine.contactPace() of both ends at a state: at the end of a step that of the next, too.
  struct Pace {
    S guard[2], friction_rate[2];
    double step_s = 0.0;  ///< that it is for; 0: of no state
  };
  static Pace paceAt(const Machine<S>& machine, const Inputs<S>& in, const MachineState<S>& state, double h) {
    Pace out;
    for (int end = 0; end < 2; ++end)
      machine.contactPace(end, in, state.mechanics.data(), h, out.guard[end], out.friction_rate[end]);
    out.step_s = h;
    return out;
  }

  /// One step near contact. Where an end of a lane touches or leaves, the force has a jump or a kink in it: it is taken
  /// again in parts, and the part with the change likewise.
  void stepThroughContact(const Simulator<S>& sim, double t, double h, int level, MachineState<S>& state,
                          const typename Simulator<S>::Held& held, Inputs<S>& in) {
    if (level == refinements || h < finest_s) {
      now_.step_s = 0.0;
      return runStep(sim, t, h, state, held, in);
    }
    if (now_.step_s != h) now_ = paceAt(sim.machine(), in, state, h);
    const Pace before = now_;
    const int pieces = level == 0 ? piecesFor(maximum(before.friction_rate[0], before.friction_rate[1]), h) : 1;
    if (pieces > 1) {
      for (int k = 0; k < pieces; ++k) stepThroughContact(sim, t + k * h / pieces, h / pieces, 1, state, held, in);
      return;
    }
    Kept& kept = kept_[level];
    kept.mechanics = state.mechanics;
    kept.lag = state.lag;
    std::copy(state.current, state.current + 4, kept.current);
    kept.in = in;
    runStep(sim, t, h, state, held, in);
    now_ = paceAt(sim.machine(), in, state, h);
    if (!any((before.guard[0] > S(0.0)) != (now_.guard[0] > S(0.0))) &&
        !any((before.guard[1] > S(0.0)) != (now_.guard[1] > S(0.0))))
      return;
    now_.step_s = 0.0;
    state.mechanics = kept.mechanics;
    state.lag = kept.lag;
    std::copy(kept.current, kept.current + 4, state.current);
    in = kept.in;
    const double part = h / parts;
    for (int k = 0; k < parts; ++k) stepThroughContact(sim, t + k * part, part, level + 1, state, held, in);
  }

  /// Pieces of a step in which the fastest friction near sticking is resolved; Runge and Kutta's method is stable to 2.8.
  static int piecesFor(const S& rate, double h) {
    constexpr double resolved = 1.5;
    constexpr int most = 16;  // beyond: friction that holds some 10 kN on a few kg
    double fastest = 0.0;
    for (std::size_t l = 0; l < ScalarTraits<S>::lanes; ++l) fastest = std::max(fastest, laneValue(rate, l));
    return std::clamp(static_cast<int>(std::ceil(std::min(fastest * h / resolved, 1.0 * most))), 1, most);
  }

  /// One Runge-Kutta step from t; `in` holds the inputs at its start and afterwards those at its end.
  void runStep(const Simulator<S>& sim, double t, double h, MachineState<S>& state,
               const typename Simulator<S>::Held& held, Inputs<S>& in) {
    const Machine<S>& machine = sim.machine();
    const int n = machine.stateSize();
    const auto& decay = decayOf(sim.track(), 0.5 * h);
    S* y = state.mechanics.data();
    const auto moveShaft = [&](double time) {
      if (machine.spin() == Spin::prescribed) in.shaft = sim.drive().shaft(time);
      in.shaft.time = time;
    };
    const S hs(h), half(0.5 * h), sixth(h / 6.0), two(2.0);
    in.shaft.time = t;
    outside(sim, t, in);
    machine.derivatives(in, y, k1_.data());
    for (int i = 0; i < n; ++i) work_[i] = y[i] + half * k1_[i];
    sim.track().move(decay, held.target, state.current, state.lag.data());
    sim.track().forceCurrent(state.current, state.lag.data(), in.force_current);
    moveShaft(t + 0.5 * h);
    outside(sim, t + 0.5 * h, in);
    sim.electricInputs(t + 0.5 * h, since_, held, in);
    machine.derivatives(in, work_.data(), k2_.data());
    for (int i = 0; i < n; ++i) work_[i] = y[i] + half * k2_[i];
    machine.derivatives(in, work_.data(), k3_.data());
    for (int i = 0; i < n; ++i) work_[i] = y[i] + hs * k3_[i];
    sim.track().move(decay, held.target, state.current, state.lag.data());
    sim.track().forceCurrent(state.current, state.lag.data(), in.force_current);
    moveShaft(t + h);
    outside(sim, t + h, in);
    sim.electricInputs(t + h, since_, held, in);
    machine.derivatives(in, work_.data(), k4_.data());
    for (int i = 0; i < n; ++i) y[i] += sixth * (k1_[i] + two * (k2_[i] + k3_[i]) + k4_[i]);
  }

  void outside(const Simulator<S>& sim, double time, Inputs<S>& in) {
    const Schedule* schedule = sim.drive().schedule;
    if (schedule == nullptr || (schedule->forcePlanes().empty() && schedule->unbalances().empty())) return;
    schedule->forces(time, since_, forces_);
    schedule->unbalanceFactors(time, since_, factors_);
    lane_forces_.resize(forces_.size());
    lane_factors_.resize(factors_.size());
    for (std::size_t i = 0; i < forces_.size(); ++i) lane_forces_[i] = {S(forces_[i].x), S(forces_[i].y)};
    for (std::size_t i = 0; i < factors_.size(); ++i) lane_factors_[i] = S(factors_[i]);
    in.extra_force = lane_forces_.data();
    in.extra_unbalance = lane_factors_.data();
  }

  double largest_, contact_;
  double since_ = 0.0;  ///< instant that advance() came from: what is on there is on up to the next
  std::vector<S> k1_, k2_, k3_, k4_, work_;
  struct Kept {
    std::vector<S> mechanics, lag;
    S current[4] = {S(0.0), S(0.0), S(0.0), S(0.0)};
    Inputs<S> in;
  };
  Kept kept_[refinements];
  Pace now_;
  static constexpr unsigned kept_decays = 8;
  typename CurrentTrack<S>::Decay cache_[kept_decays];
  unsigned next_ = 0;
  std::vector<Vec2<double>> forces_;
  std::vector<double> factors_;
  std::vector<Vec2<S>> lane_forces_;
  std::vector<S> lane_factors_;
};

}  // namespace amb_rotor
