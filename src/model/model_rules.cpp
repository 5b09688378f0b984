#include "amb_rotor/model/model_rules.hpp"

#include <algorithm>
#include <cmath>
#include <set>

#include "amb_rotor/model/yaml_document.hpp"
#include "control_text.hpp"

namespace amb_rotor {
namespace {

constexpr bool above = true;
constexpr bool from = false;
constexpr const char* longest = "no rotor on magnets is as long; is it in m?";
/// Radius of gyration of a rotor that tilts over the span of its planes: 0.29 for a rod that ends there, 0.03 for a disc
/// of a tenth of the span whose shaft weighs next to nothing, 6 for a flywheel on bearings close together. Wide limits: another
/// unit is off by 30 (grams) or 1000 (kg mm2, mm).
constexpr double least_gyration = 0.01, most_gyration = 20.0;

bool startsWith(const std::string& text, const std::string& head) {
  return text.compare(0, head.size(), head) == 0;
}

std::string fieldPath(const char* name, std::size_t unbalance_index) {
  const std::string path = name;
  const std::string list = "unbalance.";
  if (!startsWith(path, list)) return "rig." + path;
  return "rig." + list + std::to_string(unbalance_index / 3) + "." + path.substr(list.size());
}

/// Calls f(path with index, name, field) for every field of the rig.
template <class R, class F>
void visitRig(R& rig, F&& f) {
  std::size_t unbalance_index = 0;
  Rig<double>::visit(rig, [&](const char* name, auto& value) {
    f(fieldPath(name, unbalance_index), name, value);
    if (startsWith(name, "unbalance.")) ++unbalance_index;
  });
}

/// The value, or none where it breaks its own limit.
double sound(const std::string& path, double value) { return rigLimit(path).holds(value) ? value : std::nan(""); }

/// Collects the faults of relations between values. A relation to a value that is unreadable or breaks its
/// own limit is left out: it would only repeat that fault.
class Relations {
 public:
  explicit Relations(std::vector<Fault>& faults) : faults_(faults) {}
  void require(const std::string& path, double value, double other, bool holds, const std::string& rule) {
    if (std::isfinite(value) && std::isfinite(other) && !holds && std::isfinite(sound(fieldName(path), value)))
      faults_.push_back({"", 0, path, numberText(value), rule});
  }

 private:
  /// "rig.unbalance.0.moment_kg_m" -> "unbalance.moment_kg_m", as rigLimits() has it.
  static std::string fieldName(const std::string& path) {
    const std::string name = path.substr(std::string("rig.").size());
    return startsWith(name, "unbalance.") ? "unbalance" + name.substr(name.rfind('.')) : name;
  }
  std::vector<Fault>& faults_;
};

/// Lengths and masses that do not belong to one machine: one of them has another unit.
void checkProportions(const Model& model, Relations& relations) {
  const auto& rig = model.rig;
  const double mass = sound("rotor.mass_kg", rig.rotor.mass_kg);
  const double radius = sound("auxiliary_bearing.rotor_radius_m", rig.auxiliary_bearing.rotor_radius_m);
  relations.require("rig.auxiliary_bearing.clearance_m", rig.auxiliary_bearing.clearance_m, radius,
                    rig.auxiliary_bearing.clearance_m < radius,
                    "must be below the rotor's radius in the bearing, " + numberText(radius) + " m (is it in m?)");
  if (model.rotor_model != RotorModel::rigid_mass) {  // a rigid_mass does not tilt
    double first = unlimited, last = -unlimited;
    Rig<double>::visit(rig, [&](const char* name, const double& z) {
      if (!startsWith(name, "planes.")) return;
      first = std::isfinite(sound(name, z)) ? std::min(first, z) : std::nan("");
      last = std::max(last, z);
    });
    const double span = last - first, inertia = rig.rotor.transverse_inertia_kg_m2, gyration = std::sqrt(inertia / mass);
    relations.require("rig.rotor.transverse_inertia_kg_m2", inertia, span > 0.0 ? gyration : std::nan(""),
                      gyration >= least_gyration * span && gyration <= most_gyration * span,
                      "with the mass, " + numberText(mass) + " kg, gives a radius of gyration of " + numberText(gyration) +
                          " m; must be from " + numberText(least_gyration * span) + " to " + numberText(most_gyration * span) +
                          " m, between a hundredth and twenty times what the planes span (are they in kg, kg m2 and m?)");
  }
  for (std::size_t i = 0; i < rig.unbalance.size(); ++i) {
    const double moment = rig.unbalance[i].moment_kg_m, eccentricity = moment / mass;
    relations.require("rig.unbalance." + std::to_string(i) + ".moment_kg_m", moment, radius, !(eccentricity > radius),
                      "over the mass is an eccentricity of " + numberText(eccentricity) +
                          " m; must be at most the rotor's radius in the auxiliary bearing, " + numberText(radius) +
                          " m (is it in kg m?)");
  }
}

void checkRelations(const Model& model, std::vector<Fault>& faults) {
  const auto& rig = model.rig;
  Relations relations(faults);
  const double transverse = sound("rotor.transverse_inertia_kg_m2", rig.rotor.transverse_inertia_kg_m2);
  relations.require("rig.rotor.polar_inertia_kg_m2", rig.rotor.polar_inertia_kg_m2, transverse,
                    rig.rotor.polar_inertia_kg_m2 <= 2.0 * transverse,
                    "must be at most twice the transverse inertia, " + numberText(2.0 * transverse) +
                        " kg m2 (no body has a larger one: triangle inequality)");
  const auto ordered = [&](const std::string& name, const double(&z)[2]) {
    relations.require("rig.planes." + name + ".b", z[1], z[0], z[0] < z[1],
                      "must be above plane a, " + numberText(z[0]) + " m (end B is at the larger z)");
  };
  ordered("amb", rig.planes.amb);
  ordered("sensor", rig.planes.sensor);
  ordered("aux", rig.planes.aux);
  checkProportions(model, relations);
  if (model.amb_model != AmbModel::linear) return;
  const double air_gap = sound("amb.air_gap_m", rig.amb.air_gap_m);
  relations.require("rig.auxiliary_bearing.clearance_m", rig.auxiliary_bearing.clearance_m, air_gap,
                    rig.auxiliary_bearing.clearance_m < air_gap,
                    "must be below the air gap, " + numberText(air_gap) +
                        " m (or the rotor hits the magnets before the auxiliary bearing)");
  const double max_current = sound("amb.max_current_A", rig.amb.max_current_A);
  relations.require("rig.amb.bias_current_A", rig.amb.bias_current_A, max_current,
                    rig.amb.bias_current_A <= max_current,
                    "must be at most max_current_A, " + numberText(max_current) + " A");
  const double rate = sound("controller.sample_rate_hz", rig.controller.sample_rate_hz);
  constexpr double round_off = 1e-9;  // of a product such as 0.002 s * 10000 Hz
  relations.require("rig.controller.delay_s", rig.controller.delay_s, rate,
                    rig.controller.delay_s * rate <= max_delay_samples + round_off,
                    "must be at most " + numberText(max_delay_samples) + " samples, " +
                        numberText(max_delay_samples / rate) + " s");
}

void checkUncertainty(const Model& model, bool skip_unreadable, std::vector<Fault>& faults) {
  const auto names = uncertaintyNames(model);
  for (const auto& entry : model.uncertainty) {
    const std::string path = "rig.uncertainty." + entry.first;
    if (std::find(names.begin(), names.end(), entry.first) == names.end()) {
      faults.push_back({"", 0, path, numberText(entry.second),
                        "no number of this rig has this name; nearest: " + nearestWord(entry.first, names)});
    } else if (std::isfinite(entry.second) ? entry.second < 0.0 : !skip_unreadable) {
      faults.push_back(
          {"", 0, path, numberText(entry.second),
           "must be from 0 (a standard deviation; relative, but rad for a phase, m for an offset)"});
    }
  }
}

/// A fault of the effect where the rig's field is not above 0, or has no meaning for its bearings.
void requireField(const Model& model, const std::string& field, const std::string& effect,
                  std::vector<Fault>& faults) {
  Rig<double>::visit(model.rig, [&](const char* name, const double& value) {
    if (field != name) return;
    const bool applies = rigFieldApplies(name, model);
    if (applies && value > 0.0) return;
    const char* lack = applies ? "is not stated" : "has no meaning for an equivalent bearing";
    faults.push_back({"", 0, effect, "", "needs rig." + field + ", which " + lack + ": it would do nothing"});
  });
}

void checkEffects(const Model& model, const EffectCatalogue& catalogue, bool skip_unreadable,
                  std::vector<Fault>& faults) {
  std::set<std::string> seen;
  for (const EffectSetting& effect : model.effects) {
    const std::string path = "effects." + effect.id;
    const EffectSchema* schema = catalogue.find(effect.id);
    if (schema == nullptr) {
      std::vector<std::string> ids;
      for (const auto& known : catalogue.all()) ids.push_back(known.id);
      faults.push_back({"", 0, path, "", "the effect is not known; nearest: " + nearestWord(effect.id, ids)});
      continue;
    }
    if (!seen.insert(effect.id).second)
      faults.push_back({"", 0, path, "", "the effect stands twice; it may act once"});
    if (effect.values.size() != schema->parameters.size()) {
      faults.push_back({"", 0, path, "",
                        "has " + std::to_string(effect.values.size()) + " values; its schema has " +
                            std::to_string(schema->parameters.size())});
      continue;
    }
    if (!schema->needs_field.empty()) requireField(model, schema->needs_field, path, faults);
    for (std::size_t i = 0; i < effect.values.size(); ++i) {
      const ParameterSchema& parameter = schema->parameters[i];
      const double value = effect.values[i];
      if (!std::isfinite(value) && skip_unreadable) continue;
      if (value >= parameter.lower && value <= parameter.upper) continue;
      faults.push_back({"", 0, path + "." + parameter.name, numberText(value),
                        "must be from " + numberText(parameter.lower) + " to " + numberText(parameter.upper) +
                            " " + parameter.unit + " (" + parameter.meaning + ")"});
    }
  }
}

/// Effects that a model's structure leaves nothing to act on, and effects that exclude each other.
void checkStructure(const Model& model, std::vector<Fault>& faults) {
  const auto has = [&](const char* id) {
    return std::any_of(model.effects.begin(), model.effects.end(),
                       [&](const EffectSetting& effect) { return effect.id == id; });
  };
  if (has("gyroscopic_coupling") && model.rotor_model == RotorModel::rigid_mass)
    faults.push_back(
        {"", 0, "effects.gyroscopic_coupling", "", "needs a rotor that tilts; a rigid_mass does not"});
  if (has("gyroscopic_coupling") && model.rotor_model == RotorModel::flexible)
    faults.push_back({"", 0, "effects.gyroscopic_coupling", "",
                      "is for a rigid_beam; a flexible rotor has its gyroscopic matrix from its geometry"});
  if (has("shaft_flexibility") && model.rotor_model == RotorModel::rigid_mass)
    faults.push_back({"", 0, "effects.shaft_flexibility", "",
                      "is for a rigid_beam; a rigid_mass moves alike at all planes, and a rotor that bends tilts, too"});
  if (has("shaft_flexibility") && model.rotor_model == RotorModel::flexible)
    faults.push_back({"", 0, "effects.shaft_flexibility", "",
                      "is for a rigid_beam; a flexible rotor has its first bending mode from its geometry: it would bend twice"});
  if (has("compliant_mount") && has("fractional_mount"))
    faults.push_back(
        {"", 0, "effects.fractional_mount", "", "excludes compliant_mount; a bearing has one mount"});
}

/// What a bearing that is off its place leaves of its clearance, and of the air gap.
void checkBearingPlaces(const Model& model, const EffectCatalogue& catalogue, std::vector<Fault>& faults) {
  const double clearance = model.rig.auxiliary_bearing.clearance_m;
  for (const EffectSetting& effect : model.effects) {
    const auto value = [&](const std::string& name) {
      const int index = catalogue.find(effect.id)->indexOf(name);
      return effect.values[static_cast<std::size_t>(index)];
    };
    for (const char* end : {"a", "b"}) {
      const std::string key = "effects." + effect.id, of = end;
      if (effect.id == "auxiliary_bearing_misalignment" && model.amb_model == AmbModel::linear) {
        const double offset = std::hypot(value("offset_" + of + "x_m"), value("offset_" + of + "y_m"));
        if (!(offset + clearance < model.rig.amb.air_gap_m))
          faults.push_back({"", 0, key + ".offset_" + of + "x_m", numberText(offset),
                            "with the clearance, " + numberText(clearance) + " m, must be below the air gap, " +
                                numberText(model.rig.amb.air_gap_m) + " m (or the rotor hits the magnets first)"});
      }
      if (effect.id == "auxiliary_bearing_tilt") {
        const double edge = 0.5 * value("width_m") * std::hypot(value("slope_" + of + "x_rad"), value("slope_" + of + "y_rad"));
        if (!(edge < clearance))
          faults.push_back({"", 0, key + ".slope_" + of + "x_rad", numberText(edge),
                            "the edges' offset, half the width times the slope, must be below the clearance, " +
                                numberText(clearance) + " m (or the shaft does not pass)"});
      }
    }
  }
}

/// What holds between the rig's numbers holds between those that effects put in their place, too.
void checkReplaced(const Model& model, const EffectCatalogue& catalogue, std::vector<Fault>& faults) {
  for (const EffectSetting& effect : model.effects) {
    const EffectSchema* schema = catalogue.find(effect.id);
    Model with = model;
    bool any = false;
    for (std::size_t i = 0; i < effect.values.size(); ++i) {
      if (schema->parameters[i].replaces.empty()) continue;
      Rig<double>::visit(with.rig, [&](const char* name, double& value) {
        if (schema->parameters[i].replaces == name) value = effect.values[i], any = true;
      });
    }
    if (!any) continue;
    std::vector<Fault> broken;
    checkRelations(with, broken);
    for (const Fault& fault : broken)
      faults.push_back({"", 0, "effects." + effect.id, "", "with it " + fault.key + " = " + fault.value + " " + fault.rule});
  }
}

}  // namespace

std::vector<Fault> checkShaft(const Model& model, const EffectCatalogue& catalogue) {
  constexpr double mass_agreement = 0.01, tilt_agreement = 0.05;
  constexpr double end_m = 1e-6;  // of a shaft, for round-off
  std::vector<Fault> faults;
  const FlexibleModes& shaft = model.flexible;
  if (model.rotor_model != RotorModel::flexible || shaft.mass.size() < 2 || shaft.z_m.empty()) return faults;
  const auto agrees = [&](const char* name, double value, double own, double share, const char* unit, const char* to) {
    if (!(std::fabs(own / value - 1.0) <= share))
      faults.push_back({"", 0, std::string("rig.rotor.") + name, numberText(value),
                        std::string("must agree with the geometry's, ") + numberText(own) + " " + unit + ", to " + to});
  };
  agrees("mass_kg", model.rig.rotor.mass_kg, shaft.mass[0], mass_agreement, "kg", "1 %");
  agrees("transverse_inertia_kg_m2", model.rig.rotor.transverse_inertia_kg_m2, shaft.mass[1], tilt_agreement, "kg m2", "5 %");
  // the rigid tilt has slope 1, so its gyroscopic number is the shaft's own polar inertia
  const double polar = shaft.gyroscopic.size() == shaft.mass.size() * shaft.mass.size()
                           ? std::fabs(shaft.gyroscopic[shaft.mass.size() + 1]) : 0.0;
  if (model.rig.rotor.polar_inertia_kg_m2 > 0.0 && polar > 0.0)  // 0: not stated
    agrees("polar_inertia_kg_m2", model.rig.rotor.polar_inertia_kg_m2, polar, tilt_agreement, "kg m2", "5 %");
  const auto onShaft = [&](const std::string& path, double z) {
    if (!(z >= shaft.z_m.front() - end_m && z <= shaft.z_m.back() + end_m))
      faults.push_back({"", 0, path, numberText(z),
                        "must be on the shaft, from " + numberText(shaft.z_m.front()) + " to " + numberText(shaft.z_m.back()) +
                            " m from the centre of gravity"});
  };
  visitRig(model.rig, [&](const std::string& path, const char* name, const double& value) {
    if (startsWith(name, "planes.") || std::string(name) == "unbalance.plane_z_m") onShaft(path, value);
  });
  for (const EffectSetting& effect : model.effects) {
    const EffectSchema* schema = catalogue.find(effect.id);
    for (std::size_t i = 0; schema != nullptr && i < std::min(effect.values.size(), schema->parameters.size()); ++i) {
      const std::string& name = schema->parameters[i].name;
      if (name == "z_m" || name == "plane_z_m") onShaft("effects." + effect.id + "." + name, effect.values[i]);
    }
  }
  return faults;
}

std::string FieldLimit::text() const {
  std::string rule = "must be a finite number";
  if (std::isfinite(lower))
    rule = std::string("must be ") + (lower_is_open ? "above " : "from ") + numberText(lower);
  if (std::isfinite(upper)) rule += " to " + numberText(upper);
  const bool has_unit = std::isfinite(lower) && std::string(unit) != "1";
  return rule + (has_unit ? std::string(" ") + unit : "") + " (" + reason + ")";
}

std::string FieldLimit::text(double value) const {
  if (!isTooLarge(value)) return text();
  const std::string bound = numberText(largest);
  return (std::isfinite(lower) ? "must be at most " + bound : "must be from -" + bound + " to " + bound) + " " + unit + " (" +
         why_largest + ")";
}

const std::vector<FieldLimit>& rigLimits() {
  static const std::vector<FieldLimit> limits = {
      {"rotor.mass_kg", 0, above, unlimited, "kg", "a rotor has a mass", 1e5, "the heaviest on magnets have some tonnes"},
      {"rotor.transverse_inertia_kg_m2", 0, above, unlimited, "kg m2", "a rotor resists tilting", 1e7, "100 t on 30 m"},
      {"rotor.polar_inertia_kg_m2", 0, from, unlimited, "kg m2", "0: no gyroscopic moment", 1e7, "100 t of 10 m"},
      {"planes.amb.a", -unlimited, from, unlimited, "m", "from the centre of gravity", 20, longest},
      {"planes.amb.b", -unlimited, from, unlimited, "m", "from the centre of gravity", 20, longest},
      {"planes.sensor.a", -unlimited, from, unlimited, "m", "from the centre of gravity", 20, longest},
      {"planes.sensor.b", -unlimited, from, unlimited, "m", "from the centre of gravity", 20, longest},
      {"planes.aux.a", -unlimited, from, unlimited, "m", "from the centre of gravity", 20, longest},
      {"planes.aux.b", -unlimited, from, unlimited, "m", "from the centre of gravity", 20, longest},
      {"amb.current_stiffness_N_per_A", 0, above, unlimited, "N/A", "a current pulls towards its coil", 1e6, "10 kN at 10 A are 1e3"},
      {"amb.displacement_stiffness_N_per_m", 0, from, unlimited, "N/m", "a magnet pulls off centre, never back", 1e10,
       "10 kN in a gap of 0.5 mm are 2e7"},
      {"amb.bias_current_A", 0, above, unlimited, "A", "the linear law is about a bias current", 1e4, "no coil bears it"},
      {"amb.air_gap_m", 0, above, unlimited, "m", "between magnet and centred rotor", 0.05, "mostly 0.3 to 2 mm; is it in m?"},
      {"amb.bias_flux_density_T", 0, from, unlimited, "T", "0: not stated", 4, "iron saturates near 2 T"},
      {"amb.amplifier_bandwidth_hz", 0, above, unlimited, "Hz", "a first-order lag", 1e8, "no amplifier is as fast"},
      {"amb.max_current_A", 0, above, unlimited, "A", "of one coil", 1e4, "no coil bears it"},
      {"amb.stiffness_N_per_m", 0, from, unlimited, "N/m", "of one bearing and axis", 1e12, "solid steel has less"},
      {"amb.damping_N_s_per_m", 0, from, unlimited, "N s/m", "of one bearing and axis", 1e9, "nothing damps as much"},
      {"controller.sample_rate_hz", 0, above, unlimited, "Hz", "the controller is sampled", 1e8, "no converter is as fast"},
      {"controller.kp_A_per_m", 0, from, unlimited, "A/m", "positive pulls back to the centre", 1e10, "10 A for a nanometre"},
      {"controller.kd_A_s_per_m", 0, from, unlimited, "A s/m", "positive damps", 1e8, "100 A for a um/s"},
      {"controller.ki_A_per_m_s", 0, from, unlimited, "A/(m s)", "positive pulls back to the centre", 1e13, "10 A/s for a pm"},
      {"controller.derivative_filter_hz", 0, above, unlimited, "Hz", "or the filter is not stable", 1e8, "no converter is as fast"},
      {"controller.delay_s", 0, from, unlimited, "s", "the command follows its sample", 1, "is it in s?"},
      {"auxiliary_bearing.clearance_m", 0, above, unlimited, "m", "or the rotor is never free", 0.02,
       "mostly 0.1 to 0.5 mm; is it in m?"},
      {"auxiliary_bearing.rotor_radius_m", 0, above, unlimited, "m", "of the rotor in the auxiliary bearing", 2, "is it in m?"},
      {"auxiliary_bearing.contact.stiffness_N_per_m", 0, above, unlimited, "N/m", "contact pushes back", 1e13, "solid steel has less"},
      {"auxiliary_bearing.contact.damping_N_s_per_m", 0, from, unlimited, "N s/m", "contact takes energy out", 1e9,
       "nothing damps as much"},
      {"auxiliary_bearing.friction_coefficient", 0, from, 2, "1", "of dry or lubricated metal"},
      {"gravity_m_s2", 0, from, unlimited, "m/s2", "acts downwards, along -y", 300, "30 times that of the earth"},
      {"unbalance.plane_z_m", -unlimited, from, unlimited, "m", "from the centre of gravity", 20, longest},
      {"unbalance.moment_kg_m", 0, from, unlimited, "kg m", "its direction is the phase", 100, "100 t 1 mm off their axis"},
      {"unbalance.phase_rad", -unlimited, from, unlimited, "rad", "from the tacho mark", 1e6, "is it in rad?"}};
  return limits;
}

const FieldLimit& rigLimit(const std::string& path) {
  const auto& limits = rigLimits();
  const auto found =
      std::find_if(limits.begin(), limits.end(), [&](const FieldLimit& limit) { return path == limit.path; });
  AMB_ROTOR_CHECK(found != limits.end(), "no limit for the rig's field " + path);
  return *found;
}

bool rigFieldApplies(const std::string& path, AmbModel amb_model) {
  const bool of_equivalent = path == "amb.stiffness_N_per_m" || path == "amb.damping_N_s_per_m";
  if (amb_model == AmbModel::linear) return !of_equivalent;
  return of_equivalent || !(startsWith(path, "amb.") || startsWith(path, "controller."));
}

bool rigFieldApplies(const std::string& path, const Model& model) {
  if (model.control.type == ControllerType::state_space && model.amb_model == AmbModel::linear)
    for (const char* name : {"kp_A_per_m", "kd_A_s_per_m", "ki_A_per_m_s", "derivative_filter_hz"})
      if (path == std::string("controller.") + name) return false;
  return rigFieldApplies(path, model.amb_model);
}

std::vector<Fault> checkRig(const Model& model, bool skip_unreadable) {
  std::vector<Fault> faults;
  bool readable = true;
  visitRig(model.rig, [&](const std::string& path, const char* name, const double& value) {
    if (!rigFieldApplies(name, model)) return;
    if (!std::isfinite(value)) readable = false;
    if (!std::isfinite(value) && skip_unreadable) return;
    const FieldLimit& limit = rigLimit(name);
    if (!std::isfinite(value) || !limit.holds(value))
      faults.push_back({"", 0, path, numberText(value), std::isfinite(value) ? limit.text(value) : limit.text()});
  });
  checkRelations(model, faults);
  checkOptions(model, skip_unreadable, faults);
  checkUncertainty(model, skip_unreadable, faults);
  if (faults.empty() && readable) checkSampleTime(model, faults);
  return faults;
}

std::vector<Fault> checkModel(const Model& model, const EffectCatalogue& catalogue, bool skip_unreadable) {
  std::vector<Fault> faults = checkRig(model, skip_unreadable);
  const bool flexible = model.rotor_model == RotorModel::flexible;
  if (flexible && model.rotor_geometry.empty() && model.flexible.mass.empty() && !skip_unreadable)
    faults.push_back({"", 0, "rotor.geometry", "", "a flexible rotor needs a geometry file"});
  if (!flexible && !model.rotor_geometry.empty())
    faults.push_back({"", 0, "rotor.geometry", model.rotor_geometry, "a rigid rotor has no geometry file"});
  checkEffects(model, catalogue, skip_unreadable, faults);
  if (faults.empty()) checkReplaced(model, catalogue, faults);
  checkStructure(model, faults);
  if (faults.empty()) checkBearingPlaces(model, catalogue, faults);
  const std::vector<Fault> of_shaft = checkShaft(model, catalogue);
  faults.insert(faults.end(), of_shaft.begin(), of_shaft.end());
  return faults;
}

void requireValid(const Model& model, const EffectCatalogue& catalogue) {
  const std::vector<Fault> faults = checkModel(model, catalogue);
  if (!faults.empty()) throw InputError(faults);
}

std::vector<ModelField> modelFields(Model& model, const EffectCatalogue& catalogue) {
  std::vector<ModelField> fields;
  visitRig(model.rig, [&](const std::string& path, const char* name, double& value) {
    if (rigFieldApplies(name, model)) fields.push_back({path, &value});
  });
  for (OptionField& field : optionFields(model)) fields.push_back({"rig." + field.path, field.value});
  for (EffectSetting& effect : model.effects) {
    const EffectSchema* schema = catalogue.find(effect.id);
    if (schema == nullptr) continue;
    for (std::size_t i = 0; i < effect.values.size() && i < schema->parameters.size(); ++i)
      fields.push_back({"effects." + effect.id + "." + schema->parameters[i].name, &effect.values[i]});
  }
  return fields;
}

std::vector<std::string> uncertaintyNames(const Model& model) {
  std::vector<std::string> names;
  for (const FieldLimit& limit : rigLimits())
    if (rigFieldApplies(limit.path, model)) names.push_back(limit.path);
  names.push_back("sensor.offset_m");
  return names;
}

}  // namespace amb_rotor
