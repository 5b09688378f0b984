// Harmonic balance against the closed form of the annular rub, and against shooting.
#include "amb_rotor/machine/basic_harmonic_balance.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "amb_rotor/machine/basic_annular_rub.hpp"
#include "amb_rotor/machine/basic_continuation.hpp"
#include "amb_rotor/machine/basic_record.hpp"

namespace amb_rotor {
namespace {

double stateDistance(const BasicState<double>& a, const BasicState<double>& b) {
  return std::hypot(std::hypot(a.x - b.x, a.y - b.y), std::hypot(a.vx - b.vx, a.vy - b.vy));
}

TEST(HarmonicBalance, WithoutContactItIsTheLinearResponse) {
  BasicParameters<double> p;
  p.frequency_ratio = 0.7;
  p.unbalance_phase = 0.4;
  HarmonicBalanceOptions options;
  options.harmonics = 4;
  // From a wrong guess, so that Newton has something to do: it is linear, so one step does it.
  const auto found = harmonicBalance(p, std::vector<BasicState<double>>(16, {0.1, 0.0, 0.0, 0.0}), options);
  ASSERT_TRUE(found.converged) << found.residual;
  EXPECT_EQ(found.iterations, 1);
  const std::complex<double> z =
      std::polar(0.49 * p.eccentricity, 0.4) / std::complex<double>(1.0 - 0.49, p.damping * 0.7);
  // Round-off of sums over 32 instants.
  EXPECT_NEAR(found.state.x, z.real(), 1e-13);
  EXPECT_NEAR(found.state.y, z.imag(), 1e-13);
  EXPECT_NEAR(found.state.vx, -0.7 * z.imag(), 1e-13);
}

TEST(HarmonicBalance, OneHarmonicIsExactForTheAnnularRub) {
  for (double eta : {1.0, 1.05, 1.3}) {
    BasicParameters<double> p;
    p.frequency_ratio = eta;
    for (double radius : annularRubRadii(p)) {
      const auto exact = annularRubState(p, radius);
      std::vector<BasicState<double>> guess;
      for (int i = 0; i < 8; ++i) {  // 3 % too large, turned by 0.02
        const auto s = rotated(exact, 2.0 * M_PI * i / 8 + 0.02);
        guess.push_back({1.03 * s.x, 1.03 * s.y, 0.0, 0.0});
      }
      HarmonicBalanceOptions options;
      options.harmonics = 1;
      const auto found = harmonicBalance(p, guess, options);
      ASSERT_TRUE(found.converged) << eta << " " << radius << " " << found.residual;
      EXPECT_GT(found.iterations, 1);
      // The residual 1e-11 over the smallest eigenvalue of the balance, about 1e-2.
      EXPECT_LT(stateDistance(found.state, exact), 1e-8) << eta << " " << radius;
    }
  }
}

/// The displaced bearing of figure 6.2, settled at this speed.
ContinuationProblem displacedProblem() {
  ContinuationProblem problem;
  problem.parameter = "frequency_ratio";
  problem.parameters = {{"misalignment", 0.62}, {"misalignment_angle_deg", 230.0}};
  return problem;
}

BranchPoint shooting(double eta, int turns) {
  const auto problem = displacedProblem();
  BasicLaneOptions run;
  run.turns_skipped = 960;
  run.turns_kept = 0;
  const auto settled = runBasicLanes({problem.machineAt(eta)}, {{}}, run).end.front();
  ContinuationOptions options;
  options.from = eta - 0.01;
  options.to = eta + 0.01;
  options.first_step = 0.4;
  options.most_points = 1;
  const Branch branch = followBranch(problem, options, eta, settled, turns);
  for (const auto& point : branch.points) {
    if (std::abs(point.parameter - eta) < 1e-12) return point;
  }
  ADD_FAILURE() << "the start is not on the branch";
  return {};
}

double balanceError(double eta, int turns, int harmonics) {
  const BranchPoint point = shooting(eta, turns);
  const auto p = displacedProblem().machineAt(eta);
  const auto record = recordBasic(p, point.state, 0, turns, 256, {});
  EXPECT_GT(record.touch_downs, 0) << "the test is about rubbing motion";
  HarmonicBalanceOptions options;
  options.turns = turns;
  options.harmonics = harmonics * turns;
  const auto found = harmonicBalance(p, record.state, options);
  EXPECT_TRUE(found.converged) << found.residual;
  return stateDistance(found.state, point.state);
}

TEST(HarmonicBalance, AgreesWithShootingOnRubbingMotionsOfOneAndTwoTurns) {
  for (const auto& [eta, turns] : {std::pair{0.91, 1}, {1.05, 2}, {1.1, 2}}) {
    // O(H^-2) at the slope's jumps, with their place between two instants as a factor: not monotone from one
    // H to the next. Seen at 64: 2e-6 to 1.5e-4. From 16 to 64 H^-2 is a factor of 16; seen 12 to 30.
    const double fine = balanceError(eta, turns, 64);
    EXPECT_LT(fine, 2e-4) << eta;
    EXPECT_LT(fine, balanceError(eta, turns, 16) / 8.0) << eta;
  }
}

TEST(HarmonicBalance, AMotionItCannotReachIsAResult) {
  BasicParameters<double> p;
  p.frequency_ratio = 1.02;
  HarmonicBalanceOptions options;
  options.most_iterations = 0;
  EXPECT_FALSE(harmonicBalance(p, {}, options).converged);  // the free motion is larger than the clearance
  options.turns = 0;
  EXPECT_THROW(harmonicBalance(p, {}, options), InputError);
}

TEST(BasicRecord, SamplesAreTheClosedFormWithoutContact) {
  BasicParameters<double> p;
  p.frequency_ratio = 0.7;
  const std::complex<double> z = 0.49 * p.eccentricity / std::complex<double>(1.0 - 0.49, p.damping * 0.7);
  const auto record = recordBasic(p, {z.real(), z.imag(), -0.7 * z.imag(), 0.7 * z.real()}, 3, 2, 64, {});
  ASSERT_EQ(record.phase.size(), 128u);
  for (std::size_t i = 0; i < record.phase.size(); ++i) {
    const auto at = z * std::polar(1.0, record.phase[i]);
    // Steps of at most 4 times the first of 0.05 rad, grown to 0.5: h^4/384 of 0.09.
    EXPECT_NEAR(record.state[i].x, at.real(), 2e-5);
    EXPECT_EQ(record.normal_force[i], 0.0);
  }
}

TEST(BasicRecord, ForceOfTheAnnularRubIsConstant) {
  BasicParameters<double> p;
  p.frequency_ratio = 1.05;
  const double radius = annularRubRadii(p).back();
  const auto record = recordBasic(p, annularRubState(p, radius), 0, 2, 50, {});
  EXPECT_EQ(record.contact_fraction, 1.0);
  for (double force : record.normal_force) {
    // alpha times the interpolation's error of the radius.
    EXPECT_NEAR(force, p.contact_stiffness * (radius - 1.0), 1e-4);
  }
  BasicParameters<double> hertz = p;
  hertz.hertz_stiffness = 16.83;
  hertz.hertz_damping = 1.286;
  EXPECT_NEAR(basicNormalForce(hertz, {0.0, 1.04, 0.0, 0.5}, BasicContact::hertz),
              16.83 * std::pow(0.04, 1.5) * (1.0 + 1.5 * 1.286 * 0.5), 1e-12);
  EXPECT_EQ(basicNormalForce(hertz, {0.0, 1.04, 0.0, -2.0}, BasicContact::hertz), 0.0);  // it does not pull
  EXPECT_EQ(basicNormalForce(hertz, {0.0, 0.96, 0.0, 0.5}, BasicContact::hertz), 0.0);
}

}  // namespace
}  // namespace amb_rotor
