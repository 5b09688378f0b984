#include "free_columns.hpp"

#include <algorithm>

#include "amb_rotor/common/shaft.hpp"

namespace amb_rotor {

FreeColumns::FreeColumns(const Recording& rec, std::vector<const float*> frozen, const std::vector<double>& outs,
                         const std::vector<double>& steps, bool offsets_in_loop)
    : rec_(rec), frozen_(std::move(frozen)), outs_(outs), scales_(steps.size()), in_loop_(offsets_in_loop ? 2 * axis_count : 0) {
  for (int c = 0; c < predicted_channels; ++c) {
    weights_[c] = rec.noise[c] > 0.0 ? 1.0 / rec.noise[c] : 0.0;
    for (std::size_t k = 0; k < steps.size(); ++k) scales_[k][c] = weights_[c] / steps[k];
  }
}

void FreeColumns::add(ChannelProducts& sums, long begin, long end) const {
  const std::size_t width = static_cast<std::size_t>(rec_.samples) * predicted_channels;
  for (long from = begin; from < end; from += ChannelProducts::block) {
    const long instants = std::min(ChannelProducts::block, end - from), numbers = instants * predicted_channels;
    const std::size_t at = from * predicted_channels;
    const double* base = outs_.data() + at;
    int k = 0;
    for (const float* known : frozen_) std::copy_n(known + at, numbers, sums.column(k++));
    for (std::size_t lane = 1; lane <= scales_.size(); ++lane)
      sums.fillDifference(k++, base + lane * width, base, scales_[lane - 1].data(), instants);
    for (int o = 0; o < in_loop_; ++o, ++k) {
      const double* shown = rec_.offset_columns.data() + at * in_loop_ + o;
      for (long i = 0; i < numbers; ++i) sums.column(k)[i] = shown[i * in_loop_] * weights_[i % predicted_channels];
    }
    for (long i = 0; i < instants; ++i) {
      const double time = static_cast<double>(from + i) / rec_.samples - 0.5;
      for (int c = 0; c < predicted_channels; ++c) {
        sums.column(k)[i * predicted_channels + c] = weights_[c];
        sums.column(k + 1)[i * predicted_channels + c] = weights_[c] * time;
      }
    }
    sums.fillDifference(k + 2, rec_.measured.data() + at, base, weights_.data(), instants);
    sums.add(instants);
  }
}

ChannelProducts FreeColumns::products() const {
  ChannelProducts sums(size());
  add(sums, 0, rec_.samples);
  return sums;
}

Eigen::MatrixXd FreeColumns::blockProducts(long length, const std::array<Eigen::VectorXd, predicted_channels>& taken,
                                           const std::array<Eigen::MatrixXd, predicted_channels>& give) const {
  Eigen::MatrixXd out = Eigen::MatrixXd::Zero(give[0].rows(), (rec_.samples + length - 1) / length);
  ChannelProducts sums(size());
  for (long block = 0; block < out.cols(); ++block) {
    sums.clear();
    add(sums, block * length, std::min(rec_.samples, (block + 1) * length));
    for (int c = 0; c < predicted_channels; ++c)
      if (weights_[c] > 0.0) out.col(block) += give[c] * (sums.of(c) * taken[c]);
  }
  return out;
}

}  // namespace amb_rotor
