#include "amb_rotor/validation/channel_products.hpp"

#include <algorithm>

namespace amb_rotor {
namespace {

AddProducts bestProducts() {
#if defined(__x86_64__)
  if (__builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512dq") && addProductsAvx512() != nullptr)
    return addProductsAvx512();
  if (__builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma") && addProductsAvx2() != nullptr)
    return addProductsAvx2();
#endif
  return addProductsBaseline();
}

}  // namespace

ChannelProducts::ChannelProducts(int columns)
    : columns_(columns), x_(columns * width, 0.0), sums_(static_cast<std::size_t>(columns) * columns * predicted_channels, 0.0) {}

void ChannelProducts::fillDifference(int k, const double* values, const double* from, const double* scale, long instants) {
  double* to = column(k);
  for (long i = 0; i < instants * predicted_channels; i += predicted_channels)
    for (int c = 0; c < predicted_channels; ++c) to[i + c] = (values[i + c] - from[i + c]) * scale[c];
}

void ChannelProducts::fill(int k, const double* values, const double* scale, long instants) {
  double* to = column(k);
  for (long i = 0; i < instants * predicted_channels; i += predicted_channels)
    for (int c = 0; c < predicted_channels; ++c) to[i + c] = values[i + c] * scale[c];
}

void ChannelProducts::add(long instants) {
  static const AddProducts products = bestProducts();
  products(x_.data(), width, instants, columns_, sums_.data());
}

void ChannelProducts::clear() { std::fill(sums_.begin(), sums_.end(), 0.0); }

Eigen::MatrixXd ChannelProducts::of(int channel) const {
  Eigen::MatrixXd out(columns_, columns_);
  for (int k = 0; k < columns_; ++k)
    for (int l = 0; l <= k; ++l)
      out(k, l) = out(l, k) = sums_[(static_cast<std::size_t>(k) * columns_ + l) * predicted_channels + channel];
  return out;
}

}  // namespace amb_rotor
