// Gains of all sensors, Ki and the loads by one factor: the runs of a linear machine do not tell it, and the beliefs decide.
#include "amb_rotor/validation/common_gain.hpp"

#include <gtest/gtest.h>
#include <unistd.h>

#include <cmath>
#include <filesystem>

#include "../support/long_tests.hpp"
#include "../support/models.hpp"
#include "amb_rotor/validation/diagnosis.hpp"
#include "amb_rotor/validation/make_dataset.hpp"

namespace amb_rotor {
namespace {

using namespace testing_support;

/// A rotor without weight that turns, with an unbalance and a load, behind sensors of four gains and a current limit that is reached.
FitSpace limited() {
  Model belief = withUnbalance(levitated(), 4e-5, 0.4, 0.02);
  belief.rig.gravity_m_s2 = 0.0;
  belief.uncertainty = {{"amb.current_stiffness_N_per_A", 0.03}, {"unbalance.moment_kg_m", 0.1}, {"unbalance.phase_rad", 0.05}, {"rotor.mass_kg", 0.01}};
  return FitSpace(belief, {{"sensor_gain_error", {1.05, 0.97, 1.1, 0.9}}, {"static_load", {5.0, -3.0}}, {"current_saturation", {3.5}}});
}

Eigen::VectorXd grown(const FitSpace& space, double share) {
  return space.start() + share * alongCommonGain(space, space.start());
}

TEST(CommonGain, AlongItNothingIsSeen) {
  const FitSpace space = limited();
  Scenario scenario = constantSpeed(40.0, 0.1);
  scenario.excitations.push_back(currentPulse(2.0, 0.01, 0.002));
  const Simulation one = simulate(space.model(space.start()), scenario), other = simulate(space.model(grown(space, 0.2)), scenario);
  ASSERT_EQ(one.outcome.status, RunStatus::ok) << one.outcome.reason;
  ASSERT_EQ(other.outcome.status, RunStatus::ok) << other.outcome.reason;
  double most = 0.0, size = 0.0, current = 0.0;
  for (int axis = 0; axis < 4; ++axis)
    for (std::size_t i = 0; i < one.trajectory.time_s.size(); ++i) {
      const double signal = one.trajectory.displacement_m[axis][i];
      size = std::max(size, std::fabs(signal));
      most = std::max(most, std::fabs(signal - other.trajectory.displacement_m[axis][i]));
      current = std::max(current, std::fabs(one.trajectory.current_A[axis][i]));
    }
  EXPECT_GE(current, 1.0 - 1e-9) << "the limit less the bias is reached";
  EXPECT_LT(most, 1e-6 * size);  // steps of the integrator are chosen by the rotor's motion, which differs
}

TEST(CommonGain, OnlyWhereGainsAndKiAreFree) {
  const FitSpace space = limited();
  const Eigen::VectorXd along = alongCommonGain(space, space.start());
  int grow = 0;
  for (int k = 0; k < space.size(); ++k) {
    EXPECT_TRUE(along[k] == 0.0 || along[k] == space.start()[k]) << space.coordinates()[k].name;
    grow += along[k] != 0.0 ? 1 : 0;
  }
  EXPECT_EQ(grow, 8) << "Ki, the unbalance's moment, four gains, two loads";
  Model known = space.model(space.start());
  known.effects.clear();
  known.uncertainty.erase("amb.current_stiffness_N_per_A");
  const FitSpace closed(known, {{"sensor_gain_error", {1.05, 0.97, 1.1, 0.9}}});
  EXPECT_EQ(alongCommonGain(closed, closed.start()).norm(), 0.0);
}

/// The least of two parabolas: Ki known to 3 % and the moment to 10 %, both 20 % too large.
TEST(CommonGain, TheBeliefsPullBack) {
  const FitSpace space = limited();
  const Eigen::VectorXd x = grown(space, 0.2);
  const PullOfBeliefs pull = pullAlong(space, x, alongCommonGain(space, x));
  EXPECT_NEAR(1.2 * (1.0 + pull.way), 1.0, 1e-12);
  EXPECT_NEAR(pull.deviation, 1.0 / (1.2 * std::hypot(1.0 / 0.03, 1.0 / 0.1)), 1e-12);
}

TEST(CommonGain, ACovarianceIsWidenedToADeviationOnce) {
  const Eigen::Vector2d deviation = {0.3, -0.4};
  Eigen::MatrixXd covariance = 1e-10 * Eigen::MatrixXd::Identity(2, 2);
  widenAlong(deviation, covariance);
  const Eigen::MatrixXd once = covariance;
  EXPECT_NEAR(std::sqrt(once(0, 0)), 0.3, 1e-6);
  EXPECT_NEAR(once(0, 1), -0.12, 1e-6);
  widenAlong(deviation, covariance);
  EXPECT_NEAR((covariance - once).norm(), 0.0, 1e-8);
}

/// Gains beside a current limit, on a rig without weight: derivatives by differences held the fit far off, and stated it far too closely.
TEST(CommonGain, ADiagnosisStatesWhatTheBeliefsLeaveOpen) {
  AMB_ROTOR_SKIP_UNLESS_LONG();
  const std::filesystem::path folder = std::filesystem::temp_directory_path() / ("amb_rotor_common_gain_" + std::to_string(::getpid()));
  const MadeDataset made = makeDataset({1100116, {"sensor_gain_error", "current_saturation"}, 4.7, false, folder.string(),
                                        {"chirp_1", "steady_2", "step_1", "steady_4", "step_2"}});
  const Dataset dataset = readDataset(folder.string());
  DiagnosisOptions options;
  options.candidates = {"sensor_gain_error", "current_saturation"};
  const Diagnosis found = diagnose(dataset.belief, dataset, options);
  ASSERT_EQ(dataset.belief.rig.gravity_m_s2, 0.0);
  ASSERT_EQ(found.steps.size(), 2u);
  for (const auto& step : found.steps)
    for (std::size_t i = 0; i < step.parameters.size() && step.added == "sensor_gain_error"; ++i) {
      const FittedParameter& gain = step.parameters[i];
      EXPECT_NEAR(gain.value, made.truth.effects[0].values[i], 3.0 * gain.std) << gain.name;
      // Ki is known to 3 %, the unbalance to 10 %
      EXPECT_GT(gain.std, 0.02 * gain.value) << gain.name;
      EXPECT_LT(gain.std, 0.04 * gain.value) << gain.name;
    }
  std::filesystem::remove_all(folder);
}

}  // namespace
}  // namespace amb_rotor
