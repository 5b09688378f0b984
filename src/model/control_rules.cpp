#include <cmath>

#include "amb_rotor/model/model_rules.hpp"
#include "control_text.hpp"

namespace amb_rotor {
namespace {

/// Faults of whole options; values that break their own limit or are unreadable are told already.
class OptionRules {
 public:
  explicit OptionRules(std::vector<Fault>& faults) : faults_(faults) {}
  void require(bool holds, const std::string& path, double value, const std::string& rule) {
    if (std::isfinite(value) && !holds) faults_.push_back({"", 0, "rig." + path, numberText(value), rule});
  }

 private:
  std::vector<Fault>& faults_;
};

void checkSections(const std::string& path, const ChannelControl& channel, double half_rate, OptionRules& rules) {
  for (std::size_t i = 0; i < channel.sections.size(); ++i) {
    const ControllerSection& section = channel.sections[i];
    const std::string at = path + ".sections." + std::to_string(i) + ".";
    const auto& v = section.values;
    if (section.type == SectionType::biquad) {
      // both poles inside the unit circle (Jury)
      rules.require(std::fabs(v[4]) < 1.0, at + "a2", v[4], "must be within -1 and 1 (or the section is not stable)");
      rules.require(std::fabs(v[3]) < 1.0 + v[4], at + "a1", v[3],
                    "must be smaller than 1 + a2 (or the section is not stable)");
      continue;
    }
    const auto& names = sectionParameters(section.type);
    const std::size_t frequencies = section.type == SectionType::notch ? 1 : 2;
    for (std::size_t k = 0; k < frequencies; ++k)
      rules.require(!(v[k] >= half_rate), at + names[k], v[k],
                    "must be below half the sample rate, " + numberText(half_rate) + " Hz");
  }
}

void checkLaw(const std::string& path, const ControlOptions& control, const ChannelControl& channel,
              OptionRules& rules) {
  if (control.type != ControllerType::state_space || channel.law.d.empty()) return;
  const double gain = staticGain(control, channel, 0.0);
  rules.require(!std::isnan(gain), path + ".a", 1.0,
                "must have no eigenvalue 1 (an integrator stands beside it: integrator_gain_A_per_m)");
  if (control.decoupled)
    rules.require(channel.law.channels == 1, path + ".d", channel.law.channels,
                  "must be 1 x 1 with coordinates: tilt_translation");
}

}  // namespace

void checkOptions(const Model& model, bool skip_unreadable, std::vector<Fault>& faults) {
  OptionRules rules(faults);
  Model copy = model;
  bool sound = true;
  for (const OptionField& field : optionFields(copy)) {
    const double value = *field.value;
    if (!std::isfinite(value) && skip_unreadable) {
      sound = false;  // told by the reader; nothing that rests on it is checked
      continue;
    }
    const OptionLimit& l = field.limit;
    const FieldLimit limit = {field.path.c_str(), l.lower, l.lower_is_open, l.upper, l.unit, l.reason};
    if (std::isfinite(value) && limit.holds(value)) continue;
    faults.push_back({"", 0, "rig." + field.path, numberText(value), limit.text()});
    sound = false;
  }
  if (!sound) return;
  const ControlOptions& control = model.control;
  const double half_rate = 0.5 * model.rig.controller.sample_rate_hz;
  checkSections("controller", control.main, half_rate, rules);
  checkLaw("controller", control, control.main, rules);
  if (control.decoupled) {
    checkSections("controller.tilt", control.tilt, half_rate, rules);
    checkLaw("controller.tilt", control, control.tilt, rules);
  }
  const SignalChain& chain = model.signal_chain;
  const auto whole = [&](const char* path, double value) {
    rules.require(value == std::round(value), path, value, "must be a whole number");
  };
  if (chain.anti_alias) whole("signal_chain.anti_alias.order", chain.anti_alias->order);
  if (chain.ad) whole("signal_chain.ad.bits", chain.ad->bits);
  if (chain.da) whole("signal_chain.da.bits", chain.da->bits);
  if (!model.coil) return;
  const double drop = model.coil->resistance_ohm * model.rig.amb.bias_current_A;
  rules.require(!(drop >= model.coil->voltage_limit_V), "amb.coil.voltage_limit_V", model.coil->voltage_limit_V,
                "must be above the drop of the bias current, " + numberText(drop) + " V");
  for (const EffectSetting& effect : model.effects)
    if (effect.id == "eddy_current_lag")
      faults.push_back({"", 0, "effects.eddy_current_lag", "",
                        "does not go with rig.amb.coil: its lags are known only behind a lag without a voltage limit"});
}

}  // namespace amb_rotor
