#include <algorithm>
#include <cmath>

#include "amb_rotor/model/scenario_reader.hpp"
#include "amb_rotor/model/yaml_document.hpp"
#include "scenario_fields.hpp"

namespace amb_rotor {
namespace {

using namespace scenario_fields;

/// Beyond these a start has another unit.
constexpr double farthest_start_m = 0.05, steepest_start_rad = 0.5, fastest_start_m_s = 100.0, fastest_tilt_rad_s = 1e3;

class Rules {
 public:
  explicit Rules(bool skip_unreadable) : skip_unreadable_(skip_unreadable) {}

  void number(const std::string& path, double value, Limit limit) {
    if (!std::isfinite(value)) {
      if (!skip_unreadable_) add(path, value, "must be a finite number");
    } else if (limit == Limit::from_zero && value < 0.0) {
      add(path, value, "must be from 0");
    } else if (limit == Limit::above_zero && value <= 0.0) {
      add(path, value, "must be above 0");
    }
  }
  /// Of its size, too.
  void number(const std::string& path, double value, Limit limit, double most, const char* reason) {
    number(path, value, limit);
    if (std::isfinite(value) && std::fabs(value) > most)
      add(path, value, std::string(limit == Limit::any ? "must be from -" + numberText(most) + " to " : "must be at most ") +
                           numberText(most) + " (" + reason + ")");
  }
  template <class Owner>
  void keys(const std::string& path, const std::vector<Key<Owner>>& keys, const Owner& owner) {
    for (const auto& key : keys) number(path + "." + key.name, owner.*key.member, key.limit, key.most, key.reason);
  }
  void within(const std::string& path, double start_s, double duration_s) {
    if (std::isfinite(start_s) && std::isfinite(duration_s) && start_s >= duration_s && duration_s > 0.0)
      add(path, start_s, "begins at or after the end of the scenario, " + numberText(duration_s) + " s");
  }
  void add(const std::string& path, double value, const std::string& rule) {
    faults.push_back({"", 0, path, numberText(value), rule});
  }
  void address(const std::string& path, int end, int axis, int lowest) {
    if (end < lowest || end > 1) add(path + ".end", end, "there is no such end");
    if (axis < lowest || axis > 1) add(path + ".axis", axis, "there is no such axis");
  }

  std::vector<Fault> faults;

 private:
  bool skip_unreadable_;
};

void checkFault(Rules& rules, const FaultEvent& event, const std::string& path) {
  rules.keys(path, keysOf(event.type), event);
  if (addressOf(event.type) == Address::several) rules.address(path, event.end, event.axis, -1);
  if (event.duration_s > 0.0 && event.ramp_s > event.duration_s)
    rules.add(path + ".ramp_s", event.ramp_s,
              "must be at most duration_s, " + numberText(event.duration_s) + " s");
}

void checkStart(Rules& rules, const Scenario& scenario) {
  if (scenario.start_settled) return;
  const auto& displacement = scenario.initial_displacement_m;
  const auto& velocity = scenario.initial_velocity_m_s;
  if (displacement.size() != 2 && displacement.size() != 4)
    rules.add("start.displacement", static_cast<double>(displacement.size()),
              "must have 4 numbers (x_G, y_G, beta, -alpha), or 2 for a rigid_mass (x_G, y_G)");
  if (velocity.size() != displacement.size())
    rules.add("start.velocity", static_cast<double>(velocity.size()),
              "must have as many numbers as displacement");
  // the first two are the centre's, then come the slopes
  for (std::size_t i = 0; i < displacement.size(); ++i)
    rules.number("start.displacement." + std::to_string(i), displacement[i], Limit::any, i < 2 ? farthest_start_m : steepest_start_rad,
                 i < 2 ? "no air gap is as wide, in m" : "a tilt is a small angle, in rad");
  for (std::size_t i = 0; i < velocity.size(); ++i)
    rules.number("start.velocity." + std::to_string(i), velocity[i], Limit::any, i < 2 ? fastest_start_m_s : fastest_tilt_rad_s,
                 i < 2 ? "nothing in an air gap is as fast, in m/s" : "nothing in an air gap is as fast, in rad/s");
}

}  // namespace

std::vector<Fault> checkFaultEvent(const FaultEvent& event, const std::string& path, bool skip_unreadable) {
  Rules rules(skip_unreadable);
  checkFault(rules, event, path);
  return rules.faults;
}

std::vector<Fault> checkScenario(const Scenario& scenario, bool skip_unreadable) {
  Rules rules(skip_unreadable);
  rules.number("duration_s", scenario.duration_s, Limit::above_zero);
  rules.number("record_rate_hz", scenario.record_rate_hz, Limit::above_zero);
  if (scenario.duration_s * scenario.record_rate_hz > max_recorded_samples)
    rules.add("record_rate_hz", scenario.record_rate_hz,
              "times duration_s is more than " + numberText(max_recorded_samples) + " samples");
  rules.keys("speed", keysOf(scenario.speed.type), scenario.speed);
  if (scenario.speed.type == SpeedType::ramp || scenario.speed.type == SpeedType::decay)
    rules.within("speed.start_s", scenario.speed.start_s, scenario.duration_s);
  for (std::size_t i = 0; i < scenario.excitations.size(); ++i) {
    const Excitation& excitation = scenario.excitations[i];
    const std::string path = "excitations." + std::to_string(i);
    rules.keys(path, keysOf(excitation), excitation);
    rules.within(path + ".start_s", excitation.start_s, scenario.duration_s);
    if (excitation.kind == Excitation::Kind::current) rules.address(path, excitation.end, excitation.axis, 0);
    if (excitation.waveform == Waveform::chirp && excitation.start_hz == excitation.end_hz)
      rules.add(path + ".end_hz", excitation.end_hz, "must differ from start_hz (one frequency is a sine)");
  }
  for (std::size_t i = 0; i < scenario.faults.size(); ++i) {
    const std::string path = "faults." + std::to_string(i);
    checkFault(rules, scenario.faults[i], path);
    rules.within(path + ".start_s", scenario.faults[i].start_s, scenario.duration_s);
  }
  checkStart(rules, scenario);
  return rules.faults;
}

}  // namespace amb_rotor
