// The map between a fit's coordinates and a model's parameters.
#include <gtest/gtest.h>

#include <cmath>

#include "amb_rotor/common/units.hpp"
#include "amb_rotor/effects/catalogue.hpp"
#include "amb_rotor/validation/coordinates.hpp"

namespace amb_rotor {
namespace {

Model belief() {
  Model model;
  model.rig.rotor.mass_kg = 3.0;
  model.rig.amb.current_stiffness_N_per_A = 100.0;
  model.rig.unbalance.push_back({0.0, 2e-5, 0.4});
  model.uncertainty = {{"rotor.mass_kg", 0.005},
                       {"amb.current_stiffness_N_per_A", 0.03},
                       {"unbalance.moment_kg_m", 0.1},
                       {"unbalance.phase_rad", 0.05},
                       {"sensor.offset_m", 1e-6}};
  return model;
}

const EffectSetting runout{"sensor_runout", {2e-6, 0.7, 1e-6, 0.3, 3e-6, -1.2, 0.5e-6, 1.0}};

TEST(FitSpaceTest, NuisanceTakesTheStatedUncertaintyAsPrior) {
  const FitSpace space(belief(), {});
  ASSERT_EQ(space.nuisances(), 4) << "the sensor's offset belongs to the recording";
  for (const auto& c : space.coordinates()) {
    if (c.name == "rotor.mass_kg") { EXPECT_DOUBLE_EQ(c.prior_std, 0.005 * belief().rig.rotor.mass_kg); }
    if (c.name == "unbalance.moment_kg_m") { EXPECT_DOUBLE_EQ(c.prior_std, 2e-6); }
    if (c.name == "unbalance.phase_rad") { EXPECT_DOUBLE_EQ(c.prior_std, 0.05) << "absolute"; }
  }
}

TEST(FitSpaceTest, WhatForcesAreLinearInGoesAsItIs) {
  const FitSpace space(belief(), {});
  ASSERT_EQ(space.coordinates()[1].name, "amb.current_stiffness_N_per_A");
  Eigen::VectorXd x = space.start();
  EXPECT_DOUBLE_EQ(space.coordinates()[1].prior_std, 3.0);
  x[1] += 50.0;
  EXPECT_NEAR(space.model(x).rig.amb.current_stiffness_N_per_A, 150.0, 1e-12);
  x[1] += 1e6;
  EXPECT_NEAR(space.model(x).rig.amb.current_stiffness_N_per_A, 2000.0, 1e-9) << "twenty times the belief at most";
}

TEST(FitSpaceTest, AFactorGoesByItsLogarithm) {
  Model model = belief();
  model.rig.amb.amplifier_bandwidth_hz = 100.0;
  model.uncertainty = {{"amb.amplifier_bandwidth_hz", 0.02}};
  const FitSpace space(model, {});
  ASSERT_EQ(space.nuisances(), 1);
  EXPECT_DOUBLE_EQ(space.coordinates()[0].prior_std, 0.02) << "of the logarithm";
  Eigen::VectorXd x = space.start();
  x[0] += std::log(1.5);
  EXPECT_NEAR(space.model(x).rig.amb.amplifier_bandwidth_hz, 150.0, 1e-12);
  Eigen::MatrixXd covariance = Eigen::MatrixXd::Zero(space.size(), space.size());
  covariance(0, 0) = 0.01 * 0.01;
  const FittedParameter fitted = space.nuisanceValues(x, covariance)[0];
  EXPECT_NEAR(fitted.value, 150.0, 1e-12);
  EXPECT_NEAR(fitted.std, 1.5, 1e-12) << "1 % of the value";
  x[0] += 100.0;
  EXPECT_NEAR(space.model(x).rig.amb.amplifier_bandwidth_hz, 2000.0, 1e-9) << "twenty times the belief at most";
}

TEST(FitSpaceTest, StartGivesTheModelItCameFrom) {
  const FitSpace space(belief(), {runout, {"foundation_resonance", {30.0, 50.0, 0.03}}});
  const Model model = space.model(space.start());
  ASSERT_EQ(model.effects.size(), 2u);
  // through cosine, sine and logarithm and back: a few roundings
  for (std::size_t i = 0; i < runout.values.size(); ++i)
    EXPECT_NEAR(model.effects[0].values[i], runout.values[i], 1e-12) << i;
  EXPECT_NEAR(model.effects[1].values[0], 30.0, 1e-12);
  EXPECT_NEAR(model.effects[1].values[1], 50.0, 1e-12);
}

TEST(FitSpaceTest, SecondHarmonicPhaseIsTheShaftAngle) {
  const FitSpace space(belief(), {runout});
  Eigen::VectorXd x = space.start();
  // turn the vector of a's second harmonic by a quarter: its phase as shaft angle moves by an eighth of a turn
  const int c = space.nuisances() + 2;
  const double u = x[c], v = x[c + 1];
  x[c] = -v;
  x[c + 1] = u;
  const double moved = space.model(x).effects[0].values[3];
  EXPECT_NEAR(moved - 0.3, M_PI / 4.0, 1e-12);
  EXPECT_NEAR(space.model(x).effects[0].values[2], 1e-6, 1e-18);
}

TEST(FitSpaceTest, StandardDeviationsOfAmplitudeAndPhase) {
  const FitSpace space(belief(), {runout});
  // equal, uncorrelated errors of the vector: the amplitude has them, the phase has them over the amplitude
  Eigen::MatrixXd covariance = Eigen::MatrixXd::Zero(space.size(), space.size());
  const double std = 1e-8;
  for (int k = space.nuisances(); k < space.size(); ++k) covariance(k, k) = std * std;
  const auto values = space.effectValues(0, space.start(), covariance);
  EXPECT_NEAR(values[0].std, std, 1e-14);
  EXPECT_NEAR(values[1].std, std / 2e-6, 1e-9);
  EXPECT_NEAR(values[3].std, std / 1e-6 / 2.0, 1e-9) << "half: the phase is the shaft's angle";
}

TEST(FitSpaceTest, AnAmplitudeThatMayBeNothingHasAnyPhaseWithinThreeDeviations) {
  const FitSpace space(belief(), {runout});
  // along the vector so many of its lengths, across it next to nothing: a line through the origin
  const int c = space.nuisances();
  const auto phaseOf = [&](int coordinate, double lengths) {
    const Eigen::Vector2d along = lengths * space.start().segment<2>(coordinate);
    Eigen::MatrixXd covariance = Eigen::MatrixXd::Zero(space.size(), space.size());
    covariance.block<2, 2>(coordinate, coordinate) = along * along.transpose();
    return space.effectValues(0, space.start(), covariance)[coordinate - c + 1].std;
  };
  EXPECT_LT(phaseOf(c, 0.3), 1e-6) << "nothing is farther off than three";
  EXPECT_NEAR(phaseOf(c, 0.5), M_PI / 3.0, 1e-12);
  EXPECT_NEAR(phaseOf(c, 50.0), M_PI / 3.0, 1e-12) << "never more than any";
  EXPECT_NEAR(phaseOf(c + 2, 0.5), M_PI / 6.0, 1e-12) << "twice a turn";
}

TEST(FitSpaceTest, LimitsHold) {
  const FitSpace space(belief(), {{"foundation_resonance", {30.0, 50.0, 0.03}}});
  Eigen::VectorXd x = space.start();
  x[space.nuisances() + 2] = -5.0;  // damping ratio
  EXPECT_EQ(space.model(x).effects[0].values[2], 0.0);
}

/// A fit that has led it once round leaves the same machine, and the belief a whole turn away would count as wrong.
TEST(FitSpaceTest, AnAngleIsKeptWithinHalfATurnOfItsBelief) {
  const FitSpace space(belief(), {});
  int phase = 0;
  while (space.coordinates()[phase].name != "unbalance.phase_rad") ASSERT_LT(++phase, space.nuisances());
  Eigen::VectorXd x = space.start();
  for (const double off : {-3.0, 0.2, 3.0})
    for (const int turns : {-1, 0, 2}) {
      x[phase] = space.start()[phase] + off + turns * two_pi;
      EXPECT_NEAR(space.clamped(x)[phase], space.start()[phase] + off, 1e-12);
    }
}

TEST(FitSpaceTest, APositiveParameterGoesByItsLogarithm) {
  const FitSpace space(belief(), {{"foundation_resonance", {30.0, 50.0, 0.03}}});
  const int frequency = space.nuisances() + 1;
  Eigen::VectorXd x = space.start();
  x[frequency] += std::log(2.0);
  EXPECT_NEAR(space.model(x).effects[0].values[1], 100.0, 1e-12);
  Eigen::MatrixXd covariance = Eigen::MatrixXd::Zero(space.size(), space.size());
  covariance(frequency, frequency) = 0.01 * 0.01;
  EXPECT_NEAR(space.effectValues(0, x, covariance)[1].std, 100.0 * std::expm1(0.01), 1e-12) << "1 % of the value";
}

TEST(FitSpaceTest, WhatIsNeutralAtItsUpperLimitGoesByItsInverseRoot) {
  const FitSpace space(belief(), {{"eddy_current_lag", {2500.0}}});
  const int corner = space.nuisances();
  Eigen::VectorXd x = space.start();
  EXPECT_NEAR(x[corner], 0.02, 1e-15) << "1/sqrt(2500)";
  x[corner] = 0.01;
  EXPECT_NEAR(space.model(x).effects[0].values[0], 1e4, 1e-8);
  Eigen::MatrixXd covariance = Eigen::MatrixXd::Zero(space.size(), space.size());
  covariance(corner, corner) = 1e-5 * 1e-5;
  // f = u^-2, one deviation lower: 2 f^(3/2) du = 2 * 1e6 * 1e-5 to first order
  EXPECT_NEAR(space.effectValues(0, x, covariance)[0].std, std::pow(0.01 - 1e-5, -2.0) - 1e4, 1e-8);
}

TEST(FitSpaceTest, WhatTwoFactorsShareIsAStraightLine) {
  // a mode's shape at a magnet and at a sensor: their product is what a response tells best
  const std::vector<double> given = {360.0, 0.006, -0.9, 0.15, -2.3, 2.0, 0.0, 1.4, 4.2};
  const FitSpace space(belief(), {{"shaft_flexibility", given}});
  const auto from = space.model(space.start()).effects.back().values;
  for (std::size_t i = 0; i < given.size(); ++i) EXPECT_NEAR(from[i], given[i], 1e-12) << "either sign, and none";
  int magnet = -1, sensor = -1;
  for (int k = 0; k < space.size(); ++k) {
    if (space.coordinates()[k].name == "shaft_flexibility.shape_amb_a") magnet = k;
    if (space.coordinates()[k].name == "shaft_flexibility.shape_sensor_a") sensor = k;
  }
  ASSERT_TRUE(magnet >= 0 && sensor >= 0);
  for (const double step : {-0.5, -0.1, 0.1, 0.5}) {
    Eigen::VectorXd x = space.start();
    x[magnet] += step;
    x[sensor] -= step;
    const auto moved = space.model(x).effects.back().values;
    EXPECT_NEAR(moved[2] / given[2], std::exp(-step), 0.02) << "a change by a factor";
    EXPECT_NEAR(moved[2] * moved[4], given[2] * given[4], 0.01 * given[2] * given[4]) << "and the product stays";
  }
  Eigen::MatrixXd covariance = Eigen::MatrixXd::Zero(space.size(), space.size());
  covariance(sensor, sensor) = 0.01 * 0.01;
  EXPECT_NEAR(space.effectValues(0, space.start(), covariance)[4].std, 0.01 * 2.3, 0.02 * 0.01 * 2.3);
}

TEST(FitSpaceTest, ARiseGoesByItsLogarithmAndASpeedByItsReciprocal) {
  for (const double at_rest : {0.3, 0.02}) {  // above what slides fast, and below
    const FitSpace space(belief(), {{"velocity_dependent_friction", {at_rest, 0.06, 0.8}}});
    const int rise = space.nuisances(), speed = rise + 2;
    Eigen::VectorXd x = space.start();
    EXPECT_NEAR(x[rise], std::log(std::fabs(at_rest - 0.06)), 1e-12);
    EXPECT_NEAR(x[speed], 1.25, 1e-12);
    // what is seen at one speed alone stays as it is along the valley: ln(rise) - v/v_s
    const double v = 2.5, seen = 0.06 + (at_rest - 0.06) * std::exp(-v / 0.8);
    x[speed] -= 0.5;
    x[rise] -= 0.5 * v;
    const auto moved = space.model(x).effects[0].values;
    EXPECT_NEAR(moved[1] + (moved[0] - moved[1]) * std::exp(-v / moved[2]), seen, 1e-12);
  }
}

TEST(FitSpaceTest, ARiseKnownToAFactorDeviatesByThatFactor) {
  const FitSpace space(belief(), {{"velocity_dependent_friction", {0.08, 0.06, 2.0}}});
  const int rise = space.nuisances(), sliding = rise + 1, speed = rise + 2;
  Eigen::MatrixXd covariance = Eigen::MatrixXd::Zero(space.size(), space.size());
  covariance(rise, rise) = 1.0;
  covariance(sliding, sliding) = 1e-3 * 1e-3;
  covariance(speed, speed) = 0.1 * 0.1;
  const auto values = space.effectValues(0, space.start(), covariance);
  // beside it the share that steps through contact leave open, 1e-4 of each
  EXPECT_NEAR(values[0].std, std::hypot(0.02 * std::expm1(1.0), 1e-3, 0.08e-4), 1e-12) << "0.02 or e times that";
  EXPECT_NEAR(values[1].std, std::hypot(1e-3, 0.06e-4), 1e-12);
  EXPECT_NEAR(values[2].std, std::hypot(1.0 / (0.5 - 0.1) - 2.0, 2e-4), 1e-12);
  const auto sure = space.effectValues(0, space.start(), Eigen::MatrixXd::Zero(space.size(), space.size()));
  EXPECT_NEAR(sure[1].std, 0.06e-4, 1e-12) << "never exact";
}

/// Each by its own logarithm they were stated up to 50 deviations off where runs with contact had been fitted along.
TEST(FitSpaceTest, ABiasCurrentGoesByItsQuotientWithTheAirGap) {
  Model rig = belief();
  rig.rig.amb.max_current_A = 4.0;  // no bias is above it
  const FitSpace space(rig, {{"magnetic_nonlinearity", {2.0, 0.5e-3}}});
  const int quotient = space.nuisances(), gap = quotient + 1;
  Eigen::VectorXd x = space.start();
  const auto from = space.model(x).effects[0].values;
  EXPECT_NEAR(from[0], 2.0, 1e-12);
  EXPECT_NEAR(from[1], 0.5e-3, 1e-15);
  x[gap] += 0.2;
  const auto moved = space.model(x).effects[0].values;
  EXPECT_NEAR(moved[1], 0.5e-3 * std::exp(0.2), 1e-15);
  EXPECT_NEAR(moved[0] / moved[1], from[0] / from[1], 1e-9 * from[0] / from[1]) << "the slope of the magnets' force stays";
  Eigen::MatrixXd covariance = Eigen::MatrixXd::Zero(space.size(), space.size());
  covariance(quotient, quotient) = 3e-3 * 3e-3;
  covariance(gap, gap) = 4e-3 * 4e-3;
  EXPECT_NEAR(space.effectValues(0, space.start(), covariance)[0].std, 2.0 * 5e-3, 1e-12);
  covariance(quotient, gap) = covariance(gap, quotient) = -3e-3 * 4e-3;
  EXPECT_NEAR(space.effectValues(0, space.start(), covariance)[0].std, 2.0 * 1e-3, 1e-12);
}

TEST(FitSpaceTest, ABowIsStatedOnceOfTheTwoWaysToSayIt) {
  const FitSpace space(belief(), {{"shaft_bow", {-4e-6, 2e-6, 2.1}}});
  const auto stated = [&](std::vector<double> values) {
    Eigen::VectorXd x = space.start();
    for (int i = 0; i < 3; ++i) x[space.nuisances() + i] = values[i];
    return space.model(x).effects[0].values;
  };
  const std::vector<double> turned = stated({-4e-6, 2e-6, 2.1});
  EXPECT_DOUBLE_EQ(turned[0], 4e-6);
  EXPECT_DOUBLE_EQ(turned[1], -2e-6);
  EXPECT_NEAR(turned[2], 2.1 - M_PI, 1e-14);
  EXPECT_EQ(stated({4e-6, -2e-6, -1.0}), (std::vector<double>{4e-6, -2e-6, -1.0})) << "the first is positive already";
  EXPECT_GT(stated({1e-8, -2e-6, 0.0})[1], 0.0) << "next to nothing at a: b tells";
  EXPECT_NEAR(stated({4e-6, 0.0, 6.0})[2], 6.0 - 2.0 * M_PI, 1e-14) << "within half a turn";
}

TEST(FitSpaceTest, ACurrentLimitIsNoSharperThanTheNoiseThatRoundsIt) {
  FitSpace space(belief(), {{"current_saturation", {3.0}}});
  const Eigen::MatrixXd sure = Eigen::MatrixXd::Zero(space.size(), space.size());
  EXPECT_EQ(space.effectValues(0, space.start(), sure)[0].std, 0.0);
  space.setCurrentNoise(0.01);
  EXPECT_NEAR(space.effectValues(0, space.start(), sure)[0].std, 0.005, 1e-15);
}

TEST(FitSpaceTest, AModesShapesAreStatedOnceOfTheTwoWaysToSayThem) {
  const std::vector<double> ends = {300.0, 0.01, 0.5, 0.3, 1.2, 0.1, 1.4, 0.7, -0.4};
  std::vector<double> turned = ends;
  for (std::size_t i = 2; i < turned.size(); ++i) turned[i] = -turned[i];
  for (const auto& values : {ends, turned}) {
    const FitSpace space(belief(), {{"shaft_flexibility", values}});
    const std::vector<double> stated = space.model(space.start()).effects[0].values;
    for (std::size_t i = 0; i < ends.size(); ++i) EXPECT_NEAR(stated[i], ends[i], 1e-12 * ends[0]) << i;
  }
  // runs without contact leave those at the auxiliary bearings anywhere
  const FitSpace space(belief(), {{"shaft_flexibility", {300.0, 0.01, 0.5, 0.3, 1.2, 0.1, -9.0, -9.0, -0.4}}});
  EXPECT_GT(space.model(space.start()).effects[0].values[2], 0.0);
}

TEST(FitSpaceTest, ARiseEndsAtItsParametersLimits) {
  const FitSpace space(belief(), {{"velocity_dependent_friction", {0.08, 1.5, 2.0}}});
  Eigen::VectorXd x = space.start();
  x[space.nuisances()] = 5.0;
  EXPECT_EQ(space.model(x).effects[0].values[0], 0.0) << "no negative friction";
}

TEST(FitSpaceTest, AFittedEffectReplacesTheBeliefsAndEachUnbalanceIsItsOwn) {
  Model model = belief();
  model.effects.push_back({"foundation_resonance", {10.0, 20.0, 0.01}});
  model.rig.unbalance.push_back({0.05, 3e-5, -0.2});
  const FitSpace space(model, {{"foundation_resonance", {30.0, 50.0, 0.03}}});
  EXPECT_EQ(space.nuisances(), 6) << "mass, Ki, and moment and phase of two";
  Eigen::VectorXd x = space.start();
  ASSERT_EQ(space.coordinates()[5].name, "unbalance.phase_rad");
  x[5] = 0.9;
  const Model at = space.model(x);
  ASSERT_EQ(at.effects.size(), 1u);
  EXPECT_NEAR(at.effects[0].values[1], 50.0, 1e-12);
  EXPECT_EQ(at.rig.unbalance[0].phase_rad, 0.4);
  EXPECT_EQ(at.rig.unbalance[1].phase_rad, 0.9);
}

}  // namespace
}  // namespace amb_rotor
