#include "amb_rotor/validation/term_search.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "amb_rotor/common/linear_algebra.hpp"

namespace amb_rotor {
namespace {

constexpr int most_terms = 3;
/// A term that the others nearly span within this share of its own curvature is not told from them.
constexpr double least_own_curvature = 1e-6;

int bitsOf(unsigned value) {
  int count = 0;
  for (; value != 0; value &= value - 1) ++count;
  return count;
}

/// The library with the base taken out of it (Schur complement), scaled to curvature 1.
struct Reduced {
  Eigen::MatrixXd h;
  Eigen::VectorXd g;
  std::vector<int> place;  ///< in the library
};

Reduced reduce(const Eigen::MatrixXd& h, const Eigen::VectorXd& g, const std::vector<int>& base,
               const std::vector<int>& library) {
  const int n = static_cast<int>(base.size()), m = static_cast<int>(library.size());
  Eigen::MatrixXd own(n, n), cross(n, m), rest(m, m);
  Eigen::VectorXd own_g(n), rest_g(m);
  for (int i = 0; i < n; ++i) {
    own_g[i] = g[base[i]];
    for (int j = 0; j < n; ++j) own(i, j) = h(base[i], base[j]);
    for (int j = 0; j < m; ++j) cross(i, j) = h(base[i], library[j]);
    own(i, i) = own(i, i) * (1.0 + 1e-10) + 1e-300;
  }
  for (int i = 0; i < m; ++i) {
    rest_g[i] = g[library[i]];
    for (int j = 0; j < m; ++j) rest(i, j) = h(library[i], library[j]);
  }
  if (n > 0) {
    const Ldlt factor(own);
    rest -= cross.transpose() * factor.solveColumns(cross);
    rest_g -= cross.transpose() * factor.solve(own_g);
  }
  Reduced out;
  for (int i = 0; i < m; ++i) {
    const double whole = h(library[i], library[i]);
    if (whole > 0.0 && rest(i, i) > least_own_curvature * whole) out.place.push_back(i);
  }
  const int k = static_cast<int>(out.place.size());
  out.h.resize(k, k);
  out.g.resize(k);
  for (int i = 0; i < k; ++i) {
    const double si = std::sqrt(rest(out.place[i], out.place[i]));
    out.g[i] = rest_g[out.place[i]] / si;
    for (int j = 0; j < k; ++j)
      out.h(i, j) = rest(out.place[i], out.place[j]) / (si * std::sqrt(rest(out.place[j], out.place[j])));
  }
  return out;
}

/// Drop by a subset of the reduced library; 0 where its members cannot be told apart.
double dropOf(const Reduced& r, const int* subset, int size) {
  if (size == 1) return r.g[subset[0]] * r.g[subset[0]];
  if (size == 2) {
    const double c = r.h(subset[0], subset[1]), a = r.g[subset[0]], b = r.g[subset[1]], det = 1.0 - c * c;
    return det > least_own_curvature ? (a * a + b * b - 2.0 * c * a * b) / det : 0.0;
  }
  Eigen::Matrix3d h;
  Eigen::Vector3d g;
  for (int i = 0; i < 3; ++i) {
    g[i] = r.g[subset[i]];
    for (int j = 0; j < 3; ++j) h(i, j) = r.h(subset[i], subset[j]);
  }
  const double det = h.determinant();
  return det > least_own_curvature ? g.dot(h.inverse() * g) : 0.0;
}

/// Calls look(s) for every subset of a size, `s` its members' places in rising order.
template <class Look>
void forEachSubset(int k, int size, const Look& look) {
  int s[most_terms] = {0, 0, 0};
  const auto choose = [&](const auto& self, int place, int from) -> void {
    if (place == size || place == most_terms) return look(s);
    for (s[place] = from; s[place] < k; ++s[place]) self(self, place + 1, s[place] + 1);
  };
  choose(choose, 0, 0);
}

/// The best subset of a size; of those within `tie` of it the one of the fewest quantities.
TermChoice bestOfSize(const Reduced& r, int size, const std::vector<unsigned>& quantities, double tie) {
  const int k = static_cast<int>(r.place.size());
  double most = 0.0;
  forEachSubset(k, size, [&](const int* s) { most = std::max(most, dropOf(r, s, size)); });
  TermChoice best;
  int fewest = 1 << 20;
  forEachSubset(k, size, [&](const int* s) {
    const double drop = dropOf(r, s, size);
    if (drop < most - tie) return;
    unsigned bits = 0;
    for (int i = 0; i < size; ++i) bits |= quantities[r.place[s[i]]];
    const int count = bitsOf(bits);
    if (count > fewest || (count == fewest && !(drop > best.drop))) return;
    fewest = count;
    best.drop = drop;
    best.terms.assign(s, s + size);
  });
  return best;
}

}  // namespace

TermChoice bestTerms(const Eigen::MatrixXd& h, const Eigen::VectorXd& g, const std::vector<int>& base,
                     const std::vector<int>& library, const std::vector<unsigned>& quantities, double least,
                     double tie, int most) {
  const Reduced reduced = reduce(h, g, base, library);
  TermChoice chosen;
  for (int size = 1; size <= std::min(most, most_terms) && size <= static_cast<int>(reduced.place.size()); ++size) {
    const TermChoice next = bestOfSize(reduced, size, quantities, tie);
    if (next.drop < chosen.drop + least) break;
    chosen = next;
  }
  for (int& term : chosen.terms) term = library[reduced.place[term]];
  return chosen;
}

std::vector<TermChoice> bestSubsets(const Eigen::MatrixXd& h, const Eigen::VectorXd& g, const std::vector<int>& base,
                                    const std::vector<int>& library, int size, int count) {
  const Reduced reduced = reduce(h, g, base, library);
  std::vector<TermChoice> best;
  if (count <= 0) return best;
  const auto order = [](const TermChoice& a, const TermChoice& b) { return a.drop > b.drop; };
  forEachSubset(static_cast<int>(reduced.place.size()), size, [&](const int* s) {
    const double drop = dropOf(reduced, s, size);
    if (static_cast<int>(best.size()) == count && !(drop > best.back().drop)) return;
    if (static_cast<int>(best.size()) == count) best.pop_back();
    TermChoice one;
    one.drop = drop;
    for (int i = 0; i < size; ++i) one.terms.push_back(library[reduced.place[s[i]]]);
    best.insert(std::upper_bound(best.begin(), best.end(), one, order), one);
  });
  return best;
}

Eigen::VectorXd solveFor(const Eigen::MatrixXd& h, const Eigen::VectorXd& g, const std::vector<int>& chosen) {
  const int n = static_cast<int>(chosen.size());
  Eigen::MatrixXd own(n, n);
  Eigen::VectorXd right(n);
  for (int i = 0; i < n; ++i) {
    right[i] = g[chosen[i]];
    for (int j = 0; j < n; ++j) own(i, j) = h(chosen[i], chosen[j]);
    own(i, i) = own(i, i) * (1.0 + 1e-10) + 1e-300;
  }
  return Ldlt(own).solve(right);
}

}  // namespace amb_rotor
