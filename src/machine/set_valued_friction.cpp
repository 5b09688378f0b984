#include "amb_rotor/machine/set_valued_friction.hpp"

#include <cmath>
#include <cstdio>

#include "amb_rotor/common/error.hpp"

namespace amb_rotor {
namespace {

/// Share of the trace on the diagonal of B: far above round-off, far below what a force is known to.
constexpr double least_norm_share = 1e-9;

}  // namespace

void refuseSetValuedFriction(FrictionLaw law, const std::string& where) {
  if (law != FrictionLaw::set_valued) return;
  char width[16];
  std::snprintf(width, sizeof width, "%g m/s", friction_regularisation_m_s);
  throw InputError({{"", 0, "rig.auxiliary_bearing.friction_law", "set_valued",
                     "must be regularised in " + where +
                         ", whose fixed steps have no stick. regularised slides alike and creeps, below v0 = " + width +
                         " by mu N tanh(v/v0), instead of sticking; what goes by located events takes set_valued"}});
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

void SlidingModes::begin(const Inputs<double>& in, const double* y, MachineState<double>& state) {
  state_ = &state;
  if (!on_) return;
  for (int end = 0; end < 2; ++end)
    if (state.contact_mode[end] != 0 && state.sliding[end] == sliding_unset) startSliding(end, in, y);
}

void SlidingModes::complete(Inputs<double>& in, const double* y, double force[2]) const {
  if (!on_) return;
  in.sliding = state_->sliding;
  solver_.solve(in, state_->sliding, y, force);
  in.stick_force = force;
}

void SlidingModes::guardValues(Inputs<double> in, const double* y, double guard[2]) const {
  if (!on_) return;
  in.sliding = state_->sliding;
  double force[2] = {0.0, 0.0};
  if (sticking(0) || sticking(1)) solver_.solve(in, state_->sliding, y, force);
  for (int end = 0; end < 2; ++end) {
    if (state_->contact_mode[end] == 0)
      guard[end] = 1.0;
    else if (sticking(end))
      guard[end] = solver_.limit(in, end, y) - std::fabs(force[end]);
    else
      guard[end] = state_->sliding[end] * machine_.slip(end, in, y) + stick_threshold_m_s;
  }
}

void SlidingModes::onContact(int end, Inputs<double> in, const double* y) {
  if (!on_) return;
  in.sliding = state_->sliding;
  state_->sliding[end] = sliding_unset;
  if (state_->contact_mode[end] != 0) startSliding(end, in, y);
}

/// A contact begins: it slides as it arrives; one that arrives without sliding sticks until its guard says
/// otherwise.
void SlidingModes::startSliding(int end, const Inputs<double>& in, const double* y) {
  const double slip = machine_.slip(end, in, y);
  state_->sliding[end] = std::fabs(slip) <= stick_threshold_m_s ? 0 : (slip > 0.0 ? 1 : -1);
}

void SlidingModes::onGuard(int end, Inputs<double> in, const double* y) {
  in.sliding = state_->sliding;
  int& mode = state_->sliding[end];
  const int before = mode;
  double force[2];
  mode = 0;
  if (before != 0 && bothHold(1 - end, in, y)) return;
  solver_.solve(in, state_->sliding, y, force);
  const bool holds = std::fabs(force[end]) <= solver_.limit(in, end, y);
  if (before != 0)  // sliding came to rest: it stays there, or goes on the other way
    mode = holds ? 0 : -before;
  else  // the force was not enough: slides against it
    mode = force[end] > 0.0 ? -1 : 1;
}

/// Two ends that come to rest at one instant (a rotor that does not tilt) hold each other up only together:
/// where both hold, the other end sticks from now on, too.
bool SlidingModes::bothHold(int other, const Inputs<double>& in, const double* y) {
  int& mode = state_->sliding[other];
  if (state_->contact_mode[other] == 0 || mode == 0) return false;
  if (std::fabs(machine_.slip(other, in, y)) > 10.0 * stick_threshold_m_s) return false;
  const int before = mode;
  mode = 0;
  double force[2];
  solver_.solve(in, state_->sliding, y, force);
  if (std::fabs(force[0]) <= solver_.limit(in, 0, y) && std::fabs(force[1]) <= solver_.limit(in, 1, y)) return true;
  mode = before;
  return false;
}

}  // namespace amb_rotor
