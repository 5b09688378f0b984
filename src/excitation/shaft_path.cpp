#include "amb_rotor/excitation/shaft_path.hpp"

#include <algorithm>
#include <cmath>

#include "amb_rotor/common/units.hpp"

namespace amb_rotor {

PiecewiseShaft::PiecewiseShaft(double angle0, double speed0) {
  pieces_.push_back({0.0, angle0, speed0, 0.0, 0.0});
}

ShaftInstant PiecewiseShaft::within(const Piece& p, double time) {
  const double t = time - p.start;
  if (p.decay > 0.0 && t > 0.0) {
    const double share = 1.0 + p.decay * t;
    return {p.angle + p.speed / p.decay * std::log(share), p.speed / share,
            -p.speed * p.decay / (share * share)};
  }
  return {p.angle + p.speed * t + 0.5 * p.slope * t * t, p.speed + p.slope * t, p.slope};
}

void PiecewiseShaft::append(double time, double slope, double decay, const double* new_speed) {
  // a change in the middle of another takes its place: what was planned after it is dropped
  while (pieces_.size() > 1 && pieces_.back().start > time) pieces_.pop_back();
  const ShaftInstant now = within(pieces_.back(), time);
  pieces_.push_back({time, now.angle, new_speed != nullptr ? *new_speed : now.speed, slope, decay});
  times_.push_back(time);
}

void PiecewiseShaft::rampTo(double time, double speed, double duration) {
  if (duration <= 0.0) {
    append(time, 0.0, 0.0, &speed);
    return;
  }
  const double now = at(time).speed;
  append(time, (speed - now) / duration, 0.0, nullptr);
  append(time + duration, 0.0, 0.0, &speed);
}

void PiecewiseShaft::decayFrom(double time, double factor) { append(time, 0.0, factor, nullptr); }

ShaftInstant PiecewiseShaft::at(double time) const {
  std::size_t i = pieces_.size() - 1;
  while (i > 0 && pieces_[i].start > time) --i;
  return within(pieces_[i], time);
}

PiecewiseShaft shaftPath(const Scenario& scenario) {
  const SpeedLaw& law = scenario.speed;
  PiecewiseShaft path(law.initial_angle_rad, radPerSecond(law.start_hz));
  if (law.type == SpeedType::ramp) path.rampTo(law.start_s, radPerSecond(law.end_hz), law.duration_s);
  if (law.type == SpeedType::decay) path.decayFrom(law.start_s, law.decay_factor_per_s);
  std::vector<FaultEvent> changes;
  for (const auto& fault : scenario.faults)
    if (fault.type == FaultType::speed_change) changes.push_back(fault);
  std::stable_sort(changes.begin(), changes.end(),
                   [](const FaultEvent& a, const FaultEvent& b) { return a.start_s < b.start_s; });
  for (const auto& change : changes) {
    const double before = path.at(change.start_s).speed;
    path.rampTo(change.start_s, radPerSecond(change.amount), change.ramp_s);
    if (change.duration_s > 0.0) path.rampTo(change.start_s + change.duration_s, before, change.ramp_s);
  }
  return path;
}

}  // namespace amb_rotor
