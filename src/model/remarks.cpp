#include "amb_rotor/model/remarks.hpp"

#include <algorithm>
#include <cmath>
#include <string>

#include "amb_rotor/common/units.hpp"
#include "amb_rotor/model/model_rules.hpp"
#include "amb_rotor/model/yaml_document.hpp"
#include "scenario_fields.hpp"

namespace amb_rotor {
namespace {

/// Where a number of the rig mostly lies; 0 is never remarked.
struct UsualRange {
  const char* path;
  double lower, upper;
  const char* why;
};

constexpr double most_turns_rad = 2.0 * two_pi;
constexpr const char* an_angle = "two turns are 12.6 rad; are these degrees?";
constexpr const char* a_position = "from the centre of gravity; is it in m?";

/// From machines of a gram at 500 000 rpm to compressors of some tonnes, and some room around them.
const UsualRange usual_ranges[] = {
    {"rotor.mass_kg", 1e-3, 2e4, "is it in kg?"},
    {"planes.amb.a", 1e-3, 5.0, a_position},
    {"planes.amb.b", 1e-3, 5.0, a_position},
    {"planes.sensor.a", 1e-3, 5.0, a_position},
    {"planes.sensor.b", 1e-3, 5.0, a_position},
    {"planes.aux.a", 1e-3, 5.0, a_position},
    {"planes.aux.b", 1e-3, 5.0, a_position},
    {"amb.current_stiffness_N_per_A", 0.1, 1e4, "the thesis's bearing has 19 N/A"},
    {"amb.displacement_stiffness_N_per_m", 100.0, 1e9, "39.7 N/mm are 39700 N/m"},
    {"amb.bias_current_A", 0.01, 200.0, "is it in A?"},
    {"amb.air_gap_m", 5e-5, 5e-3, "0.75 mm are 0.75e-3 m"},
    {"amb.bias_flux_density_T", 0.01, 2.0, "iron saturates near 2 T"},
    {"amb.amplifier_bandwidth_hz", 20.0, 1e6, "is it in Hz?"},
    {"amb.max_current_A", 0.05, 500.0, "is it in A?"},
    {"amb.stiffness_N_per_m", 100.0, 1e10, "2.47 N/um are 2.47e6 N/m"},
    {"amb.damping_N_s_per_m", 1e-3, 1e7, "is it in N s/m?"},
    {"controller.sample_rate_hz", 200.0, 1e6, "is it in Hz?"},
    {"controller.derivative_filter_hz", 10.0, 1e6, "is it in Hz?"},
    {"controller.delay_s", 1e-8, 5e-3, "is it in s?"},
    {"auxiliary_bearing.clearance_m", 1e-5, 2e-3, "0.3 mm are 0.3e-3 m"},
    {"auxiliary_bearing.rotor_radius_m", 1e-3, 0.5, "10 mm are 0.010 m"},
    {"auxiliary_bearing.contact.stiffness_N_per_m", 1e4, 1e12, "33.8 N/um are 3.38e7 N/m"},
    {"auxiliary_bearing.contact.damping_N_s_per_m", 1e-3, 1e7, "is it in N s/m?"},
    {"gravity_m_s2", 0.1, 50.0, "on earth 9.81"},
    {"unbalance.plane_z_m", 1e-6, 5.0, a_position},
    {"unbalance.phase_rad", 0.0, most_turns_rad, an_angle}};

/// Beyond this multiple of what the other numbers give, a number of the magnets is remarked.
constexpr double far_off = 30.0;
/// 120 000 turns a minute.
constexpr double fast_hz = 2000.0;

void remark(const std::string& path, double value, const std::string& text, std::vector<Fault>& remarks) {
  remarks.push_back({"", 0, path, numberText(value), text});
}

void remarkOnMagnets(const Model& model, std::vector<Fault>& remarks) {
  const auto& amb = model.rig.amb;
  const double ks = amb.displacement_stiffness_N_per_m, ki = amb.current_stiffness_N_per_A;
  const double expected = ki * amb.bias_current_A / amb.air_gap_m;
  if (ks > 0.0 && (ks > far_off * expected || ks < expected / far_off))
    remark("rig.amb.displacement_stiffness_N_per_m", ks,
           "seldom so far from Ki i0/s0 = " + numberText(expected) + " N/m, which two magnets of this current stiffness, bias "
           "and air gap have (3.18)", remarks);
  const double weight = model.rig.rotor.mass_kg * model.rig.gravity_m_s2;
  const double carried = 2.0 * ki * std::min(amb.bias_current_A, amb.max_current_A - amb.bias_current_A);
  if (weight > carried)
    remark("rig.rotor.mass_kg", model.rig.rotor.mass_kg,
           "the weight, " + numberText(weight) + " N, is more than both magnetic bearings carry, " + numberText(carried) +
               " N (Ki times the control current that bias and largest current leave)", remarks);
}

template <class Owner>
void remarkOnKeys(const std::string& path, const std::vector<scenario_fields::Key<Owner>>& keys, const Owner& owner,
                  std::vector<Fault>& remarks) {
  const auto ends = [](const std::string& name, const std::string& tail) {
    return name.size() >= tail.size() && name.compare(name.size() - tail.size(), tail.size(), tail) == 0;
  };
  for (const auto& key : keys) {
    const double value = owner.*key.member;
    const std::string name = key.name, at = path + "." + name;
    if (ends(name, "_rad") && std::fabs(value) > most_turns_rad) remark(at, value, an_angle, remarks);
    if (ends(name, "plane_z_m") && std::fabs(value) > 5.0) remark(at, value, a_position, remarks);
    if (path == "speed" && ends(name, "_hz") && value > fast_hz)
      remark(at, value, numberText(60.0 * value) + " turns a minute are more than nearly all rotors make; is it in Hz?", remarks);
  }
}

std::vector<Fault> locatedIn(const std::shared_ptr<const FaultList>& source, const std::vector<Fault>& remarks) {
  return source != nullptr ? source->located(remarks) : remarks;
}

}  // namespace

std::vector<Fault> remarksOn(const Model& model) {
  std::vector<Fault> remarks;
  std::size_t unbalance_number = 0;
  const std::string list = "unbalance.";
  Rig<double>::visit(model.rig, [&](const char* name, const double& value) {
    std::string path = name;
    if (path.compare(0, list.size(), list) == 0)
      path = list + std::to_string(unbalance_number++ / 3) + "." + path.substr(list.size());
    if (!rigFieldApplies(name, model) || value == 0.0) return;
    for (const UsualRange& range : usual_ranges)
      if (std::string(range.path) == name && (std::fabs(value) < range.lower || std::fabs(value) > range.upper))
        remark("rig." + path, value,
               "mostly from " + numberText(range.lower) + " to " + numberText(range.upper) + " " + rigLimit(name).unit + " (" +
                   range.why + ")", remarks);
  });
  if (model.amb_model == AmbModel::linear) remarkOnMagnets(model, remarks);
  for (std::size_t i = 0; i < model.rig.unbalance.size(); ++i) {
    const double moment = model.rig.unbalance[i].moment_kg_m, clearance = model.rig.auxiliary_bearing.clearance_m;
    if (moment > model.rig.rotor.mass_kg * clearance)
      remark("rig.unbalance." + std::to_string(i) + ".moment_kg_m", moment,
             "over the mass is an eccentricity of " + numberText(moment / model.rig.rotor.mass_kg) +
                 " m, more than the clearance, " + numberText(clearance) + " m: the rotor cannot turn about its mass's centre",
             remarks);
  }
  return locatedIn(model.source, remarks);
}

std::vector<Fault> remarksOn(const Scenario& scenario) {
  using namespace scenario_fields;
  std::vector<Fault> remarks;
  remarkOnKeys("speed", keysOf(scenario.speed.type), scenario.speed, remarks);
  for (std::size_t i = 0; i < scenario.excitations.size(); ++i)
    remarkOnKeys("excitations." + std::to_string(i), keysOf(scenario.excitations[i]), scenario.excitations[i], remarks);
  for (std::size_t i = 0; i < scenario.faults.size(); ++i) {
    const FaultEvent& event = scenario.faults[i];
    const std::string path = "faults." + std::to_string(i);
    remarkOnKeys(path, keysOf(event.type), event, remarks);
    if (event.type == FaultType::speed_change && event.amount > fast_hz)
      remark(path + ".speed_hz", event.amount, "more turns than nearly all rotors make; is it in Hz?", remarks);
  }
  return locatedIn(scenario.source, remarks);
}

std::vector<Fault> remarksOn(const Model& model, const Scenario& scenario) {
  if (model.amb_model != AmbModel::linear) return {};
  const double half_rate = 0.5 * model.rig.controller.sample_rate_hz;
  std::vector<Fault> remarks;
  const auto look = [&](const std::string& path, double hz) {
    if (hz > half_rate)
      remark(path, hz, "above half of the controller's sample rate, " + numberText(half_rate) +
                 " Hz: it sees the unbalance at another frequency", remarks);
  };
  look("speed.start_hz", scenario.speed.start_hz);
  if (scenario.speed.type == SpeedType::ramp) look("speed.end_hz", scenario.speed.end_hz);
  for (std::size_t i = 0; i < scenario.faults.size(); ++i)
    if (scenario.faults[i].type == FaultType::speed_change) look("faults." + std::to_string(i) + ".speed_hz", scenario.faults[i].amount);
  return locatedIn(scenario.source, remarks);
}

}  // namespace amb_rotor
