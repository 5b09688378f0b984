// The modes of a linear system: put together again they are the system, whichever way they were found.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "amb_rotor/integration/linear_flow.hpp"

namespace amb_rotor {
namespace {

constexpr int shaft_modes = 4;

/// x, y, x', y' of a rotor with a pull from its axis: modes that swing, turn, are damped, and one that runs away.
LinearSystem rotorSystem(double speed, double pull, double anisotropy) {
  constexpr int m = shaft_modes;
  LinearSystem system;
  system.a = Eigen::MatrixXd::Zero(4 * m, 4 * m);
  system.a.topRightCorner(2 * m, 2 * m).setIdentity();
  const double frequency[m] = {0.0, 90.0, 2e3, 3e4}, phi[m] = {0.5, 0.3, -0.4, 0.6};
  for (int plane = 0; plane < 2; ++plane)
    for (int i = 0; i < m; ++i) {
      const int row = (2 + plane) * m + i, first = plane * m;
      for (int j = 0; j < m; ++j) {
        const double own = plane == 0 ? pull + anisotropy : pull;
        system.a(row, first + j) = own * phi[i] * phi[j] - (i == j ? frequency[i] * frequency[i] : 0.0);
        const double g = 0.05 * (1.0 + (i == j ? i : 0.0)) * speed;
        system.a(row, (3 - plane) * m + j) = plane == 0 ? -g : g;
      }
      system.a(row, row) -= 5.0 + 0.01 * frequency[i];
    }
  system.b = Eigen::MatrixXd::Random(4 * m, 4);
  system.c = Eigen::MatrixXd::Random(8, 4 * m);
  return system;
}

LinearSystem paired(LinearSystem system) {
  for (int k = 0; k < shaft_modes; ++k)
    for (const int first : {0, 2 * shaft_modes}) system.pairs.emplace_back(first + k, first + shaft_modes + k);
  return system;
}

/// Largest entry of A M - M (its blocks), over the size of A, and of M times its inverse less 1.
double misfit(const LinearFlow& flow, const Eigen::MatrixXd& a) {
  const Eigen::MatrixXd& m = flow.fromModal();
  const int n = flow.modes(), zeros = flow.size() - 2 * n;
  Eigen::MatrixXd turned = Eigen::MatrixXd::Zero(m.rows(), m.cols());
  for (int k = 0; k < n; ++k) {
    const std::complex<double> l = flow.eigenvalues()[k];
    turned.col(k) = l.real() * m.col(k) + l.imag() * m.col(n + k);
    turned.col(n + k) = l.real() * m.col(n + k) - l.imag() * m.col(k);
  }
  turned.rightCols(zeros) = m.rightCols(zeros) * flow.chain();
  return std::max((turned - a * m).norm() / (a.norm() * m.norm()),
                  (m * flow.toModal() - Eigen::MatrixXd::Identity(a.rows(), a.rows())).norm());
}

std::vector<double> sortedImaginary(const LinearFlow& flow) {
  std::vector<double> out;
  for (int k = 0; k < flow.modes(); ++k) out.push_back(flow.eigenvalues()[k].imag());
  std::sort(out.begin(), out.end());
  return out;
}

TEST(LinearFlowModes, HalfTheProblemHasTheSameModes) {
  for (const double speed : {0.0, 300.0})
    for (const double pull : {-4e4, 3e4}) {
      const LinearSystem system = rotorSystem(speed, pull, 0.0);
      const LinearFlow whole(system), half(paired(system));
      ASSERT_TRUE(whole.usable()) << whole.reason();
      ASSERT_TRUE(half.usable()) << half.reason();
      // round-off of A (1e9) in its slowest modes (100 rad/s), which balancing evens out
      EXPECT_LT(misfit(whole, system.a), 1e-10) << speed << " " << pull;
      EXPECT_LT(misfit(half, system.a), 1e-10) << speed << " " << pull;
      EXPECT_EQ(half.modes(), 2 * shaft_modes) << "each of them stands for a pair";
      std::vector<double> found = sortedImaginary(half), expected = sortedImaginary(whole);
      // a root without oscillation stands alone in the one and with its twin in the other
      while (expected.size() > found.size()) expected.erase(expected.begin());
      for (std::size_t k = 0; k < expected.size(); ++k) EXPECT_NEAR(found[k], expected[k], 1e-6 * (1.0 + expected[k]));
    }
}

TEST(LinearFlowModes, AMachineWithAPreferredDirectionIsTakenWhole) {
  const LinearSystem system = paired(rotorSystem(300.0, -4e4, -1e3));
  const LinearFlow flow(system);
  ASSERT_TRUE(flow.usable()) << flow.reason();
  EXPECT_LT(misfit(flow, system.a), 1e-10);
}

}  // namespace
}  // namespace amb_rotor
