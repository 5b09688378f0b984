#include "amb_rotor/validation/recording.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "amb_rotor/common/units.hpp"
#include "amb_rotor/validation/plausibility.hpp"
#include "amb_rotor/validation/sensor_remarks.hpp"

namespace amb_rotor {
namespace {

/// Turns at the start of a run of constant speed that fix its angle and speed.
constexpr int turns_at_start = 8;
/// Least error of a pulse's time [s]: values rounded to 0.001 on a ramp over two samples of 0.1 ms (analysis/tacho.hpp).
constexpr double least_edge_std_s = 5.8e-8;
/// Scatter of all edges over that of times rounded to samples within which they lie on one line, no speed being lost.
constexpr double on_one_line = 1.15;
/// The belief of the speed helps where few turns were recorded; this is how far it may be off.
constexpr double believed_speed_std = 0.01;

/// The path of a driven shaft through the pulses of its tacho.
class TachoPath final : public ShaftPath {
 public:
  explicit TachoPath(const TachoPulses& pulses) : angle_(pulses) {}
  ShaftInstant at(double time) const override {
    return {angle_.angle(time), angle_.speed(time), angle_.acceleration(time)};
  }

 private:
  ShaftAngle angle_;
};

std::vector<FaultEvent> bearingFaults(const Run& run) {
  std::vector<FaultEvent> faults;
  for (const auto& event : run.events) {
    FaultEvent fault;
    fault.type = event.amb_on ? FaultType::amb_on : FaultType::amb_off;
    fault.start_s = event.time_s;
    faults.push_back(fault);
  }
  return faults;
}

/// What to think of a tacho that is faster by a whole number.
std::string pulsesATurn(const Recording& rec, const Run& run) {
  constexpr double whole = 0.02;
  const double ratio = rec.speed_rad_s / radPerSecond(run.speed_hz), times = std::round(ratio);
  if (times < 2.0 || std::fabs(ratio / times - 1.0) > whole) return "";
  return ": it is " + std::to_string(static_cast<int>(times)) + " times as fast; are there as many pulses a turn?";
}

/// What is taken for the angle that no pulse tells, and fills it in.
std::string shaftWords(Recording& rec, const Model& belief) {
  if (!findShaft(rec, belief))
    return ": the believed speed is taken, and the shaft's angle, which nothing shows, as 0: what turns with the shaft is not predicted";
  char text[40];
  std::snprintf(text, sizeof text, "%.6g Hz", rec.speed_rad_s / two_pi);
  return std::string(": the shaft's speed (") + text +
         ") and angle are those of the first harmonic, its phase as believed: phases of unbalance, bow and runout are not measured here";
}

}  // namespace

double FreeSpin::reach(double time_s) const {
  return decay_per_s == 0.0 ? time_s : -std::expm1(-decay_per_s * time_s) / decay_per_s;
}

double FreeSpin::lost(double time_s) const {
  constexpr double series_below = 1e-4;  // the difference has lost half its digits there, the series' next term is 1e-9
  const double x = decay_per_s * time_s;
  return std::fabs(x) < series_below ? time_s * time_s * (0.5 - x / 6.0) : (time_s - reach(time_s)) / decay_per_s;
}

void Recording::startOfSpin(const FreeSpin& spin, double& angle0, double& speed) const {
  angle0 = angle0_rad;
  speed = speed_rad_s;
  if (standstill || (spin.decay_per_s == 0.0 && spin.constant_rad_s2 == 0.0) || pulses.time.size() < 2) return;
  // least squares of angle + constant lost(t) over the same pulses: a straight line again, in reach(t)
  const std::size_t n = std::min<std::size_t>(pulses.time.size(), turns_at_start + 1);
  double st = 0, sa = 0, stt = 0, sta = 0;
  for (std::size_t i = 0; i < n; ++i) {
    const double t = spin.reach(pulses.time[i]);
    const double a = two_pi * static_cast<double>(pulses.turn[i]) + spin.constant_rad_s2 * spin.lost(pulses.time[i]);
    st += t;
    sa += a;
    stt += t * t;
    sta += t * a;
  }
  speed = (n * sta - st * sa) / (n * stt - st * st);
  angle0 = (sa - speed * st) / n;
}

Recording prepareRecording(const Dataset& dataset, const Run& run) {
  Recording rec;
  rec.run = run;
  const RunTable table = readRun(dataset, run);
  for (RunEvent& event : rec.run.events) event.time_s -= table.begins_s;
  rec.samples = static_cast<long>(table.time_s.size());
  rec.measured.assign(rec.samples * predicted_channels, 0.0);
  rec.excitation.rate_hz = run.sample_rate_hz;
  for (int a = 0; a < 4; ++a) {
    const Channel* displacement = dataset.findChannel(ChannelMeaning::displacement, a);
    const Channel* current = dataset.findChannel(ChannelMeaning::control_current, a);
    if (displacement != nullptr && !table.displacement_m[a].empty()) {
      rec.noise[a] = displacement->noise();
      for (long i = 0; i < rec.samples; ++i) rec.measured[i * predicted_channels + a] = table.displacement_m[a][i];
    }
    if (current != nullptr && !table.current_A[a].empty()) {
      rec.noise[4 + a] = current->noise();
      for (long i = 0; i < rec.samples; ++i) rec.measured[i * predicted_channels + 4 + a] = table.current_A[a][i];
    }
    rec.excitation.axis[a] = table.excitation_A[a];
  }
  rec.schedule = Schedule({}, bearingFaults(rec.run));
  const Channel* tacho = dataset.findChannel(ChannelMeaning::tacho);
  if (tacho != nullptr && !table.tacho.empty()) {
    TachoOptions options;
    options.threshold = tacho->threshold;
    rec.pulses = findPulses(table.time_s, table.tacho, options);
    for (const auto& fault : rec.pulses.faults) rec.remarks.push_back(fault.text());
  }
  const bool driven = run.kind == RunKind::run_up || run.kind == RunKind::coast_down;
  const bool believed_turning = (run.speed_from_tacho && driven) || run.speed_hz != 0.0;
  if (run.speed_from_tacho && rec.pulses.state != TachoState::turning) {
    if (driven)
      throw InputError({{datasetFile(dataset.folder), 0, "channels." + tacho->name, "",
                         "shows no turning in " + run.file + ", and run " + run.id +
                             " takes its speed from it; look at its threshold, or state the speed"}});
    rec.standstill = true;
    rec.remarks.push_back("the tacho shows no turning: the shaft is taken to stand still");
    return rec;
  }
  if (!(believed_turning || run.speed_from_tacho) || rec.pulses.state != TachoState::turning) {
    rec.standstill = !believed_turning;
    rec.speed_rad_s = radPerSecond(run.speed_hz);
    if (believed_turning)
      rec.remarks.push_back(std::string(tacho == nullptr ? "there is no tacho channel"
                                                         : "the tacho shows no turning, the belief does (look at its threshold)") +
                            shaftWords(rec, dataset.belief));
    return rec;
  }
  if (run.speed_from_tacho) {
    rec.path = std::make_shared<TachoPath>(rec.pulses);
    if (rec.pulses.half_width_s > 0.0 && rec.pulses.time.size() > 1) {  // a straight line's, and as much again for what bends
      const double edges = static_cast<double>(rec.pulses.time.size()), length = rec.pulses.time.back() - rec.pulses.time.front();
      rec.first_turns_s = 0.5 * (rec.pulses.time.front() + rec.pulses.time.back());
      rec.angle_std_rad = 2.0 * rec.path->at(rec.first_turns_s).speed * rec.pulses.half_width_s / std::sqrt(3.0 * edges);
      rec.speed_std_rad_s = std::sqrt(12.0) * rec.angle_std_rad / length;
    }
    const ShaftInstant start = rec.path->at(0.0);
    rec.angle0_rad = start.angle;
    rec.speed_rad_s = start.speed;
  } else {
    const double edge_std_s =
        std::max({least_edge_std_s, rec.pulses.rounding_s, rec.pulses.half_width_s / std::sqrt(3.0), edgeScatter(rec.pulses)});
    const SpeedFit all = fitSpeed(rec.pulses, 0, false, edge_std_s);
    const bool on_a_line = rec.pulses.half_width_s > 0.0 && all.valid && all.edge_rms < on_one_line * edge_std_s;
    const SpeedFit fit = on_a_line ? all : fitSpeed(rec.pulses, turns_at_start, false, edge_std_s);
    rec.speed_rad_s = fit.valid ? fit.speed : radPerSecond(run.speed_hz);
    rec.angle0_rad = -rec.speed_rad_s * (fit.valid ? fit.reference_time : rec.pulses.time.front());
    if (fit.valid && fit.speed_std > 0.0) {
      rec.angle_std_rad = fit.speed * std::max(fit.edge_rms, edge_std_s);
      rec.speed_std_rad_s = fit.speed_std;
      rec.first_turns_s = fit.reference_time + 0.5 * fit.turns * two_pi / fit.speed;
    }
    if (std::fabs(rec.speed_rad_s / radPerSecond(run.speed_hz) - 1.0) > believed_speed_std)
      rec.remarks.push_back("the tacho's speed differs from the believed one by more than 1 %" + pulsesATurn(rec, run));
  }
  return rec;
}

std::vector<Recording> prepareRecordings(const Dataset& dataset) {
  std::vector<Recording> recordings;
  for (const Run& run : dataset.runs) {
    recordings.push_back(prepareRecording(dataset, run));
    Recording& rec = recordings.back();
    for (const auto& remarks : {sensorRemarks(rec, dataset), channelRemarks(rec, dataset), excitationRemarks(rec, dataset),
                                turningRemarks(rec), clockRemarks(rec)})
      rec.remarks.insert(rec.remarks.end(), remarks.begin(), remarks.end());
  }
  applyLoopReading(recordings, dataset.belief);
  for (Recording& rec : recordings) rec.stays_inside = staysInside(rec, dataset.belief);
  return recordings;
}

}  // namespace amb_rotor
