#include "amb_rotor/machine/run.hpp"

#include <cmath>
#include <cstdio>
#include <type_traits>

#include "amb_rotor/effects/catalogue.hpp"
#include "amb_rotor/machine/assembly.hpp"
#include "amb_rotor/machine/modal_stepper.hpp"
#include "amb_rotor/machine/set_valued_friction.hpp"
#include "amb_rotor/machine/simulator.hpp"

namespace amb_rotor {
namespace {

/// Beyond this multiple of the clearance a run counts as diverged.
constexpr double divergence_factor = 50.0;

void append(std::array<std::vector<double>, 4>& rows, const Vec2<double> value[2]) {
  rows[0].push_back(value[0].x);
  rows[1].push_back(value[0].y);
  rows[2].push_back(value[1].x);
  rows[3].push_back(value[1].y);
}

/// Writes one recorded instant into a trajectory; what the mechanics show comes from the stepper where it keeps them.
template <class Stepper>
RotorView record(const Simulator<double>& sim, Stepper& stepper, const Record<double>& seen, MachineState<double>& state,
                 Trajectory& out) {
  Inputs<double> in;
  in.shaft = seen.shaft;
  sim.track().forceCurrent(state.current, state.lag.data(), in.force_current);
  for (int a = 0; a < 4; ++a)
    (a % 2 == 0 ? in.bearing_on[a / 2].x : in.bearing_on[a / 2].y) = sim.bearingOn(a, seen.time) ? 1.0 : 0.0;
  in.contact_mode = state.contact_mode;
  double stick_force[2] = {0.0, 0.0};
  std::vector<Vec2<double>> forces;
  std::vector<double> factors;
  if (sim.machine().frictionLaw() == FrictionLaw::set_valued) {
    if (sim.drive().schedule != nullptr) {  // what keeps an end sticking depends on all that acts
      sim.drive().schedule->forces(seen.time, forces);
      sim.drive().schedule->unbalanceFactors(seen.time, factors);
      in.extra_force = forces.data();
      in.extra_unbalance = factors.data();
    }
    in.sliding = state.sliding;
    StickSolver(sim.machine()).solve(in, state.sliding, state.mechanics.data(), stick_force);
    in.stick_force = stick_force;
  }
  RotorView view;
  bool known = false;
  if constexpr (KeepsMechanics<Stepper, double>::value) {
    known = stepper.view(in, state, view);
    if (!known) stepper.bring(state);
  }
  if (!known) view = RotorView::of(sim.machine(), in, state.mechanics.data());
  out.time_s.push_back(seen.time);
  out.angle_rad.push_back(seen.shaft.angle);
  out.speed_rad_s.push_back(seen.shaft.speed);
  Vec2<double> force[2], centre[2];
  for (int end = 0; end < 2; ++end) {
    const auto& contact = view.contact[end];
    force[end] = contact.force;
    centre[end] = contact.centre;
    out.normal_force_N[end].push_back(contact.normal_force);
    out.friction_force_N[end].push_back(contact.friction_force);
    out.penetration_m[end].push_back(contact.penetration);
    out.slip_m_s[end].push_back(contact.slip);
    out.ring_speed_rad_s[end].push_back(view.ring_speed[end]);
  }
  append(out.position_m, view.sensor_position);
  append(out.aux_position_m, view.aux_position);
  append(out.aux_centre_m, centre);
  append(out.bearing_force_N, view.bearing_force);
  append(out.contact_force_N, force);
  for (int a = 0; a < 4; ++a) {
    out.displacement_m[a].push_back(seen.signal[a]);
    out.current_A[a].push_back(state.current[a]);
  }
  return view;
}

/// An effect whose law comes from a file; empty: there is none. Such a law may act beyond a threshold, in a part of the turn
/// or at some times only, which no trial of its linearity would find.
std::string lawOfAFile(const Model& model) {
  for (const auto& effect : model.effects) {
    const EffectSchema* schema = effectCatalogue().find(effect.id);
    if (schema != nullptr && schema->law != nullptr) return effect.id;
  }
  return "";
}

/// A rotor that bends has modes so fast that the event stepper is slow, whatever else the machine has. A rigid one stays
/// with the event stepper.
bool inModes(const Machine<double>& machine, const RunOptions& options) {
  return options.modal && machine.isFlexible();
}

/// The first end at which the rotor is not within the air gap.
std::optional<MagnetHit> hitAt(const Vec2<double> position[2], double air_gap_m, double time_s) {
  for (int end = 0; end < 2; ++end) {
    const double displacement = std::hypot(position[end].x, position[end].y);
    if (displacement >= air_gap_m) return MagnetHit{end, time_s, displacement, air_gap_m};
  }
  return std::nullopt;
}

/// A stepper that ends a run at the first instant at which the rotor is at a magnet.
template <class Stepper>
class WithinGaps {
 public:
  WithinGaps(const Machine<double>& machine, Stepper& stepper)
      : machine_(machine), stepper_(stepper), air_gap_(machine.rig().amb.air_gap_m) {}

  bool advance(const Simulator<double>& sim, double from, double to, MachineState<double>& state,
               const Simulator<double>::Held& held) {
    if (!looked_ && !within(state, from)) return false;
    return stepper_.advance(sim, from, to, state, held) && within(state, to);
  }
  void bring(MachineState<double>& state) {
    if constexpr (KeepsMechanics<Stepper, double>::value) stepper_.bring(state);
  }
  bool atSensors(const MachineState<double>& state, Vec2<double> out[2]) const {
    if constexpr (KeepsMechanics<Stepper, double>::value) return stepper_.atSensors(state, out);
    return false;
  }
  const std::optional<MagnetHit>& hit() const { return hit_; }

 private:
  bool within(const MachineState<double>& state, double time) {
    looked_ = true;
    if (machine_.ambModel() != AmbModel::linear) return true;
    Vec2<double> position[2];
    bool known = false;
    if constexpr (KeepsMechanics<Stepper, double>::value) known = stepper_.atMagnets(state, position);
    if (!known) machine_.atMagnets(state.mechanics.data(), position);
    hit_ = hitAt(position, air_gap_, time);
    return !hit_;
  }

  const Machine<double>& machine_;
  Stepper& stepper_;
  double air_gap_;
  bool looked_ = false;
  std::optional<MagnetHit> hit_;
};

/// Why a stepper did not get through, into an outcome.
void fail(const std::optional<MagnetHit>& hit, const IntegrationResult& result, const std::string& when, RunOutcome& outcome) {
  outcome.status = hit ? RunStatus::magnet_hit : RunStatus::integration_failed;
  outcome.magnet_hit = hit;
  outcome.reason = when + (hit ? hit->text() : result.reason());
}

}  // namespace

std::string MagnetHit::text() const {
  char text[160];
  std::snprintf(text, sizeof text, "the rotor reached the magnets of bearing %c: displaced by %.4g m, the air gap is %.4g m",
                end == 0 ? 'a' : 'b', displacement_m, air_gap_m);
  return text;
}

std::optional<MagnetHit> magnetHit(const Machine<double>& machine, const double* mechanics, double time_s) {
  if (machine.ambModel() != AmbModel::linear) return std::nullopt;
  Vec2<double> position[2];
  machine.atMagnets(mechanics, position);
  return hitAt(position, machine.rig().amb.air_gap_m, time_s);
}

namespace {

/// Of a rotor that is somewhere as far as this from the stator's axis.
std::string divergence(const Machine<double>& machine, double largest_radius) {
  const double limit = divergence_factor * machine.rig().auxiliary_bearing.clearance_m;
  if (largest_radius < limit) return "";
  return "the rotor left the bearing by more than " + std::to_string(int(divergence_factor)) +
         " clearances at a magnetic bearing, a sensor or an auxiliary bearing";
}

}  // namespace

std::string divergence(const Machine<double>& machine, const double* mechanics) {
  return divergence(machine, RotorView::largestRadius(machine.rotor(), mechanics));
}

void startAsGiven(const Machine<double>& machine, const Scenario& scenario, MachineState<double>& state) {
  const std::size_t n = static_cast<std::size_t>(machine.rotor().modes());
  // x_G, y_G, then beta and -alpha: the first two coordinates of each plane
  const auto place = [&](const std::vector<double>& given, std::size_t offset) {
    for (std::size_t i = 0; i < given.size() && i / 2 < n; ++i) state.mechanics[offset + (i % 2) * n + i / 2] = given[i];
  };
  place(scenario.initial_displacement_m, 0);
  place(scenario.initial_velocity_m_s, 2 * n);
  for (int end = 0; end < 2; ++end)
    state.contact_mode[end] = machine.contactGuard(end, state.mechanics.data()) > 0.0 ? 1 : 0;
}

Spin spinOf(const Model& model, const Scenario& scenario) {
  if (scenario.speed.type == SpeedType::free) return Spin::free;
  if (scenario.speed.type == SpeedType::constant)
    for (const auto& effect : model.effects)
      if (effect.id == "spin_drag") return Spin::drag;
  return Spin::prescribed;
}

MachineState<double> settledState(const Machine<double>& machine, const Drive<double>& drive, const RunOptions& options,
                                  RunOutcome& outcome, ModalStepper* modes) {
  const ShaftInstant start = drive.path != nullptr
                                 ? drive.path->at(0.0)
                                 : ShaftInstant{drive.angle0, drive.speed, 0.0};
  Drive<double> run_in = drive;
  const ConstantShaft shaft(start.angle, start.speed);
  run_in.path = &shaft;
  run_in.hold_speed = true;
  run_in.excitation = nullptr;
  run_in.schedule = nullptr;
  Simulator<double> sim(machine, run_in, 0.0);
  sim.restIntegrators();
  sim.settleLags(options.settle_s);
  // whole samples before t = 0, so that the controller's instants fall on its grid
  const double rate = machine.ambModel() == AmbModel::linear ? machine.rig().controller.sample_rate_hz : 1e4;
  const double from = -std::ceil(options.settle_s * rate) / rate;
  MachineState<double> state = sim.atRest(from);
  const auto run = [&](auto&& stepper) {
    WithinGaps within(machine, stepper);
    if (!sim.run(state, 0.0, within, [](const Record<double>&) {})) fail(within.hit(), stepper.result(), "run-in: ", outcome);
  };
  if (modes != nullptr && inModes(machine, options))
    run(*modes);
  else if (inModes(machine, options))
    run(ModalStepper(machine, options.relative_tolerance));
  else
    run(EventStepper(machine, options.relative_tolerance));
  state.next_record = 0;
  if (machine.spin() != Spin::prescribed) {  // exactly, not to the tolerance of the integration
    state.mechanics[machine.stateSize() - 2] = start.angle;
    state.mechanics[machine.stateSize() - 1] = start.speed;
  }
  return state;
}

namespace {

/// Fills a trajectory, and says whether the rotor has left its bearings.
template <class Stepper>
struct Recorder {
  static constexpr bool asks_stepper = true;
  const Simulator<double>& sim;
  Stepper& stepper;
  MachineState<double>& state;
  Trajectory& out;
  std::string& diverged;

  void operator()(const Record<double>& seen) const {
    const RotorView view = record(sim, stepper, seen, state, out);
    if (diverged.empty()) diverged = divergence(sim.machine(), view.largest_radius);
  }
};

/// The run itself: fills trajectory and outcome.
template <class Stepper>
void fillRun(const Simulator<double>& sim, const Scenario& scenario, MachineState<double>& state, Stepper&& stepper,
            Simulation& run) {
  const Machine<double>& machine = sim.machine();
  Trajectory& out = run.trajectory;
  double since[2] = {0.0, 0.0};
  stepper.setContactObserver([&](int end, bool touching, double time, const double*) {
    if (touching)
      since[end] = time;
    else
      out.contacts.push_back({end, since[end], time});
  });
  WithinGaps within(machine, stepper);
  std::string diverged;
  const Recorder<std::remove_reference_t<Stepper>> sink{sim, stepper, state, out, diverged};
  const bool finished = [&] {
    // in slices, so that a diverging run ends early
    const double slice = std::max(scenario.duration_s / 200.0, 1e-3);
    for (double end = std::min(slice, scenario.duration_s);; end = std::min(end + slice, scenario.duration_s)) {
      const bool last = end >= scenario.duration_s;
      if (!sim.run(state, end, within, sink, last)) return false;
      if (diverged.empty()) diverged = divergence(machine, state.mechanics.data());
      if (!diverged.empty() || last) return true;
    }
  }();
  if (within.hit()) state.time = within.hit()->time_s;  // the mechanics are those that were seen there
  for (int end = 0; end < 2; ++end)
    if (state.contact_mode[end] != 0) out.contacts.push_back({end, since[end], state.time});
  run.outcome.time_s = state.time;
  run.outcome.steps = stepper.statistics().steps;
  run.outcome.evaluations = stepper.statistics().evaluations;
  run.outcome.events = stepper.statistics().events;
  if (!finished) {
    fail(within.hit(), stepper.result(), "", run.outcome);
  } else if (!diverged.empty()) {
    run.outcome.status = RunStatus::diverged;
    run.outcome.reason = diverged;
  }
  if constexpr (std::is_same_v<std::decay_t<Stepper>, ModalStepper>)
    run.outcome.path = stepper.taken().text();
}

}  // namespace

Simulation simulate(const Model& model, const Scenario& scenario, const RunOptions& wanted) {
  Simulation run;
  run.trajectory.clearance_m = model.rig.auxiliary_bearing.clearance_m;  // also of a run that does not begin
  const std::string own_law = lawOfAFile(model);
  RunOptions options = wanted;
  options.modal = wanted.modal && own_law.empty();
  const Schedule schedule(scenario.excitations, scenario.faults);
  const PiecewiseShaft path = shaftPath(scenario);
  const Machine<double> machine({&model}, spinOf(model, scenario), {schedule.forcePlanes(), schedule.unbalances()});
  Drive<double> drive;
  drive.path = &path;
  drive.schedule = schedule.empty() ? nullptr : &schedule;  // none: the run-in's equations serve the run
  ModalStepper modes(machine, options.relative_tolerance);
  const Simulator<double> sim(machine, drive, scenario.record_rate_hz);
  MachineState<double> state = sim.atRest(0.0);
  if (scenario.start_settled) {
    state = settledState(machine, drive, options, run.outcome, &modes);
    if (run.outcome.status != RunStatus::ok) return run;
  } else {
    startAsGiven(machine, scenario, state);
  }
  if (inModes(machine, options)) {
    modes.countAnew();
    fillRun(sim, scenario, state, modes, run);
  } else {
    fillRun(sim, scenario, state, EventStepper(machine, options.relative_tolerance), run);
    run.outcome.path = !machine.isFlexible() ? "event stepper (the rotor does not bend)"
                       : !wanted.modal       ? "event stepper (asked for)"
                                             : "event stepper (" + own_law + " is a law of a file)";
  }
  run.final_state = std::move(state);
  return run;
}

}  // namespace amb_rotor
