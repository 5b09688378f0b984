// Which terms a residual is explained by: against least squares by hand, and where a choice one after the
// other fails. And the line that all runs share.
#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <cmath>
#include <random>

#include "amb_rotor/common/units.hpp"
#include "amb_rotor/validation/common_line.hpp"
#include "amb_rotor/validation/term_search.hpp"

namespace amb_rotor {
namespace {

/// Normal equations of columns against a target.
struct Problem {
  Eigen::MatrixXd h;
  Eigen::VectorXd g;
  Problem(const Eigen::MatrixXd& columns, const Eigen::VectorXd& target)
      : h(columns.transpose() * columns), g(columns.transpose() * target) {}
};

constexpr double roundings = 1e-9;

TEST(TermSearchTest, TwoThatOnlyTogetherExplainAreFoundBehindOneThatAlmostDoes) {
  // target = a + b; c lies close to the target, a and b at 20 degrees from its normal: alone each explains
  // cos^2(70 deg)
  const double small = std::sin(20.0 * pi / 180.0), large = std::cos(20.0 * pi / 180.0);
  Eigen::MatrixXd columns(3, 3);
  columns << small, small, 1.0,  //
      large, -large, 0.3,        //
      0.0, 0.0, 0.2;
  Eigen::VectorXd target(3);
  target << 2.0 * small, 0.0, 0.0;
  const Problem p(columns, target);
  const double whole = target.squaredNorm();
  const double alone = std::pow(columns.col(0).dot(target), 2) / columns.col(0).squaredNorm();
  ASSERT_LT(alone, 0.15 * whole);
  const TermChoice found = bestTerms(p.h, p.g, {}, {0, 1, 2}, {1, 1, 1}, 0.05 * whole, 0.0);
  EXPECT_EQ(found.terms, (std::vector<int>{0, 1}));
  EXPECT_NEAR(found.drop / whole, 1.0, roundings);
  // too dear: then the one that almost does stays
  const TermChoice one = bestTerms(p.h, p.g, {}, {0, 1, 2}, {1, 1, 1}, 0.2 * whole, 0.0);
  EXPECT_EQ(one.terms, std::vector<int>{2});
}

TEST(TermSearchTest, TheDropIsThatOfLeastSquaresBesideTheBase) {
  std::mt19937_64 engine(7);
  std::normal_distribution<double> normal;
  Eigen::MatrixXd columns(200, 9);
  for (double& value : columns.reshaped()) value = normal(engine);
  columns.col(8) = columns.col(0) + 1e-9 * columns.col(8);  // what the base holds already is no term
  Eigen::VectorXd target(200);
  for (double& value : target) value = normal(engine);
  target += 3.0 * columns.col(5) - 2.0 * columns.col(7) + columns.col(3) + 4.0 * columns.col(0);
  const Problem p(columns, target);
  const TermChoice found =
      bestTerms(p.h, p.g, {0, 1}, {2, 3, 4, 5, 6, 7, 8}, std::vector<unsigned>(7, 1), 1.0, 0.0);
  EXPECT_EQ(found.terms, (std::vector<int>{3, 5, 7}));
  const auto left = [&](const std::vector<int>& which) {
    Eigen::MatrixXd some(200, which.size());
    for (std::size_t i = 0; i < which.size(); ++i) some.col(static_cast<long>(i)) = columns.col(which[i]);
    return (target - some * some.colPivHouseholderQr().solve(target)).squaredNorm();
  };
  EXPECT_NEAR(found.drop / (left({0, 1}) - left({0, 1, 3, 5, 7})), 1.0, 1e-6);
  const Eigen::VectorXd solved = solveFor(p.h, p.g, {0, 1, 3, 5, 7});
  EXPECT_NEAR(solved[3], 3.0, 0.4) << "five standard deviations of 1/sqrt(200)";
}

TEST(TermSearchTest, TheBestSubsetsOfASizeComeInOrder) {
  std::mt19937_64 engine(11);
  std::normal_distribution<double> normal;
  Eigen::MatrixXd columns(100, 5);
  for (double& value : columns.reshaped()) value = normal(engine);
  Eigen::VectorXd target = 3.0 * columns.col(4) + 2.0 * columns.col(1) + columns.col(2);
  const Problem p(columns, target);
  const std::vector<int> library = {1, 2, 3, 4};
  const auto drop = [&](const std::vector<int>& which) {
    Eigen::MatrixXd some(100, which.size() + 1);
    some.col(0) = columns.col(0);
    for (std::size_t i = 0; i < which.size(); ++i) some.col(static_cast<long>(i) + 1) = columns.col(which[i]);
    const double base = (target - some.leftCols(1) * some.leftCols(1).colPivHouseholderQr().solve(target)).squaredNorm();
    return base - (target - some * some.colPivHouseholderQr().solve(target)).squaredNorm();
  };
  for (const int size : {1, 2}) {
    const auto best = bestSubsets(p.h, p.g, {0}, library, size, 3);
    ASSERT_EQ(best.size(), 3u);
    EXPECT_EQ(best[0].terms, size == 1 ? std::vector<int>({4}) : std::vector<int>({1, 4}));
    for (std::size_t i = 0; i < best.size(); ++i) {
      EXPECT_NEAR(best[i].drop / drop(best[i].terms), 1.0, 1e-6);
      if (i > 0) {
        EXPECT_LE(best[i].drop, best[i - 1].drop);
      }
    }
  }
  EXPECT_EQ(bestSubsets(p.h, p.g, {0}, library, 1, 10).size(), 4u);
  EXPECT_TRUE(bestSubsets(p.h, p.g, {0}, library, 1, 0).empty());
}

TEST(TermSearchTest, OfEqualsTheOneThatDependsOnLessIsTaken) {
  Eigen::MatrixXd columns(3, 2);
  columns << 1.0, 1.0, 0.0, 0.01, 0.0, 0.0;
  Eigen::VectorXd target(3);
  target << 1.0, 0.011, 0.0;
  const Problem p(columns, target);
  EXPECT_EQ(bestTerms(p.h, p.g, {}, {0, 1}, {1, 1 | 2}, 0.05, 0.01).terms, std::vector<int>{0});
  EXPECT_EQ(bestTerms(p.h, p.g, {}, {0, 1}, {1, 1 | 2}, 0.05, 0.0).terms, std::vector<int>{1});
}

/// Runs of white noise (1) with a line of an amplitude each, at a phase of its own.
std::vector<ResidualRows> runs(const std::vector<double>& seconds, const std::vector<double>& frequency_hz,
                               double amplitude) {
  std::mt19937_64 engine(3);
  std::normal_distribution<double> normal;
  std::vector<ResidualRows> out;
  for (std::size_t r = 0; r < seconds.size(); ++r) {
    ResidualRows rows;
    rows.sample_rate_hz = 5000.0;
    for (int c = 0; c < 4; ++c) {
      std::vector<double> row(static_cast<std::size_t>(seconds[r] * rows.sample_rate_hz));
      for (std::size_t i = 0; i < row.size(); ++i)
        row[i] = normal(engine) +
                 amplitude * std::sin(two_pi * frequency_hz[r] * i / rows.sample_rate_hz + c + 0.7 * r);
      rows.channels.push_back(row);
    }
    out.push_back(rows);
  }
  return out;
}

TEST(CommonLineTest, ALineOfAllRunsIsFoundToItsFrequency) {
  const CommonLine line = commonLine(runs({1.0, 0.4, 1.2}, {47.3, 47.3, 47.3}, 0.5));
  // A sine of amplitude a in noise s of n samples: the frequency's standard deviation is sqrt(6) s/(pi a T
  // sqrt(n)), 0.02 Hz for one channel of 1 s; four channels and three runs halve it twice.
  EXPECT_NEAR(line.frequency_hz, 47.3, 0.05);
  EXPECT_GT(line.prominence, 12.0);
}

TEST(CommonLineTest, LinesOfTheRunsOwnAndPlainNoiseAreNone) {
  EXPECT_EQ(commonLine(runs({1.0, 1.0, 1.0}, {30.0, 47.0, 71.0}, 2.0)).frequency_hz, 0.0)
      << "each run its own speed";
  EXPECT_EQ(commonLine(runs({1.0, 1.0, 1.0}, {30.0, 30.0, 30.0}, 0.0)).frequency_hz, 0.0);
  EXPECT_EQ(commonLine(runs({1.0}, {47.0}, 2.0)).frequency_hz, 0.0)
      << "one run cannot tell the shaft from time";
}

}  // namespace
}  // namespace amb_rotor
