// Whiteness tests against white and coloured noise of known correlation.
#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "amb_rotor/analysis/whiteness.hpp"
#include "amb_rotor/common/error.hpp"

namespace amb_rotor {
namespace {

std::vector<double> noise(std::size_t n, double memory, unsigned seed) {
  std::mt19937 generator(seed);
  std::normal_distribution<double> normal;
  std::vector<double> u(n);
  double last = 0.0;
  for (double& value : u) value = last = memory * last + normal(generator);
  return u;
}

TEST(AnalysisWhiteness, ChiSquaredTable) {
  // Published 5 % and 1 % points of chi-squared, four digits.
  EXPECT_NEAR(chiSquaredExceedance(3.841, 1), 0.05, 1e-4);
  EXPECT_NEAR(chiSquaredExceedance(18.31, 10), 0.05, 1e-4);
  EXPECT_NEAR(chiSquaredExceedance(37.57, 20), 0.01, 1e-4);
  EXPECT_EQ(chiSquaredExceedance(0.0, 3), 1.0);
}

TEST(AnalysisWhiteness, AutocorrelationOfAFirstOrderProcess) {
  const auto r = autocorrelation(noise(20000, 0.6, 1), 3);
  ASSERT_EQ(r.size(), 4u);
  EXPECT_DOUBLE_EQ(r[0], 1.0);
  // 0.6^k; standard error below sqrt((1 + 0.36)/(1 - 0.36)/n) = 0.0103; four of them.
  for (int k = 1; k <= 3; ++k) EXPECT_NEAR(r[k], std::pow(0.6, k), 0.04);
  EXPECT_TRUE(autocorrelation(std::vector<double>(50, 0.1), 3).empty());
}

TEST(AnalysisWhiteness, LjungBoxByHand) {
  // u = 1, -1, 1, -1: r_1 = -3/4; Q = 4 * 6 * (9/16)/3 = 4.5 with 1 degree: P = erfc(sqrt(4.5/2)) = 0.0339.
  const LjungBox test = ljungBoxTest({1, -1, 1, -1}, 1);
  ASSERT_TRUE(test.valid);
  EXPECT_NEAR(test.statistic, 4.5, 1e-12);
  EXPECT_NEAR(test.p_value, std::erfc(1.5), 1e-12);
}

TEST(AnalysisWhiteness, RejectsAtItsLevelAndNotMore) {
  int rejected = 0, coloured = 0;
  for (unsigned seed = 0; seed < 400; ++seed) {
    rejected += ljungBoxTest(noise(500, 0.0, seed), 20).p_value < 0.05;
    coloured += ljungBoxTest(noise(500, 0.3, seed), 20).p_value < 0.05;
  }
  // Binomial: 20 of 400 with standard deviation 4.4; four of them.
  EXPECT_NEAR(rejected, 20, 18);
  EXPECT_GT(coloured, 390);  // r_1 = 0.3 is 6.7 standard errors
  EXPECT_FALSE(ljungBoxTest(noise(10, 0.0, 1), 20).valid);
  EXPECT_FALSE(ljungBoxTest(noise(100, 0.0, 1), 2, 2).valid);
}

TEST(AnalysisWhiteness, BootstrapOfTheMeanOverBlocks) {
  // 200 blocks of 5 equal values: the standard error of the mean is that of 200 values, not of 1000.
  const auto levels = noise(200, 0.0, 7);
  std::vector<std::vector<double>> blocks;
  for (double level : levels) blocks.emplace_back(5, level);
  const auto mean = [](const std::vector<double>& v) {
    double sum = 0.0;
    for (double value : v) sum += value;
    return sum / static_cast<double>(v.size());
  };
  BootstrapOptions options;
  options.replicates = 2000;
  const BootstrapResult result = blockBootstrap(blocks, mean, options);
  // 1/sqrt(200) = 0.0707; the sample's own scatter 5 %, the bootstrap's 1.6 %: 20 % is four of both.
  EXPECT_NEAR(result.standard_error, 0.0707, 0.0141);
  EXPECT_LT(result.low, result.value);
  EXPECT_GT(result.high, result.value);
  EXPECT_NEAR((result.high - result.low) / (2.0 * 1.96 * result.standard_error), 1.0, 0.1);
  EXPECT_EQ(blockBootstrap(blocks, mean, options).standard_error, result.standard_error);
  EXPECT_THROW(blockBootstrap({{1.0}}, mean), InputError);
}

TEST(AnalysisWhiteness, TurnBlocksAreWholeTurns) {
  std::vector<double> angle, value;
  for (int i = 0; i < 35; ++i) {
    angle.push_back(2.0 * M_PI * (i + 0.5) / 10.0 + 2.0);
    value.push_back(i);
  }
  const auto blocks = turnBlocks(angle, value);
  // Begins at 0.37 turns: the first part and the last are left out.
  ASSERT_EQ(blocks.size(), 2u);
  EXPECT_EQ(blocks[0].size(), 10u);
  EXPECT_EQ(blocks[0].front(), 7.0);
  EXPECT_EQ(turnBlocks({0.0, 3.0, 6.0, 9.0}, {1, 2, 3, 4}).size(), 1u);  // begins at 0: whole
}

}  // namespace
}  // namespace amb_rotor
