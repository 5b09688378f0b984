#include "amb_rotor/integration/dense_products.hpp"

namespace amb_rotor {
namespace {

void byColumns(const double* a, Eigen::Index rows, Eigen::Index columns, const double* x, double* y,
               bool add) {
  const Eigen::Map<const Eigen::MatrixXd> matrix(a, rows, columns);
  const Eigen::Map<const Eigen::VectorXd> vector(x, columns);
  Eigen::Map<Eigen::VectorXd> out(y, rows);
  if (add)
    out.noalias() += matrix * vector;
  else
    out.noalias() = matrix * vector;
}

DenseProduct best() {
#if defined(__x86_64__)
  if (__builtin_cpu_supports("avx512f") && denseProductAvx512() != nullptr) return denseProductAvx512();
  if (__builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma") && denseProductAvx2() != nullptr)
    return denseProductAvx2();
#endif
  return denseProductBaseline();
}
const DenseProduct chosen = best();

}  // namespace

DenseProduct denseProductBaseline() { return byColumns; }

void product(const double* a, Eigen::Index rows, Eigen::Index columns, const double* x, double* y, bool add) {
  chosen(a, rows, columns, x, y, add);
}

}  // namespace amb_rotor
