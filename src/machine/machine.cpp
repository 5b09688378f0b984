#include "amb_rotor/machine/machine_impl.hpp"

namespace amb_rotor {
template class Machine<double>;
}  // namespace amb_rotor
