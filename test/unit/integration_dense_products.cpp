// Products by every instruction set that this processor has, against Eigen's.
#include <gtest/gtest.h>

#include <Eigen/Core>
#include <cstdint>
#include <string>
#include <vector>

#include "amb_rotor/common/aligned_matrix.hpp"
#include "amb_rotor/integration/dense_products.hpp"

namespace amb_rotor {
namespace {

struct Set {
  std::string name;
  DenseProduct product;
};

std::vector<Set> setsHere() {
  std::vector<Set> sets = {{"baseline", denseProductBaseline()}};
#if defined(__x86_64__)
  if (__builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma") && denseProductAvx2() != nullptr)
    sets.push_back({"AVX2", denseProductAvx2()});
  if (__builtin_cpu_supports("avx512f") && denseProductAvx512() != nullptr)
    sets.push_back({"AVX-512", denseProductAvx512()});
#endif
  return sets;
}

TEST(DenseProducts, AllSetsGiveEigensProductAndTouchNothingElse) {
  constexpr double guard = 1234.5;
  for (const Set& set : setsHere())
    for (int rows : {0, 1, 3, 4, 7, 8, 9, 16, 24, 31, 32, 40, 41, 47, 48, 49, 63, 96, 101})
      for (int columns : {0, 1, 2, 3, 5, 8, 13, 50})
        for (const bool add : {false, true}) {
          const Eigen::MatrixXd a = Eigen::MatrixXd::Random(rows, columns);
          const Eigen::VectorXd x = Eigen::VectorXd::Random(columns);
          Eigen::VectorXd y = Eigen::VectorXd::Random(rows + 1);
          y[rows] = guard;
          Eigen::VectorXd expected = a * x;
          if (add) expected += y.head(rows);
          set.product(a.data(), rows, columns, x.data(), y.data(), add);
          // sums of up to 50 products below 1 in another order
          for (int i = 0; i < rows; ++i)
            ASSERT_NEAR(y[i], expected[i], 50 * 2.3e-16 * 2) << set.name << " " << rows << " x " << columns << " row " << i;
          ASSERT_EQ(y[rows], guard) << set.name << " " << rows << " x " << columns;
        }
}

TEST(AlignedMatrixTest, BeginsAtALineAndIsAMatrixToEigen) {
  const Eigen::MatrixXd plain = Eigen::MatrixXd::Random(13, 7);
  AlignedMatrix kept;
  EXPECT_EQ(kept.size(), 0);
  kept = plain;
  const auto offset = [](const AlignedMatrix& m) { return reinterpret_cast<std::uintptr_t>(m.data()) % 64; };
  EXPECT_EQ(offset(kept), 0u);
  EXPECT_EQ(kept, plain);
  AlignedMatrix copy = kept;
  EXPECT_EQ(offset(copy), 0u);
  EXPECT_NE(copy.data(), kept.data());
  copy(2, 3) = 5.0;
  EXPECT_EQ(kept, plain) << "a copy has numbers of its own";
  const double* const numbers = copy.data();
  const AlignedMatrix moved = std::move(copy);
  EXPECT_EQ(moved.data(), numbers);
  EXPECT_EQ(moved(2, 3), 5.0);
  kept = 2.0 * plain.transpose();
  EXPECT_EQ(kept, 2.0 * plain.transpose());
  kept.setZero(3, 2);
  EXPECT_EQ(kept, Eigen::MatrixXd::Zero(3, 2));
  kept.setZero(0, 4);
  EXPECT_EQ(kept.cols(), 4);
}

}  // namespace
}  // namespace amb_rotor
