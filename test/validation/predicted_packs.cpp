// Predictions of more machines than a pack holds: what parts two of them is what parts their models.
#include <gtest/gtest.h>
#include <tbb/global_control.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>

#include "../support/models.hpp"
#include "amb_rotor/common/units.hpp"
#include "amb_rotor/machine/lane_stepper.hpp"
#include "amb_rotor/machine/simulator.hpp"
#include "amb_rotor/validation/predict.hpp"

namespace amb_rotor {
namespace {

using namespace testing_support;

/// What a crack of some depth changes in 0.1 s of 90 Hz, beside as many sound machines as fill packs of their own.
std::vector<double> changeByCrack(double relative_depth) {
  const Model sound = with(withUnbalance(levitated(), 3e-5, 0.5, 0.02), "shaft_crack", {0.0, 0.4});
  const Model cracked = with(withUnbalance(levitated(), 3e-5, 0.5, 0.02), "shaft_crack", {relative_depth, 0.4});
  Stretch stretch;
  stretch.record_rate_hz = 10000.0;
  stretch.last = 1000;
  const std::size_t rows = static_cast<std::size_t>(stretch.last) * predicted_channels;
  const std::size_t count = static_cast<std::size_t>(predictionLanes()) + 1;
  std::vector<double> out(rows * count);
  std::vector<LaneJob> jobs(count);
  for (std::size_t k = 0; k < count; ++k) {
    jobs[k].model = k + 1 < count ? &sound : &cracked;
    jobs[k].speed_rad_s = two_pi * 90.0;
    jobs[k].out = out.data() + k * rows;
  }
  predict(stretch, jobs);
  for (const LaneJob& job : jobs) EXPECT_TRUE(job.finite);
  std::vector<double> change(rows);
  for (std::size_t i = 0; i < rows; ++i) change[i] = out[(count - 1) * rows + i] - out[i];
  return change;
}

/// 60 Hz that rise by 40 Hz each second, turned by an angle and a speed.
class Rising final : public ShaftPath {
 public:
  Rising(double more_rad, double more_rad_s) : more_rad_(more_rad), more_rad_s_(more_rad_s) {}
  ShaftInstant at(double time) const override {
    constexpr double speed = two_pi * 60.0, rise = two_pi * 40.0;
    return {more_rad_ + (speed + more_rad_s_) * time + 0.5 * rise * time * time, speed + more_rad_s_ + rise * time, rise};
  }

 private:
  double more_rad_, more_rad_s_;
};

/// On that path, its lane turned by so much beside it.
std::vector<double> onAPath(const Model& model, const Rising& path, double more_rad, double more_rad_s) {
  Stretch stretch;
  stretch.path = &path;
  stretch.record_rate_hz = 10000.0;
  stretch.last = 2000;
  std::vector<double> out(static_cast<std::size_t>(stretch.last) * predicted_channels);
  std::vector<LaneJob> jobs(1);
  jobs[0].model = &model;
  jobs[0].angle0_rad = more_rad;
  jobs[0].speed_rad_s = more_rad_s;
  jobs[0].out = out.data();
  predict(stretch, jobs);
  EXPECT_TRUE(jobs[0].finite);
  return out;
}

double lengthOf(const std::vector<double>& values) {
  double sum = 0.0;
  for (const double value : values) sum += value * value;
  return std::sqrt(sum);
}

TEST(PredictedPacks, AllOfThemGoTheSameWay) {
  // A sound shaft is linear and could go by exact steps, a cracked one cannot. Were the pack of the sound ones to do so, the
  // difference would hold the steps' own error, which does not shrink with the crack: a derivative of nothing.
  const std::vector<double> small = changeByCrack(1e-6), large = changeByCrack(1e-4);
  ASSERT_GT(lengthOf(large), 0.0);
  std::vector<double> apart(small.size());
  for (std::size_t i = 0; i < small.size(); ++i) apart[i] = 100.0 * small[i] - large[i];
  EXPECT_LT(lengthOf(apart), 1e-3 * lengthOf(large)) << "in proportion, to the square of the depth and round-off over 1e-6";
}

TEST(PredictedPacks, ALaneThatIsTurnedBesideAPathGoesAsOnThePathTurned) {
  const Model linear = withUnbalance(levitated(), 3e-5, 0.5, 0.02), cracked = with(linear, "shaft_crack", {0.1, 0.4});
  ASSERT_TRUE(predictsExactly({}, linear));
  ASSERT_FALSE(predictsExactly({}, cracked));
  for (const Model& model : {linear, cracked}) {
    const std::vector<double> beside = onAPath(model, Rising(0.0, 0.0), 0.4, 0.7), on = onAPath(model, Rising(0.4, 0.7), 0.0, 0.0),
                              off = onAPath(model, Rising(0.0, 0.0), 0.0, 0.0);
    std::vector<double> apart(on.size()), turned(on.size());
    for (std::size_t i = 0; i < on.size(); ++i) apart[i] = beside[i] - on[i], turned[i] = on[i] - off[i];
    EXPECT_GT(lengthOf(turned), 0.1 * lengthOf(off));
    EXPECT_LT(lengthOf(apart), 1e-7 * lengthOf(on)) << model.effects.size();  // exact steps interpolate between speeds, to so much
  }
}

/// More machines than a pack holds, each with a chirp of its own size: as if each went alone with that as the stretch's.
TEST(PredictedPacks, EachLaneFollowsItsOwnExcitation) {
  const Model model = levitated();
  const std::size_t count = static_cast<std::size_t>(predictionLanes()) + 2;
  Stretch stretch;
  stretch.record_rate_hz = 10000.0;
  stretch.last = 1000;
  const std::size_t rows = static_cast<std::size_t>(stretch.last) * predicted_channels;
  std::vector<HeldExcitation> own(count);
  for (std::size_t k = 0; k < count; ++k) {
    own[k].rate_hz = stretch.record_rate_hz;
    for (long i = 0; i < stretch.last; ++i) own[k].axis[k % 4].push_back(0.02 * (1.0 + k) * std::sin(1e-4 * i * i));
  }
  std::vector<double> together(rows * count), alone(rows);
  std::vector<LaneJob> jobs(count);
  for (std::size_t k = 0; k < count; ++k) {
    jobs[k].model = &model;
    jobs[k].excitation = &own[k];
    jobs[k].out = together.data() + k * rows;
  }
  predict(stretch, jobs);
  for (std::size_t k = 0; k < count; ++k) {
    std::vector<LaneJob> single(1);
    single[0].model = &model;
    single[0].out = alone.data();
    stretch.excitation = &own[k];
    predict(stretch, single);
    ASSERT_TRUE(jobs[k].finite && single[0].finite);
    ASSERT_GT(lengthOf(alone), 0.0);
    // the same operations in another lane
    for (std::size_t i = 0; i < rows; ++i) ASSERT_DOUBLE_EQ(together[k * rows + i], alone[i]) << "machine " << k << ", number " << i;
  }
}

TEST(PredictedPacks, AreTheSameWhicheverThreadsRunThem) {
  const Model rig = withUnbalance(levitated(), 3e-5, 0.5, 0.02);
  const std::size_t count = 5 * static_cast<std::size_t>(predictionLanes()) + 1;
  std::vector<Model> models(count, rig);
  for (std::size_t k = 0; k < count; ++k) models[k].rig.rotor.mass_kg *= 1.0 + 0.01 * static_cast<double>(k);
  Stretch stretch;
  stretch.record_rate_hz = 10000.0;
  stretch.last = 800;
  stretch.settle_s = 0.4;
  const std::size_t rows = static_cast<std::size_t>(stretch.last) * predicted_channels;
  // of so many machines at a time
  const auto predicted = [&](std::size_t together) {
    std::vector<double> out(rows * count);
    for (std::size_t from = 0; from < count; from += together) {
      std::vector<LaneJob> jobs(std::min(together, count - from));
      for (std::size_t k = 0; k < jobs.size(); ++k) {
        jobs[k].model = &models[from + k];
        jobs[k].speed_rad_s = two_pi * 90.0;
        jobs[k].out = out.data() + (from + k) * rows;
      }
      predict(stretch, jobs);
      for (const LaneJob& job : jobs) EXPECT_TRUE(job.finite);
    }
    return out;
  };
  std::vector<double> by_packs;
  {
    const tbb::global_control one(tbb::global_control::max_allowed_parallelism, 1);
    by_packs = predicted(static_cast<std::size_t>(predictionLanes()));
  }
  ASSERT_GT(lengthOf(by_packs), 0.0);
  std::vector<std::vector<double>> beside(4);
  tbb::parallel_for(std::size_t{0}, beside.size(), [&](std::size_t i) { beside[i] = predicted(count); });
  for (const auto& one : beside) EXPECT_EQ(one, by_packs);
}

TEST(PredictedPacks, IronSaturatesInThemAsInOneMachine) {
  // wide packs take a fourth root by an estimate and Newton's steps; after one step 4e-8 of the flux are left
  Model iron = withUnbalance(levitated(), 3e-5, 0.5, 0.02);
  iron.rig.amb.bias_flux_density_T = 0.6;
  iron = with(iron, "magnetic_saturation", {0.7});
  constexpr double rate_hz = 10000.0, step_s = 5e-5, turning_rad_s = two_pi * 90.0;
  constexpr long samples = 300;
  const Machine<double> machine({&iron}, Spin::prescribed);
  Drive<double> drive;
  drive.speed = turning_rad_s;
  const Simulator<double> simulator(machine, drive, rate_hz);
  const MachineState<double> start = simulator.atRest(0.0);
  std::vector<double> single;
  MachineState<double> state = start;
  LaneStepper<double> stepper(machine, step_s, 2.5e-6);
  ASSERT_TRUE(simulator.run(state, samples / rate_hz, stepper, [&](const Record<double>& seen) {
    for (int a = 0; a < 4; ++a) single.push_back(seen.signal[a]);
  }));
  Stretch stretch;
  stretch.record_rate_hz = rate_hz;
  stretch.last = samples;
  stretch.largest_step_s = step_s;
  std::vector<double> out(samples * predicted_channels);
  LaneJob job;
  job.model = &iron;
  job.speed_rad_s = turning_rad_s;
  job.start = &start;
  job.out = out.data();
  std::vector<LaneJob> jobs = {job};
  predict(stretch, jobs);
  ASSERT_TRUE(jobs[0].finite);
  ASSERT_EQ(single.size(), 4u * samples);
  double largest = 0.0, apart = 0.0;
  for (long i = 0; i < samples; ++i)
    for (int a = 0; a < 4; ++a) {
      largest = std::max(largest, std::fabs(single[i * 4 + a]));
      apart = std::max(apart, std::fabs(single[i * 4 + a] - out[i * predicted_channels + a]));
    }
  EXPECT_GT(largest, 1e-7);
  EXPECT_LT(apart, 1e-11 * largest) << "round-off of some thousand steps";
}

}  // namespace
}  // namespace amb_rotor
