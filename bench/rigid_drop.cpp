// The drop of a rigid beam into auxiliary bearings on compliant mounts, Hertz contact and regularised
// friction, spinning at 100 Hz: 16 states, 0.1 s. Ours by modal coordinates and by the event stepper, beside
// the peers (peers.hpp), which get the equations written out by hand for this machine alone; a check holds
// them to the machine's own derivatives.
#include <benchmark/benchmark.h>

#include <array>
#include <cmath>
#include <string>

#include "amb_rotor/common/check.hpp"
#include "amb_rotor/common/units.hpp"
#include "amb_rotor/excitation/schedule.hpp"
#include "amb_rotor/machine/assembly.hpp"
#include "amb_rotor/machine/modal_stepper.hpp"
#include "amb_rotor/machine/run.hpp"
#include "peers.hpp"

namespace amb_rotor {
namespace {

constexpr double length_s = 0.1, speed_rad_s = two_pi * 100.0;
constexpr double mass = 3.36, inertia = 0.017, moment = 5e-6, arm = 0.14, clearance = 2e-4, radius = 0.012,
                 mu = 0.1;
constexpr double hertz = 2.4e9, hertz_damping = 0.5, mount_k = 5e6, mount_d = 300.0, mount_mass = 0.07,
                 gravity = 9.81;
constexpr double start_x = 1e-5, start_y = 2e-5, start_tilt = 1e-4;
using State =
    std::array<double, 16>;  // x, beta, y, -alpha, their rates, then each mount's place and velocity

Model dropped() {
  Model model;
  model.rotor_model = RotorModel::rigid_beam;
  model.amb_model = AmbModel::equivalent;
  Rig<double>& rig = model.rig;
  rig.gravity_m_s2 = gravity;
  rig.rotor.mass_kg = mass;
  rig.rotor.transverse_inertia_kg_m2 = inertia;
  for (int e = 0; e < 2; ++e) {
    rig.planes.amb[e] = e == 0 ? -0.096 : 0.096;
    rig.planes.sensor[e] = e == 0 ? -0.118 : 0.118;
    rig.planes.aux[e] = e == 0 ? -arm : arm;
  }
  rig.auxiliary_bearing.clearance_m = clearance;
  rig.auxiliary_bearing.rotor_radius_m = radius;
  rig.auxiliary_bearing.stiffness_N_per_m = 3.38e7;
  rig.auxiliary_bearing.friction_coefficient = mu;
  rig.unbalance.emplace_back();
  rig.unbalance.back().moment_kg_m = moment;
  model.effects.push_back({"compliant_mount", {mount_k, mount_d, mount_mass}});
  model.effects.push_back({"hertzian_contact", {hertz, hertz_damping}});
  return model;
}

/// Equations by hand, in units of 1e-5 m and 1e-2 m/s; guards are the gaps in 1e-5 m.
struct Problem {
  static constexpr double length = 1e-5, speed = 1e-2;
  double calls = 0.0;
  bool by_gap = true;
  int mode[2] = {0, 0};

  int size() const { return 16; }
  int guards() const { return 2; }
  void by_state(bool on) { by_gap = on; }
  void flip(int end) { mode[end] = 1 - mode[end]; }
  void guard(double, const double* q, double* g) const {
    for (int e = 0; e < 2; ++e) {
      const double s = e == 0 ? -arm : arm;
      const double* b = q + 8 + 4 * e;
      const double x = q[0] + s * q[1] - b[0], y = q[2] + s * q[3] - b[1];
      g[e] = std::sqrt(x * x + y * y) - clearance / length;
    }
  }
  void rate(double t, const double* q, double* out) {
    ++calls;
    constexpr double turn = speed / length, back = 1.0 / speed;
    double fx = moment * speed_rad_s * speed_rad_s * std::cos(speed_rad_s * t);
    double fy = moment * speed_rad_s * speed_rad_s * std::sin(speed_rad_s * t) - mass * gravity;
    double mx = 0.0, my = 0.0;
    for (int i = 0; i < 4; ++i) out[i] = turn * q[4 + i];
    for (int e = 0; e < 2; ++e) {
      const double s = e == 0 ? -arm : arm;
      const double* b = q + 8 + 4 * e;
      double px = 0.0, py = 0.0;
      const double x = length * (q[0] + s * q[1] - b[0]), y = length * (q[2] + s * q[3] - b[1]);
      const double square = x * x + y * y;
      if (by_gap ? square > clearance * clearance : mode[e] != 0) {
        const double vx = speed * (q[4] + s * q[5] - b[2]), vy = speed * (q[6] + s * q[7] - b[3]);
        const double r = std::sqrt(square), nx = x / r, ny = y / r, depth = std::max(0.0, r - clearance);
        double normal = hertz * depth * std::sqrt(depth) * (1.0 + hertz_damping * (nx * vx + ny * vy));
        if (by_gap) normal = std::max(0.0, normal);
        const double slip = radius * speed_rad_s + nx * vy - ny * vx;
        const double friction = -mu * normal * std::tanh(slip / friction_regularisation_m_s);
        px = -normal * nx - friction * ny;
        py = -normal * ny + friction * nx;
      }
      fx += px;
      fy += py;
      mx += s * px;
      my += s * py;
      double* rate = out + 8 + 4 * e;
      rate[0] = turn * b[2];
      rate[1] = turn * b[3];
      rate[2] = back / mount_mass * (-px - mount_k * length * b[0] - mount_d * speed * b[2]);
      rate[3] = back / mount_mass * (-py - mount_k * length * b[1] - mount_d * speed * b[3]);
    }
    out[4] = back / mass * fx;
    out[5] = back / inertia * mx;
    out[6] = back / mass * fy;
    out[7] = back / inertia * my;
  }
};

struct Setting {
  Model model = dropped();
  Scenario scenario;
  Schedule schedule{{}, {}};
  PiecewiseShaft path;
  Machine<double> machine;
  Drive<double> drive;

  static Scenario falling() {
    Scenario s;
    s.duration_s = length_s;
    s.speed.type = SpeedType::constant;
    s.speed.start_hz = speed_rad_s / two_pi;
    FaultEvent fault;
    fault.type = FaultType::amb_off;
    fault.start_s = 0.0;
    fault.end = fault.axis = -1;
    s.faults.push_back(fault);
    return s;
  }
  Setting()
      : scenario(falling()), schedule({}, scenario.faults), path(shaftPath(scenario)), machine({&model}) {
    drive.path = &path;
    drive.schedule = &schedule;
  }
  MachineState<double> start(const Simulator<double>& sim) const {
    MachineState<double> state = sim.atRest(0.0);
    state.mechanics[0] = start_x;
    state.mechanics[1] = start_tilt;
    state.mechanics[2] = start_y;
    return state;
  }
};

/// End state in the peers' units.
template <class Stepper>
State ours(double tolerance, long* calls = nullptr) {
  static const Setting setting;
  const Simulator<double> sim(setting.machine, setting.drive, 0.0);
  MachineState<double> state = setting.start(sim);
  Stepper stepper(setting.machine, tolerance);
  AMB_ROTOR_CHECK(sim.run(state, length_s, stepper, [](const Record<double>&) {}), "the drop must end");
  if constexpr (std::is_same_v<Stepper, ModalStepper>)
    AMB_ROTOR_CHECK(stepper.reason().empty(), "the drop is linear between contacts: " + stepper.reason());
  if (calls != nullptr) *calls = stepper.statistics().evaluations;
  State out;
  for (int i = 0; i < 16; ++i) {
    const bool place = i < 4 || (i >= 8 && i % 4 < 2);
    out[static_cast<std::size_t>(i)] =
        state.mechanics[static_cast<std::size_t>(i)] / (place ? Problem::length : Problem::speed);
  }
  return out;
}

/// The equations by hand are the machine's.
void checkProblem() {
  const Setting setting;
  Problem problem;
  State q, by_hand;
  std::vector<double> y(16), rate(16);
  for (int trial = 0; trial < 20; ++trial) {
    for (std::size_t i = 0; i < 16; ++i) {
      q[i] = 18.0 * std::sin(1.7 * static_cast<double>(i) + trial);
      y[i] = q[i] * (i < 4 || (i >= 8 && i % 4 < 2) ? Problem::length : Problem::speed);
    }
    const double t = 1e-3 * trial;
    problem.rate(t, q.data(), by_hand.data());
    Inputs<double> in;
    in.shaft = setting.drive.shaft(t);
    in.bearing_on[0] = in.bearing_on[1] = {0.0, 0.0};
    setting.machine.derivatives(in, y.data(), rate.data());
    for (std::size_t i = 0; i < 16; ++i) {
      const double scale = i < 4 || (i >= 8 && i % 4 < 2) ? Problem::length : Problem::speed;
      AMB_ROTOR_CHECK(std::abs(rate[i] / scale - by_hand[i]) <= 1e-10 * (1.0 + std::abs(by_hand[i])),
                      "equations by hand differ in state " + std::to_string(i));
    }
  }
}

/// Largest error of the ends' places, over the clearance.
double error(const State& a) {
  static const State truth = ours<EventStepper>(1e-13);
  double most = 0.0;
  for (double s : {-arm, arm})
    most = std::max(
        most, std::hypot(a[0] - truth[0] + s * (a[1] - truth[1]), a[2] - truth[2] + s * (a[3] - truth[3])));
  return most * Problem::length / clearance;
}

void report(benchmark::State& state, const State& end, double calls, double tolerance) {
  state.counters["error"] = error(end);
  state.counters["calls"] = calls;
  state.counters["tolerance"] = tolerance;
}

template <class Run>
void peer(benchmark::State& state, double tolerance, const Run& run) {
  State q{};
  Problem problem;
  for (auto _ : state) {
    q = {};
    q[0] = start_x / Problem::length;
    q[1] = start_tilt / Problem::length;
    q[2] = start_y / Problem::length;
    problem = Problem();
    run(problem, length_s, q);
    benchmark::DoNotOptimize(q);
  }
  report(state, q, problem.calls, tolerance);
}

template <class Stepper>
void own(benchmark::State& state, double tolerance) {
  State end{};
  long calls = 0;
  for (auto _ : state) {
    end = ours<Stepper>(tolerance, &calls);
    benchmark::DoNotOptimize(end);
  }
  report(state, end, static_cast<double>(calls), tolerance);
}

const bool registered = [] {
  using benchmark::RegisterBenchmark;
  checkProblem();
  const auto add = [](const char* name, double tolerance, auto run) {
    RegisterBenchmark(
        (std::string(name) + "/" + std::to_string(static_cast<int>(std::round(-std::log10(tolerance)))))
            .c_str(),
        [=](benchmark::State& s) { peer(s, tolerance, run); });
  };
  for (double tolerance : {1e-3, 1e-4, 1e-5, 1e-6, 1e-7, 1e-8, 1e-9, 1e-10}) {
    const std::string text = "/" + std::to_string(static_cast<int>(std::round(-std::log10(tolerance))));
    RegisterBenchmark(("modal" + text).c_str(),
                      [=](benchmark::State& s) { own<ModalStepper>(s, tolerance); });
    RegisterBenchmark(("event_stepper" + text).c_str(),
                      [=](benchmark::State& s) { own<EventStepper>(s, tolerance); });
    add("odeint_dopri5", tolerance, [=](Problem& p, double end, State& q) {
      peers::runOdeint<peers::Dopri5<State>>(p, end, 1e-5, tolerance, q);
    });
    add("odeint_fehlberg78", tolerance, [=](Problem& p, double end, State& q) {
      peers::runOdeint<peers::Fehlberg78<State>>(p, end, 1e-5, tolerance, q);
    });
#ifdef AMB_ROTOR_WITH_SUNDIALS
    for (bool restart : {false, true}) {
      const std::string kind = restart ? "_restarted" : "_roots";
      for (int method : {CV_ADAMS, CV_BDF})
        add(((method == CV_ADAMS ? "cvode_adams" : "cvode_bdf") + kind).c_str(), tolerance,
            [=](Problem& p, double end, State& q) {
              peers::runCvode(p, method, restart, end, tolerance, q.data());
            });
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
