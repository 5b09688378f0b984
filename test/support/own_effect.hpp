#pragma once
// Effects of files, put into the program's catalogue by a test.
#include <optional>
#include <string>

#include "amb_rotor/effects/catalogue.hpp"
#include "amb_rotor/model/effect_file.hpp"

namespace amb_rotor {

/// A force with one number c, which is 0 where there is none: at the magnetic bearings, at a plane of the rotor, or elsewhere, where a
/// place is given: `tilt`, or `sensors`, of which it is what is added to the signals.
inline const EffectSchema& ownForce(const std::string& id, double typical, const std::string& x, const std::string& y,
                                    std::optional<double> plane_z_m = {}, const std::string& elsewhere = {}, double upper = 1e30) {
  const std::string place = !elsewhere.empty() ? elsewhere : plane_z_m ? "rotor" : "magnetic_bearings";
  const bool signal = place == "sensors";
  const std::string plane = plane_z_m ? "  - {name: z_m, unit: m, lower: -2.0, upper: 2.0, typical: " + std::to_string(*plane_z_m) +
                                            ", meaning: \"axial position\"}\n"
                                      : "";
  const std::string text =
      "format: amb-effect/1\neffect: " + id + "\nsummary: \"of a test\"\nexcited_by: \"anything\"\nplace: " + place +
      "\nparameters:\n  - {name: c, unit: \"1\", lower: -1.0e+30, upper: " + (upper < 1e30 ? std::to_string(upper) : "1.0e+30") +
      ", typical: " + std::to_string(typical) +
      ", neutral: 0.0, meaning: \"size\"}\n" + plane + "law:\n  " + (signal ? "signal_x_m" : "force_x_N") + ": \"" + x + "\"\n  " +
      (signal ? "signal_y_m" : "force_y_N") + ": \"" + y + "\"\n";
  FaultList faults(id);
  const YamlNode document = parseYaml(text, faults);
  YamlMap root(&document, "", faults);
  const EffectSchema schema = readEffect(root, document);
  faults.throwIfAny();
  return *effectCatalogue().add(schema);
}

}  // namespace amb_rotor
