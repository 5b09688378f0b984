#pragma once
// The integrators that users have: Boost.odeint, SUNDIALS CVODE and ARKODE, on one problem with contact
// events.
//
// A problem gives  size(), rate(t, q, out), guards(), guard(t, q, g), flip(guard) and by_state(bool). Its
// states are scaled so that one tolerance, absolute and relative, serves all of them. With by_state(true) the
// right-hand side takes the contact as the state says, and an integrator meets kinks; with false it takes the
// mode that flip() changes, and the integrator is restarted at each root, which is how SUNDIALS advises to
// treat them.
#include <array>

// odeint's generic steppers copy members that they set later
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wuninitialized"
#include <boost/numeric/odeint.hpp>
#pragma GCC diagnostic pop
#include <vector>
#ifdef AMB_ROTOR_WITH_SUNDIALS
#include <arkode/arkode_erkstep.h>
#include <cvode/cvode.h>
#include <nvector/nvector_serial.h>
#include <sunlinsol/sunlinsol_dense.h>
#include <sunmatrix/sunmatrix_dense.h>
#include <sunnonlinsol/sunnonlinsol_fixedpoint.h>
#endif

namespace amb_rotor::peers {

/// State: std::array for a size known when compiled, else std::vector.
template <class Stepper, class State, class Problem>
void runOdeint(Problem& problem, double end, double first_step, double tolerance, State& q) {
  using namespace boost::numeric::odeint;
  problem.by_state(true);
  const auto system = [&](const State& at, State& out, double t) { problem.rate(t, at.data(), out.data()); };
  integrate_adaptive(make_controlled(tolerance, tolerance, Stepper()), system, q, 0.0, end, first_step);
}
template <class State>
using Dopri5 = boost::numeric::odeint::runge_kutta_dopri5<State>;
template <class State>
using Fehlberg78 = boost::numeric::odeint::runge_kutta_fehlberg78<State>;

#ifdef AMB_ROTOR_WITH_SUNDIALS
template <class Problem>
int sundialsRate(realtype t, N_Vector q, N_Vector rate, void* data) {
  static_cast<Problem*>(data)->rate(t, N_VGetArrayPointer(q), N_VGetArrayPointer(rate));
  return 0;
}
template <class Problem>
int sundialsRoot(realtype t, N_Vector q, realtype* g, void* data) {
  static_cast<Problem*>(data)->guard(t, N_VGetArrayPointer(q), g);
  return 0;
}

/// Flips the modes whose guards were found.
template <class Problem>
void flipFound(Problem& problem, const std::vector<int>& found) {
  for (int g = 0; g < problem.guards(); ++g)
    if (found[static_cast<std::size_t>(g)] != 0) problem.flip(g);
}

/// @param method  CV_ADAMS (fixed-point iteration) or CV_BDF (Newton with a dense difference Jacobian)
template <class Problem>
void runCvode(Problem& problem, int method, bool restart, double end, double tolerance, double* state) {
  problem.by_state(!restart);
  SUNContext context = nullptr;
  SUNContext_Create(nullptr, &context);
  const int n = problem.size();
  N_Vector q = N_VMake_Serial(n, state, context);
  void* memory = CVodeCreate(method, context);
  CVodeInit(memory, sundialsRate<Problem>, 0.0, q);
  CVodeSStolerances(memory, tolerance, tolerance);
  CVodeSetUserData(memory, &problem);
  CVodeRootInit(memory, problem.guards(), sundialsRoot<Problem>);
  CVodeSetMaxNumSteps(memory, 100000000);
  SUNMatrix matrix = nullptr;
  SUNLinearSolver solver = nullptr;
  SUNNonlinearSolver fixed_point = nullptr;
  if (method == CV_BDF) {
    matrix = SUNDenseMatrix(n, n, context);
    solver = SUNLinSol_Dense(q, matrix, context);
    CVodeSetLinearSolver(memory, solver, matrix);
  } else {
    fixed_point = SUNNonlinSol_FixedPoint(q, 0, context);
    CVodeSetNonlinearSolver(memory, fixed_point);
  }
  realtype t = 0.0;
  CVodeSetStopTime(memory, end);
  std::vector<int> found(static_cast<std::size_t>(problem.guards()));
  int flag = CV_SUCCESS;
  while (t < end && (flag = CVode(memory, end, q, &t, CV_NORMAL)) >= 0) {
    if (!restart || flag != CV_ROOT_RETURN) continue;
    CVodeGetRootInfo(memory, found.data());
    flipFound(problem, found);
    CVodeReInit(memory, t, q);
    CVodeSetStopTime(memory, end);
  }
  CVodeFree(&memory);
  if (solver != nullptr) SUNLinSolFree(solver);
  if (matrix != nullptr) SUNMatDestroy(matrix);
  if (fixed_point != nullptr) SUNNonlinSolFree(fixed_point);
  N_VDestroy(q);
  SUNContext_Free(&context);
}

template <class Problem>
void runArkode(Problem& problem, ARKODE_ERKTableID table, bool restart, double end, double tolerance,
               double* state) {
  problem.by_state(!restart);
  SUNContext context = nullptr;
  SUNContext_Create(nullptr, &context);
  N_Vector q = N_VMake_Serial(problem.size(), state, context);
  void* memory = ERKStepCreate(sundialsRate<Problem>, 0.0, q, context);
  ERKStepSetTableNum(memory, table);
  ERKStepSStolerances(memory, tolerance, tolerance);
  ERKStepSetUserData(memory, &problem);
  ERKStepRootInit(memory, problem.guards(), sundialsRoot<Problem>);
  ERKStepSetMaxNumSteps(memory, 100000000);
  ERKStepSetInterpolantDegree(memory, 5);
  realtype t = 0.0;
  ERKStepSetStopTime(memory, end);
  std::vector<int> found(static_cast<std::size_t>(problem.guards()));
  int flag = ARK_SUCCESS;
  while (t < end && (flag = ERKStepEvolve(memory, end, q, &t, ARK_NORMAL)) >= 0) {
    if (!restart || flag != ARK_ROOT_RETURN) continue;
    ERKStepGetRootInfo(memory, found.data());
    flipFound(problem, found);
    ERKStepReset(memory, t, q);
    ERKStepSetStopTime(memory, end);
  }
  ERKStepFree(&memory);
  N_VDestroy(q);
  SUNContext_Free(&context);
}
#endif

}  // namespace amb_rotor::peers
