#include "amb_rotor/machine/bearing_response.hpp"

#include <cmath>

#include "amb_rotor/common/units.hpp"

namespace amb_rotor {
namespace {

constexpr double displacement_step_m = 1e-7;
constexpr double current_step_A = 1e-4;

struct Look {
  double force[4], position[4], signal[4];
};

/// Forces and signals with the rotor moved by dx, dy and the same current in all axes.
Look lookAt(const Machine<double>& machine, double speed, double dx, double dy, double current) {
  std::vector<double> state(static_cast<std::size_t>(machine.stateSize()), 0.0);
  machine.initialise(state.data());
  state[0] += dx;
  state[static_cast<std::size_t>(machine.rotor().modes())] += dy;
  Inputs<double> in;
  in.shaft = Shaft<double>::at(0.0, speed, 0.0);
  in.far_from_contact = true;
  for (auto& i : in.force_current) i = {current, current};
  Observation<double> seen;
  machine.observe(in, state.data(), nullptr, seen);
  Vec2<double> signal[2];
  machine.signals(in.shaft, state.data(), signal);
  Look look{};
  for (int a = 0; a < 4; ++a) {
    const auto part = [&](const Vec2<double>* v) { return a % 2 == 0 ? v[a / 2].x : v[a / 2].y; };
    look.force[a] = part(seen.bearing_force);
    look.position[a] = part(seen.amb_position);
    look.signal[a] = part(signal);
  }
  return look;
}

/// C(z) of the sampled PID (magnetic_bearing/pid.hpp).
std::complex<double> pidTransfer(const Rig<double>& rig, std::complex<double> z) {
  const auto& c = rig.controller;
  const double period = 1.0 / c.sample_rate_hz;
  const double pole = std::exp(-two_pi * c.derivative_filter_hz * period);
  const std::complex<double> back = 1.0 / z;
  std::complex<double> gain = c.kp_A_per_m;
  gain += c.kd_A_s_per_m * (1.0 - pole) / period * (1.0 - back) / (1.0 - pole * back);
  if (c.ki_A_per_m_s != 0.0) gain += c.ki_A_per_m_s * period / (1.0 - back);
  return gain;
}

}  // namespace

std::array<AxisSlopes, 4> axisSlopes(const Machine<double>& machine, double speed) {
  std::array<AxisSlopes, 4> slopes;
  const double d = displacement_step_m, i = current_step_A;
  const Look more = lookAt(machine, speed, 0.0, 0.0, i), less = lookAt(machine, speed, 0.0, 0.0, -i);
  for (int a = 0; a < 4; ++a) {
    const double dx = a % 2 == 0 ? d : 0.0, dy = a % 2 == 0 ? 0.0 : d;
    const Look up = lookAt(machine, speed, dx, dy, 0.0), down = lookAt(machine, speed, -dx, -dy, 0.0);
    const double moved = up.position[a] - down.position[a];
    slopes[static_cast<std::size_t>(a)] = {(more.force[a] - less.force[a]) / (2.0 * i),
                                           (up.force[a] - down.force[a]) / moved,
                                           (up.signal[a] - down.signal[a]) / moved};
  }
  return slopes;
}

ControlPath controlPath(const Machine<double>& machine) {
  AMB_ROTOR_CHECK(machine.ambModel() == AmbModel::linear, "a bearing with a controller");
  const Rig<double>& rig = machine.rig();
  ControlPath path;
  path.sample_rate_hz = rig.controller.sample_rate_hz;
  path.delay_s = rig.controller.delay_s;
  path.amplifier_rate = radPerSecond(rig.amb.amplifier_bandwidth_hz);
  path.relaxation_weights = machine.relaxationWeights();
  path.relaxation_rates = machine.relaxationRates();
  path.controller = [&rig](std::complex<double> z) { return pidTransfer(rig, z); };
  return path;
}

std::vector<std::array<EquivalentBearing, 4>> equivalentBearings(const Machine<double>& machine, double speed,
                                                                 const std::vector<double>& frequencies_hz) {
  const auto slopes = axisSlopes(machine, speed);
  const ControlPath path = controlPath(machine);
  std::vector<std::array<EquivalentBearing, 4>> rows;
  for (const double frequency : frequencies_hz) {
    const std::complex<double> gain = pathResponse(path, frequency);
    rows.emplace_back();
    for (std::size_t a = 0; a < 4; ++a)
      rows.back()[a] = equivalentBearing(slopes[a].sensor_gain * gain, slopes[a].ki, slopes[a].ks, frequency);
  }
  return rows;
}

}  // namespace amb_rotor
