#include "scenario_fields.hpp"

namespace amb_rotor::scenario_fields {
namespace {

// What no run with a rotor on magnets has, by a factor of ten or so: beyond it a unit is wrong.
constexpr double most_speed_hz = 2e4, most_frequency_hz = 1e6, most_force_N = 1e7, most_current_A = 1e4;
constexpr double most_plane_m = 20.0, most_moment_kg_m = 100.0, most_offset_m = 0.05, most_decay_per_s = 1e4;
constexpr const char* fastest = "1.2 million turns a minute; rpm are sixty times Hz";
constexpr const char* highest = "no force of a machine is as fast";
constexpr const char* heaviest = "the weight of 1000 t";
constexpr const char* largest_current = "no coil bears it";
constexpr const char* farthest = "from the centre of gravity, in m";
constexpr const char* most_unbalanced = "in kg m";
constexpr const char* widest = "no air gap is as wide, in m";

}  // namespace

const std::vector<std::string> speed_names = {"constant", "ramp", "decay", "free"};
const std::vector<std::string> waveform_names = {"step", "impulse", "chirp", "sine"};
const std::vector<std::string> fault_names = {
    "unbalance_step", "amb_off", "amb_on", "force_impulse", "force_step", "sensor_offset", "speed_change"};

std::vector<Key<SpeedLaw>> keysOf(SpeedType type) {
  std::vector<Key<SpeedLaw>> keys = {{"start_hz", &SpeedLaw::start_hz, Limit::from_zero, most_speed_hz, fastest},
                                     {"initial_angle_rad", &SpeedLaw::initial_angle_rad, Limit::any}};
  if (type == SpeedType::ramp || type == SpeedType::decay)
    keys.push_back({"start_s", &SpeedLaw::start_s, Limit::from_zero});
  if (type == SpeedType::ramp) {
    keys.push_back({"end_hz", &SpeedLaw::end_hz, Limit::from_zero, most_speed_hz, fastest});
    keys.push_back({"duration_s", &SpeedLaw::duration_s, Limit::above_zero});
  }
  if (type == SpeedType::decay)
    keys.push_back({"decay_factor_per_s", &SpeedLaw::decay_factor_per_s, Limit::above_zero, most_decay_per_s,
                    "the rotor stands still at once"});
  return keys;
}

std::vector<Key<Excitation>> keysOf(const Excitation& excitation) {
  std::vector<Key<Excitation>> keys;
  if (excitation.kind == Excitation::Kind::force) {
    keys = {{"plane_z_m", &Excitation::plane_z_m, Limit::any, most_plane_m, farthest},
            {"direction_rad", &Excitation::direction_rad, Limit::any},
            {"amplitude_N", &Excitation::amplitude, Limit::any, most_force_N, heaviest}};
  } else {
    keys = {{"amplitude_A", &Excitation::amplitude, Limit::any, most_current_A, largest_current}};
  }
  keys.push_back({"start_s", &Excitation::start_s, Limit::from_zero});
  const bool may_last = excitation.waveform == Waveform::step || excitation.waveform == Waveform::sine;
  keys.push_back({"duration_s", &Excitation::duration_s, may_last ? Limit::from_zero : Limit::above_zero});
  if (excitation.waveform == Waveform::chirp) {
    keys.push_back({"start_hz", &Excitation::start_hz, Limit::from_zero, most_frequency_hz, highest});
    keys.push_back({"end_hz", &Excitation::end_hz, Limit::from_zero, most_frequency_hz, highest});
  }
  if (excitation.waveform == Waveform::sine)
    keys.push_back({"frequency_hz", &Excitation::start_hz, Limit::above_zero, most_frequency_hz, highest});
  return keys;
}

std::vector<Key<FaultEvent>> keysOf(FaultType type) {
  const Key<FaultEvent> start = {"start_s", &FaultEvent::start_s, Limit::from_zero};
  const Key<FaultEvent> ramp = {"ramp_s", &FaultEvent::ramp_s, Limit::from_zero};
  const Key<FaultEvent> duration = {"duration_s", &FaultEvent::duration_s, Limit::from_zero};
  const Key<FaultEvent> plane = {"plane_z_m", &FaultEvent::plane_z_m, Limit::any, most_plane_m, farthest};
  const Key<FaultEvent> direction = {"direction_rad", &FaultEvent::phase_rad, Limit::any};
  const Key<FaultEvent> force = {"force_N", &FaultEvent::amount, Limit::any, most_force_N, heaviest};
  switch (type) {
    case FaultType::unbalance_step:
      return {start,    ramp,
              duration, {"moment_kg_m", &FaultEvent::amount, Limit::from_zero, most_moment_kg_m, most_unbalanced},
              plane,    {"phase_rad", &FaultEvent::phase_rad, Limit::any}};
    case FaultType::amb_off:
      return {start, duration};
    case FaultType::amb_on:
      return {start};
    case FaultType::force_impulse:
      return {start, {"duration_s", &FaultEvent::duration_s, Limit::above_zero}, force, plane, direction};
    case FaultType::force_step:
      return {start, ramp, duration, force, plane, direction};
    case FaultType::sensor_offset:
      return {start, ramp, duration, {"offset_m", &FaultEvent::amount, Limit::any, most_offset_m, widest}};
    case FaultType::speed_change:
      return {start, ramp, {"speed_hz", &FaultEvent::amount, Limit::from_zero, most_speed_hz, fastest}};
  }
  return {};
}

Address addressOf(FaultType type) {
  const bool addressed =
      type == FaultType::amb_off || type == FaultType::amb_on || type == FaultType::sensor_offset;
  return addressed ? Address::several : Address::none;
}

}  // namespace amb_rotor::scenario_fields
