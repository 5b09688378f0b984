#include "amb_rotor/validation/stretches.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

#include "amb_rotor/common/units.hpp"
#include "amb_rotor/effects/catalogue.hpp"
#include "amb_rotor/machine/simulator.hpp"

namespace amb_rotor {
namespace {

/// Times of the integrators' leak in a run-in, and the longest that it becomes for them [s].
constexpr double leak_times = 4.0, longest_leak_s = 0.5;
/// Deepest penetration that the step through a Hertzian contact is made for [m].
constexpr double hertz_penetration_m = 2e-5;

FreeSpin freeSpinOf(const Model& model) {
  for (const auto& effect : model.effects)
    if (effect.id == "spin_drag") {
      const double inertia = model.rig.rotor.polar_inertia_kg_m2;
      return {effect.values[0], inertia > 0.0 ? effect.values[1] / inertia : 0.0};
    }
  return {};
}

bool hasEffect(const Model& model, const char* id) {
  for (const auto& effect : model.effects)
    if (effect.id == id) return true;
  return false;
}

}  // namespace

Stretch stretchOf(const Recording& rec, const Model& model) {
  Stretch stretch;
  stretch.path = rec.path.get();
  stretch.excitation = &rec.excitation;
  stretch.schedule = &rec.schedule;
  stretch.record_rate_hz = rec.run.sample_rate_hz;
  stretch.first = 0;
  stretch.last = rec.samples;
  stretch.largest_step_s = freeStep(model);
  const double settling = settlingTime(model);
  stretch.settle_s = std::max(stretch.settle_s, settling);
  // a lag that settleLags() hurries in 0.15 s would follow the turns and not only the mean
  if (hasEffect(model, "eddy_current_lag")) stretch.settle_s = std::max(stretch.settle_s, 0.5);
  // and a limit of the currents that the settled motion keeps may be too low for the way there from rest
  if (settling > 0.0 || hasEffect(model, "current_saturation")) stretch.calm_s = 0.15;
  if (rec.integrator_leak_per_s > 0.0) {
    stretch.integrator_leak_per_s = rec.integrator_leak_per_s;
    stretch.settle_s = std::max(stretch.settle_s, std::min(leak_times / rec.integrator_leak_per_s, longest_leak_s));
  }
  stretch.contact_step_s = rec.stays_inside ? 0.0 : 1e-5;
  stretch.spin = rec.path == nullptr && !rec.standstill && hasEffect(model, "spin_drag") ? Spin::drag : Spin::prescribed;
  return stretch;
}

LaneJob jobOf(const Recording& rec, const Model& model, double standstill_angle) {
  LaneJob job;
  job.model = &model;
  if (rec.path == nullptr) rec.startOfSpin(freeSpinOf(model), job.angle0_rad, job.speed_rad_s);
  if (rec.standstill) job.angle0_rad = standstill_angle;
  std::copy(rec.integral_m_s.begin(), rec.integral_m_s.end(), job.integral_m_s);
  return job;
}

void turnShaft(const Recording& rec, const ShaftTurn& turn, LaneJob& job) {
  job.speed_rad_s += turn.rad_s;
  job.angle0_rad += turn.rad - turn.rad_s * rec.first_turns_s;
}

/// A trial weight in a run is known; it joins the machine's unbalance.
std::vector<Model> withTrialWeights(const std::vector<Model>& models, const Recording& rec) {
  std::vector<Model> out = models;
  for (auto& model : out)
    model.rig.unbalance.insert(model.rig.unbalance.end(), rec.run.unbalance.begin(), rec.run.unbalance.end());
  return out;
}

ShaftInstant shaftAt(const Recording& rec, const Model& model, double time) {
  if (rec.path != nullptr) return rec.path->at(time);
  const FreeSpin spin = freeSpinOf(model);
  double angle0 = 0.0, speed = 0.0;
  rec.startOfSpin(spin, angle0, speed);
  const double reach = spin.reach(time);
  return {angle0 + speed * reach - spin.constant_rad_s2 * spin.lost(time),
          speed * (1.0 - spin.decay_per_s * reach) - spin.constant_rad_s2 * reach, 0.0};
}

namespace {

/// Whether an effect is a mode of its own, with frequency_hz and damping_ratio.
bool isMode(const EffectSetting& effect) {
  return effect.id == "shaft_flexibility" || effect.id == "foundation_resonance";
}

}  // namespace

double freeStep(const Model& model) {
  double step = 1e-4;
  if (model.coil) step = std::min(step, 0.2 / radPerSecond(model.rig.amb.amplifier_bandwidth_hz));
  if (model.signal_chain.anti_alias) step = std::min(step, 0.2 / radPerSecond(model.signal_chain.anti_alias->corner_hz));
  for (const auto& effect : model.effects) {
    if (!isMode(effect)) continue;
    const double frequency = effect.values[effectCatalogue().find(effect.id)->indexOf("frequency_hz")];
    step = std::min(step, 0.4 / (two_pi * std::max(frequency, 1.0)));
  }
  return std::max(step, 2e-6);
}

Model calmed(const Model& model) {
  constexpr double damping_ratio = 0.7;
  Model out = model;
  for (auto& effect : out.effects)
    if (isMode(effect)) {
      double& own = effect.values[effectCatalogue().find(effect.id)->indexOf("damping_ratio")];
      own = std::max(own, damping_ratio);
    } else if (effect.id == "current_saturation") {
      effect.values[0] = std::max(effect.values[0], out.rig.amb.max_current_A);
    }
  return out;
}

double settlingTime(const Model& model) {
  constexpr double time_constants = 6.0, longest_s = 0.8;
  double longest = 0.0;
  for (const auto& effect : model.effects) {
    if (!isMode(effect)) continue;
    const EffectSchema* schema = effectCatalogue().find(effect.id);
    const double frequency = effect.values[schema->indexOf("frequency_hz")];
    const double damping = effect.values[schema->indexOf("damping_ratio")];
    longest = std::max(longest, time_constants / std::max(two_pi * frequency * damping, 1e-9));
  }
  return std::min(longest, longest_s);
}

namespace {

/// Mean square over the noise of what parts two rows of samples; where `level`, each channel's mean apart.
double meanSquareOver(const Recording& rec, const double* one, const double* other, long samples, bool level) {
  double sum = 0.0;
  long count = 0;
  for (int c = 0; c < predicted_channels; ++c) {
    if (rec.noise[c] <= 0.0) continue;
    double mean = 0.0, square = 0.0;
    for (long i = 0; i < samples; ++i) {
      const double apart = (one[i * predicted_channels + c] - other[i * predicted_channels + c]) / rec.noise[c];
      mean += apart;
      square += apart * apart;
    }
    sum += level ? square - mean * mean / samples : square;
    count += samples;
  }
  return sum / std::max(1L, count);
}

}  // namespace

double settledRunIn(const Recording& rec, const Model& model, const Stretch& stretch, double standstill_angle) {
  constexpr double longest_s = 2.4, seen_s = 0.02, allowed = 0.05, settling_share = 0.7;
  Stretch start = stretch;
  start.last = std::min(rec.samples, stretch.first + std::max(1L, std::lround(seen_s * stretch.record_rate_hz)));
  const long samples = start.last - start.first;
  const std::size_t size = static_cast<std::size_t>(samples) * predicted_channels, at = start.first * predicted_channels;
  const double* measured = rec.measured.size() >= at + size ? rec.measured.data() + at : nullptr;
  std::vector<double> before, now(size);
  double last = 0.0;
  // the run-in looked at is half of start.settle_s: the one twice as long tells how far it is from settled
  for (;; start.settle_s *= 2.0, before = now) {
    std::vector<LaneJob> jobs = {jobOf(rec, model, standstill_angle)};
    jobs[0].out = now.data();
    predict(start, jobs);
    if (!jobs[0].finite) return stretch.settle_s;
    if (before.empty()) continue;
    const double square = meanSquareOver(rec, now.data(), before.data(), samples, false);
    const double off = measured != nullptr ? meanSquareOver(rec, now.data(), measured, samples, true) : 0.0;
    if (square <= allowed * allowed * std::max(1.0, off)) return 0.5 * start.settle_s;
    if (start.settle_s >= longest_s) return square < settling_share * settling_share * last ? start.settle_s : stretch.settle_s;
    last = square;
  }
}

double contactStep(const Model& model) {
  // 0.3 rad of the end's own oscillation on the contact's stiffness: Runge and Kutta's error in a step is then 2e-5 of
  // the penetration, and touch-down and lift-off are met to 1/64 of a step. Four sets of another program, their true effects in the model,
  // are left as far off as by steps of 5 us, to 2e-4 of the noise
  const auto& rig = model.rig;
  double inverse_mass = 0.0;
  for (const double z : rig.planes.aux) {
    const double tilt = rig.rotor.transverse_inertia_kg_m2 > 0.0 ? z * z / rig.rotor.transverse_inertia_kg_m2 : 0.0;
    inverse_mass = std::max(inverse_mass, 1.0 / rig.rotor.mass_kg + tilt);
  }
  double stiffness = rig.auxiliary_bearing.stiffness_N_per_m;
  for (const auto& effect : model.effects)
    if (effect.id == "hertzian_contact")  // the slope at a penetration that is rarely passed
      stiffness = std::max(stiffness, 1.5 * effect.values[0] * std::sqrt(hertz_penetration_m));
  // friction next to rolling is stiffer still, and has its steps taken in pieces (LaneStepper)
  double step = std::min(5e-5, 0.3 / std::sqrt(stiffness * inverse_mass));
  for (const auto& effect : model.effects)
    if (effect.id == "compliant_mount" || effect.id == "fractional_mount") {
      // the mount's own motion under the contact's stiffness; an elastomer's at the fastest it can be
      const double mass = effect.values[effect.id == "fractional_mount" ? 3 : 2];
      step = std::min(step, 0.5 / std::sqrt((stiffness + effect.values[0]) / std::max(mass, 1e-6)));
    }
  // lighter mounts follow their springs: stable down to 0.2 g, beyond which the prediction is refused as not finite
  return std::max(step, 8e-6);
}

void localParabola(const Recording& rec, int channel, long from, long count, long at, double& value, double& slope) {
  from = std::max<long>(0, std::min(from, rec.samples - count));
  Eigen::Matrix3d normal = Eigen::Matrix3d::Zero();
  Eigen::Vector3d right = Eigen::Vector3d::Zero();
  for (long i = from; i < from + count && i < rec.samples; ++i) {
    const double t = static_cast<double>(i - at);
    const Eigen::Vector3d row(1.0, t, t * t);
    normal += row * row.transpose();
    right += row * rec.measured[i * predicted_channels + channel];
  }
  const Eigen::Vector3d c = normal.ldlt().solve(right);
  value = c[0];
  slope = c[1] * rec.run.sample_rate_hz;
}

namespace {

/// Runs the controller over the measured signals of the samples before `last`; before the recording it sees its first
/// values.
void warmUp(const Recording& rec, const Controller<double>& controller, double speed, long last,
            MachineState<double>& state) {
  constexpr long most_samples = 2000;  // 0.2 s at 10 kHz: slower memories of a law start short of their state
  for (long k = last - most_samples; k < last; ++k) {
    const double at = std::max(0.0, std::min(static_cast<double>(rec.samples - 1),
                                             k * controller.period() * rec.run.sample_rate_hz));
    const long i = std::min(static_cast<long>(at), rec.samples - 2);
    double signal[4], unused[4];
    for (int a = 0; a < 4; ++a) {
      const double left = rec.measured[i * predicted_channels + a];
      signal[a] = left + (at - i) * (rec.measured[(i + 1) * predicted_channels + a] - left);
    }
    controller.sample(signal, speed, state.controller, state.control.data(), unused, false);
  }
}

}  // namespace

namespace {

/// Limits of the time over which an integrator's current is averaged [s].
constexpr double shortest_mean_s = 0.01, longest_mean_s = 0.05;

/// What a PID's integrator holds where its measured current is this, by the mean over about a turn [m s]; 0 where that cannot
/// be known: no integral part, no current measured, or at its limit.
double integralFromCurrent(const Recording& rec, const Rig<double>& rig, int axis, long first, double speed) {
  const double ki = rig.controller.ki_A_per_m_s, rate = rec.run.sample_rate_hz;
  if (!(ki > 0.0) || rec.noise[4 + axis] <= 0.0) return 0.0;
  const double turn = std::fabs(speed) > 0.0 ? two_pi / std::fabs(speed) : longest_mean_s;
  const long half = std::lround(0.5 * rate * std::clamp(turn, shortest_mean_s, longest_mean_s));
  long from = std::max(0L, first - half), to = std::min(rec.samples, first + half);
  for (const auto& event : rec.run.events) {  // a bearing that fails, and the like
    const long at = std::lround(event.time_s * rate);
    if (at <= first) from = std::max(from, at);
    if (at > first) to = std::min(to, at);
  }
  if (to - from < 2) return 0.0;
  const double limit = std::min(rig.amb.bias_current_A, rig.amb.max_current_A - rig.amb.bias_current_A);
  double sum = 0.0;
  for (long i = from; i < to; ++i) {
    const double current = rec.measured[i * predicted_channels + 4 + axis];
    if (std::fabs(current) > 0.95 * limit) return 0.0;
    sum += current - rec.excitation.at(axis, static_cast<double>(i) / rate) + rig.controller.kp_A_per_m * rec.measured[i * predicted_channels + axis];
  }
  const double slope = (rec.measured[(to - 1) * predicted_channels + axis] - rec.measured[from * predicted_channels + axis]) *
                       rate / static_cast<double>(to - 1 - from);
  return -(sum / static_cast<double>(to - from) + rig.controller.kd_A_s_per_m * slope) / ki;
}

/// Where the rotor is where its sensors show this: runout, gain and rotation of the sensors taken out, by Newton's method.
void outOfSensors(const Machine<double>& machine, const ShaftInstant& at, double time, const double shown[4], double place[4]) {
  constexpr int rounds = 3;  // exact after one where the signals go with the place
  constexpr double step_m = 1e-6;
  Shaft<double> shaft = Shaft<double>::at(at.angle, at.speed, at.acceleration);
  shaft.time = time;
  std::copy(shown, shown + 4, place);
  for (int round = 0; round < rounds; ++round) {
    Vec2<double> now[3][2];  // as it is, and a step on in x and in y
    for (int k = 0; k < 3; ++k) {
      for (int end = 0; end < 2; ++end)
        now[k][end] = {place[2 * end] + (k == 1 ? step_m : 0.0), place[2 * end + 1] + (k == 2 ? step_m : 0.0)};
      machine.sense(shaft, now[k]);
    }
    for (int end = 0; end < 2; ++end) {
      const double xx = (now[1][end].x - now[0][end].x) / step_m, xy = (now[2][end].x - now[0][end].x) / step_m;
      const double yx = (now[1][end].y - now[0][end].y) / step_m, yy = (now[2][end].y - now[0][end].y) / step_m;
      const double determinant = xx * yy - xy * yx;
      if (!(std::fabs(determinant) > 1e-6)) continue;
      const double x = shown[2 * end] - now[0][end].x, y = shown[2 * end + 1] - now[0][end].y;
      place[2 * end] += (yy * x - xy * y) / determinant;
      place[2 * end + 1] += (xx * y - yx * x) / determinant;
    }
  }
}

}  // namespace

MachineState<double> stateFromMeasurement(const Recording& rec, const Model& model, Spin spin, long first,
                                          const MeasuredFrom& span) {
  const Machine<double> machine({&model}, spin);
  const Drive<double> drive;
  const Simulator<double> sim(machine, drive, rec.run.sample_rate_hz);
  const double time = first / rec.run.sample_rate_hz;
  MachineState<double> state = sim.atRest(time);
  state.next_record = first;
  const bool controlled = machine.ambModel() == AmbModel::linear;
  const auto& rig = model.rig;
  double value[4], slope[4];
  for (int a = 0; a < 4; ++a) localParabola(rec, a, first + span.from, span.count, first, value[a], slope[a]);
  double place[4], rate_of_place[4], soon[4];
  const double instant = 0.1 / rec.run.sample_rate_hz;
  for (int a = 0; a < 4; ++a) soon[a] = value[a] + instant * slope[a];
  outOfSensors(machine, shaftAt(rec, model, time), time, value, place);
  outOfSensors(machine, shaftAt(rec, model, time + instant), time + instant, soon, rate_of_place);
  for (int a = 0; a < 4; ++a) rate_of_place[a] = (rate_of_place[a] - place[a]) / instant;
  const int n = machine.rotor().modes();
  for (int axis = 0; axis < 2; ++axis) {
    // two sensors, two rigid coordinates
    const double za = rig.planes.sensor[0], zb = rig.planes.sensor[1];
    for (int rate = 0; rate < 2; ++rate) {
      const double* now = rate ? rate_of_place : place;
      const double a = now[axis], b = now[2 + axis];
      double* q = state.mechanics.data() + 2 * n * rate + axis * n;
      if (n == 1) {
        q[0] = 0.5 * (a + b);
      } else {
        q[1] = (b - a) / (zb - za);
        q[0] = a - za * q[1];
      }
    }
  }
  if (machine.mountState() >= 0) {
    // a mount gives way by its share of what the rotor went in
    double stiffness = 0.0;
    for (const auto& effect : model.effects)
      if (effect.id == "compliant_mount") stiffness = effect.values[0];
    const double contact = rig.auxiliary_bearing.stiffness_N_per_m;
    for (int end = 0; end < 2; ++end) {
      double* centre = state.mechanics.data() + machine.mountState() + 4 * end;
      const double tilt = n > 1 ? rig.planes.aux[end] : 0.0;
      const double* q = state.mechanics.data();
      const double dx = q[0] + tilt * (n > 1 ? q[1] : 0.0) - centre[0];
      const double dy = q[n] + tilt * (n > 1 ? q[n + 1] : 0.0) - centre[1];
      const double radius = std::hypot(dx, dy), depth = radius - rig.auxiliary_bearing.clearance_m;
      if (depth <= 0.0) continue;
      const double share = depth * contact / (contact + stiffness) / radius;
      centre[0] += share * dx;
      centre[1] += share * dy;
    }
  }
  for (int a = 0; a < 4; ++a) {
    double current = 0.0, unused = 0.0;
    if (rec.noise[4 + a] > 0.0) localParabola(rec, 4 + a, first, 4, first, current, unused);
    state.current[a] = current;
    const std::size_t lags = state.lag.size() / 4;
    for (std::size_t j = 0; j < lags; ++j) state.lag[a * lags + j] = current;
  }
  if (controlled) {
    const double rate = rig.controller.sample_rate_hz, delay = rig.controller.delay_s;
    const bool plain = machine.controlOptions().plain();
    const Controller<double> controller = machine.controller();
    const long samples_before = static_cast<long>(std::ceil(delay * rate)) + 1;
    // a law with a memory of its own first runs over what was measured
    if (!plain) warmUp(rec, controller, shaftAt(rec, model, time).speed, state.next_sample - samples_before, state);
    double held[4] = {0.0, 0.0, 0.0, 0.0};
    if (plain)
      for (int a = 0; a < 4; ++a)
        held[a] = state.controller[a].integral = integralFromCurrent(rec, rig, a, first, shaftAt(rec, model, time).speed);
    for (long k = state.next_sample - samples_before; k < state.next_sample; ++k) {
      const double at = k / rate * rec.run.sample_rate_hz;  // in recorded instants
      PendingCommand<double> command;
      command.due = k / rate + delay;
      for (int a = 0; a < 4; ++a) {
        const double s = value[a] + slope[a] * (at - first) / rec.run.sample_rate_hz;
        command.command[a] = -(rig.controller.kp_A_per_m * s + rig.controller.kd_A_s_per_m * slope[a] +
                               rig.controller.ki_A_per_m_s * held[a]);
        if (!plain) continue;
        state.controller[a].previous_signal = s;
        state.controller[a].derivative = slope[a];
      }
      if (!plain) {
        double signal[4];
        for (int a = 0; a < 4; ++a) signal[a] = value[a] + slope[a] * (at - first) / rec.run.sample_rate_hz;
        controller.sample(signal, shaftAt(rec, model, time).speed, state.controller, state.control.data(),
                          command.command, false);
      }
      if (command.due <= time + 1e-9)
        std::copy(command.command, command.command + 4, state.command);
      else
        state.pending.push_back(command);
    }
  }
  machine.electrics().set(value, slope, state.current, state.mechanics.data() + machine.electricsOffset());
  if (spin != Spin::prescribed) {
    const ShaftInstant shaft = shaftAt(rec, model, time);
    state.mechanics[machine.stateSize() - 2] = shaft.angle;
    state.mechanics[machine.stateSize() - 1] = shaft.speed;
  }
  return state;
}

}  // namespace amb_rotor
