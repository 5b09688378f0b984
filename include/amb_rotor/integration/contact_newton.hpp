#pragma once
// Newton's method on the normal forces of a step of contact (contact_flow.hpp), at all nodes and ends at
// once, by the widest instructions that this processor has.
//
//   N_i = k_i n_i.x_i + c_i n_i.v_i + ...,  x_i and v_i moved by all u_j = -N_j e_j
//   (k, c: the force by depth and by its rate; n: the normal, e: the same turned by the friction's share)
//
// Arrays hold the nodes of the end a, then those of b: LinearFlow::row() and column() likewise.
#include "amb_rotor/integration/linear_flow.hpp"

namespace amb_rotor {

/// The law of contact at a step's nodes.
struct ContactNodes {
  static constexpr int ends = 2, nodes = LinearFlow::nodes, most = nodes * ends;
  alignas(64) double force[most] = {};  ///< normal [N]
  double slope[most] = {};              ///< by depth [N/m]
  double damping[most] = {};            ///< by the depth's rate [N s/m]
  double x[most] = {}, y[most] = {};    ///< the displacement's direction
  double guard[most] = {};              ///< positive while the end goes on carrying [m]
};

/// For `ends` ends from `first` on; w, u, evaluated: of both ends.
struct ContactKernels {
  /// Largest change of the outputs, in these units.
  double (*change)(int first, int ends, const double* w, const double* before, double length, double speed);
  /// The inverse of the matrix of N - k n.x(N) - c n.v(N), by columns. forced: LinearFlow::Table::forced, for
  /// the force that was evaluated.
  void (*linearise)(int first, int ends, const double* forced, const ContactNodes& nodes,
                    const double* evaluated, double (*inverse)[ContactNodes::most]);
  /// Newton's step from u; directions are those of the evaluation.
  void (*correct)(int first, int ends, const ContactNodes& nodes, const double* evaluated,
                  const double (*inverse)[ContactNodes::most], double* u);
};

ContactKernels contactKernelsBaseline();
ContactKernels contactKernelsAvx2();    ///< null: not in this build
ContactKernels contactKernelsAvx512();  ///< likewise
/// Those of this processor.
const ContactKernels& contactKernels();

}  // namespace amb_rotor
