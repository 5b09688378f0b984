// One run of the basic model in rub, event-accurate, beside Boost.odeint's DOPRI5 and SUNDIALS CVODE with
// root finding: 300 turns from (1, 0) at rest, centred bearing, frequency ratio 1.05. Counters: the error of
// the end position against our own run at tolerance 1e-13, right-hand-side calls, and the tolerance.
#include <benchmark/benchmark.h>

#include <array>
#include <boost/numeric/odeint.hpp>
#include <cmath>
#include <string>

#include "amb_rotor/common/units.hpp"
#include "amb_rotor/machine/basic_orbit.hpp"
#ifdef AMB_ROTOR_WITH_SUNDIALS
#include <cvode/cvode.h>
#include <nvector/nvector_serial.h>
#include <sunlinsol/sunlinsol_dense.h>
#include <sunmatrix/sunmatrix_dense.h>
#endif

namespace amb_rotor {
namespace {

constexpr int turns = 300;

BasicParameters<double> rubbing() {
  BasicParameters<double> p;
  p.frequency_ratio = 1.05;
  return p;
}

BasicState<double> reference() {
  static const BasicState<double> state = [] {
    BasicOrbitOptions options;
    options.tolerance = 1e-13;
    return advanceBasic(rubbing(), {1.0, 0.0, 0.0, 0.0}, turns, options).end;
  }();
  return state;
}

void report(benchmark::State& state, double x, double y, double calls, double tolerance) {
  state.counters["error"] = std::hypot(x - reference().x, y - reference().y);
  state.counters["calls"] = calls;
  state.counters["tolerance"] = tolerance;
}

/// The right-hand side that the peers get: the same template as ours, by the radius.
struct Rate {
  BasicCoefficients<double> c = basicCoefficients<LinearContact>(rubbing(), 1.0);
  double eta = rubbing().frequency_ratio;
  mutable double calls = 0.0;
  void operator()(const double* q, double* rate, double t) const {
    ++calls;
    rate[0] = q[2];
    rate[1] = q[3];
    BasicModel<LinearContact, SpinFriction>::acceleration(c, c.forcing * std::cos(eta * t),
                                                          c.forcing * std::sin(eta * t), q[0], q[1], q[2],
                                                          q[3], rate[2], rate[3]);
  }
};

void ours(benchmark::State& state, double tolerance) {
  BasicOrbitOptions options;
  options.tolerance = tolerance;
  BasicOrbit orbit;
  for (auto _ : state) {
    orbit = advanceBasic(rubbing(), {1.0, 0.0, 0.0, 0.0}, turns, options);
    benchmark::DoNotOptimize(orbit.end);
  }
  report(state, orbit.end.x, orbit.end.y, static_cast<double>(orbit.evaluations), tolerance);
}

void odeint(benchmark::State& state, double tolerance) {
  using State = std::array<double, 4>;
  using namespace boost::numeric::odeint;
  State q{};
  Rate rate;
  for (auto _ : state) {
    q = {1.0, 0.0, 0.0, 0.0};
    rate.calls = 0.0;
    const auto system = [&](const State& at, State& out, double t) { rate(at.data(), out.data(), t); };
    integrate_adaptive(make_controlled(tolerance, tolerance, runge_kutta_dopri5<State>()), system, q, 0.0,
                       turns * two_pi / rate.eta, 0.01);
  }
  report(state, q[0], q[1], rate.calls, tolerance);
}

#ifdef AMB_ROTOR_WITH_SUNDIALS
int cvodeRate(realtype t, N_Vector q, N_Vector rate, void* data) {
  (*static_cast<Rate*>(data))(N_VGetArrayPointer(q), N_VGetArrayPointer(rate), t);
  return 0;
}
int cvodeRoot(realtype, N_Vector q, realtype* g, void*) {
  const double* s = N_VGetArrayPointer(q);
  g[0] = s[0] * s[0] + s[1] * s[1] - 1.0;
  return 0;
}

void cvode(benchmark::State& state, double tolerance) {
  Rate rate;
  double x = 0.0, y = 0.0;
  for (auto _ : state) {
    rate.calls = 0.0;
    SUNContext context = nullptr;
    SUNContext_Create(nullptr, &context);
    N_Vector q = N_VNew_Serial(4, context);
    const double start[4] = {1.0, 0.0, 0.0, 0.0};
    std::copy(start, start + 4, N_VGetArrayPointer(q));
    void* memory = CVodeCreate(CV_BDF, context);
    CVodeInit(memory, cvodeRate, 0.0, q);
    CVodeSStolerances(memory, tolerance, tolerance);
    CVodeSetUserData(memory, &rate);
    CVodeRootInit(memory, 1, cvodeRoot);
    CVodeSetMaxNumSteps(memory, 100000000);
    SUNMatrix matrix = SUNDenseMatrix(4, 4, context);
    SUNLinearSolver solver = SUNLinSol_Dense(q, matrix, context);
    CVodeSetLinearSolver(memory, solver, matrix);
    const double end = turns * two_pi / rate.eta;
    realtype t = 0.0;
    CVodeSetStopTime(memory, end);
    while (t < end && CVode(memory, end, q, &t, CV_NORMAL) >= 0) {
    }
    x = N_VGetArrayPointer(q)[0];
    y = N_VGetArrayPointer(q)[1];
    CVodeFree(&memory);
    SUNLinSolFree(solver);
    SUNMatDestroy(matrix);
    N_VDestroy(q);
    SUNContext_Free(&context);
  }
  report(state, x, y, rate.calls, tolerance);
}
#endif

/// The lanes on the same machine, 1024 of them; the time is that of one.
void lanes(benchmark::State& state, int steps) {
  BasicLaneOptions options;
  options.steps_per_turn = steps;
  options.turns_skipped = turns;
  options.turns_kept = 0;
  options.threads = 1;
  constexpr int machines = 1024;
  BasicState<double> end;
  for (auto _ : state) {
    end = runBasicLanes(std::vector<BasicParameters<double>>(machines, rubbing()), {{1.0, 0.0, 0.0, 0.0}},
                        options)
              .end.front();
  }
  report(state, end.x, end.y, 4.0 * steps * turns, 0.0);
  state.counters["machines"] = machines;
}

const bool registered = [] {
  using benchmark::RegisterBenchmark;
  for (int steps : {200, 400, 800}) {
    RegisterBenchmark(("lanes_rk4/steps:" + std::to_string(steps)).c_str(),
                      [=](benchmark::State& s) { lanes(s, steps); });
  }
  for (double tolerance : {1e-6, 1e-8, 1e-10}) {
    const std::string text = "/" + std::to_string(static_cast<int>(std::round(-std::log10(tolerance))));
    RegisterBenchmark(("event_accurate" + text).c_str(), [=](benchmark::State& s) { ours(s, tolerance); });
    RegisterBenchmark(("odeint_dopri5" + text).c_str(), [=](benchmark::State& s) { odeint(s, tolerance); });
#ifdef AMB_ROTOR_WITH_SUNDIALS
    RegisterBenchmark(("cvode_bdf_roots" + text).c_str(), [=](benchmark::State& s) { cvode(s, tolerance); });
#endif
  }
  return true;
}();

}  // namespace
}  // namespace amb_rotor
