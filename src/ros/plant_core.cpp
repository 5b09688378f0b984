#include "amb_rotor/ros/plant_core.hpp"

#include <algorithm>
#include <cmath>

#include "amb_rotor/common/error.hpp"
#include "amb_rotor/common/units.hpp"
#include "amb_rotor/effects/catalogue.hpp"
#include "amb_rotor/excitation/schedule.hpp"
#include "amb_rotor/excitation/shaft_path.hpp"
#include "amb_rotor/machine/assembly.hpp"
#include "amb_rotor/machine/set_valued_friction.hpp"
#include "amb_rotor/model/model_writer.hpp"
#include "amb_rotor/model/scenario_reader.hpp"
#include "amb_rotor/ros/conversions.hpp"

namespace amb_rotor {
namespace {

/// No step is shorter, whatever a partner says [s].
constexpr double shortest_step_s = 1e-9;

}  // namespace

PlantCore::PlantCore(const Model& model, const Scenario& scenario, std::uint64_t run,
                     const RunOptions& options)
    : model_(model), scenario_(scenario), tolerance_(options.relative_tolerance) {
  message_.run = run;
  message_.model_hash = hashNumber(model);
  message_.header.frame_id = stator_frame;
  message_.record_rate = scenario.record_rate_hz;
  buildMachine(Injection());
  start(options);
}

PlantCore::~PlantCore() = default;

void PlantCore::buildMachine(const Injection& injection) {
  std::vector<double> planes = {static_cast<double>(injection.forces.size())};
  for (const auto& force : injection.forces) planes.push_back(force.plane_z);
  for (const auto& u : injection.unbalances) planes.insert(planes.end(), {u.plane_z, u.moment, u.phase});
  if (machine_ != nullptr && planes == planes_) return;
  planes_ = planes;
  ExtraPlanes<double> extra;
  for (const auto& force : injection.forces) extra.force_z_m.push_back(force.plane_z);
  for (const auto& u : injection.unbalances) extra.unbalance.push_back({u.plane_z, u.moment, u.phase});
  stepper_.reset();
  machine_ =
      std::make_unique<Machine<double>>(std::vector<const Model*>{&model_}, spinOf(model_, scenario_), extra);
  stepper_ = std::make_unique<PlantStepper>(*machine_, tolerance_);
}

void PlantCore::start(const RunOptions& options) {
  const Schedule schedule(scenario_.excitations, scenario_.faults);
  const PiecewiseShaft path = shaftPath(scenario_);
  Drive<double> drive;
  drive.path = &path;
  drive.schedule = &schedule;
  if (scenario_.start_settled) {
    RunOutcome outcome;
    state_ = settledState(*machine_, drive, options, outcome);
    if (outcome.status != RunStatus::ok) throw InputError({{"", 0, "start", "settled", outcome.reason}});
  } else {
    const Simulator<double> sim(*machine_, drive, scenario_.record_rate_hz);
    state_ = sim.atRest(0.0);
    startAsGiven(*machine_, scenario_, state_);
  }
  double offset[4];
  bool on[4];
  for (int a = 0; a < 4; ++a) {
    offset[a] = schedule.sensorOffset(a, 0.0);
    on[a] = schedule.bearingOn(a, 0.0);
  }
  message_.controller_memory = memoryMessage(state_.controller);
  message_.control_state = state_.control;
  message_.queue = queueMessage(state_.pending);
  message_.command = axisValues(state_.command);
  message_.next_sample = state_.next_sample;
  const Shaft<double> shaft =
      machine_->spin() == Spin::prescribed ? drive.shaft(0.0) : machine_->shaftOf(state_.mechanics.data());
  // the forces of the first step are not answered yet: sticking without them
  double stick_force[2];
  StickSolver(*machine_).solve(present(shaft, on), state_.sliding, state_.mechanics.data(), stick_force);
  describe(shaft, offset, on, stick_force);
}

Inputs<double> PlantCore::present(const Shaft<double>& shaft, const bool bearing_on[4]) const {
  const CurrentTrack<double> track(*machine_);
  Inputs<double> in;
  in.shaft = shaft;
  in.shaft.time = state_.time;  // a message's shaft has none
  for (int a = 0; a < 4; ++a)
    (a % 2 == 0 ? in.bearing_on[a / 2].x : in.bearing_on[a / 2].y) = bearing_on[a] ? 1.0 : 0.0;
  in.contact_mode = state_.contact_mode;
  track.forceCurrent(state_.current, state_.lag.data(), in.force_current);
  return in;
}

void PlantCore::describe(const Shaft<double>& shaft, const double sensor_offset[4], const bool bearing_on[4],
                         const double stick_force[2]) {
  RotorState& out = message_;
  out.time = state_.time;
  out.record = -1;
  if (static_cast<double>(state_.next_record) / scenario_.record_rate_hz <= state_.time + instant_tolerance_s)
    out.record = state_.next_record++;
  out.next_record = state_.next_record;
  finished_ = state_.time >= scenario_.duration_s - instant_tolerance_s;
  out.horizon =
      std::min(static_cast<double>(state_.next_record) / scenario_.record_rate_hz, scenario_.duration_s);
  out.shaft = shaftMessage(shaft);
  out.mechanics = state_.mechanics;
  out.current = axisValues(state_.current);
  out.current_lag = state_.lag;
  out.contact_mode.assign(state_.contact_mode, state_.contact_mode + 2);
  out.sliding.assign(state_.sliding, state_.sliding + 2);
  out.stick_force.assign(stick_force, stick_force + 2);

  Inputs<double> in = present(shaft, bearing_on);
  in.sliding = state_.sliding;
  in.stick_force = stick_force;
  Observation<double> seen;
  machine_->observe(in, state_.mechanics.data(), nullptr, seen);
  Vec2<double> signal[2];
  machine_->signals(in.shaft, state_.mechanics.data(), signal);
  const double value[4] = {signal[0].x + sensor_offset[0], signal[0].y + sensor_offset[1],
                           signal[1].x + sensor_offset[2], signal[1].y + sensor_offset[3]};
  out.sensor_signal = axisValues(value);
  out.sensor_position = axisValues(seen.sensor_position);
  out.amb_position = axisValues(seen.amb_position);
  out.aux_position = axisValues(seen.aux_position);
  out.aux_velocity = axisValues(seen.aux_velocity);
  out.bearing_force = axisValues(seen.bearing_force);
  out.centre_x = seen.centre.x;
  out.centre_y = seen.centre.y;
}

void PlantCore::findPulses(double from, const Shaft<double>& before, const Shaft<double>& after) {
  pulses_.clear();
  for (double turn = std::floor(before.angle / two_pi) + 1.0; two_pi * turn <= after.angle; turn += 1.0) {
    Tacho pulse;
    pulse.run = message_.run;
    pulse.turn = static_cast<std::int64_t>(turn);
    const double share = (two_pi * turn - before.angle) / (after.angle - before.angle);
    pulse.time = from + share * (state_.time - from);
    pulse.speed = before.speed + share * (after.speed - before.speed);
    pulses_.push_back(pulse);
  }
}

bool PlantCore::advance(const ControlCommand& control, const ContactForces& contact,
                        const Injection& injection) {
  AMB_ROTOR_CHECK(control.step == message_.step && contact.step == message_.step &&
                      injection.step == message_.step && contact.ends.size() == 2,
                  "the answers are to the present step");
  buildMachine(injection);
  const CurrentTrack<double> track(*machine_);
  const Shaft<double> before = machine_->spin() == Spin::prescribed
                                   ? shaftFrom(injection.shaft)
                                   : machine_->shaftOf(state_.mechanics.data());
  StepInputs step;
  step.from = state_.time;
  step.to = std::min({message_.horizon, control.valid_until, contact.valid_until, injection.valid_until});
  step.to = std::max(step.to, step.from + shortest_step_s);
  step.contact = &contact;
  step.injection = &injection;
  for (int a = 0; a < 4; ++a)
    step.target[a] =
        injection.bearing_on[a] && machine_->ambModel() == AmbModel::linear
            ? track.amplifier().limited(axisOf(control.command, a) + axisOf(injection.current, a))
            : 0.0;
  if (!stepper_->advance(step, state_)) {
    reason_ = stepper_->result().reason();
    return false;
  }
  reason_ = divergence(*machine_, state_.mechanics.data());
  if (const auto hit = magnetHit(*machine_, state_.mechanics.data(), state_.time)) reason_ = hit->text();
  diverged_ = !reason_.empty();

  const Shaft<double> after = machine_->spin() == Spin::prescribed
                                  ? shaftFrom(injection.shaft, step.to - step.from)
                                  : machine_->shaftOf(state_.mechanics.data());
  findPulses(step.from, before, after);
  const double share = (step.to - step.from) / std::max(injection.valid_until - step.from, shortest_step_s);
  const bool after_jump = step.to >= injection.valid_until - instant_tolerance_s;
  double offset[4];
  bool on[4];
  std::copy(injection.bearing_on.begin(), injection.bearing_on.end(), on);
  for (int a = 0; a < 4; ++a)
    offset[a] = after_jump ? axisOf(injection.sensor_offset_after, a)
                           : parabola(axisOf(injection.sensor_offset_start, a),
                                      axisOf(injection.sensor_offset_middle, a),
                                      axisOf(injection.sensor_offset_end, a), share);
  message_.controller_memory = control.controller_memory;
  message_.control_state = control.control_state;
  message_.queue = control.queue;
  message_.command = control.command;
  message_.next_sample = control.next_sample;
  message_.faults = injection.faults;
  ++message_.step;
  describe(after, offset, on, stepper_->stickForce());
  return !diverged_;
}

ModelInfo PlantCore::info() const {
  ModelInfo info;
  info.header.frame_id = stator_frame;
  info.run = message_.run;
  info.model_hash = message_.model_hash;
  info.model_name = model_.name;
  info.model_text = modelText(model_, effectCatalogue());
  info.scenario_name = scenario_.name;
  info.scenario_text = scenarioText(scenario_);
  info.duration = scenario_.duration_s;
  info.record_rate = scenario_.record_rate_hz;
  info.clearance = machine_->rig().auxiliary_bearing.clearance_m;
  info.rotor_radius = machine_->rig().auxiliary_bearing.rotor_radius_m;
  for (int end = 0; end < 2; ++end) {
    info.amb_z[end] = machine_->rig().planes.amb[end];
    info.sensor_z[end] = machine_->rig().planes.sensor[end];
    info.aux_z[end] = machine_->rig().planes.aux[end];
  }
  return info;
}

}  // namespace amb_rotor
