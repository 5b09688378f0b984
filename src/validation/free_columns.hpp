#pragma once
// The columns of least squares over a run that is predicted in one piece, over the noise: derivatives, offsets, residual.
#include <array>
#include <vector>

#include "amb_rotor/validation/channel_products.hpp"
#include "amb_rotor/validation/recording.hpp"

namespace amb_rotor {

/// In this order: `frozen` (known already), differences of the predicted lanes from the first over their steps, the
/// recording's columns of offsets in the loop (8, if it has them), 1, t (-0.5 to 0.5 over the run), residual.
class FreeColumns {
 public:
  /// @param frozen  each samples * predicted_channels
  /// @param outs    the lanes' predictions, one after the other, each of samples * predicted_channels
  /// @param steps   of lane 1, 2, ...
  /// All must outlive this.
  FreeColumns(const Recording& rec, std::vector<const float*> frozen, const std::vector<double>& outs,
              const std::vector<double>& steps, bool offsets_in_loop);

  int size() const { return residual() + 1; }
  int one() const { return residual() - 2; }
  int residual() const { return static_cast<int>(frozen_.size() + scales_.size()) + in_loop_ + 2; }

  /// Products over all samples.
  ChannelProducts products() const;
  /// For each stretch of `length` samples (the last may be shorter) the product of every column with the combination
  /// `taken[channel]` of all columns, summed over channels as `give` says: give[channel] is out x size().
  Eigen::MatrixXd blockProducts(long length, const std::array<Eigen::VectorXd, predicted_channels>& taken,
                                const std::array<Eigen::MatrixXd, predicted_channels>& give) const;

 private:
  void add(ChannelProducts& sums, long from, long to) const;

  const Recording& rec_;
  std::vector<const float*> frozen_;
  const std::vector<double>& outs_;
  std::vector<std::array<double, predicted_channels>> scales_;  // of each lane's difference
  std::array<double, predicted_channels> weights_;              // 1/noise; 0: does not count
  int in_loop_;  // how many columns
};

}  // namespace amb_rotor
