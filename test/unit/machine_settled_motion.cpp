// The settled motion of a linear machine, found in closed form, is where a long run-in ends; and it is not told where
// there is none.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <string>
#include <vector>

#include "../support/models.hpp"
#include "amb_rotor/common/units.hpp"
#include "amb_rotor/effects/catalogue.hpp"
#include "amb_rotor/validation/predict_impl.hpp"
#include "amb_rotor/validation/stretches.hpp"

namespace amb_rotor {
namespace {

using namespace testing_support;

constexpr long samples = 300;

Model turning() {
  Model model = withUnbalance(levitated(), 2e-5, 0.3);
  model.rig.gravity_m_s2 = 9.81;
  return model;
}

Model withTypical(Model model, const char* effect, const std::map<std::string, double>& values) {
  const EffectSchema& schema = *effectCatalogue().find(effect);
  std::vector<double> all;
  for (const auto& parameter : schema.parameters) all.push_back(parameter.typical);
  for (const auto& [name, value] : values) all[schema.indexOf(name)] = value;
  model.effects.push_back({effect, all});
  return model;
}

Stretch stretchFor(const Model& model) {
  Recording rec;
  rec.run.kind = RunKind::steady;
  rec.run.sample_rate_hz = 1e4;
  rec.samples = samples;
  rec.speed_rad_s = radPerSecond(50.0);
  Stretch stretch = stretchOf(rec, model);
  stretch.excitation = nullptr;
  stretch.schedule = nullptr;
  stretch.contact_step_s = 0.0;
  return stretch;
}

LaneJob jobFor(const Model& model, std::vector<double>& out) {
  LaneJob job;
  job.model = &model;
  job.angle0_rad = 0.7;
  job.speed_rad_s = radPerSecond(50.0);
  job.offset_m[1] = 3e-6;
  job.integral_m_s[2] = 1e-7;
  out.assign(samples * predicted_channels, 0.0);
  job.out = out.data();
  return job;
}

bool settles(const Model& model, const Stretch& stretch, MachineState<double>& state) {
  std::vector<double> out;
  const LaneJob job = jobFor(model, out);
  return settlePack<double>(stretch, &job, 1, &state);
}

/// Asks that a record from the settled motion be one behind a run-in of a time [s].
void expectAsBehind(double run_in_s, const Model& model, Stretch stretch) {
  MachineState<double> state;
  ASSERT_TRUE(settles(model, stretch, state));
  std::vector<double> solved, run;
  LaneJob job = jobFor(model, solved);
  job.start = &state;
  predictPack<double, ExactSteps<double>>(stretch, &job, 1);
  stretch.settle_s = run_in_s;
  LaneJob from_rest = jobFor(model, run);
  predictPack<double, ExactSteps<double>>(stretch, &from_rest, 1);
  ASSERT_TRUE(job.finite && from_rest.finite);
  for (long i = 0; i < samples; ++i)
    for (int c = 0; c < predicted_channels; ++c) {
      const long k = i * predicted_channels + c;
      // 1 nm and 10 uA: far below any sensor, far above what adds up in 1e5 steps
      ASSERT_NEAR(solved[k], run[k], c < axis_count ? 1e-9 : 1e-5) << "instant " << i << ", channel " << c;
    }
}

TEST(SettledMotionTest, IsWhereALongRunInEnds) {
  constexpr double run_in_s = 8.0;  // exp(-0.02 2 pi 40 8) = 3e-18
  const Model weak_foundation = withTypical(turning(), "foundation_resonance", {{"frequency_hz", 40.0}, {"damping_ratio", 0.02}});
  const Model weak_shaft = withTypical(turning(), "shaft_flexibility", {{"frequency_hz", 150.0}, {"damping_ratio", 0.005}});
  const Model runout = withTypical(turning(), "sensor_runout", {});
  Model delayed = weak_foundation;
  delayed.rig.controller.delay_s = 1.4 / delayed.rig.controller.sample_rate_hz;
  Model with_notch = turning();
  with_notch.control.unbalance_rejection = UnbalanceRejection{};
  with_notch.control.unbalance_rejection->bandwidth_hz = 1.0;
  with_notch.control.unbalance_rejection->phase_rad = pi;  // below the rigid modes
  for (const Model& model : {turning(), weak_foundation, weak_shaft, runout, delayed, with_notch}) {
    SCOPED_TRACE(model.effects.empty() ? "no effect" : model.effects[0].id);
    expectAsBehind(run_in_s, model, stretchFor(model));
  }
}

TEST(SettledMotionTest, LeakingIntegratorsComeToRestInIt) {
  const Model model = turning();
  Stretch stretch = stretchFor(model);
  stretch.integrator_leak_per_s = 10.0;
  expectAsBehind(8.0, model, stretch);
}

TEST(SettledMotionTest, LagsFollowTheMeanAtTheirOwnPace) {
  // hurried as for a run-in of 8 s they are hardly hurried
  const Model model = withTypical(turning(), "eddy_current_lag", {});
  expectAsBehind(8.0, model, stretchFor(model));
}

TEST(SettledMotionTest, ItDoesNotDependOnTheBeginningOfTime) {
  // A path of constant speed and a constant speed are one.
  const Model model = withTypical(turning(), "foundation_resonance", {{"frequency_hz", 40.0}, {"damping_ratio", 0.02}});
  Stretch stretch = stretchFor(model);
  MachineState<double> own, on_path;
  ASSERT_TRUE(settles(model, stretch, own));
  const ConstantShaft path(0.7, radPerSecond(50.0));
  stretch.path = &path;
  std::vector<double> out;
  LaneJob job = jobFor(model, out);
  job.angle0_rad = job.speed_rad_s = 0.0;
  ASSERT_TRUE(settlePack<double>(stretch, &job, 1, &on_path));
  for (std::size_t i = 0; i < own.mechanics.size(); ++i)
    EXPECT_NEAR(own.mechanics[i], on_path.mechanics[i], 1e-9 * (1.0 + 100.0 * std::fabs(own.mechanics[i])));
}

TEST(SettledMotionTest, AMachineThatDoesNotSettleHasNone) {
  MachineState<double> state;
  Model unstable = turning();
  unstable.rig.controller.kd_A_s_per_m *= 0.15;
  EXPECT_FALSE(settles(unstable, stretchFor(unstable), state));
}

TEST(SettledMotionTest, OneThatReachesWhatIsNotLinearHasNone) {
  MachineState<double> state;
  // a converter's steps, a command beyond the amplifiers' limit, the auxiliary bearings
  Model rounded = turning();
  rounded.signal_chain.ad = Converter{};
  rounded.signal_chain.ad->bits = 12;
  rounded.signal_chain.ad->range = 1e-3;
  EXPECT_FALSE(settles(rounded, stretchFor(rounded), state));
  Model loaded = turning();
  loaded.rig.amb.max_current_A = loaded.rig.amb.bias_current_A + 0.05;
  EXPECT_FALSE(settles(loaded, stretchFor(loaded), state));
  Model near = turning();
  near.rig.auxiliary_bearing.clearance_m = 2e-5;
  Stretch with_contact = stretchFor(near);
  EXPECT_TRUE(settles(near, with_contact, state)) << "contact is left out";
  with_contact.contact_step_s = 1e-5;
  EXPECT_FALSE(settles(near, with_contact, state));
}

TEST(SettledMotionTest, NoneIsToldThatALimitOfTheCommandsCutsAtItsCrest) {
  // Unbalance alone: the limit is passed within a few degrees of each crest only. What is told must be what the machine with
  // its limit does over a turn.
  Model free = turning();
  free.rig.gravity_m_s2 = 0.0;
  const Stretch stretch = stretchFor(free);
  const auto seen = [&](const Model& model, const MachineState<double>& begin) {
    std::vector<double> out;
    LaneJob job = jobFor(model, out);
    job.start = &begin;
    predictPack<double, ExactSteps<double>>(stretch, &job, 1);
    return out;
  };
  MachineState<double> state;
  ASSERT_TRUE(settles(free, stretch, state));
  const std::vector<double> unlimited = seen(free, state);
  double peak = 0.0;
  for (std::size_t k = 0; k < unlimited.size(); ++k)
    if (k % predicted_channels >= axis_count) peak = std::max(peak, std::fabs(unlimited[k]));
  int told = 0, refused = 0;
  for (double share = 1.0; share < 1.2; share += 0.001) {  // the amplifiers' lag keeps the currents below their commands
    Model limited = free;
    limited.rig.amb.max_current_A = limited.rig.amb.bias_current_A + share * peak;
    if (!settles(limited, stretch, state)) {
      ++refused;
      continue;
    }
    ++told;
    const std::vector<double> own = seen(limited, state);
    for (std::size_t k = 0; k < own.size(); ++k) ASSERT_NEAR(own[k], unlimited[k], 1e-12 + 1e-9 * peak) << "at " << share << " of the currents' peak";
  }
  EXPECT_GT(told, 0);
  EXPECT_GT(refused, 0);
}

}  // namespace
}  // namespace amb_rotor
