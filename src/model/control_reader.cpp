#include "control_text.hpp"

namespace amb_rotor {
namespace {

struct Matrix {
  std::vector<double> values;  ///< row by row
  int rows = 0, columns = 0;
  bool sound = true;
};

/// A list of rows of numbers, all of the same length.
Matrix readMatrix(YamlMap& owner, const std::string& key) {
  Matrix matrix;
  const std::string path = owner.pathOf(key);
  for (const YamlNode& row : owner.list(key)) {
    if (row.kind != YamlNode::Kind::sequence) {
      owner.faults().add(row.line, path, row.text, "must be a list of rows, each a list of numbers");
      matrix.sound = false;
      continue;
    }
    if (matrix.rows++ == 0) matrix.columns = static_cast<int>(row.items.size());
    if (static_cast<int>(row.items.size()) != matrix.columns) {
      owner.faults().add(row.line, path, std::to_string(row.items.size()) + " numbers",
                         "must have as many numbers in each row, " + std::to_string(matrix.columns));
      matrix.sound = false;
    }
    for (const YamlNode& item : row.items) {
      const auto value = item.kind == YamlNode::Kind::scalar && item.plain ? parseNumber(item.text) : std::nullopt;
      if (!value) {
        owner.faults().add(item.line, path, item.text, "must be a finite number");
        matrix.sound = false;
      }
      matrix.values.push_back(value.value_or(0.0));
    }
  }
  return matrix;
}

StateSpaceLaw readLaw(YamlMap& owner) {
  const Matrix a = readMatrix(owner, "a"), b = readMatrix(owner, "b"), c = readMatrix(owner, "c"),
               d = readMatrix(owner, "d");
  StateSpaceLaw law;
  if (!a.sound || !b.sound || !c.sound || !d.sound) return law;
  const int n = a.rows, m = d.rows;
  const auto require = [&](const char* key, const Matrix& matrix, int rows, int columns) {
    const bool empty = rows * columns == 0 && matrix.values.empty();
    if (empty || (matrix.rows == rows && matrix.columns == columns)) return true;
    owner.fault(key, "must have " + std::to_string(rows) + " rows of " + std::to_string(columns) + " (a is n x n, b n x m, c m x n, d m x m)");
    return false;
  };
  bool sound = require("a", a, n, n) && require("d", d, m, m);
  if (m != 1 && m != 4) {
    owner.fault("d", "must be 1 x 1 (each axis its own copy) or 4 x 4 (ax, ay, bx, by)");
    sound = false;
  }
  if (!sound || !require("b", b, n, m) || !require("c", c, m, n)) return law;
  law.states = n;
  law.channels = m;
  law.a = a.values;
  law.b = b.values;
  law.c = c.values;
  law.d = d.values;
  return law;
}

std::vector<ControllerSection> readSections(YamlMap& owner) {
  std::vector<ControllerSection> sections;
  if (!owner.has("sections")) return sections;
  for (const YamlNode& item : owner.list("sections")) {
    YamlMap entry(&item, owner.pathOf("sections") + "." + std::to_string(sections.size()), owner.faults());
    const int type = entry.choice("type", {"lead_lag", "notch", "biquad"});
    if (type < 0) continue;
    ControllerSection section;
    section.type = static_cast<SectionType>(type);
    for (const std::string& name : sectionParameters(section.type)) section.values.push_back(entry.number(name));
    entry.finish();
    sections.push_back(std::move(section));
  }
  return sections;
}

/// @param with_gains  of a PID: those of the first channel are in the rig block
void readChannel(YamlMap& owner, ControllerType type, bool with_gains, ChannelControl& channel) {
  if (type == ControllerType::state_space) {
    channel.law = readLaw(owner);
    channel.integrator_gain_A_per_m = owner.optionalNumber("integrator_gain_A_per_m").value_or(0.0);
  } else if (with_gains) {
    channel.kp_A_per_m = owner.number("kp_A_per_m");
    channel.kd_A_s_per_m = owner.number("kd_A_s_per_m");
    channel.ki_A_per_m_s = owner.number("ki_A_per_m_s");
  }
  channel.sections = readSections(owner);
}

std::optional<Converter> readConverter(YamlMap& chain, const std::string& key, const std::string& range) {
  if (!chain.has(key)) return std::nullopt;
  YamlMap map = chain.map(key);
  Converter converter;
  converter.bits = map.number("bits");
  converter.range = map.number(range);
  map.finish();
  return converter;
}

}  // namespace

void readControlOptions(YamlMap& controller, Model& model) {
  ControlOptions& control = model.control;
  readChannel(controller, control.type, false, control.main);
  if (controller.has("coordinates"))
    control.decoupled = controller.choice("coordinates", {"axes", "tilt_translation"}) == 1;
  if (control.decoupled) {
    YamlMap tilt = controller.map("tilt");
    readChannel(tilt, control.type, true, control.tilt);
    tilt.finish();
  }
  if (controller.has("unbalance_force_rejection")) {
    YamlMap map = controller.map("unbalance_force_rejection");
    UnbalanceRejection rejection;
    rejection.bandwidth_hz = map.number("bandwidth_hz");
    rejection.phase_rad = map.number("phase_rad");
    rejection.minimum_speed_hz = map.number("minimum_speed_hz");
    rejection.displacement_compensation_A_per_m = map.number("displacement_compensation_A_per_m");
    rejection.lead_s = map.number("lead_s");
    map.finish();
    control.unbalance_rejection = rejection;
  }
}

void readSignalChain(YamlMap& rig, Model& model) {
  if (!rig.has("signal_chain")) return;
  YamlMap map = rig.map("signal_chain");
  if (map.has("anti_alias")) {
    YamlMap filter = map.map("anti_alias");
    AntiAliasFilter anti_alias;
    anti_alias.order = filter.number("order");
    anti_alias.corner_hz = filter.number("corner_hz");
    filter.finish();
    model.signal_chain.anti_alias = anti_alias;
  }
  model.signal_chain.ad = readConverter(map, "ad", "range_m");
  model.signal_chain.da = readConverter(map, "da", "range_A");
  if (map.valid() && model.signal_chain.empty())
    rig.fault("signal_chain", "must have at least one of anti_alias, ad, da");
  map.finish();
}

void readCoil(YamlMap& amb, Model& model) {
  if (!amb.has("coil")) return;
  YamlMap map = amb.map("coil");
  CoilCircuit coil;
  coil.resistance_ohm = map.number("resistance_ohm");
  coil.inductance_H = map.number("inductance_H");
  coil.voltage_limit_V = map.number("voltage_limit_V");
  map.finish();
  model.coil = coil;
}

}  // namespace amb_rotor
