// Predictions through contact of set-valued friction: by located events, as the run itself; and fits through them.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>

#include "../support/made_sets.hpp"
#include "../support/models.hpp"
#include "amb_rotor/effects/catalogue.hpp"
#include "amb_rotor/validation/fit.hpp"
#include "amb_rotor/validation/predict.hpp"
#include "amb_rotor/validation/stretches.hpp"

namespace amb_rotor {
namespace {

using namespace testing_support;

constexpr double drop_hz = 0.02, drop_s = 0.08, drop_begin_s = 0.02, drop_rate_hz = 10000.0;

/// Dropped at a slow spin onto a grippy bearing: it bounces, rolls up the wall sticking, and slides.
Model gripped() {
  Model model = withUnbalance(levitated(), 4e-5, 0.3, 0.02);
  model.friction_law = FrictionLaw::set_valued;
  model.rig.gravity_m_s2 = 9.81;
  model.rig.auxiliary_bearing.friction_coefficient = 0.3;
  model.rig.auxiliary_bearing.damping_N_s_per_m = 2000.0;
  return model;
}

Scenario dropTo(double end_s) { return bearingsOff(constantSpeed(drop_hz, end_s, drop_rate_hz), 0.005); }

/// Of a prediction that starts where a run has come, beside those of other machines, the largest distance from where that run goes on
/// [m].
double parted(const Model& model, bool by_events) {
  const Simulation begun = simulate(model, dropTo(drop_begin_s)), whole = simulate(model, dropTo(drop_s));
  EXPECT_EQ(whole.outcome.status, RunStatus::ok) << whole.outcome.reason;
  const Scenario scenario = dropTo(drop_s);
  const Schedule schedule(scenario.excitations, scenario.faults);
  Stretch stretch;
  stretch.schedule = &schedule;
  stretch.record_rate_hz = drop_rate_hz;
  stretch.first = std::lround(drop_begin_s * drop_rate_hz);
  stretch.last = std::lround(drop_s * drop_rate_hz);
  stretch.by_events = by_events;
  MachineState<double> start = begun.final_state;
  start.next_record = stretch.first;
  Model other = model;
  other.rig.rotor.mass_kg *= 1.02;
  const Model* machines[] = {&other, &model, &other};
  std::vector<double> outs[3];
  std::vector<LaneJob> jobs(3);
  for (std::size_t k = 0; k < jobs.size(); ++k) {
    outs[k].resize(static_cast<std::size_t>(stretch.last - stretch.first) * predicted_channels);
    jobs[k].model = machines[k];
    jobs[k].speed_rad_s = radPerSecond(drop_hz);
    jobs[k].start = &start;
    jobs[k].out = outs[k].data();
  }
  predict(stretch, jobs);
  for (const LaneJob& job : jobs) EXPECT_TRUE(job.finite);
  EXPECT_EQ(outs[0], outs[2]);
  EXPECT_NE(outs[0], outs[1]) << "it is another machine";
  const std::vector<double>& out = outs[1];
  double far = 0.0;
  for (long i = stretch.first; i < stretch.last; ++i)
    for (int a = 0; a < 4; ++a)
      far = std::max(far, std::fabs(out[(i - stretch.first) * predicted_channels + a] -
                                    whole.trajectory.displacement_m[a][static_cast<std::size_t>(i)]));
  return far;
}

TEST(SetValuedWindows, APredictionByEventsIsTheRunThatGoesOn) {
  const Model model = gripped();
  const Trajectory t = simulate(model, dropTo(drop_s)).trajectory;
  const long first = std::lround(drop_begin_s * drop_rate_hz);
  long sticks = 0, slides = 0;
  for (std::size_t i = static_cast<std::size_t>(first); i < t.time_s.size(); ++i)
    if (t.normal_force_N[0][i] > 0.0) ++(std::fabs(t.slip_m_s[0][i]) < 1e-6 ? sticks : slides);
  EXPECT_GT(sticks, 50);
  // tolerances of 1e-8 (run) and 1e-7 (prediction) of 1e-5 m a step, multiplied by the impacts: 1/100 of a sensor's noise
  EXPECT_LT(parted(model, true), 5e-9);
  // lanes creep instead, by up to v0 = 0.01 m/s times the span: the comparison sees it
  EXPECT_GT(parted(model, false), 1e-7);
}

TEST(SetValuedWindows, AFitTakesTheLaw) {
  // a drop at speed slides throughout: there both laws are Coulomb's, and windows must not tell them apart
  const MadeSet& set = madeSet(21, "none", 0.0, true, {"drop_1"});
  const std::vector<Recording> recordings = {beginningOf(set.recordings.at(0), 1000)};
  double error[2];
  for (int law = 0; law < 2; ++law) {
    Model model = set.truth();
    model.friction_law = law == 0 ? FrictionLaw::regularised : FrictionLaw::set_valued;
    const FitSpace space(model, {});
    const FitProblem problem(recordings, space, set.offset_std_m);
    std::vector<LocalState> local(1);
    EvaluationOptions options;
    options.jacobian = false;
    std::vector<RunResult> results;
    problem.evaluate(space.start(), {0}, local, options, &results);
    ASSERT_TRUE(results.at(0).finite);
    error[law] = std::sqrt(results[0].mean_square);
  }
  EXPECT_GT(error[0], 0.5);
  // these windows slide throughout, so the lanes predict them whatever the law: the same numbers
  EXPECT_DOUBLE_EQ(error[1], error[0]);
}

TEST(SetValuedWindows, LanesTakeOnlyWhatSlidesFarFromStick) {
  const MadeSet& set = madeSet(21, "none", 0.0, true, {"drop_1"});
  const Recording& drop = set.recordings.at(0);
  Model model = set.truth();
  EXPECT_TRUE(slidesThroughout(drop, model, 0, drop.samples));
  Model slow = model;  // its surface is no faster than its whirl
  slow.rig.auxiliary_bearing.rotor_radius_m *= 0.02;
  EXPECT_FALSE(slidesThroughout(drop, slow, 0, drop.samples));
  Recording still = drop;
  still.path = nullptr;
  still.speed_rad_s = 0.0;
  EXPECT_FALSE(slidesThroughout(still, model, 0, drop.samples));
  Recording blind = drop;  // no sensor, no speed of the whirl
  blind.noise[2] = 0.0;
  EXPECT_FALSE(slidesThroughout(blind, model, 0, drop.samples));
  const EffectSchema& ring = *effectCatalogue().find("inner_ring_spin");  // its ring may come to roll
  model.effects.push_back({ring.id, {}});
  for (const auto& parameter : ring.parameters) model.effects.back().values.push_back(parameter.typical);
  EXPECT_FALSE(slidesThroughout(drop, model, 0, drop.samples));
}

TEST(SetValuedWindows, ASetIsMadeWithTheLaw) {
  MakeDatasetOptions options{21, {"none"}, 0.0, true, "", {"drop_1"}, FrictionLaw::set_valued};
  const auto folder = std::filesystem::temp_directory_path() / ("amb_rotor_set_valued_" + std::to_string(::getpid()));
  options.out = folder.string();
  const MadeDataset made = makeDataset(options);
  EXPECT_EQ(made.truth.friction_law, FrictionLaw::set_valued);
  EXPECT_EQ(readDataset(options.out).belief.friction_law, FrictionLaw::set_valued);
  std::filesystem::remove_all(folder);
  options.effects = {"hum"};  // its own integrator knows no sticking
  EXPECT_THROW(makeDataset(options), InputError);
}

}  // namespace
}  // namespace amb_rotor
