#pragma once
// Body of predict() for one Scalar; included by one source file for each instruction set.
#include <cmath>

#include "amb_rotor/machine/exact_stepper.hpp"
#include "amb_rotor/machine/lane_stepper.hpp"
#include "amb_rotor/machine/machine_impl.hpp"
#include "amb_rotor/machine/settled_motion.hpp"
#include "amb_rotor/validation/predict.hpp"

namespace amb_rotor {

template <class S>
MachineState<S> packStates(const std::vector<const MachineState<double>*>& lanes) {
  constexpr std::size_t width = ScalarTraits<S>::lanes;
  const MachineState<double>& first = *lanes[0];
  MachineState<S> packed;
  packed.time = first.time;
  packed.next_sample = first.next_sample;
  packed.next_record = first.next_record;
  packed.mechanics.assign(first.mechanics.size(), S(0.0));
  packed.lag.assign(first.lag.size(), S(0.0));
  packed.control.assign(first.control.size(), S(0.0));
  packed.pending.resize(first.pending.size());
  for (std::size_t l = 0; l < width; ++l) {
    const MachineState<double>& lane = *lanes[l < lanes.size() ? l : lanes.size() - 1];
    for (std::size_t i = 0; i < first.mechanics.size(); ++i) setLane(packed.mechanics[i], l, lane.mechanics[i]);
    for (std::size_t i = 0; i < first.lag.size(); ++i) setLane(packed.lag[i], l, lane.lag[i]);
    for (std::size_t i = 0; i < first.control.size(); ++i) setLane(packed.control[i], l, lane.control[i]);
    for (int a = 0; a < 4; ++a) {
      setLane(packed.controller[a].previous_signal, l, lane.controller[a].previous_signal);
      setLane(packed.controller[a].derivative, l, lane.controller[a].derivative);
      setLane(packed.controller[a].integral, l, lane.controller[a].integral);
      setLane(packed.command[a], l, lane.command[a]);
      setLane(packed.current[a], l, lane.current[a]);
    }
    for (std::size_t p = 0; p < first.pending.size(); ++p) {
      packed.pending[p].due = first.pending[p].due;
      for (int a = 0; a < 4; ++a) setLane(packed.pending[p].command[a], l, lane.pending[p].command[a]);
    }
  }
  return packed;
}

template <class S>
void unpackState(const MachineState<S>& packed, std::size_t l, MachineState<double>& lane) {
  lane.time = packed.time;
  lane.next_sample = packed.next_sample;
  lane.next_record = packed.next_record;
  lane.mechanics.resize(packed.mechanics.size());
  lane.lag.resize(packed.lag.size());
  for (std::size_t i = 0; i < packed.mechanics.size(); ++i) lane.mechanics[i] = laneValue(packed.mechanics[i], l);
  for (std::size_t i = 0; i < packed.lag.size(); ++i) lane.lag[i] = laneValue(packed.lag[i], l);
  lane.control.resize(packed.control.size());
  for (std::size_t i = 0; i < packed.control.size(); ++i) lane.control[i] = laneValue(packed.control[i], l);
  for (int a = 0; a < 4; ++a) {
    lane.controller[a].previous_signal = laneValue(packed.controller[a].previous_signal, l);
    lane.controller[a].derivative = laneValue(packed.controller[a].derivative, l);
    lane.controller[a].integral = laneValue(packed.controller[a].integral, l);
    lane.command[a] = laneValue(packed.command[a], l);
    lane.current[a] = laneValue(packed.current[a], l);
  }
  lane.pending.resize(packed.pending.size());
  for (std::size_t p = 0; p < packed.pending.size(); ++p) {
    lane.pending[p].due = packed.pending[p].due;
    for (int a = 0; a < 4; ++a) lane.pending[p].command[a] = laneValue(packed.pending[p].command[a], l);
  }
}

/// How a pack goes: in lanes, by a stepper of them.
template <class S, class LaneSteps>
struct BySteps {
  using Stepper = LaneSteps;
  static Stepper make(const Machine<S>& machine, double largest_step_s, double contact_step_s) {
    return Stepper(machine, largest_step_s, contact_step_s);
  }
  /// Once a state has been put where a stretch begins.
  static void begin(const Machine<S>&, MachineState<S>&) {}
};
template <class S>
using FixedSteps = BySteps<S, LaneStepper<S>>;
/// Exact where the machine is linear and out of contact.
template <class S>
using ExactSteps = BySteps<S, ExactStepper<S>>;

template <class S>
Drive<S> packDrive(const Stretch& stretch, const LaneJob* jobs, std::size_t count) {
  Drive<S> drive;
  drive.path = stretch.path;
  drive.excitation = stretch.excitation;
  drive.schedule = stretch.schedule;
  for (std::size_t l = 0; l < ScalarTraits<S>::lanes; ++l) {
    const LaneJob& job = jobs[l < count ? l : count - 1];
    drive.turned = drive.turned || (stretch.path != nullptr && (job.angle0_rad != 0.0 || job.speed_rad_s != 0.0));
    if (job.excitation != nullptr) {
      if (l == 0) drive.excitation = job.excitation;  // for its rate
      AMB_ROTOR_CHECK(job.excitation->rate_hz == drive.excitation->rate_hz, "lanes are excited at one rate");
      drive.lane_excitation.push_back(job.excitation);
    }
    setLane(drive.angle0, l, job.angle0_rad);
    setLane(drive.speed, l, job.speed_rad_s);
    for (int a = 0; a < 4; ++a) {
      setLane(drive.sensor_offset[a], l, job.offset_m[a]);
      setLane(drive.sensor_drift[a], l, job.drift_m_per_s[a]);
    }
  }
  AMB_ROTOR_CHECK(drive.lane_excitation.empty() || drive.lane_excitation.size() == ScalarTraits<S>::lanes, "all lanes or none are excited by themselves");
  return drive;
}

template <class S>
Machine<S> packMachine(const Stretch& stretch, const LaneJob* jobs, std::size_t count) {
  std::vector<const Model*> models;
  for (std::size_t l = 0; l < count; ++l) models.push_back(jobs[l].model);
  return Machine<S>(models, stretch.spin);
}

/// Puts a lane's mechanics but for its spin, its currents and what the controller remembers of its signals into a state.
template <class S>
void takeMotion(const MachineState<double>& from, Spin spin, std::size_t lane, MachineState<S>& state) {
  const std::size_t spin_states = spin == Spin::prescribed ? 0 : 2;
  AMB_ROTOR_CHECK(from.mechanics.size() == state.mechanics.size(), "the motion is one of this machine");
  for (std::size_t i = 0; i + spin_states < from.mechanics.size(); ++i) setLane(state.mechanics[i], lane, from.mechanics[i]);
  for (int a = 0; a < 4; ++a) {
    setLane(state.current[a], lane, from.current[a]);
    setLane(state.command[a], lane, from.command[a]);
    setLane(state.controller[a].previous_signal, lane, from.controller[a].previous_signal);
    setLane(state.controller[a].derivative, lane, from.controller[a].derivative);
  }
}

/// What a pack is driven by before a stretch: a constant speed, no excitation, no schedule, its integrators at rest or leaking.
template <class S>
class RunIn {
 public:
  RunIn(const Stretch& stretch, const LaneJob* jobs, std::size_t count, const Machine<S>& machine, const Drive<S>& of_stretch)
      : drive_(of_stretch),
        constant_(0.0, 0.0),
        start_time_(stretch.first / stretch.record_rate_hz),
        rate_hz_(machine.ambModel() == AmbModel::linear ? laneValue(machine.rig().controller.sample_rate_hz, 0)
                                                        : stretch.record_rate_hz),
        leak_per_s_(stretch.integrator_leak_per_s) {
    drive_.hold_speed = true;
    drive_.excitation = nullptr;
    drive_.lane_excitation.clear();
    drive_.schedule = nullptr;
    for (int a = 0; a < 4; ++a) drive_.sensor_drift[a] = S(0.0);
    if (stretch.path != nullptr) {
      const ShaftInstant now = stretch.path->at(start_time_);
      constant_ = ConstantShaft(now.angle - now.speed * start_time_, now.speed);
      drive_.path = &constant_;
    }
    for (std::size_t l = 0; l < ScalarTraits<S>::lanes; ++l)
      for (int a = 0; a < 4; ++a) setLane(integral_m_s_[a], l, jobs[l < count ? l : count - 1].integral_m_s[a]);
  }
  RunIn(const RunIn&) = delete;
  RunIn& operator=(const RunIn&) = delete;

  const Drive<S>& drive() const { return drive_; }
  double startTime() const { return start_time_; }
  /// Of the controller, or of the record where there is none.
  double rate() const { return rate_hz_; }
  const S* integrals() const { return integral_m_s_; }
  void prepare(Simulator<S>& sim) const {
    if (leak_per_s_ > 0.0)
      sim.leakIntegrators(leak_per_s_, integral_m_s_);
    else
      sim.restIntegrators();
  }

 private:
  Drive<S> drive_;
  ConstantShaft constant_;
  double start_time_, rate_hz_, leak_per_s_;
  S integral_m_s_[4];
};

/// The settled motion of every lane at the stretch's beginning, see machine/settled_motion.hpp; false where one has none.
template <class S>
bool settlePack(const Stretch& stretch, const LaneJob* jobs, std::size_t count, MachineState<double>* out) {
  const Machine<S> machine = packMachine<S>(stretch, jobs, count);
  const Drive<S> drive = packDrive<S>(stretch, jobs, count);
  const RunIn<S> run_in(stretch, jobs, count, machine, drive);
  const SettledMotion<S> settled(machine, run_in.drive(), run_in.startTime(), 1.0 / run_in.rate(), run_in.integrals(),
                                 stretch.largest_step_s, stretch.contact_step_s > 0.0,
                                 [&run_in](Simulator<S>& sim) { run_in.prepare(sim); });
  if (!settled.solved()) return false;
  for (std::size_t l = 0; l < count; ++l) {
    unpackState(settled.state(), l, out[l]);
    out[l].next_record = stretch.first;
  }
  return true;
}

/// One pack: jobs [from, from + lanes).
template <class S, class Steps = FixedSteps<S>>
void predictPack(const Stretch& stretch, LaneJob* jobs, std::size_t count) {
  std::vector<const Model*> models;
  for (std::size_t l = 0; l < count; ++l) models.push_back(jobs[l].model);
  const Machine<S> machine(models, stretch.spin);
  const Drive<S> drive = packDrive<S>(stretch, jobs, count);
  Simulator<S> sim(machine, drive, stretch.record_rate_hz);
  typename Steps::Stepper stepper = Steps::make(machine, stretch.largest_step_s, stretch.contact_step_s);
  MachineState<S> state;
  const double start_time = stretch.first / stretch.record_rate_hz;
  if (jobs[0].start != nullptr) {
    std::vector<const MachineState<double>*> starts;
    for (std::size_t l = 0; l < count; ++l) starts.push_back(jobs[l].start);
    state = packStates<S>(starts);
  } else {
    const double coarse_contact = stretch.contact_step_s > 0.0 ? stretch.largest_step_s : 0.0;
    const RunIn<S> run_in(stretch, jobs, count, machine, drive);
    const double rate = run_in.rate();
    Simulator<S> before(machine, run_in.drive(), 0.0);
    run_in.prepare(before);
    before.settleLags(stretch.settle_s);
    const double begin = start_time - std::ceil(stretch.settle_s * rate) / rate;
    const bool moving = jobs[0].settle_from != nullptr;
    state = before.atRest(moving ? begin : begin - std::ceil(stretch.calm_s * rate) / rate);
    for (int a = 0; a < 4; ++a) state.controller[a].integral = run_in.integrals()[a];
    if (moving) {
      for (std::size_t l = 0; l < count; ++l) takeMotion(*jobs[l].settle_from, machine.spin(), l, state);
    }
    if (stretch.calm_s > 0.0 && !moving) {
      std::vector<Model> calm;
      for (const Model* model : models) calm.push_back(calmed(*model));
      std::vector<const Model*> these;
      for (const Model& model : calm) these.push_back(&model);
      const Machine<S> held_back(these, stretch.spin);
      Simulator<S> first(held_back, run_in.drive(), 0.0);
      first.restIntegrators();
      first.settleLags(stretch.settle_s);
      typename Steps::Stepper steps = Steps::make(held_back, stretch.largest_step_s, coarse_contact);
      first.run(state, begin, steps, [](const Record<S>&) {});
    }
    typename Steps::Stepper coarse = Steps::make(machine, stretch.largest_step_s, coarse_contact);
    before.run(state, start_time, coarse, [](const Record<S>&) {});
    state.next_record = stretch.first;
    if (machine.spin() != Spin::prescribed) {
      const Shaft<S> shaft = drive.shaft(start_time);
      state.mechanics[machine.stateSize() - 2] = shaft.angle;
      state.mechanics[machine.stateSize() - 1] = shaft.speed;
    }
  }
  for (std::size_t l = 0; l < count; ++l)
    if (jobs[l].begin != nullptr) unpackState(state, l, *jobs[l].begin);
  for (std::size_t l = 0; l < count; ++l) {
    if (jobs[l].start_change == nullptr) continue;
    const int n = machine.stateSize();
    for (int i = 0; i < n; ++i)
      setLane(state.mechanics[i], l, laneValue(state.mechanics[i], l) + jobs[l].start_change[i]);
    for (int a = 0; a < 4; ++a)
      setLane(state.current[a], l, laneValue(state.current[a], l) + jobs[l].start_change[n + a]);
    for (int a = 0; a < 4; ++a)
      setLane(state.controller[a].integral, l, laneValue(state.controller[a].integral, l) + jobs[l].start_change[n + 4 + a]);
  }
  Steps::begin(machine, state);
  const bool done = sim.run(state, stretch.last / stretch.record_rate_hz, stepper, [&](const Record<S>& seen) {
    const long row = seen.index - stretch.first;
    if (row < 0 || seen.index >= stretch.last) return;
    for (std::size_t l = 0; l < count; ++l) {
      double* out = jobs[l].out + row * predicted_channels;
      for (int a = 0; a < 4; ++a) {
        out[a] = laneValue(seen.signal[a], l);
        out[4 + a] = laneValue(seen.state->current[a], l);
      }
    }
  });
  for (std::size_t l = 0; l < count; ++l) {
    if (jobs[l].end != nullptr) unpackState(state, l, *jobs[l].end);
    const double* out = jobs[l].out;
    double sum = 0.0;
    for (long i = 0; i < (stretch.last - stretch.first) * predicted_channels; ++i) sum += std::fabs(out[i]);
    jobs[l].finite = done && std::isfinite(sum) && sum < 1e12;
  }
}

/// One pack, as the stretch asks: exactly, or in steps.
template <class S>
void predictLanes(const Stretch& stretch, LaneJob* jobs, std::size_t count) {
  AMB_ROTOR_CHECK(count <= ScalarTraits<S>::lanes, "a pack holds no more machines");
  if (stretch.exact)
    predictPack<S, ExactSteps<S>>(stretch, jobs, count);
  else
    predictPack<S>(stretch, jobs, count);
}

/// Whether all machines, of however many packs, are linear out of contact.
template <class S>
bool allLinear(const Stretch& stretch, LaneJob* jobs, std::size_t count) {
  constexpr std::size_t width = ScalarTraits<S>::lanes;
  for (std::size_t from = 0; from < count; from += width) {
    const std::size_t size = std::min(width, count - from);
    if (!ExactStepper<S>::takes(packMachine<S>(stretch, jobs + from, size), packDrive<S>(stretch, jobs + from, size))) return false;
  }
  return true;
}

}  // namespace amb_rotor
