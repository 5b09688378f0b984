// Starts of a bending mode with shapes that the runs ask for: the solution itself against a matrix that is known, and at the work
// it is for, a rotor whose shapes are not those of a uniform beam.
#include "../../src/validation/seen_shapes.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "../../src/validation/foreseen.hpp"
#include "../support/made_sets.hpp"
#include "../support/models.hpp"
#include "amb_rotor/validation/starts.hpp"

namespace amb_rotor {
namespace {

using namespace testing_support;

TEST(SeenShapes, ProductsThatAreOfRankOneAreFound) {
  // S of directions that overlap, a = S c: the maximum is c itself
  Eigen::MatrixXd roots(6, 6);
  for (int i = 0; i < 6; ++i)
    for (int j = 0; j < 6; ++j) roots(i, j) = std::cos(1.3 * i * j + 0.7 * i - 0.4 * j) + (i == j ? 2.0 : 0.0);
  const Eigen::MatrixXd squares = roots.transpose() * roots;
  const Eigen::Vector2d seen(1.1, -0.3);
  const Eigen::Vector3d driven(0.5, 0.2, -0.7);
  const Eigen::Matrix<double, 2, 3, Eigen::RowMajor> products = seen * driven.transpose();
  const Eigen::VectorXd along = squares * Eigen::Map<const Eigen::VectorXd>(products.data(), 6);
  // what counts as one direction is 1e-4 of its squares, so much the products are off
  EXPECT_LT((likeliestProducts(squares, along) - products).norm(), 1e-3 * products.norm());
}

TEST(SeenShapes, AWayThatChangesNothingDoesNotHideTheOthers) {
  // no unbalance is stated: its two directions are none
  Eigen::VectorXd seen_there(6);
  seen_there << 1.0, 1.0, 0.0, 1.0, 1.0, 0.0;
  const Eigen::Vector2d seen(0.8, 0.6);
  const Eigen::Vector3d driven(0.5, 0.2, 0.0);
  const Eigen::Matrix<double, 2, 3, Eigen::RowMajor> products = seen * driven.transpose();
  const Eigen::VectorXd along = Eigen::Map<const Eigen::VectorXd>(products.data(), 6);
  const auto found = likeliestProducts(seen_there.asDiagonal(), along);
  EXPECT_LT((found - products).norm(), 1e-3 * products.norm());
}

TEST(SeenShapes, WhereNoneActsThereIsNone) {
  EXPECT_LT(likeliestProducts(Eigen::MatrixXd::Identity(6, 6), Eigen::VectorXd::Zero(6)).norm(), 1e-12);
}

/// Shapes on a curve along the shaft, at all planes of a rig.
EffectSetting modeOnCurve(const Rig<double>& rig) {
  const auto curve = [](double z) { return -0.6 - 2.0 * z + 90.0 * z * z; };
  EffectSetting mode = {"shaft_flexibility", {237.0, 0.007}};
  for (const double* planes : {rig.planes.amb, rig.planes.sensor, rig.planes.aux})
    for (int end = 0; end < 2; ++end) mode.values.push_back(curve(planes[end]));
  mode.values.push_back(curve(rig.unbalance[0].plane_z_m));
  return mode;
}

TEST(SeenShapes, OfAllSharesOfTheSameProductsThatOnACurveIsFound) {
  const Model belief = cleanSet().dataset.belief;
  const EffectSetting mode = modeOnCurve(belief.rig);
  EffectSetting shared = mode;
  for (const int i : {2, 3, 8}) shared.values[i] /= 7.0;
  for (const int i : {4, 5}) shared.values[i] *= 7.0;
  for (const int i : {6, 7}) shared.values[i] = 0.3;  // runs without contact say nothing of them
  const auto smooth = smoothMode(belief, shared);
  ASSERT_TRUE(smooth);
  for (std::size_t i = 0; i < mode.values.size(); ++i) EXPECT_NEAR(smooth->values[i], mode.values[i], 1e-9) << i;
}

TEST(SeenShapes, SensorsWithinTheirBearingsAndAnUnbalanceThereTellNoBendAndNothingIsLost) {
  Model belief = cleanSet().dataset.belief;
  for (int end = 0; end < 2; ++end) belief.rig.planes.sensor[end] = belief.rig.planes.amb[end];
  belief.rig.unbalance[0].plane_z_m = belief.rig.planes.amb[1];
  EffectSetting shared = modeOnCurve(belief.rig);
  for (const int i : {4, 5}) shared.values[i] *= 7.0;
  const auto smooth = smoothMode(belief, shared);
  ASSERT_TRUE(smooth);
  for (const double value : smooth->values) EXPECT_TRUE(std::isfinite(value));
  for (int end = 0; end < 2; ++end) EXPECT_NEAR(smooth->values[2 + end], smooth->values[4 + end], 1e-9) << "they are at one place";
}

TEST(SeenShapes, WhereNothingDrivesAModeOrNoUnbalanceIsStatedNoCurveIsAskedFor) {
  Model belief = cleanSet().dataset.belief;
  EffectSetting mode = modeOnCurve(belief.rig);
  for (const int i : {2, 3, 8}) mode.values[i] = 0.0;
  EXPECT_FALSE(smoothMode(belief, mode));
  mode = modeOnCurve(belief.rig);
  belief.rig.unbalance.clear();
  EXPECT_FALSE(smoothMode(belief, mode));
}

TEST(SeenShapes, AModeIsStatedWithItsEndsPositive) {
  // both are one machine; where nothing tells the ends (the auxiliary bearings of runs without contact) the middle does
  const std::vector<double> beam = {237.0, 0.007, -0.16, -0.37, 0.45, 0.28, 0.1, 0.09, -1.04};
  std::vector<double> turned = beam;
  for (std::size_t i = 2; i < turned.size(); ++i) turned[i] = -beam[i];
  for (const auto& values : {beam, turned}) {
    const FitSpace space(cleanSet().dataset.belief, {{"shaft_flexibility", values}});
    const std::vector<double> stated = space.model(space.start()).effects.at(0).values;
    for (std::size_t i = 0; i < beam.size(); ++i) EXPECT_NEAR(stated[i], beam[i], 1e-9) << i;
  }
}

/// The clean set as it would be with a mode whose node lies at one of the sensors.
struct BentOtherwise {
  BentOtherwise() : recordings_of(cleanSet()) {
    // frequency, damping; then bearings, sensors, auxiliary bearings, unbalance: a beam has 1.4 at its ends
    const Model bent = with(cleanSet().truth(), "shaft_flexibility", shapes);
    for (Recording& rec : recordings_of.recordings) rec = asOf(bent, cleanSet().truth(), rec);
  }
  const std::vector<double> shapes = {237.0, 0.007, 0.49, 0.30, 1.15, 0.08, 1.4, 0.74, -0.44};
  MadeSet recordings_of;
};

TEST(SeenShapes, AStartPointsToWhereTheDataDo) {
  const BentOtherwise set;
  const MadeSet& made = set.recordings_of;
  const Model belief = made.dataset.belief;
  std::vector<int> which;
  for (const int run : made.runs(RunUse::fit, false))
    if (!made.recordings[run].standstill) which.push_back(run);
  const FitSpace space(belief, {});
  const std::vector<LocalState> local(made.recordings.size());
  References references;
  references.screen =
      std::make_shared<const StartScreen>(made.recordings, which, space, space.start(), local, made.offset_std_m);
  std::string unused;
  std::vector<Settings> starts;
  for (const auto& values : startingValues("shaft_flexibility", belief, made.recordings, unused))
    starts.push_back({{"shaft_flexibility", values}});
  const std::size_t beams = starts.size();
  addSeenShapes(belief, space.start(), references, starts);
  ASSERT_GT(starts.size(), beams);
  starts.push_back({{"shaft_flexibility", set.shapes}});
  const auto gains = gainsOf(belief, starts, space.start(), references);
  const auto best = [&](std::size_t from, std::size_t to) {
    double gain = 0.0;
    for (std::size_t i = from; i < to; ++i) gain = std::max(gain, gains[i].gain);
    return gain;
  };
  const double truth = gains.back().gain, beam = best(0, beams), seen = best(beams, starts.size() - 1);
  RecordProperty("beam_of_truth", std::to_string(beam / truth));
  RecordProperty("seen_of_truth", std::to_string(seen / truth));
  EXPECT_GT(seen, 1.2 * beam) << "the shapes of a beam would do";
  EXPECT_GT(seen, 0.5 * truth) << "all but what its frequency, known to a third, takes";
}

TEST(SeenShapes, OtherEffectsKeepTheirStarts) {
  std::vector<Settings> starts = {{{"static_load", {0.0, 0.0}}}};
  addSeenShapes(cleanSet().dataset.belief, Eigen::VectorXd(), References(), starts);
  EXPECT_EQ(starts.size(), 1u);
}

}  // namespace
}  // namespace amb_rotor
