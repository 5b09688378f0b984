// A window's starting state read off the measurement: the rotor is where it is, not where its sensors show it, and the
// integrators hold what the currents say.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "../support/models.hpp"
#include "amb_rotor/common/units.hpp"
#include "amb_rotor/validation/stretches.hpp"

namespace amb_rotor {
namespace {

using namespace testing_support;

/// A lying rotor whose integrators are slowly taking its sag away while its sensor tracks are not round.
Model lyingRotor() {
  Model model = withUnbalance(levitated(), 2e-5, 0.3);
  model.rig.gravity_m_s2 = 9.81;
  model.rig.controller.ki_A_per_m_s = 2e4;
  model.effects.push_back({"sensor_runout", {4e-6, 0.4, 2e-6, -1.0, 3e-6, 2.0, 1e-6, 0.2}});
  return model;
}

/// Its own prediction taken for a measurement.
Recording recorded(const Model& model) {
  Recording rec;
  rec.run.kind = RunKind::steady;
  rec.run.sample_rate_hz = 1e4;
  rec.samples = 3000;
  rec.speed_rad_s = radPerSecond(40.0);
  for (int c = 0; c < predicted_channels; ++c) rec.noise[c] = c < 4 ? 1e-7 : 1e-3;
  rec.measured.resize(rec.samples * predicted_channels);
  Stretch stretch = stretchOf(rec, model);
  stretch.settle_s = 0.02;  // the integrators are then still on their way
  std::vector<LaneJob> jobs = {jobOf(rec, model, 0.0)};
  jobs[0].out = rec.measured.data();
  predict(stretch, jobs);
  EXPECT_TRUE(jobs[0].finite);
  return rec;
}

/// Largest difference of a displacement over 10 ms from a start [m].
double largestMiss(const Recording& rec, const Model& model, long first, const MachineState<double>& start) {
  Stretch stretch = stretchOf(rec, model);
  stretch.first = first;
  stretch.last = first + 100;
  std::vector<double> out(100 * predicted_channels);
  std::vector<LaneJob> jobs = {jobOf(rec, model, 0.0)};
  jobs[0].start = &start;
  jobs[0].out = out.data();
  predict(stretch, jobs);
  EXPECT_TRUE(jobs[0].finite);
  double miss = 0.0;
  for (long i = 0; i < 100; ++i)
    for (int a = 0; a < 4; ++a)
      miss = std::max(miss, std::fabs(out[i * predicted_channels + a] - rec.measured[(first + i) * predicted_channels + a]));
  return miss;
}

TEST(WindowStart, IsTheMachinesOwn) {
  const Model model = lyingRotor();
  const Recording rec = recorded(model);
  Model round = model;
  round.effects.clear();
  Model without = model;
  without.rig.controller.ki_A_per_m_s = 0.0;
  for (const long first : {600L, 1500L, 2800L}) {
    const auto startOf = [&](const Model& read) { return stateFromMeasurement(rec, read, Spin::prescribed, first); };
    const double miss = largestMiss(rec, model, first, startOf(model));
    // what is left: the mean of the currents over a turn, in which the sag goes on falling, and parabolas over 0.8 ms of a
    // signal with 2X: a tenth of the runout
    EXPECT_LT(miss, 1.2e-6) << first;
    EXPECT_GT(largestMiss(rec, model, first, startOf(round)), 2.0 * miss) << first << ": runout taken for motion";
    EXPECT_GT(largestMiss(rec, model, first, startOf(without)), 5.0 * miss) << first << ": integrators left empty";
  }
}

}  // namespace
}  // namespace amb_rotor
