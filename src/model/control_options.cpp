#include "amb_rotor/model/control_options.hpp"

#include <cmath>
#include <limits>

#include "amb_rotor/model/model.hpp"

namespace amb_rotor {
namespace {

constexpr double infinite = std::numeric_limits<double>::infinity();
constexpr OptionLimit any_number = {-infinite, false, infinite, "1", "a coefficient"};

void addMatrix(std::vector<OptionField>& fields, const std::string& path, std::vector<double>& values,
               int columns) {
  for (std::size_t i = 0; i < values.size(); ++i) {
    const int at = static_cast<int>(i), width = columns > 0 ? columns : 1;
    fields.push_back({path + "." + std::to_string(at / width) + "." + std::to_string(at % width), &values[i],
                      any_number});
  }
}

OptionLimit sectionLimit(SectionType type, std::size_t index) {
  switch (type) {
    case SectionType::lead_lag:
      return {0.0, true, infinite, "Hz", "a corner of a lead or lag"};
    case SectionType::notch:
      if (index == 0) return {0.0, true, infinite, "Hz", "centre of a notch"};
      if (index == 1) return {0.0, false, 10.0, "1", "0: nothing passes at the centre"};
      return {0.0, true, 10.0, "1", "or the notch rings for ever"};
    case SectionType::biquad:
      return any_number;
  }
  return any_number;
}

void addChannel(std::vector<OptionField>& fields, const std::string& path, const ControlOptions& options,
                ChannelControl& channel, bool with_gains) {
  if (options.type == ControllerType::state_space) {
    addMatrix(fields, path + ".a", channel.law.a, channel.law.states);
    addMatrix(fields, path + ".b", channel.law.b, channel.law.channels);
    addMatrix(fields, path + ".c", channel.law.c, channel.law.states);
    addMatrix(fields, path + ".d", channel.law.d, channel.law.channels);
    fields.push_back({path + ".integrator_gain_A_per_m", &channel.integrator_gain_A_per_m,
                      {0.0, false, infinite, "A/m", "positive pulls back to the centre"}});
  } else if (with_gains) {
    fields.push_back({path + ".kp_A_per_m", &channel.kp_A_per_m,
                      {0.0, false, infinite, "A/m", "positive pulls back to the centre"}});
    fields.push_back(
        {path + ".kd_A_s_per_m", &channel.kd_A_s_per_m, {0.0, false, infinite, "A s/m", "positive damps"}});
    fields.push_back({path + ".ki_A_per_m_s", &channel.ki_A_per_m_s,
                      {0.0, false, infinite, "A/(m s)", "positive pulls back to the centre"}});
  }
  for (std::size_t i = 0; i < channel.sections.size(); ++i) {
    ControllerSection& section = channel.sections[i];
    const auto& names = sectionParameters(section.type);
    for (std::size_t k = 0; k < section.values.size() && k < names.size(); ++k)
      fields.push_back({path + ".sections." + std::to_string(i) + "." + names[k], &section.values[k],
                        sectionLimit(section.type, k)});
  }
}

void addConverter(std::vector<OptionField>& fields, const std::string& path, const char* range, const char* unit,
                  std::optional<Converter>& converter) {
  if (!converter) return;
  fields.push_back({path + ".bits", &converter->bits, {1.0, false, 32.0, "1", "of a converter"}});
  fields.push_back({path + "." + range, &converter->range, {0.0, true, infinite, unit, "largest magnitude"}});
}

std::string channelChoices(const std::string& path, const ControlOptions& options, const ChannelControl& channel) {
  std::string text;
  if (options.type == ControllerType::state_space)
    text += path + ".states=" + std::to_string(channel.law.states) + "\n" + path +
            ".channels=" + std::to_string(channel.law.channels) + "\n";
  for (std::size_t i = 0; i < channel.sections.size(); ++i)
    text += path + ".sections." + std::to_string(i) + "=" + sectionName(channel.sections[i].type) + "\n";
  return text;
}

/// d + c (1 - a)^-1 b of one channel (of four: the first row's sum over its end); NaN where 1 - a is singular.
double lawAtRest(const StateSpaceLaw& law) {
  const int n = law.states, m = law.channels;
  // columns: translation of the first axis, in at ax and, with four channels, bx
  const auto input = [&](const std::vector<double>& v, int row) {
    return v[static_cast<std::size_t>(row * m)] + (m == 4 ? v[static_cast<std::size_t>(row * m + 2)] : 0.0);
  };
  std::vector<std::vector<double>> rows(static_cast<std::size_t>(n));
  for (int i = 0; i < n; ++i) {
    for (int j = 0; j < n; ++j)
      rows[static_cast<std::size_t>(i)].push_back((i == j ? 1.0 : 0.0) - law.a[static_cast<std::size_t>(i * n + j)]);
    rows[static_cast<std::size_t>(i)].push_back(input(law.b, i));
  }
  for (std::size_t p = 0; p < rows.size(); ++p) {
    std::size_t best = p;
    for (std::size_t r = p; r < rows.size(); ++r)
      if (std::fabs(rows[r][p]) > std::fabs(rows[best][p])) best = r;
    std::swap(rows[p], rows[best]);
    if (std::fabs(rows[p][p]) < 1e-12) return std::nan("");
    for (std::size_t r = 0; r < rows.size(); ++r) {
      if (r == p) continue;
      const double factor = rows[r][p] / rows[p][p];
      for (std::size_t c = p; c <= rows.size(); ++c) rows[r][c] -= factor * rows[p][c];
    }
  }
  double gain = input(law.d, 0);
  for (std::size_t i = 0; i < rows.size(); ++i) gain += law.c[i] * rows[i].back() / rows[i][i];
  return gain;
}

}  // namespace

const std::vector<std::string>& sectionParameters(SectionType type) {
  static const std::vector<std::string> lead_lag = {"zero_hz", "pole_hz"};
  static const std::vector<std::string> notch = {"frequency_hz", "zero_damping_ratio", "pole_damping_ratio"};
  static const std::vector<std::string> biquad = {"b0", "b1", "b2", "a1", "a2"};
  return type == SectionType::lead_lag ? lead_lag : type == SectionType::notch ? notch : biquad;
}

const char* sectionName(SectionType type) {
  return type == SectionType::lead_lag ? "lead_lag" : type == SectionType::notch ? "notch" : "biquad";
}

std::vector<OptionField> optionFields(Model& model) {
  std::vector<OptionField> fields;
  ControlOptions& control = model.control;
  addChannel(fields, "controller", control, control.main, false);
  if (control.decoupled) addChannel(fields, "controller.tilt", control, control.tilt, true);
  if (control.unbalance_rejection) {
    const std::string path = "controller.unbalance_force_rejection.";
    UnbalanceRejection& r = *control.unbalance_rejection;
    fields.push_back({path + "bandwidth_hz", &r.bandwidth_hz, {0.0, true, infinite, "Hz", "width of the notch"}});
    fields.push_back({path + "phase_rad", &r.phase_rad, {-infinite, false, infinite, "rad", "of the correction"}});
    fields.push_back(
        {path + "minimum_speed_hz", &r.minimum_speed_hz, {0.0, false, infinite, "Hz", "below it off"}});
    fields.push_back({path + "displacement_compensation_A_per_m", &r.displacement_compensation_A_per_m,
                      {0.0, false, infinite, "A/m", "Ks/Ki at most makes sense"}});
    fields.push_back({path + "lead_s", &r.lead_s, {0.0, false, infinite, "s", "the force follows its sample"}});
  }
  SignalChain& chain = model.signal_chain;
  if (chain.anti_alias) {
    fields.push_back({"signal_chain.anti_alias.order", &chain.anti_alias->order, {1.0, false, 2.0, "1", "1 or 2"}});
    fields.push_back({"signal_chain.anti_alias.corner_hz", &chain.anti_alias->corner_hz,
                      {0.0, true, infinite, "Hz", "a low pass"}});
  }
  addConverter(fields, "signal_chain.ad", "range_m", "m", chain.ad);
  addConverter(fields, "signal_chain.da", "range_A", "A", chain.da);
  if (model.coil) {
    fields.push_back({"amb.coil.resistance_ohm", &model.coil->resistance_ohm,
                      {0.0, false, infinite, "ohm", "of one coil"}});
    fields.push_back(
        {"amb.coil.inductance_H", &model.coil->inductance_H, {0.0, true, infinite, "H", "of one coil"}});
    fields.push_back({"amb.coil.voltage_limit_V", &model.coil->voltage_limit_V,
                      {0.0, true, infinite, "V", "of one amplifier"}});
  }
  return fields;
}

std::string optionChoices(const Model& model) {
  const ControlOptions& control = model.control;
  std::string text;
  if (control.type == ControllerType::state_space) text += "controller.type=state_space\n";
  text += channelChoices("controller", control, control.main);
  if (control.decoupled) {
    text += "controller.coordinates=tilt_translation\n";
    text += channelChoices("controller.tilt", control, control.tilt);
  }
  return text;
}

bool sameOptions(const Model& one, const Model& other) {
  if (&one == &other) return true;
  if (optionChoices(one) != optionChoices(other)) return false;
  Model a = one, b = other;
  const auto first = optionFields(a), second = optionFields(b);
  if (first.size() != second.size()) return false;
  for (std::size_t i = 0; i < first.size(); ++i)
    if (first[i].path != second[i].path || *first[i].value != *second[i].value) return false;
  return true;
}

double staticGain(const ControlOptions& options, const ChannelControl& channel, double kp) {
  double gain = options.type == ControllerType::pid ? kp : lawAtRest(channel.law);
  for (const ControllerSection& section : channel.sections)
    if (section.type == SectionType::biquad) {  // the others have the gain 1
      const auto& v = section.values;
      gain *= (v[0] + v[1] + v[2]) / (1.0 + v[3] + v[4]);
    }
  return gain;
}

}  // namespace amb_rotor
