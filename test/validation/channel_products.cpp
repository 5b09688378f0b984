// Sums of products of columns, channel by channel, against Eigen's.
#include "amb_rotor/validation/channel_products.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <random>
#include <vector>

namespace amb_rotor {
namespace {

/// Columns of random numbers, instant by instant.
std::vector<Eigen::ArrayXd> randomColumns(int columns, long instants) {
  std::mt19937 random(columns);
  std::normal_distribution<double> number;
  std::vector<Eigen::ArrayXd> out;
  for (int k = 0; k < columns; ++k)
    out.push_back(Eigen::ArrayXd::NullaryExpr(instants * predicted_channels, [&] { return number(random); }));
  return out;
}

double productOf(const std::vector<Eigen::ArrayXd>& x, int k, int l, int channel) {
  double sum = 0.0;
  for (long at = channel; at < x[k].size(); at += predicted_channels) sum += x[k][at] * x[l][at];
  return sum;
}

// Sums of some 150 products of order 1 in another order: 1e-12 is a thousand times what round-off makes of them.
constexpr double product_round_off = 1e-12;

TEST(ChannelProducts, AreThoseOfTheColumnsWhateverTheirNumber) {
  const long instants = 2 * ChannelProducts::block + 17;  // the last block is not full
  for (int columns = 1; columns <= 14; ++columns) {
    const auto x = randomColumns(columns, instants);
    ChannelProducts sums(columns);
    for (long from = 0; from < instants; from += ChannelProducts::block) {
      const long now = std::min(ChannelProducts::block, instants - from);
      const Eigen::ArrayXd ones = Eigen::ArrayXd::Ones(predicted_channels);
      for (int k = 0; k < columns; ++k) sums.fill(k, x[k].data() + from * predicted_channels, ones.data(), now);
      sums.add(now);
    }
    for (int c = 0; c < predicted_channels; ++c) {
      const Eigen::MatrixXd of = sums.of(c);
      for (int k = 0; k < columns; ++k)
        for (int l = 0; l < columns; ++l) EXPECT_NEAR(of(k, l), productOf(x, k, l, c), product_round_off) << columns;
    }
  }
}

TEST(ChannelProducts, EveryInstructionSetAgrees) {
  const long instants = ChannelProducts::block, stride = instants * predicted_channels;
  std::vector<AddProducts> sets = {addProductsBaseline()};
  if (__builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma")) sets.push_back(addProductsAvx2());
  if (__builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512dq")) sets.push_back(addProductsAvx512());
  const int columns = 11;
  const auto x = randomColumns(columns, instants);
  std::vector<double> numbers;
  for (const auto& column : x) numbers.insert(numbers.end(), column.data(), column.data() + column.size());
  for (const AddProducts add : sets) {
    if (add == nullptr) continue;
    std::vector<double> sums(columns * columns * predicted_channels, 0.0);
    add(numbers.data(), stride, instants, columns, sums.data());
    for (int k = 0; k < columns; ++k)
      for (int l = 0; l <= k; ++l)
        for (int c = 0; c < predicted_channels; ++c)
          EXPECT_NEAR(sums[(k * columns + l) * predicted_channels + c], productOf(x, k, l, c), product_round_off);
  }
}

TEST(ChannelProducts, DifferencesAreOverTheirScales) {
  const auto x = randomColumns(2, 3);
  std::array<double, predicted_channels> scale;
  for (int c = 0; c < predicted_channels; ++c) scale[c] = 0.5 * c;
  ChannelProducts sums(1);
  sums.fillDifference(0, x[0].data(), x[1].data(), scale.data(), 3);
  sums.add(3);
  for (int c = 0; c < predicted_channels; ++c) {
    double expected = 0.0;
    for (int i = 0; i < 3; ++i) expected += std::pow(0.5 * c * (x[0][8 * i + c] - x[1][8 * i + c]), 2);
    EXPECT_NEAR(sums.of(c)(0, 0), expected, product_round_off);
  }
  sums.clear();
  EXPECT_EQ(sums.of(3)(0, 0), 0.0);
}

}  // namespace
}  // namespace amb_rotor
