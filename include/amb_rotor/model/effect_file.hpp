#pragma once
// Effects that people write, format amb-effect/1; doc/formats.md. A file names parameters with units and limits and a law:
// two formulas (model/expression.hpp) over the parameters, named intermediate values and the quantities of its place.
//
//   place               the law gives                     quantities
//   magnetic_bearings   force_x_N, force_y_N at each      x y [m] relative to the stator, vx vy [m/s], ix iy [A] that make
//                       bearing, while it is on           the force, angle [rad], speed [rad/s], time [s], end (0 a, 1 b)
//   rotor               the same at parameter z_m         x y vx vy angle speed time
//   tilt                the same at magnetic bearing b,   x y [m] half of b's displacement less a's, vx vy its rate,
//                       with the other sign at a          angle speed time
//   sensors             signal_x_m, signal_y_m, added     x y [m] the signal so far, angle speed time end
//
// angle is the shaft's from the tacho mark, speed with its sign; time is that of the run. Left out: states of the
// effect's own, contact forces. A moving stator takes the reaction of what acts on the rotor.
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "amb_rotor/model/effect_schema.hpp"
#include "amb_rotor/model/expression.hpp"
#include "amb_rotor/model/yaml_document.hpp"

namespace amb_rotor {

/// The law of an effect file. Variables of its formulas: parameters, quantities, where-values, in this order.
struct EffectLaw {
  enum class Place { magnetic_bearings, rotor, sensors, tilt };
  enum Quantity : int { x, y, vx, vy, ix, iy, angle, speed, time, end, quantity_count };
  static constexpr int most_parameters = 24, most_where = 16;
  static constexpr int most_variables = most_parameters + quantity_count + most_where;

  Place place = Place::magnetic_bearings;
  int parameters = 0;
  int z_parameter = -1;            ///< place rotor: which parameter is z_m
  std::vector<Expression> where;   ///< each may use those before it
  Expression out_x, out_y;
  std::string physics;             ///< what a model's hash counts: place and formulas
  std::string definition;          ///< the whole file as YAML text

  /// Whether its formulas read a quantity.
  bool reads(Quantity quantity) const;
  /// What it depends on, in a diagnosis' words: position, velocity, control current, shaft angle, spin speed, time.
  std::vector<std::string> dependsOn() const;

  /// Fills the quantities of `variables` in front of the call, the where-values here; gives both components.
  template <class S>
  Vec2<S> evaluate(S* variables) const {
    S* next = variables + parameters + quantity_count;
    for (const Expression& formula : where) *next++ = formula.evaluate(variables);
    return {out_x.evaluate(variables), out_y.evaluate(variables)};
  }
};

/// Reads an effect from the root of its file or from `definition:` of a model; faults go to the map's list.
EffectSchema readEffect(YamlMap& root, const YamlNode& node);

/// Reads an effect file. @throw InputError: all faults at once
EffectSchema readEffectFile(const std::string& path);

/// Reads it and puts it into the catalogue. @throw InputError also where another effect has its name
const EffectSchema& loadEffectFile(const std::string& path, EffectCatalogue& catalogue);

}  // namespace amb_rotor
