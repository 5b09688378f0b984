#include "amb_rotor/model/effect_file.hpp"

#include <algorithm>
#include <cctype>
#include <cmath>

namespace amb_rotor {
namespace {

using Place = EffectLaw::Place;

constexpr std::size_t longest_name = 60;
constexpr const char* quantities[EffectLaw::quantity_count] = {"x",  "y",     "vx",    "vy",   "ix",
                                                               "iy", "angle", "speed", "time", "end"};

bool isAvailable(int quantity, Place place) {
  switch (place) {
    case Place::magnetic_bearings: return true;
    case Place::rotor:
    case Place::tilt: return quantity != EffectLaw::ix && quantity != EffectLaw::iy && quantity != EffectLaw::end;
    case Place::sensors: return quantity < EffectLaw::vx || quantity > EffectLaw::iy;
  }
  return false;
}

bool isIdentifier(const std::string& text) {
  if (text.empty() || text.size() > longest_name || std::isdigit(static_cast<unsigned char>(text[0]))) return false;
  return std::all_of(text.begin(), text.end(),
                     [](char c) { return std::isalnum(static_cast<unsigned char>(c)) || c == '_'; });
}

std::string withoutBlanks(std::string text) {
  text.erase(std::remove_if(text.begin(), text.end(), [](unsigned char c) { return std::isspace(c); }), text.end());
  return text;
}

/// The names of an effect's formulas, each of which may stand once.
class Names {
 public:
  Names(const std::vector<ParameterSchema>& parameters, Place place) {
    for (const auto& p : parameters) all_.push_back(p.name);
    for (int q = 0; q < EffectLaw::quantity_count; ++q)
      all_.push_back(isAvailable(q, place) ? quantities[q] : std::string(longest_name + 1, '?'));  // no name is so long
  }
  const std::vector<std::string>& all() const { return all_; }
  void add(const std::string& name) { all_.push_back(name); }

 private:
  std::vector<std::string> all_;
};

/// Why a name cannot be given to a value; empty: it can.
std::string nameFault(const std::string& name, const std::vector<std::string>& taken) {
  if (!isIdentifier(name)) return "a name has letters, digits and _, and does not begin with a digit";
  const auto& functions = formulaFunctions();
  if (name == "pi" || std::find(functions.begin(), functions.end(), name) != functions.end() ||
      std::find(std::begin(quantities), std::end(quantities), name) != std::end(quantities))
    return "the name is one of the formulas' own";
  if (std::find(taken.begin(), taken.end(), name) != taken.end()) return "the name stands twice";
  return "";
}

std::vector<ParameterSchema> readParameters(YamlMap& root) {
  static const std::vector<std::string> roles = {"plain", "amplitude", "phase", "fixed"};
  std::vector<ParameterSchema> parameters;
  std::vector<std::string> taken;
  std::size_t index = 0;
  for (const YamlNode& item : root.list("parameters")) {
    YamlMap entry(&item, root.pathOf("parameters") + "." + std::to_string(index++), root.faults());
    ParameterSchema p;
    p.name = entry.text("name");
    p.unit = entry.text("unit");
    p.lower = entry.number("lower");
    p.upper = entry.number("upper");
    p.typical = entry.number("typical");
    p.neutral = entry.optionalNumber("neutral").value_or(std::nan(""));
    const int role = entry.has("role") ? entry.choice("role", roles) : 0;
    p.role = static_cast<ParameterRole>(std::max(role, 0));
    p.meaning = entry.text("meaning");
    entry.finish();
    if (!p.name.empty()) {
      const std::string fault = nameFault(p.name, taken);
      if (!fault.empty()) entry.fault("name", fault);
      taken.push_back(p.name);
    }
    if (p.lower >= p.upper) entry.fault("upper", "must be above lower, " + numberText(p.lower) + " " + p.unit);
    else if (p.typical < p.lower || p.typical > p.upper)
      entry.fault("typical", "must be from lower to upper (a fit starts there, and steps by a share of it)");
    if (p.neutral < p.lower || p.neutral > p.upper) entry.fault("neutral", "must be from lower to upper");
    const bool after_amplitude = !parameters.empty() && parameters.back().role == ParameterRole::amplitude;
    if (p.role == ParameterRole::phase && !after_amplitude) entry.fault("role", "a phase stands behind its amplitude");
    parameters.push_back(p);
  }
  if (root.has("parameters") && parameters.empty())
    root.fault("parameters", "an effect has at least one parameter: what a fit may change");
  if (static_cast<int>(parameters.size()) > EffectLaw::most_parameters)
    root.fault("parameters", "there are more than " + std::to_string(EffectLaw::most_parameters));
  return parameters;
}

Expression compileAt(YamlMap& map, const std::string& key, const std::vector<std::string>& names) {
  const YamlNode* node = map.take(key, true);
  if (node == nullptr) return {};
  if (node->kind != YamlNode::Kind::scalar) {
    map.fault(key, "must be a formula");
    return {};
  }
  std::vector<FormulaFault> faults;
  Expression formula = Expression::compile(node->text, names, faults);
  for (const FormulaFault& fault : faults)
    map.faults().add(node->line + fault.line - 1, map.pathOf(key), node->text,
                     "column " + std::to_string(fault.column) + ": " + fault.rule);
  return formula;
}

/// Where-values and the law, with the text that a hash counts.
void readFormulas(YamlMap& root, const std::vector<ParameterSchema>& parameters, EffectLaw& law) {
  Names names(parameters, law.place);
  std::string physics;
  if (root.has("where")) {
    YamlMap where = root.map("where");
    const std::vector<std::string> keys = where.keys();
    for (const std::string& key : keys) {
      const std::string fault = nameFault(key, names.all());
      if (!fault.empty()) where.fault(key, fault);
      law.where.push_back(compileAt(where, key, names.all()));
      const YamlNode* node = where.take(key, false);
      if (node != nullptr) physics += key + "=" + withoutBlanks(node->text) + ";";
      names.add(key);
    }
    if (static_cast<int>(keys.size()) > EffectLaw::most_where)
      root.fault("where", "there are more than " + std::to_string(EffectLaw::most_where) + " values");
  }
  const bool signal = law.place == Place::sensors;
  YamlMap out = root.map("law");
  const char* keys[2] = {signal ? "signal_x_m" : "force_x_N", signal ? "signal_y_m" : "force_y_N"};
  law.out_x = compileAt(out, keys[0], names.all());
  law.out_y = compileAt(out, keys[1], names.all());
  for (const char* key : keys) {
    const YamlNode* node = out.take(key, false);
    if (node != nullptr) physics += std::string(key) + "=" + withoutBlanks(node->text) + ";";
  }
  out.finish();
  law.physics = physics;
}

/// A parameter that no formula reads cannot be found by any fit.
void checkRead(YamlMap& root, const std::vector<ParameterSchema>& parameters, const EffectLaw& law) {
  for (int i = 0; i < static_cast<int>(parameters.size()); ++i) {
    if (i == law.z_parameter || law.out_x.reads(i) || law.out_y.reads(i)) continue;
    if (std::any_of(law.where.begin(), law.where.end(), [&](const Expression& e) { return e.reads(i); })) continue;
    root.faults().add(root.line(), root.pathOf("parameters"), parameters[i].name, "no formula reads this parameter");
  }
}

}  // namespace

bool EffectLaw::reads(Quantity quantity) const {
  const int variable = parameters + quantity;
  return out_x.reads(variable) || out_y.reads(variable) ||
         std::any_of(where.begin(), where.end(), [&](const Expression& formula) { return formula.reads(variable); });
}

std::vector<std::string> EffectLaw::dependsOn() const {
  std::vector<std::string> out;
  if (reads(x) || reads(y)) out.push_back("position");
  if (reads(vx) || reads(vy)) out.push_back("velocity");
  if (reads(ix) || reads(iy)) out.push_back("control current");
  if (reads(angle)) out.push_back("shaft angle");
  if (reads(speed)) out.push_back("spin speed");
  if (reads(time)) out.push_back("time");
  return out;
}

EffectSchema readEffect(YamlMap& root, const YamlNode& node) {
  const std::size_t before = root.faults().faults().size();
  requireFormat(root, "amb-effect/1");
  EffectSchema schema;
  schema.id = root.text("effect");
  if (!schema.id.empty() && !isIdentifier(schema.id))
    root.fault("effect", "a name has letters, digits and _, and does not begin with a digit");
  schema.summary = root.text("summary");
  schema.excited_by = root.text("excited_by");
  auto law = std::make_shared<EffectLaw>();
  const int place = root.choice("place", {"magnetic_bearings", "rotor", "sensors", "tilt"});
  law->place = static_cast<Place>(std::max(place, 0));
  schema.parameters = readParameters(root);
  law->parameters = static_cast<int>(schema.parameters.size());
  if (law->place == Place::rotor) {
    law->z_parameter = schema.indexOf("z_m");
    if (law->z_parameter < 0)
      root.fault("parameters", "place: rotor needs the parameter z_m, the axial position (with role: fixed where it is known)");
  }
  if (place >= 0) readFormulas(root, schema.parameters, *law);
  root.finish();
  if (root.faults().faults().size() == before) checkRead(root, schema.parameters, *law);
  law->physics = std::to_string(static_cast<int>(law->place)) + ";" + law->physics;
  law->definition = yamlText(node, 0);
  schema.law = law;
  return schema;
}

EffectSchema readEffectFile(const std::string& path) {
  FaultList faults(path);
  const YamlNode document = parseYaml(readTextFile(path), faults);
  YamlMap root(&document, "", faults);
  EffectSchema schema = readEffect(root, document);
  faults.throwIfAny();
  return schema;
}

const EffectSchema& loadEffectFile(const std::string& path, EffectCatalogue& catalogue) {
  const EffectSchema schema = readEffectFile(path);
  const EffectSchema* added = catalogue.add(schema);
  if (added == nullptr)
    throw InputError({{path, 0, "effect", schema.id, "another effect of this name is known already"}});
  return *added;
}

}  // namespace amb_rotor
