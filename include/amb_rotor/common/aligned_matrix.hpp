#pragma once
// A matrix whose numbers begin at a cache line: packs of eight then cross no line where a column is whole packs long, which
// halves what the first cache is asked for (Eigen aligns to 16 bytes, and a program that uses it elsewhere has to agree on it).
#include <Eigen/Core>
#include <cstddef>
#include <cstdlib>
#include <memory>
#include <new>
#include <utility>

namespace amb_rotor {

/// Column-major, as Eigen's own; a view of numbers that it owns, so that col(), block() and the like do as they do there.
/// Sizes change by setZero() and by assignment only, which allocate.
class AlignedMatrix final : public Eigen::Map<Eigen::MatrixXd> {
  using View = Eigen::Map<Eigen::MatrixXd>;
  static constexpr std::size_t line_bytes = 64;

 public:
  AlignedMatrix() : View(nullptr, 0, 0) {}
  AlignedMatrix(const AlignedMatrix& other) : AlignedMatrix() { *this = static_cast<const View&>(other); }
  AlignedMatrix(AlignedMatrix&& other) noexcept : AlignedMatrix() { swap(other); }
  AlignedMatrix& operator=(AlignedMatrix other) noexcept {
    swap(other);
    return *this;
  }
  template <class Other>
  AlignedMatrix& operator=(const Eigen::MatrixBase<Other>& other) {
    setZero(other.rows(), other.cols());
    View::operator=(other);
    return *this;
  }

  using View::setZero;
  void setZero(Eigen::Index rows, Eigen::Index columns) {
    const std::size_t bytes = sizeof(double) * static_cast<std::size_t>(rows * columns);
    numbers_.reset();
    if (bytes > 0) {
      numbers_.reset(static_cast<double*>(std::aligned_alloc(line_bytes, (bytes + line_bytes - 1) / line_bytes * line_bytes)));
      if (numbers_ == nullptr) throw std::bad_alloc();
    }
    see(numbers_.get(), rows, columns);
    View::setZero();
  }

 private:
  void see(double* numbers, Eigen::Index rows, Eigen::Index columns) { new (static_cast<View*>(this)) View(numbers, rows, columns); }
  void swap(AlignedMatrix& other) noexcept {
    const Eigen::Index own_rows = rows(), own_columns = cols();
    numbers_.swap(other.numbers_);
    see(numbers_.get(), other.rows(), other.cols());
    other.see(other.numbers_.get(), own_rows, own_columns);
  }

  struct Free {
    void operator()(double* numbers) const { std::free(numbers); }
  };
  std::unique_ptr<double[], Free> numbers_;
};

}  // namespace amb_rotor
