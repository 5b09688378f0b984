// --set path=value.
#include "amb_rotor/model/overrides.hpp"
#include "model_test_support.hpp"

namespace amb_rotor {
namespace {

using namespace model_test;

TEST(ModelOverrides, setNumbersByTheirPath) {
  Model model = validModel();
  applyOverrides(
      model,
      {"rig.rotor.mass_kg=3.5", "rig.unbalance.0.moment_kg_m=1e-5", "effects.sensor_runout.a_1x_m=2e-6",
       "rig.auxiliary_bearing.contact.stiffness_N_per_m=1e7", "rotor.model=rigid_mass"},
      smallCatalogue());
  EXPECT_EQ(model.rig.rotor.mass_kg, 3.5);
  EXPECT_EQ(model.rig.unbalance[0].moment_kg_m, 1e-5);
  EXPECT_EQ(model.effects[0].values[0], 2e-6);
  EXPECT_EQ(model.rig.auxiliary_bearing.stiffness_N_per_m, 1e7);
  EXPECT_EQ(model.rotor_model, RotorModel::rigid_mass);
}

TEST(ModelOverrides, allFaultsAtOnceAndTheModelUnchanged) {
  Model model = validModel();
  const auto faults = faultsOf([&] {
    applyOverrides(
        model,
        {"rig.rotor.mass=3.5", "rig.rotor.mass_kg=heavy", "rig.controller.delay_s=1", "no-equals",
         "effects.control_delay.delay_s=1e-4", "effects.sensor_runout.a_1x_m=1", "rig.gravity_m_s2=nan",
         "rig.rotor.polar_inertia_kg_m2=0.5", "rotor.model=flexible", "rig.amb.stiffness_N_per_m=1"},
        smallCatalogue());
  });
  EXPECT_EQ(faults.size(), 10u) << joined(faults);
  EXPECT_NE(faultOf(faults, "rig.rotor.mass").rule.find("nearest: rig.rotor.mass_kg"), std::string::npos);
  EXPECT_NE(faultOf(faults, "effects.control_delay.delay_s").rule.find("not in this model"),
            std::string::npos);
  EXPECT_NE(faultOf(faults, "effects.sensor_runout.a_1x_m").rule.find("to 1.0e-04 m"), std::string::npos);
  EXPECT_NE(faultOf(faults, "rig.controller.delay_s").rule.find("20.0 samples"), std::string::npos);
  EXPECT_EQ(model.rig.controller.delay_s, 1e-4);
}

TEST(ModelOverrides, oneOverride) {
  Model model = validModel();
  applyOverride(model, "rig.gravity_m_s2=9.81", smallCatalogue());
  EXPECT_EQ(*requireField(model, "rig.gravity_m_s2", smallCatalogue()), 9.81);
  EXPECT_EQ(faultsOf([&] { requireField(model, "rig.gravity", smallCatalogue()); }).size(), 1u);
}

}  // namespace
}  // namespace amb_rotor
