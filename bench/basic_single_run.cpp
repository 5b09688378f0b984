// One run of the basic model in rub, event-accurate, beside Boost.odeint and SUNDIALS with root finding (peers.hpp):
// 300 turns from (1, 0) at rest, centred bearing, frequency ratio 1.05. Counters: the error of
// the end position against our own run at tolerance 1e-13, right-hand-side calls, and the tolerance.
#include <benchmark/benchmark.h>

#include <array>
#include <cmath>
#include <string>

#include "amb_rotor/common/units.hpp"
#include "amb_rotor/machine/basic_orbit.hpp"
#include "peers.hpp"

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

/// What the peers get: the same right-hand side template as ours.
struct Problem {
  using Model = BasicModel<LinearContact, SpinFriction>;
  BasicCoefficients<double> c = basicCoefficients<LinearContact>(rubbing(), 1.0);
  double eta = rubbing().frequency_ratio;
  double calls = 0.0;
  bool by_radius = true, contact = false;

  int size() const { return 4; }
  int guards() const { return 1; }
  void by_state(bool on) { by_radius = on; }
  void flip(int) { contact = !contact; }
  void guard(double, const double* q, double* g) const { g[0] = q[0] * q[0] + q[1] * q[1] - 1.0; }
  void rate(double t, const double* q, double* rate) {
    ++calls;
    rate[0] = q[2];
    rate[1] = q[3];
    const double fx = c.forcing * std::cos(eta * t), fy = c.forcing * std::sin(eta * t);
    if (by_radius)
      Model::acceleration(c, fx, fy, q[0], q[1], q[2], q[3], rate[2], rate[3]);
    else if (contact)
      Model::acceleration<BasicBranch::contact>(c, fx, fy, q[0], q[1], q[2], q[3], rate[2], rate[3]);
    else
      Model::acceleration<BasicBranch::free>(c, fx, fy, q[0], q[1], q[2], q[3], rate[2], rate[3]);
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

/// A peer: run(problem, end, state).
template <class Run>
void peer(benchmark::State& state, double tolerance, const Run& run) {
  std::array<double, 4> q{};
  Problem problem;
  for (auto _ : state) {
    q = {1.0, 0.0, 0.0, 0.0};
    problem = Problem();
    run(problem, turns * two_pi / problem.eta, q);
    benchmark::DoNotOptimize(q);
  }
  report(state, q[0], q[1], problem.calls, tolerance);
}

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
  using State = std::array<double, 4>;
  const auto add = [](const char* name, double tolerance, auto run) {
    const int digits = static_cast<int>(std::round(-std::log10(tolerance)));
    RegisterBenchmark((std::string(name) + "/" + std::to_string(digits)).c_str(),
                      [=](benchmark::State& s) { peer(s, tolerance, run); });
  };
  for (double tolerance : {1e-6, 1e-8, 1e-10, 1e-12}) {
    const std::string text = "/" + std::to_string(static_cast<int>(std::round(-std::log10(tolerance))));
    RegisterBenchmark(("event_accurate" + text).c_str(), [=](benchmark::State& s) { ours(s, tolerance); });
    add("odeint_dopri5", tolerance, [=](Problem& p, double end, State& q) {
      peers::runOdeint<peers::Dopri5<State>>(p, end, 0.01, tolerance, q);
    });
    add("odeint_fehlberg78", tolerance, [=](Problem& p, double end, State& q) {
      peers::runOdeint<peers::Fehlberg78<State>>(p, end, 0.01, tolerance, q);
    });
#ifdef AMB_ROTOR_WITH_SUNDIALS
    for (bool restart : {false, true}) {
      const std::string kind = restart ? "_restarted" : "_roots";
      for (int method : {CV_ADAMS, CV_BDF})
        add(((method == CV_ADAMS ? "cvode_adams" : "cvode_bdf") + kind).c_str(), tolerance,
            [=](Problem& p, double end, State& q) { peers::runCvode(p, method, restart, end, tolerance, q.data()); });
      for (auto [table, name] : {std::pair{ARKODE_DORMAND_PRINCE_7_4_5, "arkode_dopri5"},
                                 std::pair{ARKODE_FEHLBERG_13_7_8, "arkode_fehlberg78"}})
        add((name + kind).c_str(), tolerance, [=, table = table](Problem& p, double end, State& q) {
          peers::runArkode(p, table, restart, end, tolerance, q.data());
        });
    }
#endif
  }
  return true;
}();

}  // namespace
}  // namespace amb_rotor
