// A sample rate that makes a loop unstable is refused by name; a loop that is unstable at any rate is not.
#include <gtest/gtest.h>

#include "../support/models.hpp"
#include "amb_rotor/model/model_rules.hpp"
#include "amb_rotor/model/model_writer.hpp"
#include "model_test_support.hpp"

namespace amb_rotor {
namespace {

using namespace testing_support;

const std::string key = "rig.controller.sample_rate_hz";

bool refused(Model model, double rate) {
  model.rig.controller.sample_rate_hz = rate;
  const auto faults = checkRig(model);
  for (const Fault& fault : faults) EXPECT_EQ(fault.key, key) << fault.text();
  return !faults.empty();
}

/// How a small motion of the machine goes on: the largest in the last third of `samples` over that of the second.
double growth(Model model, double rate, int samples) {
  model.rig.controller.sample_rate_hz = rate;
  const auto run = simulate(model, from(constantSpeed(0.0, samples / rate, rate), {1e-8, 0.0, 1e-7, 0.0}, {}));  // far above the tolerance, 1e-13 m
  EXPECT_EQ(run.outcome.status, RunStatus::ok);
  EXPECT_TRUE(run.trajectory.contacts.empty());
  double most[3] = {0.0, 0.0, 0.0};
  const auto& x = run.trajectory.position_m[2];
  for (std::size_t i = 0; i < x.size(); ++i) {
    double& third = most[std::min<std::size_t>(2, 3 * i / x.size())];
    third = std::max(third, std::fabs(x[i]));
  }
  return most[2] / most[1];
}

/// The rates between which the rule begins to refuse are those between which the machine's motion begins to grow.
void expectBorderOfTheMachine(const Model& model, const std::string& what) {
  SCOPED_TRACE(what);
  ASSERT_FALSE(refused(model, 10000.0));
  ASSERT_TRUE(refused(model, 400.0));
  double low = 400.0, high = 10000.0;
  while (high - low > 1.0) {
    const double middle = 0.5 * (low + high);
    (refused(model, middle) ? low : high) = middle;
  }
  EXPECT_GT(growth(model, 0.98 * low, 300), 1.01) << low << " Hz";
  EXPECT_LT(growth(model, 1.02 * low, 300), 0.999) << low << " Hz";
  // and the growth that it tells, over the 100 samples from the second third to the last; peaks lie between samples
  Model slow = model;
  slow.rig.controller.sample_rate_hz = 0.96 * low;
  const auto faults = checkRig(slow);
  ASSERT_EQ(faults.size(), 1u);
  const std::string told = "grows by ";
  const double share = 0.01 * std::stod(faults[0].rule.substr(faults[0].rule.find(told) + told.size()));
  EXPECT_NEAR(std::log(growth(model, 0.96 * low, 300)) / 100.0, std::log1p(share), 0.03 * share + 1e-4);
}

TEST(SampleTimeRule, ItsBorderIsThatOfTheMachine) {
  for (const RotorModel rotor : {RotorModel::rigid_beam, RotorModel::rigid_mass}) {
    for (const double delay : {0.0, 1e-4}) {
      Model model = levitated();
      model.rotor_model = rotor;
      model.rig.controller.delay_s = delay;
      expectBorderOfTheMachine(model, "delay " + std::to_string(delay));
    }
  }
}

TEST(SampleTimeRule, ItsBorderIsThatOfTheMachineWhateverIsInTheLoop) {
  Model filtered = levitated();
  filtered.signal_chain.anti_alias = AntiAliasFilter{2.0, 3000.0};
  expectBorderOfTheMachine(filtered, "anti-alias filter");

  Model coils = levitated();
  coils.coil = CoilCircuit{2.0, 0.02, 1000.0};
  expectBorderOfTheMachine(coils, "coils");

  Model sections = levitated();
  sections.control.main.sections = {{SectionType::lead_lag, {150.0, 190.0}}};
  expectBorderOfTheMachine(sections, "a lead-lag section");

  Model decoupled = levitated();
  decoupled.control.decoupled = true;
  const auto& gains = decoupled.rig.controller;
  decoupled.control.tilt.kp_A_per_m = 1.2 * gains.kp_A_per_m;
  decoupled.control.tilt.kd_A_s_per_m = 1.3 * gains.kd_A_s_per_m;
  decoupled.control.tilt.ki_A_per_m_s = gains.ki_A_per_m_s;
  expectBorderOfTheMachine(decoupled, "translation and tilt");
}

TEST(SampleTimeRule, RatesFarTooLowAreRefusedToo) {
  for (const double rate : {1.0, 10.0, 30.0, 100.0, 300.0}) EXPECT_TRUE(refused(levitated(), rate)) << rate;
  Model late = levitated();  // the delay alone makes it unstable, whatever the rate
  late.rig.controller.delay_s = 1.5e-3;
  for (const double rate : {1.0, 100.0, 1000.0}) EXPECT_FALSE(refused(late, rate)) << rate;
}

TEST(SampleTimeRule, WhatBelongsToItsRateIsNotJudged) {
  Model model = levitated();
  ASSERT_TRUE(refused(model, 400.0));
  model.control.main.sections = {{SectionType::biquad, {1.0, 0.0, 0.0, 0.0, 0.0}}};  // passes all
  EXPECT_FALSE(refused(model, 400.0));
}

TEST(SampleTimeRule, WhatIsUnstableAtAnyRateIsPhysics) {
  Model weak = levitated();  // Ki kp < Ks: the magnets win
  weak.rig.controller.kp_A_per_m = 0.9 * weak.rig.amb.displacement_stiffness_N_per_m / weak.rig.amb.current_stiffness_N_per_A;
  Model undamped = levitated();  // the delay alone drives it
  undamped.rig.controller.kd_A_s_per_m = 0.0;
  Model late = levitated();
  late.rig.controller.delay_s = 1.5e-3;
  Model none = levitated();
  none.rig.controller.kp_A_per_m = none.rig.controller.kd_A_s_per_m = 0.0;
  for (const Model& model : {weak, undamped, late, none})
    for (const double rate : {1000.0, 10000.0}) EXPECT_FALSE(refused(model, rate));
  EXPECT_GT(growth(late, 10000.0, 300), 1.0) << "it is unstable";
}

TEST(SampleTimeRule, IsNamedInAFileWithItsLine) {
  Model model = levitated();
  model.name = "slow";
  const std::string text = modelText(model, effectCatalogue());
  const std::string slow = model_test::replaced(text, "sample_rate_hz: 10000.0", "sample_rate_hz: 500.0");
  const auto faults = model_test::faultsOf([&] { parseModel(slow, "m.yaml", effectCatalogue()); });
  ASSERT_EQ(faults.size(), 1u);
  EXPECT_EQ(faults[0].key, key);
  EXPECT_EQ(faults[0].line, model_test::lineOf(slow, "sample_rate_hz"));
  EXPECT_NE(faults[0].rule.find("is too low"), std::string::npos);
  EXPECT_NE(faults[0].rule.find("is stable at 4000.0 Hz"), std::string::npos) << faults[0].rule;
}

}  // namespace
}  // namespace amb_rotor
