// amb_rotor._core: a machine linearised about its centre, for modes, maps and margins (amb_rotor/modal.py
// closes the sampled loop).
//
//   x' = A x + B i_force,   s = C x
//   x        mechanics of machine/machine.hpp   i_force  ax, ay, bx, by [A]   s  signals that are sampled [m]
// With coils, currents are in x and the commands take the place of i_force.
//
// Central differences of the machine's own equations, so every effect is in. What depends on the shaft's
// angle (a crack) enters by its mean over a turn. Left out: contact; the static position under gravity or
// load.
#include <Eigen/Core>

#include "amb_rotor/common/units.hpp"
#include "amb_rotor/machine/bearing_response.hpp"
#include "amb_rotor/machine/machine.hpp"
#include "bind.hpp"

namespace py = pybind11;

namespace amb_rotor {
namespace {

using Row = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

constexpr double displacement_step_m = 1e-7;
constexpr double velocity_step_m_s = 1e-4;
constexpr double current_step_A = 1e-4;
constexpr int angles_a_turn = 16;

py::array_t<double> asArray(const Row& matrix) {
  return ownedArray(std::vector<double>(matrix.data(), matrix.data() + matrix.size()),
                    {matrix.rows(), matrix.cols()});
}

struct LinearParts {
  Row a, b, c, sensor, amb, aux;
};

class Probe {
 public:
  Probe(const Machine<double>& machine, double speed) : machine_(machine), speed_(speed) {}

  void at(double angle) { shaft_ = Shaft<double>::at(angle, speed_, 0.0); }

  /// Rates, signals and the places at sensors, magnets and auxiliary bearings for a state and currents.
  Eigen::VectorXd operator()(const std::vector<double>& state, const double current[4]) const {
    const int n = machine_.stateSize();
    Inputs<double> in;
    in.shaft = shaft_;
    in.far_from_contact = true;
    in.force_current[0] = {current[0], current[1]};
    in.force_current[1] = {current[2], current[3]};
    std::copy(current, current + 4, in.target);
    Eigen::VectorXd out(n + 16);
    Observation<double> seen;
    machine_.observe(in, state.data(), out.data(), seen);
    Vec2<double> signal[2];
    machine_.signals(shaft_, state.data(), signal);
    double sampled[4] = {signal[0].x, signal[0].y, signal[1].x, signal[1].y};
    machine_.electrics().filtered(state.data() + machine_.electricsOffset(), sampled);
    for (int e = 0; e < 2; ++e) signal[e] = {sampled[2 * e], sampled[2 * e + 1]};
    for (int e = 0; e < 2; ++e) {
      const Vec2<double> all[4] = {signal[e], seen.sensor_position[e], seen.amb_position[e],
                                   seen.aux_position[e]};
      for (int k = 0; k < 4; ++k) {
        out[n + 4 * k + 2 * e] = all[k].x;
        out[n + 4 * k + 2 * e + 1] = all[k].y;
      }
    }
    return out;
  }

 private:
  const Machine<double>& machine_;
  double speed_;
  Shaft<double> shaft_;
};

LinearParts linearise(const Machine<double>& machine, double speed_hz) {
  const int n = machine.stateSize();
  const int coordinates = machine.coordinates();
  Probe probe(machine, radPerSecond(speed_hz));
  Row slopes = Row::Zero(n + 16, n + 4);
  for (int k = 0; k < angles_a_turn; ++k) {
    probe.at(two_pi * k / angles_a_turn);
    for (int j = 0; j < n + 4; ++j) {
      const double step = j >= n                                    ? current_step_A
                          : j >= coordinates && j < 2 * coordinates ? velocity_step_m_s
                                                                    : displacement_step_m;
      Eigen::VectorXd side[2];
      for (int sign = 0; sign < 2; ++sign) {
        std::vector<double> state(static_cast<std::size_t>(n), 0.0);
        machine.initialise(state.data());
        double current[4] = {0, 0, 0, 0};
        (j < n ? state[static_cast<std::size_t>(j)] : current[j - n]) += sign == 0 ? -step : step;
        side[sign] = probe(state, current);
      }
      slopes.col(j) += (side[1] - side[0]) / (2.0 * step * angles_a_turn);
    }
  }
  return {slopes.topLeftCorner(n, n),   slopes.topRightCorner(n, 4),  slopes.block(n, 0, 4, n),
          slopes.block(n + 4, 0, 4, n), slopes.block(n + 8, 0, 4, n), slopes.block(n + 12, 0, 4, n)};
}

void requireFinite(const char* name, double value) {
  if (!std::isfinite(value)) throw InputError({{"", 0, name, numberText(value), "must be a finite number"}});
}

}  // namespace

void bindModes(py::module_& m) {
  m.def(
      "linear_parts",
      [](const Model& model, double speed_hz) {
        requireModes(model);
        requireFinite("speed_hz", speed_hz);
        const Machine<double> machine({&model});
        const LinearParts parts = linearise(machine, speed_hz);
        py::dict d;
        d["a"] = asArray(parts.a);
        d["b"] = asArray(parts.b);
        d["c"] = asArray(parts.c);
        d["sensor"] = asArray(parts.sensor);
        d["amb"] = asArray(parts.amb);
        d["aux"] = asArray(parts.aux);
        d["coordinates"] = machine.coordinates();
        std::vector<double> mass;
        for (int k = 0; k < machine.rotor().modes(); ++k) mass.push_back(machine.rotor().mass(k));
        d["mass"] = ownedArray(std::move(mass));
        d["relaxation_weights"] = machine.relaxationWeights();
        d["relaxation_rates"] = machine.relaxationRates();
        // after the effects that change the rig (delay, amplifier)
        const auto& rig = machine.rig();
        d["amplifier_rate"] = radPerSecond(rig.amb.amplifier_bandwidth_hz);
        d["sample_rate_hz"] = rig.controller.sample_rate_hz;
        d["coils"] = machine.electrics().coils();
        d["delay_s"] = rig.controller.delay_s;
        const bool controlled = machine.ambModel() == AmbModel::linear;
        d["controlled"] = controlled;
        if (controlled) {
          const ControllerMatrices law = controllerMatrices(machine, radPerSecond(speed_hz));
          py::dict matrices;
          matrices["a"] = asArray(law.a);
          matrices["b"] = asArray(law.b);
          matrices["c"] = asArray(law.c);
          matrices["d"] = asArray(law.d);
          d["controller"] = matrices;
        }
        return d;
      },
      py::arg("model"), py::arg("speed_hz"));
  m.def(
      "equivalent_bearings",
      [](const Model& model, double speed_hz, const std::vector<double>& frequencies_hz) {
        requireModes(model);
        requireFinite("speed_hz", speed_hz);
        const Machine<double> machine({&model});
        const auto rows = equivalentBearings(machine, radPerSecond(speed_hz), frequencies_hz);
        const auto count = static_cast<py::ssize_t>(rows.size());
        std::vector<double> stiffness, damping;
        for (std::size_t axis = 0; axis < 4; ++axis)
          for (const auto& row : rows) {
            stiffness.push_back(row[axis].stiffness_N_per_m);
            damping.push_back(row[axis].damping_N_s_per_m);
          }
        return py::make_tuple(ownedArray(std::move(stiffness), {4, count}),
                              ownedArray(std::move(damping), {4, count}));
      },
      py::arg("model"), py::arg("speed_hz"), py::arg("frequencies_hz"),
      "Equivalent stiffness [N/m] and damping [N s/m] of ax, ay, bx, by (rows) at frequencies (columns).");
}

}  // namespace amb_rotor
