#pragma once
// What a model file may say of controller, signal chain and coils beyond the plain PID of the rig block. All of it is
// optional; where nothing is said, model, hash and motion are those of the rig block alone.
// Equations: magnetic_bearing/controller.hpp, converter.hpp, coil.hpp. File: doc/formats.md.
//
// These numbers are the same in all lanes of a machine; a fit varies the rig block and the effects.
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace amb_rotor {

enum class ControllerType {
  pid,         ///< gains of rig.controller
  state_space  ///< discrete, a b c d (thesis 4.4)
};

enum class SectionType {
  lead_lag,  ///< (1 + s/wz)/(1 + s/wp)
  notch,     ///< (s^2 + 2 zz w s + w^2)/(s^2 + 2 zp w s + w^2)
  biquad     ///< (b0 + b1/z + b2/z^2)/(1 + a1/z + a2/z^2)
};

/// One second-order section in front of the control law; values in the order of sectionParameters().
struct ControllerSection {
  SectionType type = SectionType::biquad;
  std::vector<double> values;
};

/// W' = a W + b X, Y = c W + d X, row by row. One channel: each axis has its own copy; four: ax, ay, bx, by.
struct StateSpaceLaw {
  int states = 0, channels = 1;
  std::vector<double> a, b, c, d;
};

/// The law of a channel. Of the first channel the PID gains stand in rig.controller.
struct ChannelControl {
  double kp_A_per_m = 0.0, kd_A_s_per_m = 0.0, ki_A_per_m_s = 0.0;  ///< pid
  StateSpaceLaw law;                                                   ///< state_space
  double integrator_gain_A_per_m = 0.0;  ///< DI of thesis 4.5, a sample; state_space
  std::vector<ControllerSection> sections;
};

/// Takes the synchronous part out of the signals before the law, and may push against the magnet's displacement
/// force by what it took out.
struct UnbalanceRejection {
  double bandwidth_hz = 0.0;      ///< width of the notch at the speed
  double phase_rad = 0.0;         ///< of the correction; 0 where the loop's sensitivity is real at the speed
  double minimum_speed_hz = 0.0;  ///< below it off
  double displacement_compensation_A_per_m = 0.0;  ///< Ks/Ki: no force; 0: no current
  double lead_s = 0.0;            ///< from the sample to the force: the compensation is turned ahead by it
};

struct ControlOptions {
  ControllerType type = ControllerType::pid;
  bool decoupled = false;  ///< translation (main) and tilt instead of the four axes
  ChannelControl main, tilt;
  std::optional<UnbalanceRejection> unbalance_rejection;

  /// The PID of the rig block and nothing else.
  bool plain() const {
    return type == ControllerType::pid && !decoupled && main.sections.empty() && !unbalance_rejection;
  }
};

struct AntiAliasFilter {
  double order = 1.0;  ///< 1, or 2 (Butterworth)
  double corner_hz = 0.0;
};

/// Rounds to steps of 2 range/2^bits and stays within the range.
struct Converter {
  double bits = 0.0;
  double range = 0.0;  ///< largest magnitude [m] or [A]
};

struct SignalChain {
  std::optional<AntiAliasFilter> anti_alias;
  std::optional<Converter> ad, da;
  bool empty() const { return !anti_alias && !ad && !da; }
};

/// Coils driven by a limited voltage instead of a pure lag.
struct CoilCircuit {
  double resistance_ohm = 0.0;   ///< of one coil
  double inductance_H = 0.0;     ///< of one coil, rotor centred
  double voltage_limit_V = 0.0;  ///< of its amplifier
};

/// Limits of one number, as FieldLimit of model_rules.hpp.
struct OptionLimit {
  double lower;
  bool lower_is_open;
  double upper;
  const char* unit;
  const char* reason;
};

/// One number that the model states, with its path behind "rig.".
struct OptionField {
  std::string path;
  double* value;
  OptionLimit limit;
};

struct Model;

/// The numbers of all options that are there, in the order of the file.
std::vector<OptionField> optionFields(Model& model);
/// The choices that are there, as lines path=word; empty where nothing is said.
std::string optionChoices(const Model& model);
/// Whether two models say the same in all options.
bool sameOptions(const Model& one, const Model& other);

/// Names of the values of a section.
const std::vector<std::string>& sectionParameters(SectionType type);
const char* sectionName(SectionType type);

/// Gain at rest of the sections and the law, without integrators; NaN: the law itself integrates.
/// @param kp  gain of the PID [A/m]
double staticGain(const ControlOptions& options, const ChannelControl& channel, double kp);

}  // namespace amb_rotor
