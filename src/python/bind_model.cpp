// amb_rotor._core: models, effects, scenarios.
#include <sstream>

#include "amb_rotor/effects/all.hpp"
#include "amb_rotor/effects/catalogue.hpp"
#include "amb_rotor/machine/model_loading.hpp"
#include "amb_rotor/model/effect_file.hpp"
#include "amb_rotor/model/magnet_dimensions.hpp"
#include "amb_rotor/model/model_hash.hpp"
#include "amb_rotor/model/model_reader.hpp"
#include "amb_rotor/model/model_rules.hpp"
#include "amb_rotor/model/model_writer.hpp"
#include "amb_rotor/model/overrides.hpp"
#include "amb_rotor/model/remarks.hpp"
#include "amb_rotor/model/scenario_reader.hpp"
#include "amb_rotor/rotor/flexible_rotor.hpp"
#include "bind.hpp"

namespace py = pybind11;

namespace amb_rotor {
namespace {

py::dict schemaDict(const EffectSchema& schema) {
  py::dict d;
  py::list parameters;
  for (const auto& p : schema.parameters) {
    py::dict row;
    row["name"] = p.name;
    row["unit"] = p.unit;
    row["lower"] = p.lower;
    row["upper"] = p.upper;
    row["typical"] = p.typical;
    row["meaning"] = p.meaning;
    row["fixed"] = p.role == ParameterRole::fixed;
    parameters.append(row);
  }
  d["id"] = schema.id;
  d["summary"] = schema.summary;
  d["excited_by"] = schema.excited_by;
  d["needs_contact"] = schema.needs_contact;
  d["only_by_name"] = schema.only_by_name;
  d["definition"] = schema.law != nullptr ? py::object(py::str(schema.law->definition)) : py::object(py::none());
  d["parameters"] = parameters;
  return d;
}

/// The force of an effect at a magnetic bearing of end a: for pictures of a law, and to hold one law against another.
std::pair<double, double> bearingForce(const std::string& id, const std::vector<double>& values,
                                       std::pair<double, double> position, std::pair<double, double> velocity,
                                       std::pair<double, double> current, double angle_rad, double speed_rad_s,
                                       double time_s) {
  const auto physics = effects::makePhysics<double>(id, values);
  if (physics == nullptr) throw InputError({{"", 0, "effect", id, "there is no effect of this name"}});
  Shaft<double> shaft = Shaft<double>::at(angle_rad, speed_rad_s, 0.0);
  shaft.time = time_s;
  const Rig<double> rig;
  const BearingSite<double> site{&rig, &shaft, 0, {position.first, position.second}, {velocity.first, velocity.second},
                                 {current.first, current.second}, 0.0};
  Vec2<double> force;
  physics->bearingForce(site, force);
  return {force.x, force.y};
}

/// The signals of sensor pair a when an effect has had them: likewise.
std::pair<double, double> sensorSignal(const std::string& id, const std::vector<double>& values, std::pair<double, double> signal,
                                       double angle_rad, double speed_rad_s, double time_s) {
  const auto physics = effects::makePhysics<double>(id, values);
  if (physics == nullptr) throw InputError({{"", 0, "effect", id, "there is no effect of this name"}});
  Shaft<double> shaft = Shaft<double>::at(angle_rad, speed_rad_s, 0.0);
  shaft.time = time_s;
  Vec2<double> pairs[2] = {{signal.first, signal.second}, {signal.first, signal.second}};
  physics->sense(shaft, pairs);
  return {pairs[0].x, pairs[0].y};
}

const EffectSchema& requireEffect(const std::string& id) {
  const EffectSchema* schema = effectCatalogue().find(id);
  if (schema == nullptr) throw InputError({{"", 0, "effect", id, "there is no effect of this name"}});
  return *schema;
}

std::vector<std::string> textsOf(const std::vector<Fault>& faults) {
  std::vector<std::string> texts;
  for (const Fault& fault : faults) texts.push_back(fault.text());
  return texts;
}

py::list effectList(const Model& model) {
  py::list effects;
  for (const auto& setting : model.effects) {
    const EffectSchema& schema = requireEffect(setting.id);
    py::dict parameters, entry;
    for (std::size_t i = 0; i < setting.values.size(); ++i)
      parameters[py::str(schema.parameters[i].name)] = setting.values[i];
    entry["effect"] = setting.id;
    entry["parameters"] = parameters;
    effects.append(entry);
  }
  return effects;
}

Model withEffect(Model model, const std::string& id, const std::map<std::string, double>& parameters) {
  const EffectSchema& schema = requireEffect(id);
  EffectSetting setting{id, {}};
  std::vector<Fault> faults;
  for (const auto& p : schema.parameters) {
    const auto found = parameters.find(p.name);
    if (found == parameters.end())
      faults.push_back({"", 0, "effects." + id + "." + p.name, "", "the parameter is missing"});
    else
      setting.values.push_back(found->second);
  }
  for (const auto& [name, value] : parameters)
    if (schema.indexOf(name) < 0)
      faults.push_back({"", 0, "effects." + id + "." + name, "", "no such parameter"});
  if (!faults.empty()) throw InputError(faults);
  auto& effects = model.effects;
  for (std::size_t i = effects.size(); i-- > 0;)
    if (effects[i].id == id) effects.erase(effects.begin() + static_cast<long>(i));
  effects.push_back(setting);
  requireValid(model, effectCatalogue());
  return model;
}

Model withoutEffect(Model model, const std::string& id) {
  auto& effects = model.effects;
  for (std::size_t i = effects.size(); i-- > 0;)
    if (effects[i].id == id) effects.erase(effects.begin() + static_cast<long>(i));
  return model;
}

}  // namespace

void bindModel(py::module_& m) {
  py::class_<Model>(m, "Model", "A model, format amb-model/1: a rig, a rotor model, a list of effects.")
      .def_readwrite("name", &Model::name)
      .def_readwrite("revision", &Model::revision)
      .def_readonly("uncertainty", &Model::uncertainty)
      .def_property_readonly("rotor_model",
                             [](const Model& model) { return rotorModelName(model.rotor_model); })
      .def_property_readonly("amb_model", [](const Model& model) { return ambModelName(model.amb_model); })
      .def_property_readonly("effects", &effectList)
      .def_property_readonly(
          "faults",
          [](const Model& model) { return textsOf(checkModel(model, effectCatalogue())); },
          "What keeps it from being run: one line for each rule of models that it breaks, as values of a fit can.")
      .def_property_readonly("remarks", [](const Model& model) { return textsOf(remarksOn(model)); },
                             "What no rule forbids and yet is seldom meant, a line each.")
      .def_property_readonly("text", [](const Model& model) { return modelText(model, effectCatalogue()); })
      .def_property_readonly("hash", [](const Model& model) { return modelHash(model, effectCatalogue()); })
      .def_property_readonly("fields",
                             [](Model& model) {
                               py::dict fields;
                               for (const auto& field : modelFields(model, effectCatalogue()))
                                 fields[py::str(field.path)] = *field.value;
                               return fields;
                             })
      .def("with_overrides",
           [](Model model, const std::vector<std::string>& overrides) {
             applyOverrides(model, overrides, effectCatalogue());
             return model;
           })
      .def("with_effect", &withEffect, py::arg("effect"), py::arg("parameters"))
      .def("without_effect", &withoutEffect, py::arg("effect"))
      .def("write",
           [](const Model& model, const std::string& path) { writeModel(model, effectCatalogue(), path); });
  m.def(
      "read_model", [](const std::string& path) { return loadModel(path); },
      py::arg("path"));
  m.def(
      "parse_model",
      [](const std::string& text, const std::string& name) {
        return parseModel(text, name, effectCatalogue());
      },
      py::arg("text"), py::arg("name"));
  m.def(
      "read_effect", [](const std::string& path) { return schemaDict(readEffectFile(path)); }, py::arg("path"),
      "Checks an effect file, format amb-effect/1.");
  m.def(
      "load_effect", [](const std::string& path) { return schemaDict(loadEffectFile(path, effectCatalogue())); },
      py::arg("path"), "Reads an effect file into the catalogue of this program.");
  m.def("bearing_force", &bearingForce, py::arg("effect"), py::arg("values"), py::arg("position"), py::arg("velocity"),
        py::arg("current"), py::arg("angle_rad"), py::arg("speed_rad_s"), py::arg("time_s"));
  m.def("sensor_signal", &sensorSignal, py::arg("effect"), py::arg("values"), py::arg("signal"), py::arg("angle_rad"),
        py::arg("speed_rad_s"), py::arg("time_s"));
  m.def("magnet_pull", py::vectorize([](double windings, double pole_area_m2, double force_angle_rad, double current_A,
                                        double air_gap_m) {
          return MagnetDimensions{windings, pole_area_m2, force_angle_rad}.pull(current_A, air_gap_m);
        }),
        py::arg("windings"), py::arg("pole_area_m2"), py::arg("force_angle_rad"), py::arg("current_A"),
        py::arg("air_gap_m"), "Of one magnet, along the axis [N]; number by number.");
  m.def("magnet_flux_density", py::vectorize([](double windings, double current_A, double air_gap_m) {
          return MagnetDimensions{windings, 0.0, 0.0}.fluxDensity(current_A, air_gap_m);
        }),
        py::arg("windings"), py::arg("current_A"), py::arg("air_gap_m"), "In the gap of one magnet [T]; number by number.");
  m.def("effect_catalogue", [] {
    py::list all;
    for (const auto& schema : effectCatalogue().all()) all.append(schemaDict(schema));
    return all;
  });

  py::class_<Scenario>(m, "Scenario", "What is done to a machine in a run, format amb-scenario/1.")
      .def_readonly("name", &Scenario::name)
      .def_readwrite("duration_s", &Scenario::duration_s)
      .def_readwrite("record_rate_hz", &Scenario::record_rate_hz)
      .def_property_readonly("speed_hz", [](const Scenario& s) { return s.speed.start_hz; })
      .def_property_readonly("remarks", [](const Scenario& s) { return textsOf(remarksOn(s)); })
      .def_property_readonly("text", [](const Scenario& s) { return scenarioText(s); });
  m.def(
      "remarks", [](const Model& model, const Scenario& scenario) { return textsOf(remarksOn(model, scenario)); },
      py::arg("model"), py::arg("scenario"), "What is odd of both together.");
  m.def("read_scenario", &readScenario, py::arg("path"));
  m.def("parse_scenario", &parseScenario, py::arg("text"), py::arg("name"));
  m.def(
      "read_rotor_geometry",
      [](const std::string& path) {
        const RotorGeometry geometry = loadRotorGeometry(path);
        const FlexibleRotor rotor(geometry);
        py::dict d;
        d["name"] = geometry.name;
        d["length_m"] = geometry.length();
        d["mass_kg"] = rotor.inertia().mass;
        return d;
      },
      py::arg("path"), "What a shaft of format amb-rotor-geometry/1 is, in short.");
}

}  // namespace amb_rotor
