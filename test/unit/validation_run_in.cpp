// The run-in before a recording: long enough for a weakly damped resonance of an effect to forget how it
// began.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>

#include "amb_rotor/common/units.hpp"
#include "amb_rotor/effects/catalogue.hpp"
#include "amb_rotor/validation/stretches.hpp"

namespace amb_rotor {
namespace {

/// A rigid mass that turns at 50 Hz in magnetic bearings, with an unbalance; on a foundation where it is
/// asked for.
Model turningMass() {
  Model model;
  auto& rig = model.rig;
  rig.rotor.mass_kg = 4.0;
  rig.rotor.transverse_inertia_kg_m2 = 0.03;
  rig.rotor.polar_inertia_kg_m2 = 0.002;
  for (int end = 0; end < 2; ++end) {
    const double side = end == 0 ? -1.0 : 1.0;
    rig.planes.amb[end] = side * 0.09;
    rig.planes.sensor[end] = side * 0.11;
    rig.planes.aux[end] = side * 0.13;
  }
  rig.amb.current_stiffness_N_per_A = 80.0;
  rig.amb.displacement_stiffness_N_per_m = 2e5;
  rig.amb.amplifier_bandwidth_hz = 2000.0;
  rig.amb.bias_current_A = 2.5;
  rig.amb.max_current_A = 5.0;
  rig.controller.sample_rate_hz = 1e4;
  rig.controller.kp_A_per_m = 9000.0;
  rig.controller.kd_A_s_per_m = 20.0;
  rig.controller.derivative_filter_hz = 2000.0;
  rig.controller.delay_s = 1e-4;
  rig.auxiliary_bearing.clearance_m = 2e-4;
  rig.auxiliary_bearing.stiffness_N_per_m = 3e7;
  rig.unbalance.push_back({0.0, 2e-5, 0.3});
  return model;
}

Model onFoundation(double frequency_hz, double damping_ratio) {
  Model model = turningMass();
  model.effects.push_back({"foundation_resonance", {100.0, frequency_hz, damping_ratio}});
  return model;
}

/// What the sensor shows in the first tenth of a second after a run-in [m].
std::vector<double> shown(const Model& model, double settle_s) {
  Recording rec;
  rec.run.kind = RunKind::steady;
  rec.run.sample_rate_hz = 1e4;
  rec.samples = 1000;
  rec.speed_rad_s = radPerSecond(50.0);
  std::vector<double> out(rec.samples * predicted_channels);
  Stretch stretch = stretchOf(rec, model);
  stretch.excitation = nullptr;
  stretch.schedule = nullptr;
  stretch.settle_s = settle_s;
  std::vector<LaneJob> jobs = {jobOf(rec, model, 0.0)};
  // every run-in ends at the same angle of the shaft
  jobs[0].angle0_rad = 0.0;
  jobs[0].speed_rad_s = rec.speed_rad_s;
  jobs[0].out = out.data();
  predict(stretch, jobs);
  EXPECT_TRUE(jobs[0].finite);
  std::vector<double> x;
  for (long i = 0; i < rec.samples; ++i) x.push_back(out[i * predicted_channels]);
  return x;
}

double farthest(const std::vector<double>& one, const std::vector<double>& other) {
  double most = 0.0;
  for (std::size_t i = 0; i < one.size(); ++i) most = std::max(most, std::fabs(one[i] - other[i]));
  return most;
}

TEST(RunInTest, IsSixTimeConstantsOfTheSlowestResonanceUpToALimit) {
  EXPECT_EQ(settlingTime(turningMass()), 0.0) << "nothing that rings";
  // 6/(2 pi f zeta)
  EXPECT_NEAR(settlingTime(onFoundation(40.0, 0.05)), 0.477465, 1e-6);
  EXPECT_NEAR(settlingTime(onFoundation(80.0, 0.05)), 0.238732, 1e-6);
  EXPECT_NEAR(settlingTime(onFoundation(40.0, 0.1)), 0.238732, 1e-6);
  EXPECT_EQ(settlingTime(onFoundation(40.0, 0.001)), 0.8) << "no longer than that";
  EXPECT_EQ(settlingTime(onFoundation(40.0, 0.0)), 0.8);
  Model both = onFoundation(40.0, 0.05);
  const EffectSchema& shaft = *effectCatalogue().find("shaft_flexibility");
  std::vector<double> values;
  for (const auto& parameter : shaft.parameters) values.push_back(parameter.typical);
  values[shaft.indexOf("frequency_hz")] = 400.0;
  values[shaft.indexOf("damping_ratio")] = 0.01;
  both.effects.push_back({"shaft_flexibility", values});
  EXPECT_NEAR(settlingTime(both), 0.477465, 1e-6) << "the foundation's, which is the longer one";
  // a recording never gets less than a machine without resonances
  const Recording rec;
  const double shortest = Stretch().settle_s;
  EXPECT_EQ(stretchOf(rec, turningMass()).settle_s, shortest);
  EXPECT_EQ(stretchOf(rec, onFoundation(400.0, 0.05)).settle_s, shortest);
  EXPECT_NEAR(stretchOf(rec, onFoundation(40.0, 0.05)).settle_s, 0.477465, 1e-6);
}

TEST(RunInTest, AfterItTheMotionIsThatOfAFarLongerOne) {
  const Model model = onFoundation(40.0, 0.05);
  const std::vector<double> settled = shown(model, 3.0);
  const double early = farthest(shown(model, Stretch().settle_s), settled),
               own = farthest(shown(model, settlingTime(model)), settled);
  EXPECT_GT(early, 1e-3 * 1.25e-6) << "of the amplitude [m]: there is something to forget";
  // what rings at first falls by exp(-2 pi f zeta t); a factor of two for where in its swing it is met
  const double fall = std::exp(-two_pi * 40.0 * 0.05 * (settlingTime(model) - Stretch().settle_s));
  EXPECT_LT(own, 2.0 * fall * early);
  EXPECT_GT(own, 0.1 * fall * early) << "and it is this resonance that rang";
}

}  // namespace
}  // namespace amb_rotor
