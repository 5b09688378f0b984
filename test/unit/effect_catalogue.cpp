// The catalogue of effects: names as the data sets write them, sane limits, on changes a run, neutral and off
// do not.
#include <gtest/gtest.h>

#include <set>

#include "../support/models.hpp"
#include "amb_rotor/effects/all.hpp"
#include "amb_rotor/model/model_rules.hpp"

namespace amb_rotor {
namespace {

using namespace testing_support;

/// Names and order of doc: format amb-dataset/1, "Names and signs of the effects' parameters".
const std::vector<std::pair<std::string, std::vector<std::string>>>& documented() {
  static const std::vector<std::pair<std::string, std::vector<std::string>>> names = {
      {"couple_unbalance", {"moment_kg_m", "phase_rad", "plane_z_m"}},
      {"shaft_bow", {"bow_a_m", "bow_b_m", "phase_rad"}},
      {"sensor_runout",
       {"a_1x_m", "a_1x_phase_rad", "a_2x_m", "a_2x_phase_rad", "b_1x_m", "b_1x_phase_rad", "b_2x_m",
        "b_2x_phase_rad"}},
      {"sensor_gain_error", {"factor_ax", "factor_ay", "factor_bx", "factor_by"}},
      {"sensor_axis_rotation", {"angle_a_rad", "angle_b_rad"}},
      {"static_load", {"force_x_N", "force_y_N"}},
      {"gyroscopic_coupling", {"polar_inertia_kg_m2"}},
      {"stiffness_anisotropy", {"relative_difference"}},
      {"cross_coupled_stiffness", {"stiffness_N_per_m", "reference_speed_hz", "speed_exponent", "z_m"}},
      {"internal_damping", {"damping_N_s_per_m", "z_m"}},
      {"foundation_resonance", {"mass_kg", "frequency_hz", "damping_ratio"}},
      {"magnetic_nonlinearity", {"bias_current_A", "air_gap_m"}},
      {"magnetic_saturation", {"knee_flux_density_T"}},
      {"current_saturation", {"max_current_A"}},
      {"amplifier_lag", {"bandwidth_hz"}},
      {"control_delay", {"delay_s"}},
      {"eddy_current_lag", {"corner_hz"}},
      {"motor_magnetic_pull", {"stiffness_N_per_m", "z_m"}},
      {"auxiliary_bearing_misalignment", {"offset_ax_m", "offset_ay_m", "offset_bx_m", "offset_by_m"}},
      {"hertzian_contact", {"stiffness_N_per_m1_5", "damping_s_per_m"}},
      {"compliant_mount", {"stiffness_N_per_m", "damping_N_s_per_m", "mass_kg"}},
      {"velocity_dependent_friction", {"static_coefficient", "dynamic_coefficient", "speed_m_per_s"}},
      {"inner_ring_spin", {"inertia_kg_m2", "drag_torque_N_m"}},
      {"spin_drag", {"decay_per_s", "torque_N_m"}},
      {"shaft_crack", {"relative_depth", "phase_rad"}},
      {"shaft_flexibility",
       {"frequency_hz", "damping_ratio", "shape_amb_a", "shape_amb_b", "shape_sensor_a", "shape_sensor_b",
        "shape_aux_a", "shape_aux_b", "shape_unbalance"}}};
  return names;
}

TEST(EffectCatalogueTest, AMimicIsANumberOfTheRigAndOfContactWhereTheEffectIs) {
  std::set<std::string> fields;
  Model model;
  Rig<double>::visit(model.rig, [&](const char* name, const double&) { fields.insert(name); });
  int mimics = 0;
  for (const auto& schema : effectCatalogue().all()) {
    if (schema.lasting) { EXPECT_TRUE(schema.needs_contact) << schema.id << ": windows are of runs with contact"; }
    if (schema.mimic.empty()) continue;
    ++mimics;
    EXPECT_EQ(fields.count(schema.mimic), 1u) << schema.id << ": " << schema.mimic;
    EXPECT_EQ(schema.mimic.rfind("auxiliary_bearing.", 0) == 0, schema.needs_contact) << schema.id;
  }
  EXPECT_GE(mimics, 2);
}

TEST(EffectCatalogueTest, NamesAndParametersAsDocumented) {
  std::set<std::string> known;
  for (const auto& schema : effectCatalogue().all()) known.insert(schema.id);
  EXPECT_EQ(known.size(), effectCatalogue().all().size()) << "no name twice";
  for (const auto& effect : documented()) {
    const EffectSchema* schema = effectCatalogue().find(effect.first);
    ASSERT_NE(schema, nullptr) << effect.first;
    ASSERT_EQ(schema->parameters.size(), effect.second.size()) << effect.first;
    std::set<std::string> names, expected(effect.second.begin(), effect.second.end());
    for (const auto& parameter : schema->parameters) names.insert(parameter.name);
    EXPECT_EQ(names, expected) << effect.first;
    EXPECT_NE(effects::makePhysics<double>(effect.first, typicalValues(effect.first)), nullptr);
  }
  EXPECT_EQ(documented().size(), 26u);
  EXPECT_EQ(effects::makePhysics<double>("no_such_effect", {}), nullptr);
}

TEST(EffectCatalogueTest, LimitsHoldTheTypicalAndTheNeutralValue) {
  for (const auto& schema : effectCatalogue().all()) {
    EXPECT_FALSE(schema.summary.empty()) << schema.id;
    EXPECT_FALSE(schema.excited_by.empty()) << schema.id;
    for (const auto& p : schema.parameters) {
      const std::string name = schema.id + "." + p.name;
      EXPECT_LT(p.lower, p.upper) << name;
      EXPECT_GE(p.typical, p.lower) << name;
      EXPECT_LE(p.typical, p.upper) << name;
      if (!std::isnan(p.neutral)) {
        EXPECT_GE(p.neutral, p.lower) << name;
        EXPECT_LE(p.neutral, p.upper) << name;
      }
      EXPECT_FALSE(p.unit.empty()) << name;
      EXPECT_FALSE(p.meaning.empty()) << name;
      // the unit ends the name, as at every border of the program; a pure number has none
      std::string unit = p.unit;
      if (unit == "1") continue;
      const auto slash = unit.find('/');
      const std::string first = unit.substr(0, std::min(slash, unit.find_first_of(" ^")));
      const std::string expected = unit == "Hz" ? "hz" : first == "1" ? "per" : first;
      EXPECT_NE(p.name.find("_" + expected), std::string::npos) << name << " in " << p.unit;
    }
    const bool contact = std::set<std::string>{"auxiliary_bearing_misalignment",
                                               "auxiliary_bearing_tilt",
                                               "hertzian_contact",
                                               "compliant_mount",
                                               "fractional_mount",
                                               "velocity_dependent_friction",
                                               "inner_ring_spin"}
                             .count(schema.id) > 0;
    EXPECT_EQ(schema.needs_contact, contact) << schema.id;
  }
}

double difference(const Trajectory& a, const Trajectory& b) {
  double most = 0.0;
  for (std::size_t i = 0; i < std::min(a.time_s.size(), b.time_s.size()); ++i) {
    for (int axis = 0; axis < 4; ++axis)
      most = std::max(most, std::fabs(a.displacement_m[axis][i] - b.displacement_m[axis][i]));
    most = std::max(most, std::fabs(a.speed_rad_s[i] - b.speed_rad_s[i]));
  }
  return most;
}

TEST(EffectCatalogueTest, EveryEffectAloneChangesTheRun) {
  const auto baseline = simulate(eventfulModel(), eventful());
  ASSERT_EQ(baseline.outcome.status, RunStatus::ok);
  ASSERT_FALSE(baseline.trajectory.contacts.empty()) << "contact must occur";
  for (const auto& schema : effectCatalogue().all()) {
    const auto run = simulate(with(eventfulModel(), schema.id, typicalValues(schema.id)), eventful());
    ASSERT_NE(run.outcome.status, RunStatus::integration_failed) << schema.id << run.outcome.reason;
    // a thousandfold of the integrator's own error
    EXPECT_GT(difference(baseline.trajectory, run.trajectory), 1e-9) << schema.id;
  }
  // each has run and is off again: none has left a trace
  const auto again = simulate(eventfulModel(), eventful());
  EXPECT_EQ(difference(baseline.trajectory, again.trajectory), 0.0) << "off: bit for bit";
}

TEST(EffectCatalogueTest, OnSpringsAndDampersAnEffectChangesTheRunOrIsRefused) {
  // these have no coil and no controller: what acts there would do nothing, and nobody would notice
  Model model = withUnbalance(springBeam(), 4e-5, 0.3, 0.02);
  model.rig.gravity_m_s2 = 9.81;
  model.rig.auxiliary_bearing.friction_coefficient = 0.3;
  Scenario scenario = eventful();
  scenario.excitations.erase(scenario.excitations.begin());  // the current
  const auto baseline = simulate(model, scenario);
  ASSERT_EQ(baseline.outcome.status, RunStatus::ok) << baseline.outcome.reason;
  ASSERT_FALSE(baseline.trajectory.contacts.empty()) << "contact must occur";
  std::set<std::string> refused;
  for (const auto& schema : effectCatalogue().all()) {
    const Model one = with(model, schema.id, typicalValues(schema.id));
    const auto faults = checkModel(one, effectCatalogue());
    if (!faults.empty()) {
      EXPECT_NE(faults[0].rule.find("has no meaning for an equivalent bearing"), std::string::npos) << faults[0].text();
      refused.insert(schema.id);
      continue;
    }
    const auto run = simulate(one, scenario);
    ASSERT_NE(run.outcome.status, RunStatus::integration_failed) << schema.id << run.outcome.reason;
    EXPECT_GT(difference(baseline.trajectory, run.trajectory), 1e-9) << schema.id;
  }
  EXPECT_EQ(refused, (std::set<std::string>{"amplifier_lag", "control_delay", "current_saturation", "eddy_current_lag",
                                            "magnetic_nonlinearity", "magnetic_saturation"}));
}

TEST(EffectCatalogueTest, ABearingOffItsPlaceLeavesRoomForTheRotor) {
  const Model model = eventfulModel();
  const auto& rig = model.rig;
  const double room = rig.amb.air_gap_m - rig.auxiliary_bearing.clearance_m;
  const auto faultsOf = [&](const char* effect, const std::vector<double>& values) {
    return checkModel(with(model, effect, values), effectCatalogue());
  };
  const char* const misaligned = "auxiliary_bearing_misalignment";
  EXPECT_TRUE(faultsOf(misaligned, {0.6 * room, -0.6 * room, 0.0, 0.0}).empty());
  auto faults = faultsOf(misaligned, {0.0, 0.0, 0.8 * room, 0.8 * room});
  ASSERT_EQ(faults.size(), 1u);
  EXPECT_EQ(faults[0].key, std::string("effects.") + misaligned + ".offset_bx_m");
  const char* const leaning = "auxiliary_bearing_tilt";
  const double width = 0.02, most = 2.0 * rig.auxiliary_bearing.clearance_m / width;
  EXPECT_TRUE(faultsOf(leaning, {0.9 * most, 0.0, 0.0, 0.0, width}).empty());
  faults = faultsOf(leaning, {0.0, 1.1 * most, 0.0, 0.0, width});
  ASSERT_EQ(faults.size(), 1u);
  EXPECT_EQ(faults[0].key, std::string("effects.") + leaning + ".slope_ax_rad");
}

TEST(EffectCatalogueTest, AContactEffectLeavesAFreeRunBitForBit) {
  Scenario scenario = eventful();
  scenario.excitations.pop_back();
  const auto baseline = simulate(eventfulModel(), scenario);
  ASSERT_TRUE(baseline.trajectory.contacts.empty());
  for (const auto& schema : effectCatalogue().all()) {
    // a mount and a ring are states of their own: they take part in the choice of the step
    if (!schema.needs_contact) continue;
    const auto run = simulate(with(eventfulModel(), schema.id, typicalValues(schema.id)), scenario);
    ASSERT_TRUE(run.trajectory.contacts.empty()) << schema.id;
    const bool has_states =
        schema.id == "compliant_mount" || schema.id == "fractional_mount" || schema.id == "inner_ring_spin";
    EXPECT_LE(difference(baseline.trajectory, run.trajectory), has_states ? 1e-11 : 0.0) << schema.id;
  }
}

TEST(EffectCatalogueTest, WhatStandsInPlaceOfTheRigsNumbersObeysWhatHoldsForThem) {
  const Model model = eventfulModel();
  const auto& rig = model.rig;
  ASSERT_TRUE(checkModel(model, effectCatalogue()).empty());
  const double bias = rig.amb.bias_current_A, gap = rig.amb.air_gap_m;
  struct Case {
    const char* effect;
    std::vector<double> good, bad;
    const char* rule;
  };
  const std::vector<Case> cases = {
      {"gyroscopic_coupling", {1.9 * rig.rotor.transverse_inertia_kg_m2}, {2.1 * rig.rotor.transverse_inertia_kg_m2},
       "triangle inequality"},
      {"magnetic_nonlinearity", {bias, gap}, {bias, 0.9 * rig.auxiliary_bearing.clearance_m}, "must be below the air gap"},
      {"magnetic_nonlinearity", {bias, gap}, {1.1 * rig.amb.max_current_A, gap}, "bias_current_A"},
      {"current_saturation", {1.1 * bias}, {0.9 * bias}, "must be at most max_current_A"},
      {"control_delay", {2e-4}, {21.0 / rig.controller.sample_rate_hz}, "samples"}};
  for (const Case& one : cases) {
    EXPECT_TRUE(checkModel(with(model, one.effect, one.good), effectCatalogue()).empty()) << one.effect;
    const auto faults = checkModel(with(model, one.effect, one.bad), effectCatalogue());
    ASSERT_EQ(faults.size(), 1u) << one.effect;
    EXPECT_EQ(faults[0].key, std::string("effects.") + one.effect);
    EXPECT_NE(faults[0].rule.find(one.rule), std::string::npos) << faults[0].rule;
  }
}

TEST(EffectCatalogueTest, NeutralValuesAreTheBaseline) {
  // effects of which every plain or amplitude parameter has a neutral value vanish there
  const auto baseline = simulate(eventfulModel(), eventful());
  int tried = 0;
  for (const auto& schema : effectCatalogue().all()) {
    std::vector<double> values;
    bool has_neutral = true;
    for (const auto& p : schema.parameters) {
      has_neutral = has_neutral && !std::isnan(p.neutral);
      values.push_back(p.neutral);
    }
    // at the edge of its range only nearly neutral: 1e6 kg, 10 T, 10 MHz
    const bool nearly =
        std::set<std::string>{"foundation_resonance", "magnetic_saturation", "eddy_current_lag"}.count(
            schema.id) > 0;
    if (!has_neutral || nearly) continue;
    ++tried;
    const auto run = simulate(with(eventfulModel(), schema.id, values), eventful());
    // impacts multiply the integrator's errors by some tens
    EXPECT_LT(difference(baseline.trajectory, run.trajectory), 1e-9) << schema.id;
  }
  EXPECT_GE(tried, 12);
}

}  // namespace
}  // namespace amb_rotor
