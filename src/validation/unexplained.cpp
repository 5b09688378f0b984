#include "amb_rotor/validation/unexplained.hpp"

namespace amb_rotor {

Unexplained searchUnexplained(const std::vector<Recording>&, const FitSpace&, const Eigen::VectorXd&,
                              const std::vector<LocalState>&, double) {
  return {};
}

}  // namespace amb_rotor
