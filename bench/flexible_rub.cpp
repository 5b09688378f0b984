// A flexible rotor of 28 nodes, none of its 56 modes a plane left out, on spring and damper bearings: let go beside
// the centre it rubs in both auxiliary bearings under gravity and unbalance at 110 Hz. 224 states, 10 ms. Ours by modal
// coordinates, beside the peers (peers.hpp), which get the modal equations written out by hand for this machine alone; a
// check holds them to the machine's own derivatives.
//
// The highest mode has some MHz: explicit methods take steps that keep it stable, at any tolerance.
#include <benchmark/benchmark.h>

#include <Eigen/Core>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>
#include <vector>

#include "amb_rotor/common/check.hpp"
#include "amb_rotor/common/units.hpp"
#include "amb_rotor/effects/catalogue.hpp"
#include "amb_rotor/machine/assembly.hpp"
#include "amb_rotor/machine/modal_stepper.hpp"
#include "amb_rotor/machine/model_loading.hpp"
#include "amb_rotor/machine/run.hpp"
#include "amb_rotor/model/model_reader.hpp"
#include "peers.hpp"

namespace amb_rotor {
namespace {

constexpr double length_s = 0.01, speed_rad_s = two_pi * 110.0, start_m = 2.5e-4;
constexpr double stiffness_N_per_m = 5.96e5, damping_N_s_per_m = 300.0, moment_kg_m = 5e-4;
constexpr int nodes = 28, modes = 2 * nodes;
constexpr const char* element_length_m = "0.0150";  // with the thesis's sections and rings: 27 elements
const std::string thesis = AMB_ROTOR_SOURCE_DIR "/config/thesis/";
using State = std::vector<double>;  // x, y of each mode, then their rates

std::string text(const std::string& path) {
  std::stringstream out;
  out << std::ifstream(path).rdbuf();
  return out.str();
}

/// The thesis's shaft with elements of another length, in a folder of its own.
std::string coarserShaft() {
  const auto folder = std::filesystem::temp_directory_path() / "amb_rotor_flexible_rub";
  std::filesystem::create_directories(folder);
  std::string shaft = text(thesis + "rotor.yaml");
  const std::string key = "max_element_length_m: ";
  const auto at = shaft.find(key) + key.size();
  shaft.replace(at, shaft.find('\n', at) - at, element_length_m);
  std::ofstream(folder / "rotor.yaml") << shaft;
  return folder.string();
}

Model rubbing() {
  Model model = readModel(thesis + "flexible_model.yaml", effectCatalogue());
  model.folder = coarserShaft();
  fillFlexibleModes(model, 1e12);
  AMB_ROTOR_CHECK(model.flexible.mass.size() == modes, "28 nodes have 56 modes a plane");
  model.amb_model = AmbModel::equivalent;
  model.rig.amb.stiffness_N_per_m = stiffness_N_per_m;
  model.rig.amb.damping_N_s_per_m = damping_N_s_per_m;
  model.rig.unbalance[0].moment_kg_m = moment_kg_m;
  return model;
}

struct Setting {
  Model model = rubbing();
  Machine<double> machine{{&model}};
  Drive<double> drive;
  Setting() { drive.speed = speed_rad_s; }
};

const Setting& setting() {
  static const Setting one;
  return one;
}

/// Equations by hand, in units of 1e-5 m and 1e-2 m/s; guards are the gaps in 1e-5 m.
struct Problem {
  static constexpr double length = 1e-5, speed = 1e-2;
  double calls = 0.0;
  bool by_gap = true;
  int mode[2] = {0, 0};
  Eigen::VectorXd per_mass{modes}, stiffness{modes}, damping{modes}, force{2 * modes};
  Eigen::MatrixXd gyroscopic{modes, modes}, shape{modes, 5};  // of the bearings a, b, the ends a, b, the unbalance

  Problem() {
    const FlexibleModes& all = setting().model.flexible;
    const auto& rotor = setting().machine.rotor();
    for (int k = 0; k < modes; ++k) {
      per_mass[k] = 1.0 / all.mass[k];
      stiffness[k] = all.stiffness[k];
      damping[k] = all.damping[k];
      for (int l = 0; l < modes; ++l) gyroscopic(k, l) = all.gyroscopic[k * modes + l] * speed_rad_s;
      for (int e = 0; e < 2; ++e) {
        shape(k, e) = rotor.shape(plane_amb + e, k);
        shape(k, 2 + e) = rotor.shape(plane_aux + e, k);
      }
      shape(k, 4) = rotor.shape(plane_aux + 2, k);  // the unbalance's, the first behind those that every machine has
    }
  }
  int size() const { return 4 * modes; }
  int guards() const { return 2; }
  void by_state(bool on) { by_gap = on; }
  void flip(int end) { mode[end] = 1 - mode[end]; }
  void guard(double, const double* q, double* g) const {
    const Eigen::Map<const Eigen::VectorXd> x(q, modes), y(q + modes, modes);
    for (int e = 0; e < 2; ++e)
      g[e] = std::hypot(shape.col(2 + e).dot(x), shape.col(2 + e).dot(y)) -
             setting().model.rig.auxiliary_bearing.clearance_m / length;
  }
  void rate(double t, const double* q, double* out) {
    ++calls;
    using Column = Eigen::Map<const Eigen::VectorXd>;
    const Column x(q, modes), y(q + modes, modes), vx(q + 2 * modes, modes), vy(q + 3 * modes, modes);
    auto fx = force.head(modes), fy = force.tail(modes);
    fx.array() = -length * stiffness.array() * x.array() - speed * damping.array() * vx.array();
    fy.array() = -length * stiffness.array() * y.array() - speed * damping.array() * vy.array();
    fx.noalias() -= speed * (gyroscopic * vy);
    fy.noalias() += speed * (gyroscopic * vx);
    const auto& rig = setting().model.rig;
    const double turning = moment_kg_m * speed_rad_s * speed_rad_s, angle = speed_rad_s * t + rig.unbalance[0].phase_rad;
    fx += turning * std::cos(angle) * shape.col(4);
    fy += turning * std::sin(angle) * shape.col(4);
    fy[0] -= rig.rotor.mass_kg * rig.gravity_m_s2;
    const auto& aux = rig.auxiliary_bearing;
    for (int e = 0; e < 4; ++e) {
      const auto at = shape.col(e);
      const double dx = length * at.dot(x), dy = length * at.dot(y), wx = speed * at.dot(vx), wy = speed * at.dot(vy);
      double px, py;
      if (e < 2) {
        px = -stiffness_N_per_m * dx - damping_N_s_per_m * wx;
        py = -stiffness_N_per_m * dy - damping_N_s_per_m * wy;
      } else {
        const double r = std::sqrt(dx * dx + dy * dy);
        if (!(by_gap ? r > aux.clearance_m : mode[e - 2] != 0)) continue;
        const double nx = dx / r, ny = dy / r;
        double normal = aux.stiffness_N_per_m * (r - aux.clearance_m) + aux.damping_N_s_per_m * (nx * wx + ny * wy);
        normal = std::max(0.0, normal);  // restarted or not: its guard is the gap, the damper may let go before
        const double slip = aux.rotor_radius_m * speed_rad_s + nx * wy - ny * wx;
        const double friction = -aux.friction_coefficient * normal * std::tanh(slip / friction_regularisation_m_s);
        px = -normal * nx - friction * ny;
        py = -normal * ny + friction * nx;
      }
      fx += px * at;
      fy += py * at;
    }
    Eigen::Map<Eigen::VectorXd>(out, 2 * modes) = speed / length * Column(q + 2 * modes, 2 * modes);
    Eigen::Map<Eigen::VectorXd>(out + 2 * modes, modes).array() = 1.0 / speed * per_mass.array() * fx.array();
    Eigen::Map<Eigen::VectorXd>(out + 3 * modes, modes).array() = 1.0 / speed * per_mass.array() * fy.array();
  }
};

State start() {
  State q(4 * modes, 0.0);
  q[0] = start_m / Problem::length;
  return q;
}

/// End state in the peers' units.
template <class Stepper>
State ours(double tolerance, long* calls = nullptr) {
  const Simulator<double> sim(setting().machine, setting().drive, 0.0);
  MachineState<double> state = sim.atRest(0.0);
  state.mechanics[0] = start_m;
  Stepper stepper(setting().machine, tolerance);
  AMB_ROTOR_CHECK(sim.run(state, length_s, stepper, [](const Record<double>&) {}), stepper.result().reason());
  if constexpr (std::is_same_v<Stepper, ModalStepper>)
    AMB_ROTOR_CHECK(stepper.reason().empty(), "the rotor is linear between contacts: " + stepper.reason());
  if (calls != nullptr) *calls = stepper.statistics().evaluations;
  State out(4 * modes);
  for (std::size_t i = 0; i < out.size(); ++i)
    out[i] = state.mechanics[i] / (i < 2 * modes ? Problem::length : Problem::speed);
  return out;
}

/// The equations by hand are the machine's.
void checkProblem() {
  Problem problem;
  State q(4 * modes), by_hand(4 * modes), y(4 * modes), rate(4 * modes);
  for (int trial = 0; trial < 10; ++trial) {
    for (std::size_t i = 0; i < q.size(); ++i) {
      q[i] = (i % modes < 2 ? 18.0 : 0.1) * std::sin(1.7 * static_cast<double>(i) + trial);
      y[i] = q[i] * (i < 2 * modes ? Problem::length : Problem::speed);
    }
    const double t = 1e-3 * trial;
    problem.rate(t, q.data(), by_hand.data());
    Inputs<double> in;
    in.shaft = setting().drive.shaft(t);
    setting().machine.derivatives(in, y.data(), rate.data());
    for (std::size_t i = 0; i < q.size(); ++i) {
      const double scale = i < 2 * modes ? Problem::length : Problem::speed;
      AMB_ROTOR_CHECK(std::abs(rate[i] / scale - by_hand[i]) <= 1e-9 * (1.0 + std::abs(by_hand[i])),
                      "equations by hand differ in state " + std::to_string(i) + ": " + std::to_string(rate[i] / scale) +
                          " against " + std::to_string(by_hand[i]));
    }
  }
}

/// Largest error of the ends' places, over the clearance.
double error(const State& a) {
  static const State truth = ours<EventStepper>(1e-12);
  static const Problem problem;
  double most = 0.0;
  for (int e = 2; e < 4; ++e) {
    double x = 0.0, y = 0.0;
    for (int k = 0; k < modes; ++k) {
      x += problem.shape(k, e) * (a[k] - truth[k]);
      y += problem.shape(k, e) * (a[modes + k] - truth[modes + k]);
    }
    most = std::max(most, std::hypot(x, y));
  }
  return most * Problem::length / setting().model.rig.auxiliary_bearing.clearance_m;
}

void report(benchmark::State& state, const State& end, double calls, double tolerance) {
  state.counters["error"] = error(end);
  state.counters["calls"] = calls;
  state.counters["tolerance"] = tolerance;
}

template <class Run>
void peer(benchmark::State& state, double tolerance, const Run& run) {
  State q;
  double calls = 0.0;
  for (auto _ : state) {
    Problem problem;
    q = start();
    run(problem, length_s, q);
    calls = problem.calls;
    benchmark::DoNotOptimize(q.data());
  }
  report(state, q, calls, tolerance);
}

void own(benchmark::State& state, double tolerance) {
  State end;
  long calls = 0;
  for (auto _ : state) {
    end = ours<ModalStepper>(tolerance, &calls);
    benchmark::DoNotOptimize(end.data());
  }
  report(state, end, static_cast<double>(calls), tolerance);
}

std::string named(const char* name, double tolerance) {
  return std::string(name) + "/" + std::to_string(static_cast<int>(std::round(-std::log10(tolerance))));
}

const bool registered = [] {
  using benchmark::RegisterBenchmark;
  checkProblem();
  const auto add = [](const char* name, double tolerance, auto run) {
    return RegisterBenchmark(named(name, tolerance).c_str(), [=](benchmark::State& s) { peer(s, tolerance, run); })
        ->Unit(benchmark::kMillisecond);
  };
  for (double tolerance : {1e-5, 1e-6, 1e-7, 1e-8, 1e-9})
    RegisterBenchmark(named("modal", tolerance).c_str(), [=](benchmark::State& s) { own(s, tolerance); })
        ->Unit(benchmark::kMillisecond);
  const auto add_adaptive = [&](double tolerance) {
    add("odeint_dopri5", tolerance, [=](Problem& p, double end, State& q) {
      peers::runOdeint<peers::Dopri5<State>>(p, end, 1e-8, tolerance, q);
    });
#ifdef AMB_ROTOR_WITH_SUNDIALS
    for (bool restart : {false, true}) {
      const std::string kind = restart ? "_restarted" : "_roots";
      add(("arkode_dopri5" + kind).c_str(), tolerance, [=](Problem& p, double end, State& q) {
        peers::runArkode(p, ARKODE_DORMAND_PRINCE_7_4_5, restart, end, tolerance, q.data());
      });
      add(("cvode_adams" + kind).c_str(), tolerance, [=](Problem& p, double end, State& q) {
        peers::runCvode(p, CV_ADAMS, restart, end, tolerance, q.data());
      });
    }
#endif
  };
  for (double tolerance : {1e-5, 1e-7, 1e-9}) add_adaptive(tolerance);
#ifdef AMB_ROTOR_WITH_SUNDIALS
  // half a minute a run: its Jacobian by differences takes 224 calls, and hardly damped modes shorten its steps
  add("cvode_bdf_roots", 1e-6, [=](Problem& p, double end, State& q) {
    peers::runCvode(p, CV_BDF, false, end, 1e-6, q.data());
  })->Iterations(1)->Repetitions(1);
#endif
  return true;
}();

}  // namespace
}  // namespace amb_rotor
