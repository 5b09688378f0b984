// Controllers beside the PID, signal chain and coils in model files: read, written, hashed, refused by name and line.
#include "amb_rotor/effects/catalogue.hpp"
#include "amb_rotor/model/model_hash.hpp"
#include "amb_rotor/model/model_rules.hpp"
#include "amb_rotor/model/model_writer.hpp"
#include "model_test_support.hpp"

namespace amb_rotor {
namespace {

using namespace model_test;

const std::string pid_gains =
    "    type: pid\n    sample_rate_hz: 10000.0\n    kp_A_per_m: 13850.0\n    kd_A_s_per_m: 16.0\n"
    "    ki_A_per_m_s: 0.0\n    derivative_filter_hz: 2000.0\n    delay_s: 1.0e-4\n";
const std::string sections =
    "    sections:\n      - {type: lead_lag, zero_hz: 150.0, pole_hz: 1200.0}\n"
    "      - {type: notch, frequency_hz: 2971.0, zero_damping_ratio: 0.02, pole_damping_ratio: 0.2}\n"
    "      - {type: biquad, b0: 1.1, b1: -0.2, b2: 0.0, a1: -0.1, a2: 0.0}\n";
const std::string law =
    "    type: state_space\n    sample_rate_hz: 10000.0\n    delay_s: 1.0e-4\n"
    "    a: [[0.0, 0.0], [-7000.0, 0.28]]\n    b: [[1.0], [7000.0]]\n    c: [[-112000.0, 4.5]]\n    d: [[125000.0]]\n"
    "    integrator_gain_A_per_m: 50.0\n";
const std::string tilt =
    "    coordinates: tilt_translation\n    tilt: {kp_A_per_m: 15000.0, kd_A_s_per_m: 20.0, ki_A_per_m_s: 0.0}\n";
const std::string rejection =
    "    unbalance_force_rejection: {bandwidth_hz: 2.0, phase_rad: 0.1, minimum_speed_hz: 20.0,\n"
    "                                displacement_compensation_A_per_m: 3000.0, lead_s: 2.0e-4}\n";
const std::string chain =
    "  signal_chain:\n    anti_alias: {order: 2, corner_hz: 4000.0}\n    ad: {bits: 14, range_m: 0.5e-3}\n"
    "    da: {bits: 12, range_A: 5.0}\n";
const std::string coil = "    coil: {resistance_ohm: 2.0, inductance_H: 0.02, voltage_limit_V: 120.0}\n";

std::string controllerOf(const std::string& text) {
  const std::size_t begin = text.find("    type: pid\n"), end = text.find("  auxiliary_bearing:");
  EXPECT_LT(begin, end);
  return text.substr(begin, end - begin);
}

/// The valid model with another controller block, and lines behind it.
std::string with(const std::string& controller, const std::string& behind = "") {
  std::string text = validText();
  text = replaced(text, controllerOf(text), controller + behind);
  if (controller.find("state_space") != std::string::npos) {
    for (const char* gain : {"    controller.kp_A_per_m", "    controller.kd_A_s_per_m"}) {
      const std::size_t at = text.find(gain);
      if (at != std::string::npos) text.erase(at, text.find('\n', at) + 1 - at);
    }
  }
  return text;
}

std::vector<std::string> variants() {
  return {with(pid_gains + sections),          with(law),
          with(pid_gains + tilt),              with(pid_gains + rejection),
          with(pid_gains, chain),              replaced(validText(), "    max_current_A", coil + "    max_current_A"),
          with(law + sections + rejection, chain)};
}

TEST(ModelControlOptions, WhatIsWrittenReadsBackToTheSameBitsAndHash) {
  std::set<std::string> hashes = {modelHash(validModel(), smallCatalogue())};
  for (const std::string& source : variants()) {
    Model model = parseModel(source, "model.yaml", smallCatalogue());
    for (const OptionField& field : optionFields(model)) *field.value += *field.value / 3e9;
    if (model.signal_chain.ad) model.signal_chain = parseModel(source, "m", smallCatalogue()).signal_chain;
    const std::string text = modelText(model, smallCatalogue());
    Model back = parseModel(text, "model.yaml", smallCatalogue());
    EXPECT_EQ(modelText(back, smallCatalogue()), text);
    EXPECT_TRUE(sameOptions(model, back)) << text;
    EXPECT_EQ(modelHash(model, smallCatalogue()), modelHash(back, smallCatalogue()));
    hashes.insert(modelHash(model, smallCatalogue()));
  }
  EXPECT_EQ(hashes.size(), variants().size() + 1) << "each is another machine";
}

TEST(ModelControlOptions, HashOfAFileThatSaysNothingNewIsTheOldOne) {
  // as amb check printed it before there were such options
  const Model model = readModel(std::string(AMB_ROTOR_SOURCE_DIR) + "/config/thesis/levitation_model.yaml",
                                effectCatalogue());
  EXPECT_EQ(modelHash(model, effectCatalogue()), "71b12fbcd6d962df");
  EXPECT_TRUE(model.control.plain() && model.signal_chain.empty() && !model.coil);
}

TEST(ModelControlOptions, HashChangesWithEveryNumber) {
  for (const std::string& source : variants()) {
    Model model = parseModel(source, "model.yaml", smallCatalogue());
    const std::string hash = modelHash(model, smallCatalogue());
    EXPECT_FALSE(optionFields(model).empty());
    for (const OptionField& field : optionFields(model)) {
      const double before = *field.value;
      *field.value = before + 1e-9 * (before == 0.0 ? 1.0 : before);
      EXPECT_NE(modelHash(model, smallCatalogue()), hash) << field.path;
      *field.value = before;
    }
  }
}

struct Broken {
  std::string text, key, rule, line_of;
};

TEST(ModelControlOptions, FaultsAreToldByNameAndLine) {
  const auto notch = [&](const char* values) {
    return with(pid_gains + "    sections:\n      - {type: notch, " + values + "}\n");
  };
  const std::vector<Broken> all = {
      {notch("frequency_hz: 5000.0, zero_damping_ratio: 0.0, pole_damping_ratio: 0.2"),
       "rig.controller.sections.0.frequency_hz", "below half the sample rate", "5000.0"},
      {notch("frequency_hz: 500.0, zero_damping_ratio: 0.0, pole_damping_ratio: 0.0"),
       "rig.controller.sections.0.pole_damping_ratio", "above 0", "type: notch"},
      {notch("frequency_hz: 500.0, zero_damping_ratio: 0.0"), "rig.controller.sections.0.pole_damping_ratio",
       "missing", "type: notch"},
      {with(pid_gains + "    sections:\n      - {type: biquad, b0: 1.0, b1: 0.0, b2: 0.0, a1: 0.0, a2: 1.0}\n"),
       "rig.controller.sections.0.a2", "not stable", "type: biquad"},
      {replaced(with(law), "c: [[-112000.0, 4.5]]", "c: [[-112000.0]]"), "rig.controller.c", "1 rows of 2", "c: [["},
      {replaced(with(law), "[-7000.0, 0.28]", "[-7000.0, .nan]"), "rig.controller.a", "finite", "a: [["},
      {replaced(with(law), "[-7000.0, 0.28]", "[-7000.0, 1.0]"), "rig.controller.a", "no eigenvalue 1", "a: [["},
      {with(law + "    kp_A_per_m: 3.0\n"), "rig.controller.kp_A_per_m", "not known", "kp_A_per_m: 3.0"},
      {with(pid_gains + "    coordinates: tilt_translation\n"), "rig.controller.tilt", "missing", "type: pid"},
      {with(pid_gains, "  signal_chain: {ad: {bits: 13.5, range_m: 1.0e-3}}\n"), "rig.signal_chain.ad.bits",
       "whole number", "13.5"},
      {with(pid_gains, "  signal_chain: {ad: {bits: 14, range_m: 0}}\n"), "rig.signal_chain.ad.range_m", "above 0",
       "bits: 14"},
      {with(pid_gains, "  signal_chain: {anti_alias: {order: 3, corner_hz: 100.0}}\n"),
       "rig.signal_chain.anti_alias.order", "to 2", "order: 3"},
      {replaced(validText(), "    max_current_A",
                "    coil: {resistance_ohm: 60.0, inductance_H: 0.02, voltage_limit_V: 120.0}\n    max_current_A"),
       "rig.amb.coil.voltage_limit_V", "drop of the bias current, 150", "coil:"}};
  for (const Broken& one : all) {
    const auto faults = faultsOf([&] { parseModel(one.text, "model.yaml", smallCatalogue()); });
    ASSERT_FALSE(faults.empty()) << one.key;
    const Fault fault = faultOf(faults, one.key);
    EXPECT_NE(fault.rule.find(one.rule), std::string::npos) << fault.text();
    EXPECT_EQ(fault.line, lineOf(one.text, one.line_of)) << fault.text();
    EXPECT_EQ(fault.file, "model.yaml");
  }
}

TEST(ModelControlOptions, AnEffectThatWouldDoNothingIsRefusedByNameAndLine) {
  std::string text = validText();
  const std::size_t at = text.find("effects:");
  text = text.substr(0, at) + "effects:\n  - {effect: magnetic_saturation, parameters: {knee_flux_density_T: 1.2}}\n";
  EXPECT_TRUE(faultsOf([&] { parseModel(text, "model.yaml", effectCatalogue()); }).empty());
  const std::string line = "    bias_flux_density_T: 0.45";
  for (const char* other : {"", "    bias_flux_density_T: 0.0"}) {
    const std::string broken = replaced(text, line, other);
    const auto faults = faultsOf([&] { parseModel(broken, "model.yaml", effectCatalogue()); });
    ASSERT_EQ(faults.size(), 1u) << joined(faults);
    EXPECT_EQ(faults[0].key, "effects.magnetic_saturation");
    EXPECT_NE(faults[0].rule.find("bias_flux_density_T"), std::string::npos);
    EXPECT_EQ(faults[0].line, lineOf(broken, "magnetic_saturation"));
  }
}

}  // namespace
}  // namespace amb_rotor
