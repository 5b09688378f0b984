#include "fitted_laws.hpp"

#include <algorithm>
#include <cmath>

namespace amb_rotor {
namespace {

/// Fits of the same terms, at most, to go on or from other starts; and share of chi2 within which two have ended alike.
constexpr int most_fits = 4;
constexpr double alike_share = 1e-3;

}  // namespace

const Hypothesis* FittedLaws::settled(const std::vector<int>& terms, int iterations) const {
  const auto found = known_.find(terms);
  if (found == known_.end() || found->second.iterations < iterations) return nullptr;
  return found->second.agreed || found->second.fits >= most_fits ? &found->second.best : nullptr;
}

const Hypothesis& FittedLaws::add(const Hypothesis& fitted, int iterations) {
  Known& known = known_[fitted.terms];
  known.agreed = known.agreed || (known.fits > 0 && std::fabs(fitted.chi2 - known.best.chi2) <= alike_share * known.best.chi2);
  if (known.fits == 0 || fitted.chi2 < known.best.chi2) known.best = fitted;
  known.iterations = std::max(known.iterations, iterations);
  ++known.fits;
  return known.best;
}

}  // namespace amb_rotor
