#include "control_text.hpp"

namespace amb_rotor {
namespace {

std::string matrixText(const std::string& head, const char* name, const std::vector<double>& values, int columns) {
  std::string text = head + name + ": [";
  for (std::size_t i = 0; i < values.size(); ++i) {
    const int column = static_cast<int>(i) % columns;
    text += (i == 0 ? "[" : column == 0 ? ", [" : ", ") + numberText(values[i]);
    if (column == columns - 1) text += "]";
  }
  return text + "]\n";
}

std::string channelText(const std::string& head, ControllerType type, const ChannelControl& channel,
                        bool with_gains) {
  std::string text;
  if (type == ControllerType::state_space) {
    const StateSpaceLaw& law = channel.law;
    text += matrixText(head, "a", law.a, law.states) + matrixText(head, "b", law.b, law.channels) +
            matrixText(head, "c", law.c, law.states) + matrixText(head, "d", law.d, law.channels);
    text += head + pairText("integrator_gain_A_per_m", channel.integrator_gain_A_per_m) + "\n";
  } else if (with_gains) {
    text += head + pairText("kp_A_per_m", channel.kp_A_per_m) + "\n" + head +
            pairText("kd_A_s_per_m", channel.kd_A_s_per_m) + "\n" + head +
            pairText("ki_A_per_m_s", channel.ki_A_per_m_s) + "\n";
  }
  if (!channel.sections.empty()) text += head + "sections:\n";
  for (const ControllerSection& section : channel.sections) {
    text += head + "  - {type: " + sectionName(section.type);
    const auto& names = sectionParameters(section.type);
    for (std::size_t i = 0; i < names.size(); ++i) text += ", " + pairText(names[i].c_str(), section.values[i]);
    text += "}\n";
  }
  return text;
}

std::string converterText(const char* name, const char* range, const std::optional<Converter>& converter) {
  if (!converter) return "";
  return std::string("    ") + name + ": {" + pairText("bits", converter->bits) + ", " +
         pairText(range, converter->range) + "}\n";
}

}  // namespace

std::string controlText(const Model& model) {
  const ControlOptions& control = model.control;
  std::string text = channelText("    ", control.type, control.main, false);
  if (control.decoupled)
    text += "    coordinates: tilt_translation\n    tilt:\n" + channelText("      ", control.type, control.tilt, true);
  if (control.unbalance_rejection) {
    const UnbalanceRejection& r = *control.unbalance_rejection;
    text += "    unbalance_force_rejection:\n      " + pairText("bandwidth_hz", r.bandwidth_hz) + "\n      " +
            pairText("phase_rad", r.phase_rad) + "\n      " + pairText("minimum_speed_hz", r.minimum_speed_hz) +
            "\n      " + pairText("displacement_compensation_A_per_m", r.displacement_compensation_A_per_m) +
            "\n      " + pairText("lead_s", r.lead_s) + "\n";
  }
  return text;
}

std::string signalChainText(const Model& model) {
  const SignalChain& chain = model.signal_chain;
  if (chain.empty()) return "";
  std::string text = "  signal_chain:\n";
  if (chain.anti_alias)
    text += "    anti_alias: {" + pairText("order", chain.anti_alias->order) + ", " +
            pairText("corner_hz", chain.anti_alias->corner_hz) + "}\n";
  return text + converterText("ad", "range_m", chain.ad) + converterText("da", "range_A", chain.da);
}

std::string coilText(const Model& model) {
  if (!model.coil) return "";
  return "    coil: {" + pairText("resistance_ohm", model.coil->resistance_ohm) + ", " +
         pairText("inductance_H", model.coil->inductance_H) + ", " +
         pairText("voltage_limit_V", model.coil->voltage_limit_V) + "}\n";
}

}  // namespace amb_rotor
