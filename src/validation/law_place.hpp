#pragma once
// Where a law of no catalogue acts, and which of the program's effects stands for it: force_law at each magnetic bearing,
// force_law_at_plane at one plane of the rotor, force_law_of_tilt against its tilt, signal_law in the sensors' signals.
#include <optional>
#include <string>
#include <vector>

#include "amb_rotor/model/effect_file.hpp"
#include "amb_rotor/model/effect_schema.hpp"
#include "amb_rotor/model/model.hpp"

namespace amb_rotor {

/// Quantities of a term, out of its meaning ("position, velocity: ...").
std::vector<std::string> quantitiesOf(const std::string& meaning);

struct LawPlace {
  using Kind = EffectLaw::Place;
  Kind kind = Kind::magnetic_bearings;
  double plane_z_m = 0.0;               ///< of the rotor's plane

  static LawPlace atPlane(double z_m) { return {Kind::rotor, z_m}; }
  static LawPlace ofTilt() { return {Kind::tilt, 0.0}; }
  static LawPlace inSensors() { return {Kind::sensors, 0.0}; }
  /// Of one of those effects, its plane left open; of another none.
  static std::optional<LawPlace> of(const std::string& effect);
  bool isPlane() const { return kind == Kind::rotor; }
  bool isSensors() const { return kind == Kind::sensors; }
  /// Whether its effect has a number behind the terms that is fitted along with them: the plane, the width of a step.
  bool hasNumber() const { return kind != Kind::tilt; }

  const EffectSchema& schema() const;
  int terms() const;  ///< the effect's first parameters
  bool readsAngle(int term) const;  ///< a function of the shaft's angle
  bool repeatsInTime(int term) const;
  bool readsNumber(int term) const; ///< what hasNumber() says
  /// Whether some effect of the catalogue acts as the term does, or looks like it.
  bool isInCatalogue(int term) const;
  /// The effect with no term. @param frequency_hz  of its terms that repeat in time; 0: they take no part
  EffectSetting withoutForce(double frequency_hz) const;
};

}  // namespace amb_rotor
