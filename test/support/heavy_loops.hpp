#pragma once
// A rotor that its weight pulls at, in a loop with integrators, and what sensors in the loop are off by.
#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

#include "amb_rotor/common/units.hpp"
#include "amb_rotor/validation/predict.hpp"
#include "amb_rotor/validation/recording.hpp"
#include "amb_rotor/validation/stretches.hpp"
#include "models.hpp"

namespace amb_rotor::testing_support {

inline constexpr double loop_offset_m[4] = {1.2e-6, -0.8e-6, 0.6e-6, 1.0e-6};

/// Of a rotor that turns at 70 Hz.
inline Recording turning(long samples) {
  Recording rec;
  rec.run.kind = RunKind::steady;
  rec.run.sample_rate_hz = 1e4;
  rec.samples = samples;
  rec.speed_rad_s = radPerSecond(70.0);
  rec.noise.fill(1e-7);
  return rec;
}

/// Half a second of a rotor that its weight pulls at and that a controller with integrators holds, which begin with so much.
inline Recording heldByIntegrators(const Model& model, double share, const double* offset_m) {
  Recording rec = turning(5000);
  // at the sensors' zero each bearing carries half of the weight, by its current alone
  const auto& rig = model.rig;
  const double current = 0.5 * rig.rotor.mass_kg * 9.81 / rig.amb.current_stiffness_N_per_A;
  for (const int a : {1, 3}) rec.integral_m_s[a] = -share * current / rig.controller.ki_A_per_m_s;
  rec.measured.resize(rec.samples * predicted_channels);
  std::vector<LaneJob> jobs = {jobOf(rec, model, 0.0)};
  if (offset_m != nullptr) std::copy_n(offset_m, axis_count, jobs[0].offset_m);
  jobs[0].out = rec.measured.data();
  predict(stretchOf(rec, model), jobs);
  EXPECT_TRUE(jobs[0].finite);
  return rec;
}

inline Model heavyRotor() {
  Model model = withUnbalance(levitated(), 2e-5, 0.3);
  model.rig.gravity_m_s2 = 9.81;
  model.rig.controller.ki_A_per_m_s = 2e4;
  return model;
}

/// That the weight takes at a bearing where the sensors show nothing.
inline double heldCurrent(const Model& model, int end) {
  const auto& z = model.rig.planes.amb;
  return model.rig.rotor.mass_kg * model.rig.gravity_m_s2 * z[1 - end] / (z[1 - end] - z[end]) / model.rig.amb.current_stiffness_N_per_A;
}

}  // namespace amb_rotor::testing_support
