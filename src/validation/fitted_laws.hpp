#pragma once
// Laws as fits have left them, so that the same terms are not fitted again and again.
#include <Eigen/Core>
#include <map>
#include <vector>

#include "amb_rotor/validation/fit.hpp"

namespace amb_rotor {

/// A law with its fit.
struct Hypothesis {
  std::vector<int> terms;  ///< coordinates; empty: none was found
  Eigen::VectorXd x;
  Eigen::MatrixXd covariance;
  double chi2 = 1e300;     ///< with the nuisance's priors
  std::vector<LocalState> local;
};

/// Laws fitted so far, by their terms.
class FittedLaws {
 public:
  /// The best fit of these terms; null where another start, or more iterations, may lead elsewhere.
  const Hypothesis* settled(const std::vector<int>& terms, int iterations) const;
  /// @return the best fit of its terms
  const Hypothesis& add(const Hypothesis& fitted, int iterations);

 private:
  struct Known {
    Hypothesis best;
    int fits = 0, iterations = 0;
    bool agreed = false;  ///< two fits have ended alike
  };
  std::map<std::vector<int>, Known> known_;
};

}  // namespace amb_rotor
