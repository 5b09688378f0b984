#include "amb_rotor/machine/set_valued_friction.hpp"

#include "amb_rotor/common/error.hpp"
#include "amb_rotor/machine/state.hpp"

namespace amb_rotor {
namespace {

/// Share of the trace on the diagonal of B: far above round-off, far below what a force is known to.
constexpr double least_norm_share = 1e-9;

}  // namespace

void refuseSetValuedFriction(FrictionLaw law, const char* where) {
  if (law == FrictionLaw::set_valued)
    throw InputError(
        {{"", 0, "rig.auxiliary_bearing.friction_law", "set_valued",
          std::string("must be regularised in ") + where +
              " (stick is a mode with located events, which only an event-accurate run in process has)"}});
}

StickSolver::StickSolver(const Machine<double>& machine)
    : machine_(machine), rate_(machine.stateSize(), 0.0) {}

void StickSolver::solve(Inputs<double> in, const int sliding[2], const double* state, double force[2]) {
  force[0] = force[1] = 0.0;
  int stuck[2], count = 0;
  for (int end = 0; end < 2; ++end)
    if (sliding[end] == 0 && (in.contact_mode == nullptr || in.contact_mode[end] != 0)) stuck[count++] = end;
  if (count == 0) return;
  double trial[2] = {0.0, 0.0};
  in.sliding = sliding;
  in.stick_force = trial;
  double right[2] = {0.0, 0.0}, b[2][2] = {{0.0, 0.0}, {0.0, 0.0}};
  machine_.derivatives(in, state, rate_.data());
  for (int i = 0; i < count; ++i)
    right[i] = machine_.slipRate(stuck[i], in, state, rate_.data()) +
               machine_.slip(stuck[i], in, state) / stick_settling_s;
  for (int j = 0; j < count; ++j) {
    const double unit =
        1.0 + limit(in, stuck[j], state);  // of the order of the forces: no loss by cancellation
    trial[stuck[j]] = unit;
    machine_.derivatives(in, state, rate_.data());
    for (int i = 0; i < count; ++i) {
      const double with = machine_.slipRate(stuck[i], in, state, rate_.data()) +
                          machine_.slip(stuck[i], in, state) / stick_settling_s;
      b[i][j] = (with - right[i]) / unit;
    }
    trial[stuck[j]] = 0.0;
  }
  if (count == 1) {
    if (b[0][0] > 0.0) force[stuck[0]] = -right[0] / b[0][0];
    return;
  }
  const double share = least_norm_share * (b[0][0] + b[1][1]);
  const double a00 = b[0][0] + share, a11 = b[1][1] + share;
  const double determinant = a00 * a11 - b[0][1] * b[1][0];
  force[stuck[0]] = -(a11 * right[0] - b[0][1] * right[1]) / determinant;
  force[stuck[1]] = -(a00 * right[1] - b[1][0] * right[0]) / determinant;
}

double StickSolver::limit(Inputs<double> in, int end, const double* state) const {
  Contact<double> contact[2];
  const double none[2] = {0.0, 0.0};
  if (in.stick_force == nullptr) in.stick_force = none;
  machine_.contacts(in, state, contact);
  return contact[end].friction_coefficient * contact[end].normal_force;
}

}  // namespace amb_rotor
