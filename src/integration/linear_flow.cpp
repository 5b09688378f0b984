#include "amb_rotor/integration/linear_flow.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "amb_rotor/common/check.hpp"
#include "amb_rotor/common/complex_eigen.hpp"
#include "amb_rotor/integration/dense_products.hpp"

namespace amb_rotor {
namespace {

/// Eigenvalues below this [1/s] are zero: what drifts freely; the slowest motion of a supported rotor is far
/// above.
constexpr double zero_below = 0.5;
/// Error of A put together again, of its size: eigenvectors that nearly coincide show here.
constexpr double largest_modal_misfit = 1e-9;

/// Share of a row's largest entry up to which two entries that should be equal may differ: round-off.
constexpr double turned_share = 1e-14;

/// Rows of the matrix that makes mechanics, kept together: with 256 columns they fit the first cache, where their second
/// product finds them.
constexpr int block_rows = 16;

/// A diagonal of powers of 2 that evens rows and columns out (Osborne).
Eigen::VectorXd balance(Eigen::MatrixXd& a) {
  const int n = static_cast<int>(a.rows());
  Eigen::VectorXd scale = Eigen::VectorXd::Ones(n);
  for (int pass = 0; pass < 50; ++pass) {
    bool changed = false;
    for (int i = 0; i < n; ++i) {
      double row = 0.0, column = 0.0;
      for (int j = 0; j < n; ++j)
        if (j != i) {
          row += std::abs(a(i, j));
          column += std::abs(a(j, i));
        }
      if (row == 0.0 || column == 0.0) continue;
      const double f = std::exp2(std::round(0.5 * std::log2(row / column)));
      if (f == 1.0) continue;
      scale[i] *= f;
      a.row(i) /= f;
      a.col(i) *= f;
      changed = true;
    }
    if (!changed) break;
  }
  return scale;
}

/// Whether a quarter turn, which takes x to y and y to -x, leaves A as it is but for round-off of a row's entries.
bool isotropic(const Eigen::MatrixXd& a, const std::vector<std::pair<int, int>>& pairs) {
  if (pairs.empty() || 2 * static_cast<Eigen::Index>(pairs.size()) != a.rows()) return false;
  for (const auto& p : pairs) {
    const double least = turned_share * a.row(p.first).cwiseAbs().maxCoeff();
    for (const auto& q : pairs)
      if (!(std::abs(a(p.first, q.first) - a(p.second, q.second)) <= least) ||
          !(std::abs(a(p.first, q.second) + a(p.second, q.first)) <= least))
        return false;
  }
  return true;
}

}  // namespace

LinearFlow::Modes LinearFlow::modesOf(const Eigen::MatrixXd& a) {
  const GeneralEigen eigen = generalEigen(a);
  Modes modes;
  modes.found = eigen.converged;
  modes.vectors.resize(a.rows(), a.rows());
  for (Eigen::Index i = 0; i < a.rows() && modes.found; ++i) {
    const std::complex<double> l = eigen.values[i];
    if (std::abs(l) < zero_below) {
      ++modes.zeros;
    } else if (l.imag() >= 0.0) {
      modes.vectors.col(static_cast<Eigen::Index>(modes.values.size())) = eigen.vectors.col(i);
      modes.values.push_back(l);
      modes.pair.push_back(l.imag() > 0.0);
    }
  }
  return modes;
}

// z = x + j y obeys z' = (A_xx + j A_yx) z. An eigenvector u of that stands for the motion x = Re(u s), y = Im(u s), which
// A has with the vector (u, -j u) and the eigenvalue, or with their conjugates.
LinearFlow::Modes LinearFlow::modesOf(const Eigen::MatrixXd& a, const std::vector<std::pair<int, int>>& pairs) {
  const std::complex<double> j(0.0, 1.0);
  const Eigen::Index half = static_cast<Eigen::Index>(pairs.size());
  Eigen::MatrixXcd turning(half, half);
  for (Eigen::Index r = 0; r < half; ++r)
    for (Eigen::Index c = 0; c < half; ++c)
      turning(r, c) = {a(pairs[r].first, pairs[c].first), a(pairs[r].second, pairs[c].first)};
  const bool still = turning.imag().cwiseAbs().maxCoeff() == 0.0;  // planes apart: the real problem is quicker
  const GeneralEigen eigen = still ? generalEigen(turning.real()) : complexEigen(turning);
  Modes modes;
  modes.found = eigen.converged;
  modes.vectors.resize(a.rows(), half);
  for (Eigen::Index k = 0; k < half && modes.found; ++k) {
    std::complex<double> l = eigen.values[k];
    if (std::abs(l) < zero_below) {
      modes.zeros += 2;
      continue;
    }
    const bool backward = l.imag() < 0.0;
    if (backward) l = std::conj(l);
    const Eigen::Index column = static_cast<Eigen::Index>(modes.values.size());
    for (Eigen::Index i = 0; i < half; ++i) {
      const std::complex<double> x = eigen.vectors(i, k), y = -j * x;
      modes.vectors(pairs[i].first, column) = backward ? std::conj(x) : x;
      modes.vectors(pairs[i].second, column) = backward ? std::conj(y) : y;
    }
    modes.values.push_back(l);
    modes.pair.push_back(true);
  }
  if (!modes.found || modes.zeros > 0) return modes;
  // z = U eta, with eta the complex coordinates or, of backward ones, their conjugates
  const Eigen::MatrixXcd back = solveLuColumns(eigen.vectors, Eigen::MatrixXcd::Identity(half, half));
  modes.misfit = (eigen.vectors * eigen.values.asDiagonal() * back - turning).norm() / turning.norm();
  modes.back.resize(a.rows(), a.rows());
  for (Eigen::Index k = 0; k < half; ++k) {
    const double sign = eigen.values[k].imag() < 0.0 ? -1.0 : 1.0;
    for (Eigen::Index i = 0; i < half; ++i) {
      const std::complex<double> w = back(k, i);
      modes.back(2 * k, pairs[i].first) = w.real();
      modes.back(2 * k, pairs[i].second) = -w.imag();
      modes.back(2 * k + 1, pairs[i].first) = sign * w.imag();
      modes.back(2 * k + 1, pairs[i].second) = sign * w.real();
    }
  }
  return modes;
}

LinearFlow::LinearFlow(const LinearSystem& system) {
  const int n = static_cast<int>(system.a.rows());
  AMB_ROTOR_CHECK(system.b.rows() == n && system.c.cols() == n && system.b.cols() % 2 == 0,
                  "sizes must match");
  Eigen::MatrixXd a = system.a;
  Eigen::VectorXd scale = balance(a);
  for (const auto& pair : system.pairs) scale[pair.second] = scale[pair.first];
  if (!system.pairs.empty()) a = scale.cwiseInverse().asDiagonal() * system.a * scale.asDiagonal();
  const Modes found = isotropic(a, system.pairs) ? modesOf(a, system.pairs) : modesOf(a);
  if (!found.found) {
    reason_ = "no eigenvalues found";
    return;
  }
  zeros_ = found.zeros;
  const std::vector<bool>& pair = found.pair;
  // columns: (Re v, -Im v) of pairs, v of real ones, then the space of the eigenvalue 0
  Eigen::MatrixXd basis(n, n), blocks = Eigen::MatrixXd::Zero(n, n);
  int column = 0;
  std::vector<int> place;
  lambda_.resize(static_cast<int>(found.values.size()));
  for (std::size_t k = 0; k < found.values.size() && column + (pair[k] ? 2 : 1) <= n; ++k) {
    const std::complex<double> l = found.values[k];
    lambda_[static_cast<int>(k)] = l;
    place.push_back(column);
    blocks(column, column) = l.real();
    basis.col(column++) = found.vectors.col(static_cast<int>(k)).real();
    if (!pair[k]) continue;
    blocks(column, column) = l.real();
    blocks(column, column - 1) = l.imag();
    blocks(column - 1, column) = -l.imag();
    basis.col(column++) = -found.vectors.col(static_cast<int>(k)).imag();
  }
  if (column + zeros_ != n) {
    reason_ = "eigenvalues do not come in pairs";
    return;
  }
  chain_.resize(zeros_, zeros_);
  if (zeros_ > 0) {
    const Eigen::MatrixXd square = a * a;
    const SingularValues svd = squareSvd(square);
    const Eigen::MatrixXd null = svd.v.rightCols(zeros_);
    basis.rightCols(zeros_) = null;
    chain_ = null.transpose() * a * null;
    blocks.bottomRightCorner(zeros_, zeros_) = chain_;
  }
  // vectors that do not span the space give infinities here, which the misfit sees
  const bool known = found.back.size() > 0;
  const Eigen::MatrixXd back_to_basis = known ? found.back : inverse(basis);
  const double misfit = known ? found.misfit : (basis * blocks * back_to_basis - a).norm() / a.norm();
  const double longer = zeros_ > 0 ? (chain_ * chain_).norm() : 0.0;
  if (!(misfit < largest_modal_misfit) || !(longer < largest_modal_misfit * std::max(1.0, a.norm()))) {
    reason_ = "eigenvectors nearly coincide";
    return;
  }
  const int modes = static_cast<int>(found.values.size()), size = 2 * modes + zeros_;
  to_modal_ = Eigen::MatrixXd::Zero(size, n);
  from_modal_ = Eigen::MatrixXd::Zero(n, size);
  const Eigen::MatrixXd back = back_to_basis * scale.cwiseInverse().asDiagonal(),
                        forth = scale.asDiagonal() * basis;
  for (int k = 0; k < modes; ++k) {
    to_modal_.row(k) = back.row(place[static_cast<std::size_t>(k)]);
    from_modal_.col(k) = forth.col(place[static_cast<std::size_t>(k)]);
    if (!pair[static_cast<std::size_t>(k)]) continue;
    to_modal_.row(modes + k) = back.row(place[static_cast<std::size_t>(k)] + 1);
    from_modal_.col(modes + k) = forth.col(place[static_cast<std::size_t>(k)] + 1);
  }
  to_modal_.bottomRows(zeros_) = back.bottomRows(zeros_);
  from_modal_.rightCols(zeros_) = forth.rightCols(zeros_);
  splitRows(system.a);
  b_ = to_modal_ * system.b;
  c_ = system.c * from_modal_;
  // what a mode carries from an input to the outputs, from the first that it reaches to the last: many reach few
  const int reached = outputs();
  carried_real_.resize(reached, modes * inputs());
  carried_imaginary_.resize(reached, modes * inputs());
  for (int k = 0; k < modes; ++k) {
    transfer_begin_.push_back(static_cast<int>(transfer_.size()));
    const double most = std::hypot(b_.row(k).cwiseAbs().maxCoeff(), b_.row(modes + k).cwiseAbs().maxCoeff()) *
                        std::hypot(c_.col(k).cwiseAbs().maxCoeff(), c_.col(modes + k).cwiseAbs().maxCoeff());
    for (int i = 0; i < inputs(); ++i) {
      int first = reached, last = -1;
      for (int o = 0; o < reached; ++o) {
        const std::complex<double> q = std::complex<double>(c_(o, k), -c_(o, modes + k)) *
                                       std::complex<double>(b_(k, i), b_(modes + k, i));
        const int at = k * inputs() + i;
        carried_real_(o, at) = q.real();
        carried_imaginary_(o, at) = q.imag();
        if (!(std::abs(q) > 1e-17 * most)) continue;
        first = std::min(first, o);
        last = o;
      }
      if (last >= first) transfer_.push_back({i, first, last - first + 1});
    }
  }
  transfer_begin_.push_back(static_cast<int>(transfer_.size()));
  const auto c = c_.rightCols(zeros_);
  const auto b = b_.bottomRows(zeros_);
  later_seen_ = c * chain_;
  later_pushed_ = chain_ * b;
  drifts_ = c * b;
  later_drifts_ = c * later_pushed_;
}

void LinearFlow::splitRows(const Eigen::MatrixXd& a) {
  const int n = static_cast<int>(a.rows());
  std::vector<bool> taken(static_cast<std::size_t>(n), false);
  for (int i = 0; i < n; ++i) {
    int only = -1, entries = 0;
    for (int j = 0; j < n; ++j)
      if (a(i, j) != 0.0) {
        only = j;
        ++entries;
      }
    if (entries != 1 || a(i, only) != 1.0 || only == i || taken[static_cast<std::size_t>(i)] ||
        taken[static_cast<std::size_t>(only)])
      continue;
    places_.push_back({i, only});
    taken[static_cast<std::size_t>(i)] = taken[static_cast<std::size_t>(only)] = true;
  }
  for (int i = 0; i < n; ++i)
    if (!taken[static_cast<std::size_t>(i)]) others_.push_back(i);
  const int blocks = (static_cast<int>(places_.size()) + block_rows - 1) / block_rows;
  place_rows_.setZero(block_rows, blocks * size());
  for (int i = 0; i < static_cast<int>(places_.size()); ++i)
    place_rows_.block(i % block_rows, i / block_rows * size(), 1, size()) = from_modal_.row(places_[i].place);
  other_rows_.setZero(static_cast<int>(others_.size()), size());
  for (std::size_t i = 0; i < others_.size(); ++i)
    other_rows_.row(static_cast<int>(i)) = from_modal_.row(others_[i]);
  place_.setZero(block_rows * blocks);
  rate_ = place_;
  other_.setZero(other_rows_.rows());
}

void LinearFlow::mechanics(const Eigen::VectorXd& s, Eigen::VectorXd& turned, Eigen::VectorXd& y) const {
  const int n = modes();
  for (int k = 0; k < n; ++k) {
    const double re = lambda_[k].real(), im = lambda_[k].imag();
    turned[k] = re * s[k] - im * s[n + k];
    turned[n + k] = im * s[k] + re * s[n + k];
  }
  if (zeros_ > 0) turned.tail(zeros_).noalias() = chain_ * s.tail(zeros_);
  for (int first = 0; first < static_cast<int>(place_.size()); first += block_rows) {
    const double* block = place_rows_.col(first / block_rows * size()).data();
    product(block, block_rows, size(), s.data(), &place_[first], false);
    product(block, block_rows, size(), turned.data(), &rate_[first], false);
  }
  for (std::size_t i = 0; i < places_.size(); ++i) {
    y[places_[i].place] = place_[static_cast<int>(i)];
    y[places_[i].rate] = rate_[static_cast<int>(i)];
  }
  if (others_.empty()) return;
  product(other_rows_, s, other_);
  for (std::size_t i = 0; i < others_.size(); ++i) y[others_[i]] = other_[static_cast<int>(i)];
}

void LinearFlow::rest(const Eigen::VectorXd& g, Eigen::VectorXd& s, Eigen::VectorXd& drift) const {
  s.setZero(size());
  for (int k = 0; k < modes(); ++k) {
    const std::complex<double> z = -std::complex<double>(g[k], g[modes() + k]) / lambda_[k];
    s[k] = z.real();
    s[modes() + k] = z.imag();
  }
  drift = g.tail(zeros_);
}

void LinearFlow::harmonic(const Eigen::VectorXd& gc, const Eigen::VectorXd& gs, double speed,
                          Eigen::VectorXd& c, Eigen::VectorXd& s) const {
  const std::complex<double> i(0.0, 1.0);
  c.setZero(size());
  s.setZero(size());
  for (int k = 0; k < modes(); ++k) {
    const std::complex<double> a(gc[k], gc[modes() + k]), b(gs[k], gs[modes() + k]);
    const std::complex<double> p = 0.5 * (a - i * b) / (i * speed - lambda_[k]),
                               q = 0.5 * (a + i * b) / (-i * speed - lambda_[k]);
    const std::complex<double> cosine = p + q, sine = i * (p - q);
    c[k] = cosine.real();
    c[modes() + k] = cosine.imag();
    s[k] = sine.real();
    s[modes() + k] = sine.imag();
  }
  if (zeros_ == 0) return;
  // W ns = J nc + gc,  -W nc = J ns + gs, with J J = 0
  const Eigen::VectorXd g0 = gc.tail(zeros_), g1 = gs.tail(zeros_);
  c.tail(zeros_) = -g1 / speed - chain_ * g0 / (speed * speed);
  s.tail(zeros_) = g0 / speed - chain_ * g1 / (speed * speed);
}

Eigen::VectorXd LinearFlow::decaying(const Eigen::VectorXd& g, double rate) const {
  Eigen::VectorXd s = Eigen::VectorXd::Zero(size());
  for (int k = 0; k < modes(); ++k) {
    const std::complex<double> z = std::complex<double>(g[k], g[modes() + k]) / (-rate - lambda_[k]);
    s[k] = z.real();
    s[modes() + k] = z.imag();
  }
  if (zeros_ > 0) {
    const Eigen::VectorXd g0 = g.tail(zeros_);
    s.tail(zeros_) = -g0 / rate + chain_ * g0 / (rate * rate);
  }
  return s;
}

void LinearFlow::factors(double t, double* real, double* imaginary) const {
  for (int k = 0; k < modes(); ++k) {
    const double size = std::exp(lambda_[k].real() * t), angle = lambda_[k].imag() * t;
    real[k] = size * std::cos(angle);
    imaginary[k] = size * std::sin(angle);
  }
}

void LinearFlow::move(const double* real, const double* imaginary, double t, double* s) const {
  const int n = modes();
  for (int k = 0; k < n; ++k) {
    const double a = s[k], b = s[n + k];
    s[k] = real[k] * a - imaginary[k] * b;
    s[n + k] = imaginary[k] * a + real[k] * b;
  }
  if (zeros_ == 0) return;
  double* z = s + 2 * n;
  double before[64];
  for (int i = 0; i < zeros_; ++i) before[i] = z[i];
  for (int j = 0; j < zeros_; ++j) {
    const double* column = &chain_(0, j);
    const double along = t * before[j];
    for (int i = 0; i < zeros_; ++i) z[i] += along * column[i];
  }
}

}  // namespace amb_rotor
