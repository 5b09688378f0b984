#include <algorithm>
#include <cmath>

#include "amb_rotor/common/error.hpp"
#include "amb_rotor/model/scenario_reader.hpp"
#include "amb_rotor/ros/conversions.hpp"
#include "amb_rotor/ros/partners.hpp"

namespace amb_rotor {
namespace {

/// The value before a jump at the end of an interval is taken this much earlier [s].
constexpr double before_end_s = 2.0 * schedule_tolerance_s;

bool same(const FaultEvent& a, const FaultEvent& b) {
  return a.type == b.type && a.start_s == b.start_s && a.ramp_s == b.ramp_s && a.duration_s == b.duration_s &&
         a.end == b.end && a.axis == b.axis && a.amount == b.amount && a.plane_z_m == b.plane_z_m &&
         a.phase_rad == b.phase_rad;
}

}  // namespace

InjectorPartner::InjectorPartner(const Model& model, const Scenario& scenario)
    : model_(model),
      scenario_(scenario),
      model_hash_(hashNumber(model)),
      sample_rate_hz_(model.amb_model == AmbModel::linear ? model.rig.controller.sample_rate_hz : 0.0) {
  plan({});
}

void InjectorPartner::plan(const std::vector<FaultEvent>& faults) {
  Scenario all = scenario_;
  all.faults.insert(all.faults.end(), faults.begin(), faults.end());
  plan_ = {faults, Schedule(all.excitations, all.faults), shaftPath(all)};
}

void InjectorPartner::accept(const FaultMessage& message, double now, std::vector<FaultEvent>& faults) const {
  FaultEvent event = faultFrom(message, now);
  const std::vector<amb_rotor::Fault> wrong = checkFaultEvent(event, "fault");
  if (!wrong.empty()) throw InputError(wrong);
  if (event.start_s < now) event.start_s = now;  // an absolute time that is over: now
  if (event.type == FaultType::speed_change && scenario_.speed.type == SpeedType::free)
    throw InputError(
        {{"", 0, "fault.type", "speed_change", "the scenario's speed is free: nothing drives it"}});
  if (event.type == FaultType::unbalance_step && scenario_.speed.type == SpeedType::free) {
    std::vector<FaultEvent> all = scenario_.faults;
    all.insert(all.end(), faults.begin(), faults.end());
    all.push_back(event);
    // says whether the rotor's inertia is enough for it
    Machine<double>({&model_}, Spin::free, {{}, Schedule(scenario_.excitations, all).unbalances()});
  }
  faults.push_back(event);
}

Injection InjectorPartner::answer(const RotorState& state, const std::vector<FaultMessage>& arrived,
                                  std::vector<std::string>& refused) {
  std::vector<FaultEvent> faults;
  for (const auto& message : state.faults) faults.push_back(faultFrom(message, state.time));
  const auto replan = [&] {
    if (!std::equal(faults.begin(), faults.end(), plan_.faults.begin(), plan_.faults.end(), same))
      plan(faults);
  };
  replan();
  for (const auto& message : arrived) {
    try {
      accept(message, state.time, faults);
    } catch (const InputError& error) {
      refused.push_back(error.what());
    }
    replan();
  }
  Injection answer;
  answerTo(state, model_hash_, answer);
  answer.valid_until = nextKink(state.time, state.horizon);
  fill(state.time, answer.valid_until, answer);
  for (const auto& event : faults) answer.faults.push_back(faultMessage(event));
  return answer;
}

double InjectorPartner::nextKink(double time, double limit) const {
  for (const auto* kinks : {&plan_.schedule.breakpoints(), &plan_.path.breakpoints()})
    for (double kink : *kinks)
      if (kink > time + instant_tolerance_s) limit = std::min(limit, kink);
  return limit;
}

void InjectorPartner::fill(double from, double to, Injection& answer) const {
  const Schedule& schedule = plan_.schedule;
  const double at[3] = {from, 0.5 * (from + to), to};
  // an instant may lie a rounding before the kink that made it: look behind it
  const ShaftInstant shaft = plan_.path.at(from + schedule_tolerance_s);
  answer.shaft.angle = shaft.angle - shaft.speed * schedule_tolerance_s;
  answer.shaft.speed = shaft.speed;
  answer.shaft.acceleration = shaft.acceleration;

  answer.forces.resize(schedule.forcePlanes().size());
  answer.unbalances.resize(schedule.unbalances().size());
  std::vector<Vec2<double>> forces;
  std::vector<double> factors;
  for (int i = 0; i < 3; ++i) {
    schedule.forces(at[i], from, forces);
    schedule.unbalanceFactors(at[i], from, factors);
    for (std::size_t j = 0; j < forces.size(); ++j) {
      answer.forces[j].plane_z = schedule.forcePlanes()[j];
      answer.forces[j].x[i] = forces[j].x;
      answer.forces[j].y[i] = forces[j].y;
    }
    for (std::size_t j = 0; j < factors.size(); ++j) {
      const Unbalance<double>& unbalance = schedule.unbalances()[j];
      answer.unbalances[j].plane_z = unbalance.plane_z_m;
      answer.unbalances[j].moment = unbalance.moment_kg_m;
      answer.unbalances[j].phase = unbalance.phase_rad;
      answer.unbalances[j].factor[i] = factors[j];
    }
  }
  double current[4], offset[4][4];
  const double sampled = sample_rate_hz_ > 0.0 ? std::floor(from * sample_rate_hz_ + 1e-6) / sample_rate_hz_ : from;
  for (int a = 0; a < 4; ++a) {
    current[a] = schedule.current(a, sampled, at[0]);
    answer.bearing_on[a] = schedule.bearingOn(a, at[0]);
    for (int i = 0; i < 3; ++i) offset[i][a] = schedule.sensorOffset(a, std::min(at[i], to - before_end_s));
    offset[3][a] = schedule.sensorOffset(a, to);
  }
  answer.current = axisValues(current);
  answer.sensor_offset_start = axisValues(offset[0]);
  answer.sensor_offset_middle = axisValues(offset[1]);
  answer.sensor_offset_end = axisValues(offset[2]);
  answer.sensor_offset_after = axisValues(offset[3]);
}

}  // namespace amb_rotor
