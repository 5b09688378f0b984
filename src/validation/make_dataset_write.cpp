// Made runs as recordings: noise, offsets, drift, rounding, tacho pulses; and the files of a data set.
#include <zlib.h>

#include <cmath>
#include <cstdio>
#include <filesystem>

#include "amb_rotor/common/error.hpp"
#include "amb_rotor/common/units.hpp"
#include "amb_rotor/effects/catalogue.hpp"
#include "amb_rotor/model/model_writer.hpp"
#include "amb_rotor/model/yaml_document.hpp"
#include "make_dataset_parts.hpp"

namespace amb_rotor::making {
namespace {

constexpr const char* axes[4] = {"ax", "ay", "bx", "by"};
constexpr double pulse_share = 0.2;  ///< of a turn, from the rising edge on

/// Turns' share that lies under the pulse, from angle 0 up to an angle.
double pulseIntegral(double angle) {
  const double turns = angle / two_pi, whole = std::floor(turns);
  return whole * pulse_share + std::min(turns - whole, pulse_share);
}

/// Mean of the pulse over the sample before an instant and the one behind it (the anti-alias filter).
double pulseAt(double angle, double speed) {
  const double half = speed / sample_rate_hz;
  double value;
  if (std::fabs(half) < 1e-9)
    value = angle / two_pi - std::floor(angle / two_pi) < pulse_share ? 1.0 : 0.0;
  else
    value = (pulseIntegral(angle + half) - pulseIntegral(angle - half)) / (2.0 * half / two_pi);
  return 1e-3 * std::round(1e3 * value);
}

std::string text(double value, const char* format = "%.8g") {
  char buffer[40];
  std::snprintf(buffer, sizeof buffer, format, value);
  return buffer;
}

void writeCompressed(const std::string& path, const std::string& content) {
  const std::string beside = path + ".part";
  gzFile file = gzopen(beside.c_str(), "wb6");
  const bool written = file != nullptr && gzwrite(file, content.data(), static_cast<unsigned>(content.size())) ==
                                              static_cast<int>(content.size());
  const bool closed = file != nullptr && gzclose(file) == Z_OK;
  std::error_code error;
  if (written && closed) std::filesystem::rename(beside, path, error);
  if (!written || !closed || error) throw InputError({{path, 0, "", "", "the file cannot be written"}});
}

}  // namespace

double ChannelNoise::residual(int channel) const {
  const double resolution = channel < 4 ? displacement_resolution_m : current_resolution_A;
  return std::sqrt(stated[channel] * stated[channel] + resolution * resolution / 12.0);
}

RecordedRun record(Dice& dice, const Signals& signals, const Signals& quiet, const ChannelNoise& noise) {
  constexpr double offset_std_m = 1e-6;
  RecordedRun run;
  const std::size_t n = signals.angle.size();
  double sum = 0.0;
  for (int c = 0; c < channels; ++c) {
    const double offset = c < 4 ? offset_std_m * dice.normal() : 0.0;
    const double drift = c < 4 ? offset_std_m * dice.normal() : 0.0;
    const double resolution = c < 4 ? noise.displacement_resolution_m : noise.current_resolution_A;
    auto& row = run.rows[c];
    row.resize(n);
    for (std::size_t i = 0; i < n; ++i) {
      const double slow = offset + drift * (n > 1 ? i / (n - 1.0) : 0.0);
      row[i] = resolution * std::round((signals.rows[c][i] + slow + noise.white[c] * dice.normal()) / resolution);
      if (i < quiet.rows[c].size()) {
        const double r = (row[i] - slow - quiet.rows[c][i]) / noise.residual(c);
        sum += r * r;
      }
    }
  }
  run.floor = std::sqrt(sum / (channels * double(n)));
  for (std::size_t i = 0; i < n; ++i) run.tacho.push_back(pulseAt(signals.angle[i], signals.speed[i]));
  return run;
}

void writeRun(const std::string& folder, const RunPlan& plan, const RecordedRun& run) {
  std::string table = "t_s,tacho";
  for (const char* axis : axes) table += std::string(",") + axis + "_um";
  for (const char* axis : axes) table += std::string(",i") + axis + "_A";
  for (const char* axis : axes) table += std::string(",exc_") + axis + "_A";
  table += "\n";
  const auto cell = [&](double value) { table += "," + text(value == 0.0 ? 0.0 : value, "%.6g"); };
  for (std::size_t i = 0; i < run.tacho.size(); ++i) {
    table += text(i / sample_rate_hz, "%.6g");
    cell(run.tacho[i]);
    for (int c = 0; c < 4; ++c) cell(1e6 * run.rows[c][i]);
    for (int c = 4; c < channels; ++c) cell(run.rows[c][i]);
    for (const auto& axis : plan.excitation.axis) cell(i < axis.size() ? axis[i] : 0.0);
    table += "\n";
  }
  writeCompressed(folder + "/" + plan.run.file, table);
}

void writeDescription(const std::string& folder, const std::string& name, const Model& belief,
                      const ChannelNoise& noise, const std::vector<RunPlan>& plans) {
  // the rig's block is the one of a model file
  const std::string model = modelText(belief, effectCatalogue());
  const std::size_t from = model.find("\nrig:\n") + 1, to = model.find("\nrotor:\n") + 1;
  std::string out = "format: amb-dataset/1\nname: " + quotedText(name) + "\n" + model.substr(from, to - from);
  out += "channels:\n  tacho: {meaning: one pulse a turn, threshold: 0.5}\n";
  const auto place = [](int a) {
    return std::string(", plane: ") + (a < 2 ? "a" : "b") + ", axis: " + (a % 2 == 0 ? "x" : "y");
  };
  for (int a = 0; a < 4; ++a)
    out += std::string("  ") + axes[a] + "_um: {meaning: displacement" + place(a) +
           ", noise_rms_um: " + text(1e6 * noise.stated[a], "%.4g") +
           ", resolution_um: " + text(1e6 * noise.displacement_resolution_m) + "}\n";
  for (int a = 0; a < 4; ++a)
    out += std::string("  i") + axes[a] + "_A: {meaning: control current" + place(a) +
           ", noise_rms_A: " + text(noise.stated[4 + a], "%.4g") +
           ", resolution_A: " + text(noise.current_resolution_A) + "}\n";
  for (int a = 0; a < 4; ++a)
    out += std::string("  exc_") + axes[a] + "_A: {meaning: excitation current" + place(a) + "}\n";
  out += "runs:\n";
  for (const auto& plan : plans) {
    const Run& run = plan.run;
    out += "- id: " + run.id + "\n  file: " + run.file + "\n  kind: " + runKindName(run.kind) +
           "\n  sample_rate_hz: " + text(run.sample_rate_hz, "%.1f") + "\n  speed: " +
           (run.speed_from_tacho ? std::string("{type: tacho}") : "{type: constant, hz: " + text(run.speed_hz) + "}") +
           "\n  events:";
    if (run.events.empty()) out += " []\n";
    else out += "\n";
    for (const auto& event : run.events)
      out += "  - {time_s: " + text(event.time_s) + ", type: " + (event.amb_on ? "amb_on" : "amb_off") + "}\n";
    out += std::string("  use: ") + (run.use == RunUse::fit ? "fit" : "validate") + "\n";
  }
  writeTextFile(folder + "/dataset.yaml", out);
}

void writeTruth(const std::string& folder, const MadeDataset& made, const HiddenLaw& law, std::uint64_t seed) {
  std::string out = "format: amb-truth/1\neffects:";
  out += made.truth.effects.empty() ? " []\n" : "\n";
  for (const auto& effect : made.truth.effects) {
    const EffectSchema* schema = effectCatalogue().find(effect.id);
    out += "- effect: " + effect.id + "\n  parameters:\n";
    for (std::size_t i = 0; i < effect.values.size(); ++i)
      out += "    " + schema->parameters[i].name + ": {value: " + numberText(effect.values[i]) + ", unit: '" +
             schema->parameters[i].unit + "'}\n";
  }
  const auto& rig = made.truth.rig;
  out += "nuisance: {rotor.mass_kg: " + text(rig.rotor.mass_kg) +
         ", amb.current_stiffness_N_per_A: " + text(rig.amb.current_stiffness_N_per_A) +
         ", auxiliary_bearing.contact.stiffness_N_per_m: " + text(rig.auxiliary_bearing.stiffness_N_per_m) +
         ", auxiliary_bearing.friction_coefficient: " + text(rig.auxiliary_bearing.friction_coefficient) +
         ", unbalance.moment_kg_m: " + text(rig.unbalance[0].moment_kg_m) +
         ", unbalance.phase_rad: " + text(rig.unbalance[0].phase_rad) + "}\nfloor: {";
  std::string comma;
  for (const auto& run : made.floor) {
    out += comma + run.first + ": " + text(run.second, "%.4g");
    comma = ", ";
  }
  out += "}\nverdict: " + made.verdict + "\ndifference: " + text(made.difference, "%.4g") +
         "\nseed: " + std::to_string(seed) + "\n";
  if (law.law != Law::none)
    out += "law: {name: " + made.law + ", amount: " + numberText(law.amount) + ", second: " + numberText(law.second) + "}\n";
  if (!made.depends_on.empty()) {
    out += "depends_on: [";
    for (std::size_t i = 0; i < made.depends_on.size(); ++i) out += (i > 0 ? ", " : "") + made.depends_on[i];
    out += "]\n";
  }
  writeTextFile(folder + "/truth.yaml", out);
}

}  // namespace amb_rotor::making
