#pragma once
// What a model must obey, beside being written correctly: limits of single values, relations between
// values, limits of effects. One list for files, for overrides and for the bounds of a fit.
//
// Paths: a rig's field is "rig." and its name out of Rig::visit, unbalance i is
// "rig.unbalance.i.moment_kg_m"; an effect's parameter is "effects.ID.NAME".
#include <limits>
#include <string>
#include <vector>

#include "amb_rotor/common/error.hpp"
#include "amb_rotor/model/effect_schema.hpp"
#include "amb_rotor/model/model.hpp"

namespace amb_rotor {

constexpr double unlimited = std::numeric_limits<double>::infinity();
constexpr double max_delay_samples = 20.0;  ///< of the controller's signal delay line

/// The limit of one field of the rig, by its name out of Rig::visit ("rotor.mass_kg").
struct FieldLimit {
  const char* path;
  double lower;
  bool lower_is_open;  ///< the value must be above, not at, the lower limit
  double upper;        ///< the value may be at it
  const char* unit;
  const char* reason;
  double largest = unlimited;  ///< its size is at most that: no rotor on magnets comes near it, and a unit is wrong
  const char* why_largest = "";

  bool isTooLarge(double value) const { return value > largest || value < -largest; }
  bool holds(double value) const {
    return (lower_is_open ? value > lower : value >= lower) && value <= upper && !isTooLarge(value);
  }
  std::string text() const;  ///< "must be above 0 kg (a rotor has a mass)"
  std::string text(double value) const;  ///< of a value that breaks it: "must be at most 1e5 kg (the heaviest ...)"
};

/// One limit for every field of Rig::visit, in its order (unbalance once).
const std::vector<FieldLimit>& rigLimits();

/// The limit of a field; throws InvariantError where there is none of this name.
const FieldLimit& rigLimit(const std::string& path);

/// Whether a field of the rig (name out of Rig::visit) has a meaning for this bearing model: an
/// equivalent bearing has stiffness and damping only, and no controller.
bool rigFieldApplies(const std::string& path, AmbModel amb_model);
/// The same for a model: a controller that is no PID has no gains in the rig block.
bool rigFieldApplies(const std::string& path, const Model& model);

/// Everything that is wrong with the model, as faults with dotted paths, without file and line; empty
/// when nothing is. Values that are not finite are faults, unless `skip_unreadable` is set: then they
/// are taken as reported already, and rules that need them are left out.
std::vector<Fault> checkModel(const Model& model, const EffectCatalogue& catalogue,
                              bool skip_unreadable = false);

/// The part of checkModel() for the rig and its uncertainties.
std::vector<Fault> checkRig(const Model& model, bool skip_unreadable = false);

/// A sample rate at which the loop is unstable though it is stable when it is sampled faster. The model has no other fault.
/// Declared here, defined where controllers are: magnetic_bearing/sample_time_rule.cpp.
void checkSampleTime(const Model& model, std::vector<Fault>& faults);

/// The part of checkModel() for a flexible rotor whose modes are filled in: rig.rotor.mass_kg agrees with the shaft's mass to
/// 1 %, rig.rotor.transverse_inertia_kg_m2 and a stated polar_inertia_kg_m2 with its own to 5 %, and nothing acts beside the shaft.
std::vector<Fault> checkShaft(const Model& model, const EffectCatalogue& catalogue);

/// Throws InputError with all faults of checkModel(), if there is one.
void requireValid(const Model& model, const EffectCatalogue& catalogue);

/// A named number of a model, where it lives.
struct ModelField {
  std::string path;
  double* value;
};

/// All numbers of the model that have a meaning for it (rigFieldApplies), in the order of the file: the
/// rig's, those of its options (control_options.hpp), then the effects'.
std::vector<ModelField> modelFields(Model& model, const EffectCatalogue& catalogue);

/// Names that `uncertainty` may hold: those of Rig::visit that apply, and sensor.offset_m.
std::vector<std::string> uncertaintyNames(const Model& model);

}  // namespace amb_rotor
