#include <yaml-cpp/yaml.h>

#include <cmath>
#include <map>
#include <set>
#include <sstream>
#include <utility>

#include "amb_rotor/rotor/rotor_geometry.hpp"

namespace amb_rotor {
namespace {

constexpr char kFormat[] = "amb-rotor-geometry/1";

/// Reads nodes and collects what is wrong; every read returns something usable, so reading goes on.
class Reader {
 public:
  explicit Reader(std::string path) : path_(std::move(path)) {}

  void fault(const std::string& key, const YAML::Node& node, const std::string& rule) {
    const bool scalar = node.IsDefined() && node.IsScalar();
    faults_.push_back({path_, lineOf(node), key, scalar ? node.Scalar() : "", rule});
  }

  /// A map with only the keys known, each once, and all those required.
  bool map(const std::string& key, const YAML::Node& node, const std::set<std::string>& required,
           const std::set<std::string>& optional) {
    if (!node.IsMap()) {
      fault(key, node, "must be a map");
      return false;
    }
    std::set<std::string> seen;
    for (const auto& entry : node) {
      const std::string name = entry.first.IsScalar() ? entry.first.Scalar() : "";
      if (!seen.insert(name).second) {
        fault(joined(key, name), entry.first, "duplicate key");
      } else if (required.count(name) == 0 && optional.count(name) == 0) {
        fault(joined(key, name), entry.first, "unknown key");
      }
    }
    for (const std::string& name : required) {
      if (seen.count(name) == 0) fault(joined(key, name), node, "missing key");
    }
    return true;
  }

  double number(const std::string& parent, const YAML::Node& map, const std::string& name, double otherwise) {
    const YAML::Node node = map[name];
    if (!node) return otherwise;
    return number(joined(parent, name), node);
  }

  double number(const std::string& key, const YAML::Node& node) {
    lines_[key] = lineOf(node);
    double value = 0.0;
    if (!node.IsScalar() || !YAML::convert<double>::decode(node, value) || !std::isfinite(value)) {
      fault(key, node, "must be a finite number");
      unreadable_.insert(key);
    }
    return value;
  }

  std::string text(const std::string& parent, const YAML::Node& map, const std::string& name) {
    const YAML::Node node = map[name];
    if (!node) return "";
    if (!node.IsScalar()) fault(joined(parent, name), node, "must be a text");
    return node.IsScalar() ? node.Scalar() : "";
  }

  /// The items of a list; empty when it is left out.
  std::vector<YAML::Node> list(const std::string& key, const YAML::Node& node) {
    std::vector<YAML::Node> items;
    if (!node) return items;
    if (!node.IsSequence()) {
      fault(key, node, "must be a list");
      return items;
    }
    for (const YAML::Node& entry : node) items.push_back(entry);
    return items;
  }

  /// Gives the physical faults their file and line. Those of values that were not read, or not readable, are
  /// dropped: they only follow from a fault that is listed already.
  void add(const std::vector<Fault>& physical) {
    for (Fault fault : physical) {
      const auto line = lines_.find(fault.key);
      if (line == lines_.end() || unreadable_.count(fault.key) != 0) continue;
      fault.file = path_;
      fault.line = line->second;
      faults_.push_back(std::move(fault));
    }
  }

  void throwIfAny() {
    if (!faults_.empty()) throw InputError(std::move(faults_));
  }

  void note(const std::string& key, const YAML::Node& node) { lines_[key] = lineOf(node); }

  static std::string joined(const std::string& parent, const std::string& name) {
    return parent.empty() ? name : parent + "." + name;
  }

 private:
  static int lineOf(const YAML::Node& node) { return node.IsDefined() ? node.Mark().line + 1 : 0; }

  std::string path_;
  std::vector<Fault> faults_;
  std::map<std::string, int> lines_;
  std::set<std::string> unreadable_;
};

std::string entryOf(const char* list, std::size_t i) {
  return std::string(list) + "[" + std::to_string(i) + "]";
}

std::map<std::string, Material> readMaterials(Reader& reader, const YAML::Node& node) {
  std::map<std::string, Material> materials;
  if (!node) return materials;
  if (!node.IsMap()) {
    reader.fault("materials", node, "must be a map of materials");
    return materials;
  }
  for (const auto& entry : node) {
    const std::string name = entry.first.IsScalar() ? entry.first.Scalar() : "";
    const std::string key = "materials." + name;
    if (materials.count(name) != 0) reader.fault(key, entry.first, "duplicate key");
    Material& material = materials[name];
    if (!reader.map(key, entry.second, {"density_kg_per_m3", "youngs_modulus_Pa", "poisson_ratio"}, {}))
      continue;
    material.density = reader.number(key, entry.second, "density_kg_per_m3", 0.0);
    material.youngs_modulus = reader.number(key, entry.second, "youngs_modulus_Pa", 0.0);
    material.poisson_ratio = reader.number(key, entry.second, "poisson_ratio", 0.3);
    if (material.density <= 0.0 && entry.second["density_kg_per_m3"]) {
      reader.fault(key + ".density_kg_per_m3", entry.second["density_kg_per_m3"], "above 0 kg/m3");
    }
    if (material.youngs_modulus < 0.0) {
      reader.fault(key + ".youngs_modulus_Pa", entry.second["youngs_modulus_Pa"], "0 Pa or above");
    }
    if (!(material.poisson_ratio > -1.0 && material.poisson_ratio < 0.5)) {
      reader.fault(key + ".poisson_ratio", entry.second["poisson_ratio"], "above -1 and below 0.5");
    }
  }
  return materials;
}

Material materialOf(Reader& reader, const std::map<std::string, Material>& materials, const std::string& key,
                    const YAML::Node& node) {
  const YAML::Node name = node["material"];
  if (!name) return {};
  const auto found = name.IsScalar() ? materials.find(name.Scalar()) : materials.end();
  if (found == materials.end()) {
    reader.fault(key + ".material", name, "must name one of the materials");
    return {};
  }
  // The other properties are judged once, where the material is written.
  if (found->second.youngs_modulus == 0.0) reader.note(key + ".material.youngs_modulus_Pa", name);
  return found->second;
}

void readSections(Reader& reader, const YAML::Node& node, const std::map<std::string, Material>& materials,
                  RotorGeometry& geometry) {
  if (node) reader.note("sections", node);
  const std::vector<YAML::Node> items = reader.list("sections", node);
  for (std::size_t i = 0; i < items.size(); ++i) {
    const std::string key = entryOf("sections", i);
    ShaftSection section;
    if (reader.map(key, items[i], {"length_m", "outer_diameter_m", "material"},
                   {"outer_diameter_end_m", "inner_diameter_m", "inner_diameter_end_m", "shear_factor"})) {
      section.length = reader.number(key, items[i], "length_m", 0.0);
      section.outer_diameter_left = reader.number(key, items[i], "outer_diameter_m", 0.0);
      section.outer_diameter_right =
          reader.number(key, items[i], "outer_diameter_end_m", section.outer_diameter_left);
      section.inner_diameter_left = reader.number(key, items[i], "inner_diameter_m", 0.0);
      section.inner_diameter_right =
          reader.number(key, items[i], "inner_diameter_end_m", section.inner_diameter_left);
      section.shear_factor = reader.number(key, items[i], "shear_factor", 0.0);
      section.material = materialOf(reader, materials, key, items[i]);
    }
    geometry.sections.push_back(section);
  }
}

void readRings(Reader& reader, const YAML::Node& node, const std::map<std::string, Material>& materials,
               RotorGeometry& geometry) {
  const std::vector<YAML::Node> items = reader.list("rings", node);
  for (std::size_t i = 0; i < items.size(); ++i) {
    const std::string key = entryOf("rings", i);
    ShrunkRing ring;
    if (reader.map(key, items[i], {"from_m", "to_m", "inner_diameter_m", "outer_diameter_m", "material"},
                   {})) {
      ring.from = reader.number(key, items[i], "from_m", 0.0);
      ring.to = reader.number(key, items[i], "to_m", 0.0);
      ring.inner_diameter = reader.number(key, items[i], "inner_diameter_m", 0.0);
      ring.outer_diameter = reader.number(key, items[i], "outer_diameter_m", 0.0);
      ring.material = materialOf(reader, materials, key, items[i]);
    }
    geometry.rings.push_back(ring);
  }
}

void readDiscs(Reader& reader, const YAML::Node& node, RotorGeometry& geometry) {
  const std::vector<YAML::Node> items = reader.list("discs", node);
  for (std::size_t i = 0; i < items.size(); ++i) {
    const std::string key = entryOf("discs", i);
    Disc disc;
    if (reader.map(key, items[i], {"at_m", "mass_kg", "polar_inertia_kg_m2", "transverse_inertia_kg_m2"},
                   {})) {
      disc.at = reader.number(key, items[i], "at_m", 0.0);
      disc.mass = reader.number(key, items[i], "mass_kg", 0.0);
      disc.polar_inertia = reader.number(key, items[i], "polar_inertia_kg_m2", 0.0);
      disc.transverse_inertia = reader.number(key, items[i], "transverse_inertia_kg_m2", 0.0);
    }
    geometry.discs.push_back(disc);
  }
}

void readDamping(Reader& reader, const YAML::Node& node, ShaftDamping& damping) {
  if (!node) return;
  if (!reader.map("damping", node, {},
                  {"mass_proportional_per_s", "stiffness_proportional_s", "modal_ratios"})) {
    return;
  }
  damping.mass_proportional = reader.number("damping", node, "mass_proportional_per_s", 0.0);
  damping.stiffness_proportional = reader.number("damping", node, "stiffness_proportional_s", 0.0);
  const std::vector<YAML::Node> ratios = reader.list("damping.modal_ratios", node["modal_ratios"]);
  for (std::size_t i = 0; i < ratios.size(); ++i) {
    damping.modal_ratios.push_back(reader.number(entryOf("damping.modal_ratios", i), ratios[i]));
  }
}

void readHead(Reader& reader, const YAML::Node& root, RotorGeometry& geometry) {
  if (root["format"] && reader.text("", root, "format") != kFormat) {
    reader.fault("format", root["format"], std::string("must be ") + kFormat);
  }
  geometry.name = reader.text("", root, "name");
  const std::string theory = reader.text("", root, "theory");
  if (theory == "euler_bernoulli") {
    geometry.theory = BeamTheory::euler_bernoulli;
  } else if (root["theory"] && theory != "timoshenko") {
    reader.fault("theory", root["theory"], "must be euler_bernoulli or timoshenko");
  }
  geometry.max_element_length = reader.number("", root, "max_element_length_m", 0.0);
}

}  // namespace

RotorGeometry loadRotorGeometry(const std::string& path) {
  YAML::Node root;
  try {
    root = YAML::LoadFile(path);
  } catch (const YAML::BadFile&) {
    throw InputError({{path, 0, "", "", "cannot be read"}});
  } catch (const YAML::ParserException& error) {
    throw InputError({{path, error.mark.line + 1, "", "", "is no YAML: " + error.msg}});
  }
  Reader reader(path);
  RotorGeometry geometry;
  if (reader.map("", root, {"format", "theory", "max_element_length_m", "materials", "sections"},
                 {"name", "rings", "discs", "damping"})) {
    readHead(reader, root, geometry);
    const std::map<std::string, Material> materials = readMaterials(reader, root["materials"]);
    readSections(reader, root["sections"], materials, geometry);
    readRings(reader, root["rings"], materials, geometry);
    readDiscs(reader, root["discs"], geometry);
    readDamping(reader, root["damping"], geometry.damping);
    reader.add(faultsOf(geometry));
  }
  reader.throwIfAny();
  return geometry;
}

}  // namespace amb_rotor
