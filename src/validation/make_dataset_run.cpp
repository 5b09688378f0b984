// Machines of the generator through their runs, sample by sample: so the sensors' noise can go round the control loop,
// and laws of no catalogue can act.
#include <algorithm>
#include <cmath>

#include "amb_rotor/common/check.hpp"
#include "amb_rotor/common/units.hpp"
#include "amb_rotor/effects/catalogue.hpp"
#include "amb_rotor/machine/event_stepper.hpp"
#include "amb_rotor/machine/run.hpp"
#include "make_dataset_parts.hpp"

namespace amb_rotor::making {
namespace {

constexpr double least_run_in_s = 0.2, longest_run_in_s = 4.0;
constexpr double tolerance = 1e-7;
/// A run-in twice as long may move the start of a recording by so much [m, rad], a fraction of any sensor's noise; at
/// standstill the second half of one.
constexpr double settled = 2e-9;
/// Beyond this multiple of the clearance a run is not sound.
constexpr double lost = 5.0;

/// EventStepper with a force of no catalogue at the magnetic bearings.
class LawStepper {
 public:
  LawStepper(const Machine<double>& machine, const HiddenLaw& law) : system_(machine, law) {
    IntegratorOptions options;
    options.relative_tolerance = tolerance;
    options.absolute.assign(machine.stateSize(), 1e-3);
    for (int i = 0; i < machine.coordinates(); ++i) {
      options.absolute[i] = 1e-5;
      options.absolute[machine.coordinates() + i] = 1e-2;
    }
    integrator_ = std::make_unique<EventIntegrator>(system_, options);
  }

  bool advance(const Simulator<double>& sim, double from, double to, MachineState<double>& state,
               const Simulator<double>::Held& held) {
    system_.sim = &sim;
    system_.from = from;
    system_.state = &state;
    system_.held = &held;
    integrator_->restart();
    if (integrator_->advance(from, to, state.mechanics.data()).status != IntegrationStatus::ok) return false;
    sim.track().move(sim.track().decay(to - from), held.target, state.current, state.lag.data());
    return true;
  }

 private:
  struct System final : HybridSystem {
    System(const Machine<double>& m, const HiddenLaw& l) : machine(m), law(l) {}
    int size() const override { return machine.stateSize(); }
    int guards() const override { return 2; }
    void derivatives(double time, const double* y, double* rate) const override {
      Inputs<double> in;
      in.shaft = sim->drive().shaft(time);
      in.bearing_on[0] = held->bearing_on[0];
      in.bearing_on[1] = held->bearing_on[1];
      double current[4];
      const double decay = sim->track().amplifier().decay(time - from);
      for (int a = 0; a < 4; ++a) current[a] = held->target[a] + (state->current[a] - held->target[a]) * decay;
      sim->track().forceCurrent(current, nullptr, in.force_current);
      Vec2<double> force[2];
      for (int end = 0; end < 2; ++end) force[end] = forceAt(end, time, in, y);
      in.extra_force = force;
      in.contact_mode = state->contact_mode;
      machine.derivatives(in, y, rate);
    }
    Vec2<double> forceAt(int end, double time, const Inputs<double>& in, const double* y) const {
      const Vec2<double> place = machine.rotor().at(2 * 0 + end, y);
      const Vec2<double> speed = machine.rotor().at(2 * 0 + end, y + machine.coordinates());
      if (law.law == Law::quadratic_damping) {
        const double c = -law.amount * std::hypot(speed.x, speed.y);
        return {c * speed.x, c * speed.y};
      }
      if (law.law == Law::cubic_stiffness) {
        const double c = -law.amount * (place.x * place.x + place.y * place.y);
        return {c * place.x, c * place.y};
      }
      if (law.law == Law::speed_stiffness) {
        const double k = -law.amount * std::fabs(in.shaft.speed);
        return {k * place.x, k * place.y};
      }
      if (law.law == Law::third_harmonic_force) {
        const double turn = 3.0 * in.shaft.angle + law.second;
        return {law.amount * std::cos(turn), 0.5 * law.amount * std::sin(turn)};
      }
      if (law.law == Law::current_dead_zone) {
        const double lost = -law.amount * law.second;
        const Vec2<double>& i = in.force_current[end];
        return {lost * std::tanh(i.x / law.second), lost * std::tanh(i.y / law.second)};
      }
      const double turn = two_pi * law.second * time;
      return {law.amount * std::cos(turn), 0.6 * law.amount * std::sin(turn)};
    }
    void guardValues(double, const double* y, double* guard) const override {
      for (int end = 0; end < 2; ++end) {
        const double inside = machine.contactGuard(end, y);
        guard[end] = state->contact_mode[end] != 0 ? inside : -inside;
      }
    }
    void onEvent(int end, double, double*) override { state->contact_mode[end] = 1 - state->contact_mode[end]; }

    const Machine<double>& machine;
    const HiddenLaw& law;
    const Simulator<double>* sim = nullptr;
    double from = 0.0;
    MachineState<double>* state = nullptr;
    const Simulator<double>::Held* held = nullptr;
  };
  System system_;
  std::unique_ptr<EventIntegrator> integrator_;
};

/// Half of seven time constants of the weakest damped mode: twice as long is tried in any case.
double runInOf(const Model& model) {
  double longest = least_run_in_s;
  for (const auto& effect : model.effects)
    if (effect.id == "foundation_resonance" || effect.id == "shaft_flexibility") {
      const EffectSchema* schema = effectCatalogue().find(effect.id);
      const double decay =
          radPerSecond(effect.values[schema->indexOf("frequency_hz")]) * effect.values[schema->indexOf("damping_ratio")];
      longest = std::max(longest, 3.5 / std::max(decay, 1e-9));
    }
  return std::min(longest, 0.5 * longest_run_in_s);
}

bool pushes(Law law) { return law != Law::none && law != Law::sensor_dead_zone; }

/// A machine on its way through a plan.
class Way {
 public:
  Way(const TrueMachine& truth, const RunPlan& plan)
      : truth_(truth),
        path_(plan.angle0, radPerSecond(plan.speed_hz)),
        schedule_({}, events(plan)),
        machine_({&truth.model}, spinOf(truth.model, plan), planes(truth)) {
    if (plan.run.speed_from_tacho)
      path_.rampTo(0.0, radPerSecond(plan.end_speed_hz), (plan.samples - 1) / sample_rate_hz);
    drive_.path = &path_;
    drive_.schedule = &schedule_;
    drive_.excitation = &plan.excitation;
    if (pushes(truth.law.law))
      law_stepper_ = std::make_unique<LawStepper>(machine_, truth.law);
    else
      event_stepper_ = std::make_unique<EventStepper>(machine_, tolerance);
  }

  const Machine<double>& machine() const { return machine_; }

  /// The settled state at the start, by run-ins twice as long until that changes nothing: a loop may be weakly damped.
  bool settle(MachineState<double>& state) {
    std::vector<double> before;
    const bool stands = path_.at(0.0).speed == 0.0;
    for (double run_in_s = runInOf(truth_.model);; run_in_s *= 2.0) {
      double stirred = 0.0;
      if (!runIn(run_in_s, state, stirred)) return false;
      if (stands && stirred < settled) return true;
      double moved = before.empty() ? 1.0 : 0.0;
      for (std::size_t i = 0; i < before.size(); ++i) moved = std::max(moved, std::fabs(state.mechanics[i] - before[i]));
      if (moved < settled || run_in_s >= longest_run_in_s) return true;
      before.assign(state.mechanics.begin(), state.mechanics.begin() + machine_.coordinates());
    }
  }

  /// Adds samples first .. last - 1 to the signals.
  bool follow(MachineState<double>& state, long first, long last, const LoopNoise* noise, Signals& out, bool keep) {
    const Simulator<double> sim(machine_, drive_, sample_rate_hz);
    const double clearance = truth_.model.rig.auxiliary_bearing.clearance_m;
    const int n = machine_.coordinates();
    bool near = true;
    const auto sink = [&](const Record<double>& seen) {
      if (keep && seen.index % window_samples == 0) out.window_start.push_back(before_);
      for (int a = 0; a < 4; ++a) {
        out.rows[a].push_back(seen.signal[a]);
        out.rows[4 + a].push_back(seen.state->current[a]);
      }
      out.angle.push_back(seen.shaft.angle);
      out.speed.push_back(seen.shaft.speed);
      for (int end = 0; end < 2; ++end) {
        double penetration, rate;
        machine_.approach(end, seen.state->mechanics.data(), penetration, rate);
        out.reach = std::max(out.reach, 1.0 + penetration / clearance);
        if (penetration > 0.0 || seen.state->contact_mode[end] != 0) out.touched = true;
      }
      for (int i = 0; i < n; ++i)
        if (!(std::fabs(seen.state->mechanics[i]) < 1.0)) near = false;
      if (!(out.reach < lost)) near = false;
    };
    for (long n0 = first; n0 < last && near; n0 += window_samples)
      if (!samples(sim, drive_, state, n0, std::min(last, n0 + window_samples), noise, sink)) return false;
    return near;
  }

  /// A state of another machine of so many coordinates, of which this one has the first along each axis, made one of this.
  MachineState<double> adopt(const MachineState<double>& other, int coordinates) const {
    const Simulator<double> sim(machine_, drive_, sample_rate_hz);
    MachineState<double> state = sim.atRest(other.time);
    const auto mechanics = state.mechanics;
    state = other;
    state.mechanics = mechanics;
    const int modes = machine_.coordinates() / 2;
    AMB_ROTOR_CHECK(2 * modes <= coordinates, "a window begins from a state that lacks coordinates");
    for (int part = 0; part < 4; ++part)  // places along x and y, their rates
      std::copy_n(other.mechanics.begin() + part * (coordinates / 2), modes, state.mechanics.begin() + part * modes);
    state.takeLags(sim.track().lagCount());
    for (int end = 0; end < 2; ++end) {
      state.contact_mode[end] = machine_.contactGuard(end, state.mechanics.data()) > 0.0 ? 1 : 0;
      state.sliding[end] = sliding_unset;  // what sticks there may slide here
    }
    return state;
  }

 private:
  /// @param stirred  how far a coordinate was from where it ends, in the second half
  bool runIn(double run_in_s, MachineState<double>& state, double& stirred) {
    const ShaftInstant start = path_.at(0.0);
    const ConstantShaft shaft(start.angle, start.speed);
    Drive<double> drive = drive_;
    drive.path = &shaft;
    drive.hold_speed = true;
    drive.excitation = nullptr;
    drive.schedule = nullptr;
    Simulator<double> sim(machine_, drive, start.speed == 0.0 ? sample_rate_hz : 0.0);  // at standstill each is looked at
    sim.restIntegrators();
    sim.settleLags(run_in_s);
    const long first = -std::lround(run_in_s * sample_rate_hz);
    state = sim.atRest(first / sample_rate_hz);
    const int n = machine_.coordinates();
    std::vector<double> least(n, 1e300), most(n, -1e300);
    const auto sink = [&](const Record<double>& seen) {
      for (int i = 0; 2 * seen.index > first && i < n; ++i) {
        least[i] = std::min(least[i], seen.state->mechanics[i]);
        most[i] = std::max(most[i], seen.state->mechanics[i]);
      }
    };
    const bool sound = samples(sim, drive, state, first, 0, nullptr, sink);
    for (int i = 0; i < n; ++i) stirred = std::max({stirred, most[i] - state.mechanics[i], state.mechanics[i] - least[i]});
    state.next_record = 0;
    if (machine_.spin() != Spin::prescribed) {
      state.mechanics[machine_.stateSize() - 2] = start.angle;
      state.mechanics[machine_.stateSize() - 1] = start.speed;
    }
    return sound;
  }

  template <class Sink>
  bool samples(const Simulator<double>& sim, Drive<double>& drive, MachineState<double>& state, long first, long last,
               const LoopNoise* noise, Sink&& sink) {
    for (long n = first; n < last; ++n) {
      double offset[4] = {0.0, 0.0, 0.0, 0.0};
      for (double& value : drive.sensor_offset) value = 0.0;
      if (truth_.law.law == Law::sensor_dead_zone) {
        sim.signals(state, sim.shaft(state), offset);
        for (double& s : offset) s = -truth_.law.amount * truth_.law.second * std::tanh(s / truth_.law.second);
      }
      for (int a = 0; a < 4; ++a) drive.sensor_offset[a] = offset[a] + (noise != nullptr ? (*noise)[n][a] : 0.0);
      if (n % window_samples == 0) before_ = state;
      const double end = (n + 1) / sample_rate_hz;
      if (!(law_stepper_ ? sim.run(state, end, *law_stepper_, sink) : sim.run(state, end, *event_stepper_, sink)))
        return false;
    }
    return true;
  }
  static std::vector<FaultEvent> events(const RunPlan& plan) {
    std::vector<FaultEvent> faults;
    for (const auto& event : plan.run.events) {
      FaultEvent fault;
      fault.type = event.amb_on ? FaultType::amb_on : FaultType::amb_off;
      fault.start_s = event.time_s;
      faults.push_back(fault);
    }
    return faults;
  }
  static Spin spinOf(const Model& model, const RunPlan& plan) {
    if (!plan.run.speed_from_tacho)
      for (const auto& effect : model.effects)
        if (effect.id == "spin_drag") return Spin::drag;
    return Spin::prescribed;
  }
  static ExtraPlanes<double> planes(const TrueMachine& truth) {
    ExtraPlanes<double> extra;
    if (pushes(truth.law.law)) extra.force_z_m.assign(truth.model.rig.planes.amb, truth.model.rig.planes.amb + 2);
    return extra;
  }

  const TrueMachine& truth_;
  PiecewiseShaft path_;
  Schedule schedule_;
  Machine<double> machine_;
  Drive<double> drive_;
  MachineState<double> before_;
  std::unique_ptr<LawStepper> law_stepper_;
  std::unique_ptr<EventStepper> event_stepper_;
};

}  // namespace

Signals runMachine(const TrueMachine& machine, const RunPlan& plan, const LoopNoise* noise) {
  Signals out;
  Way way(machine, plan);
  MachineState<double> state;
  out.sound = way.settle(state) && way.follow(state, 0, plan.samples, noise, out, plan.run.holdsContact());
  out.coordinates = way.machine().coordinates();
  return out;
}

Signals runWindows(const TrueMachine& machine, const RunPlan& plan, const Signals& of) {
  Signals out;
  Way way(machine, plan);
  for (std::size_t w = 0; w < of.window_start.size() && out.sound; ++w) {
    MachineState<double> state = way.adopt(of.window_start[w], of.coordinates);
    const long first = static_cast<long>(w) * window_samples;
    out.sound = way.follow(state, first, std::min(plan.samples, first + window_samples), nullptr, out, false);
  }
  return out;
}

bool isStable(const TrueMachine& machine, double speed_hz) {
  constexpr long samples = 3000, kick = 20, tail = 500;
  constexpr double left_over = 0.03;
  for (const double speed : {0.0, speed_hz}) {
    RunPlan plan;
    plan.samples = samples;
    plan.speed_hz = speed;
    Signals quiet, kicked;
    MachineState<double> settled_state;
    {
      Way way(machine, plan);
      quiet.sound = way.settle(settled_state);
      MachineState<double> state = settled_state;
      quiet.sound = quiet.sound && way.follow(state, 0, plan.samples, nullptr, quiet, false);
    }
    plan.excitation.rate_hz = sample_rate_hz;
    const auto& rig = machine.model.rig;
    const double amplitude =
        0.2 * rig.auxiliary_bearing.clearance_m * netStiffness(machine.model) / rig.amb.current_stiffness_N_per_A;
    for (int a : {0, 3}) plan.excitation.axis[a].assign(kick, a == 0 ? amplitude : 0.7 * amplitude);
    kicked.sound = quiet.sound && Way(machine, plan).follow(settled_state, 0, plan.samples, nullptr, kicked, false);
    if (!quiet.sound || !kicked.sound || quiet.touched || kicked.touched) return false;
    double peak = 0.0, end = 0.0;
    for (int a = 0; a < 4; ++a)
      for (long i = 0; i < samples; ++i) {
        const double d = std::fabs(kicked.rows[a][i] - quiet.rows[a][i]);
        peak = std::max(peak, d);
        if (i >= samples - tail) end = std::max(end, d);
      }
    if (!(end < left_over * peak)) return false;
  }
  return true;
}

}  // namespace amb_rotor::making
