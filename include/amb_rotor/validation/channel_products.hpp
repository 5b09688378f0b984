#pragma once
// Sums of products of columns over a recording's instants, kept apart by channel:
//   P[c](k, l) = sum over instants i of x[k][i][c] x[l][i][c]
// which is what least squares with one noise a channel needs of its columns (derivatives, residual, 1 and t). By the widest
// instructions that this processor has, all channels side by side; sums are in another order from set to set, so results
// differ by round-off between processors.
#include <Eigen/Core>
#include <vector>

#include "amb_rotor/validation/predict.hpp"

namespace amb_rotor {

class ChannelProducts {
 public:
  /// Instants that are filled and added at a time. Not a power of two: columns would share a cache's few lines.
  static constexpr long block = 60;

  explicit ChannelProducts(int columns);
  /// Where column k of the block is to be written: block * predicted_channels numbers, instant by instant.
  double* column(int k) { return x_.data() + k * width; }
  /// Writes scale[c] (values - from) there, of `instants` instants; `values` and `from` instant by instant.
  void fillDifference(int k, const double* values, const double* from, const double* scale, long instants);
  /// Likewise scale[c] values.
  void fill(int k, const double* values, const double* scale, long instants);
  /// Adds what the first `instants` of the block give.
  void add(long instants);
  void clear();
  /// P of one channel, symmetric: columns x columns.
  Eigen::MatrixXd of(int channel) const;

 private:
  static constexpr long width = block * predicted_channels;
  int columns_;
  std::vector<double> x_, sums_;  // sums: channel by channel within a pair
};

/// Adds the products of `columns` columns, `stride` numbers apart, over `instants` instants to sums[(k * columns + l) *
/// predicted_channels + c], l <= k (others hold anything).
using AddProducts = void (*)(const double* x, long stride, long instants, int columns, double* sums);
AddProducts addProductsBaseline();
AddProducts addProductsAvx2();    ///< null: not in this build
AddProducts addProductsAvx512();  ///< likewise

}  // namespace amb_rotor
