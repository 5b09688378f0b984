#include "amb_rotor/excitation/schedule.hpp"

#include <algorithm>
#include <cmath>

#include "amb_rotor/common/units.hpp"

namespace amb_rotor {
namespace {

bool isForce(const FaultEvent& fault) {
  return fault.type == FaultType::force_impulse || fault.type == FaultType::force_step;
}

bool isOn(double start, double duration, double instant) {
  const double t = instant - start + schedule_tolerance_s;
  return t >= 0.0 && (duration <= 0.0 || t < duration);
}

}  // namespace

double waveformValue(const Excitation& e, double time, double since) {
  if (!isOn(e.start_s, e.duration_s, since)) return 0.0;
  const double t = time - e.start_s;
  switch (e.waveform) {
    case Waveform::step: return e.amplitude;
    case Waveform::impulse: return e.amplitude * std::sin(pi * t / e.duration_s);
    case Waveform::sine: return e.amplitude * std::sin(two_pi * e.start_hz * t);
    case Waveform::chirp:
      return e.amplitude *
             std::sin(two_pi * (e.start_hz * t + 0.5 * (e.end_hz - e.start_hz) * t * t / e.duration_s));
  }
  return 0.0;
}

double faultShare(const FaultEvent& fault, double time, double since) {
  if (!isOn(fault.start_s, fault.duration_s, since)) return 0.0;
  const double t = std::max(time - fault.start_s, 0.0);
  if (fault.type == FaultType::force_impulse) return std::sin(pi * t / fault.duration_s);
  return fault.ramp_s > 0.0 ? std::min(1.0, t / fault.ramp_s) : 1.0;
}

Schedule::Schedule(const std::vector<Excitation>& excitations, const std::vector<FaultEvent>& faults)
    : excitations_(excitations), faults_(faults) {
  for (const auto& e : excitations_) {
    if (e.kind == Excitation::Kind::force) force_planes_.push_back(e.plane_z_m);
    breakpoints_.push_back(e.start_s);
    if (e.duration_s > 0.0) breakpoints_.push_back(e.start_s + e.duration_s);
  }
  for (const auto& f : faults_) {
    if (isForce(f)) force_planes_.push_back(f.plane_z_m);
    if (f.type == FaultType::unbalance_step)
      unbalances_.push_back({f.plane_z_m, f.amount, f.phase_rad});
    breakpoints_.push_back(f.start_s);
    if (f.ramp_s > 0.0) breakpoints_.push_back(f.start_s + f.ramp_s);
    if (f.duration_s > 0.0) breakpoints_.push_back(f.start_s + f.duration_s);
  }
  std::sort(breakpoints_.begin(), breakpoints_.end());
  breakpoints_.erase(std::unique(breakpoints_.begin(), breakpoints_.end()), breakpoints_.end());
}

void Schedule::forces(double time, double since, std::vector<Vec2<double>>& out) const {
  out.clear();
  for (const auto& e : excitations_)
    if (e.kind == Excitation::Kind::force) {
      const double value = waveformValue(e, time, since);
      out.push_back({value * std::cos(e.direction_rad), value * std::sin(e.direction_rad)});
    }
  for (const auto& f : faults_)
    if (isForce(f)) {
      const double value = f.amount * faultShare(f, time, since);
      out.push_back({value * std::cos(f.phase_rad), value * std::sin(f.phase_rad)});
    }
}

bool Schedule::forcesOn(double since) const {
  for (const auto& e : excitations_)
    if (e.kind == Excitation::Kind::force && isOn(e.start_s, e.duration_s, since)) return true;
  for (const auto& f : faults_)
    if (isForce(f) && isOn(f.start_s, f.duration_s, since)) return true;
  return false;
}

void Schedule::unbalanceFactors(double time, double since, std::vector<double>& out) const {
  out.clear();
  for (const auto& f : faults_)
    if (f.type == FaultType::unbalance_step) out.push_back(faultShare(f, time, since));
}

double Schedule::current(int axis, double sampled, double now) const {
  double sum = 0.0;
  for (const auto& e : excitations_)
    if (e.kind == Excitation::Kind::current && 2 * e.end + e.axis == axis)
      sum += waveformValue(e, std::max(sampled, e.start_s), now);
  return sum;
}

double Schedule::sensorOffset(int axis, double time, double since) const {
  double sum = 0.0;
  for (const auto& f : faults_)
    if (f.type == FaultType::sensor_offset && addresses(f, axis)) sum += f.amount * faultShare(f, time, since);
  return sum;
}

bool Schedule::bearingOn(int axis, double time) const {
  bool on = true;
  double latest = -1.0;
  for (const auto& f : faults_) {
    if ((f.type != FaultType::amb_off && f.type != FaultType::amb_on) || !addresses(f, axis)) continue;
    const double t = time + schedule_tolerance_s;
    if (t < f.start_s) continue;
    const bool ended = f.duration_s > 0.0 && t >= f.start_s + f.duration_s;
    const double when = ended ? f.start_s + f.duration_s : f.start_s;
    if (when >= latest) {
      latest = when;
      on = (f.type == FaultType::amb_on) != ended;
    }
  }
  return on;
}

}  // namespace amb_rotor
