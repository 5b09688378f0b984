// Magnetic nonlinearity and saturation: slopes, symmetry, limits, against the laws written out again.
#include <gtest/gtest.h>

#include "../support/probe.hpp"

namespace amb_rotor {
namespace {

using namespace testing_support;

constexpr double ki = 19.0, ks = 63333.0, i0 = 2.5;

/// Force of bearing a in x at a current and a position.
double force(const Model& model, double current, double position) {
  Probe probe(model);
  probe.beam({position, 0.0, 0.0, 0.0});
  probe.in.force_current[0] = {current, 0.0};
  probe.look();
  EXPECT_EQ(probe.seen.bearing_force[0].y, 0.0);
  return probe.seen.bearing_force[0].x;
}

double slope(const Model& model, double i, double x, double di, double dx) {
  return (force(model, i + di, x + dx) - force(model, i - di, x - dx)) / (2.0 * (di + dx));
}

TEST(EffectMagneticNonlinearity, LawSlopesAndSymmetry) {
  const double s0 = 0.6e-3;
  const Model model = with(levitated(), "magnetic_nonlinearity", {i0, s0});
  for (double i : {-1.0, 0.0, 0.7, 2.0})
    for (double x : {-1e-4, 0.0, 1.5e-4}) {
      const double plus = (1 + i / i0) / (1 - x / s0), minus = (1 - i / i0) / (1 + x / s0);
      EXPECT_NEAR(force(model, i, x), 0.25 * ki * i0 * (plus * plus - minus * minus), 1e-11);
      EXPECT_NEAR(force(model, -i, -x), -force(model, i, x), 1e-11) << "odd";
    }
  // central differences of 1e-3 of the scale: relative error 1e-6
  EXPECT_NEAR(slope(model, 0.0, 0.0, 1e-3, 0.0), ki, 1e-5 * ki);
  EXPECT_NEAR(slope(model, 0.0, 0.0, 0.0, 1e-7), ki * i0 / s0, 1e-5 * ki * i0 / s0) << "in place of Ks";
  EXPECT_GT(slope(model, 0.0, 2e-4, 0.0, 1e-7), 1.3 * ki * i0 / s0) << "grows towards the pole";
}

TEST(EffectMagneticNonlinearity, NetStiffnessForOtherEffectsFollowsItsOwnSlope) {
  // a bow is pushed by k = Ki kp - Ki i0/s0
  const double s0 = 0.6e-3;
  Model model = with(levitated(), "magnetic_nonlinearity", {i0, s0});
  Probe plain(model), bowed(with(model, "shaft_bow", {1e-6, 1e-6, 0.0}));
  const Wrench added = addedWrench(plain, bowed);
  EXPECT_NEAR(added.force.x, 2.0 * (ki * 13850.0 - ki * i0 / s0) * 1e-6, 1e-9);
}

TEST(EffectMagneticNonlinearity, SoftensTheLevitationWithAmplitude) {
  // static load: the balance Ki kp x = law's pull is reached further out than with its slope at the centre
  const double s0 = 0.75e-3, load = 60.0;
  Model model = with(levitated(), "magnetic_nonlinearity", {i0, s0});
  model.rig.controller.kd_A_s_per_m = 16.0;
  model = with(model, "static_load", {load, 0.0});
  const auto run = simulate(model, constantSpeed(0.0, 0.001));
  ASSERT_EQ(run.outcome.status, RunStatus::ok);
  ASSERT_TRUE(run.trajectory.contacts.empty());
  const double x = run.trajectory.position_m[0][0], i = -13850.0 * x;
  const double plus = (1 + i / i0) / (1 - x / s0), minus = (1 - i / i0) / (1 + x / s0);
  EXPECT_NEAR(0.25 * ki * i0 * (plus * plus - minus * minus), -0.5 * load, 1e-6 * load) << "balance";
  EXPECT_GT(std::fabs(x - 0.5 * load / (ki * 13850.0 - ki * i0 / s0)), 1e-8) << "not the linear one";
}

TEST(EffectMagneticSaturation, LawSmallSignalLossAndLargeSignalLimit) {
  const double knee = 0.9, bk = knee / 0.45;
  const Model model = with(levitated(), "magnetic_saturation", {knee});
  const auto flux = [&](double b) { return b / std::pow(1.0 + std::pow(b / bk, 4), 0.25); };
  for (double i : {-2.0, 0.3, 2.4})
    for (double x : {-1e-4, 1e-4}) {
      const double change = i / i0 + ks * x / (ki * i0), plus = flux(1 + change), minus = flux(1 - change);
      EXPECT_NEAR(force(model, i, x), 0.25 * ki * i0 * (plus * plus - minus * minus), 1e-11);
    }
  // d(b~^2/2)/db at 1 is (1 + bk^-4)^(-3/2): the share of Ki that is left
  const double left = std::pow(1.0 + std::pow(bk, -4), -1.5);
  EXPECT_NEAR(slope(model, 0.0, 0.0, 1e-3, 0.0), ki * left, 1e-5 * ki);
  EXPECT_NEAR(slope(model, 0.0, 0.0, 0.0, 1e-7), ks * left, 1e-5 * ks);
  EXPECT_LT(force(model, 2.4, 0.0), 2.4 * ki * left) << "grows less than the linear law";
  EXPECT_NEAR(force(with(levitated(), "magnetic_saturation", {10.0}), 1.0, 0.0), ki, 1e-3 * ki)
      << "far knee: linear";
}

TEST(EffectMagneticSaturation, ActsBehindTheGapLaw) {
  const double knee = 0.9, bk = knee / 0.45, s0 = 0.75e-3, i = 1.2, x = 1e-4;
  Model model = with(levitated(), "magnetic_saturation", {knee});
  model = with(model, "magnetic_nonlinearity", {i0, s0});  // order in the file does not matter
  const auto flux = [&](double b) { return b / std::pow(1.0 + std::pow(b / bk, 4), 0.25); };
  const double plus = flux((1 + i / i0) / (1 - x / s0)), minus = flux((1 - i / i0) / (1 + x / s0));
  EXPECT_NEAR(force(model, i, x), 0.25 * ki * i0 * (plus * plus - minus * minus), 1e-11);
}

TEST(MagneticForce, LinearLawOfBothAxes) {
  Probe probe(levitated());
  probe.beam({1e-5, -3e-5, 0.0, 0.0});
  probe.in.force_current[1] = {0.4, -0.2};
  probe.look();
  EXPECT_NEAR(probe.seen.bearing_force[1].x, ki * 0.4 + ks * 1e-5, 1e-12);
  EXPECT_NEAR(probe.seen.bearing_force[1].y, -ki * 0.2 - ks * 3e-5, 1e-12);
  probe.in.bearing_on[1] = {0.0, 1.0};
  probe.look();
  EXPECT_EQ(probe.seen.bearing_force[1].x, 0.0) << "off: neither Ki i nor Ks x";
  EXPECT_NE(probe.seen.bearing_force[1].y, 0.0);
}

}  // namespace
}  // namespace amb_rotor
