#pragma once
// What the model file, the reports and the diagnosis need to know of an effect without knowing its
// physics: its name, its parameters with units and limits, and the data that can show it.
#include <deque>
#include <memory>
#include <shared_mutex>
#include <string>
#include <vector>

namespace amb_rotor {

struct EffectLaw;  // model/effect_file.hpp

/// How a parameter takes part in a fit.
enum class ParameterRole {
  plain,      ///< a number of its own
  amplitude,  ///< with the phase that follows it a vector in the rotor: fitted as a cos p, a sin p
  phase,      ///< belongs to the amplitudes before it, back to the last phase
  fixed,      ///< a reference or a choice; stays at `typical` in a fit
  rise,       ///< exceeds the parameter that follows it (or stays below): fitted as the logarithm of the difference
  quotient,   ///< acts by its quotient with the parameter that follows it most: fitted as the logarithm of that
  reciprocal, ///< acts by its reciprocal, as v in exp(-x/v), or stands against a force, as a sensor's gain: fitted as that
  factor      ///< of either sign, acts by its products with others, as the shapes of a mode do: fitted as asinh(20 x)
};

struct ParameterSchema {
  std::string name;
  std::string unit;   ///< SI; "1" for a pure number
  double lower;       ///< values outside [lower, upper] are refused
  double upper;
  double typical;     ///< a plausible strength: start of a fit and scale of its step
  double neutral;     ///< at this value (of the plain and amplitude parameters) the effect vanishes; NaN: never
  ParameterRole role;
  std::string meaning;
  int harmonic = 1;     ///< of a phase: the order of the shaft's angle that it shifts
  std::string replaces = {};  ///< number of the rig in whose place it stands: what holds for that holds for it
  bool needs_contact = false;  ///< cannot be seen without contact, whatever the effect's others can
};

struct EffectSchema {
  std::string id;          ///< as in model files
  std::string summary;     ///< one sentence
  std::string excited_by;  ///< the data that can show it, in words
  std::vector<ParameterSchema> parameters;
  bool needs_contact = false;  ///< cannot be seen without contact
  bool only_by_name = false;   ///< in no ranking and no drawn rig, unless it is asked for: a law by terms, a finer form of another
  std::string needs_field = {};  ///< number of the rig that must be above 0, or the effect would do nothing
  std::shared_ptr<const EffectLaw> law = nullptr;  ///< of an effect that a file defines
  std::string mimic = {};  ///< number of the rig that stands in for the effect where a model lacks it, and has to give way
  bool held_as_offset = false;  ///< each run's offset of the sensors stands in for it: first order tells little of what it is worth
  bool slow_to_predict = false;  ///< parts of the stator move: through contact, in small steps
  bool lasting = false;    ///< has a state that goes on from one window through contact to the next: a part of them tells little

  int indexOf(const std::string& name) const {
    for (std::size_t i = 0; i < parameters.size(); ++i)
      if (parameters[i].name == name) return static_cast<int>(i);
    return -1;
  }
};

/// The effects that a program knows, in the order in which they act. It grows by the effects of files; what is in there
/// stays where it is, so that a pointer from find() holds. Safe to use from several threads.
class EffectCatalogue {
 public:
  explicit EffectCatalogue(std::vector<EffectSchema> schemas);
  std::vector<EffectSchema> all() const;
  const EffectSchema* find(const std::string& id) const;
  /// Adds an effect of a file. Null: another one has its name (the same one again is no fault).
  const EffectSchema* add(const EffectSchema& schema);

 private:
  mutable std::shared_mutex mutex_;
  std::deque<EffectSchema> schemas_;
};

}  // namespace amb_rotor
