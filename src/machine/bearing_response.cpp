#include "amb_rotor/machine/bearing_response.hpp"

#include <cmath>


#include "amb_rotor/common/linear_algebra.hpp"
#include "amb_rotor/common/units.hpp"

namespace amb_rotor {
namespace {

constexpr double displacement_step_m = 1e-7;
constexpr double current_step_A = 1e-4;

struct Look {
  double force[4], position[4], signal[4];
};

/// Forces and signals with the rotor moved by dx, dy and the same current in all axes.
Look lookAt(const Machine<double>& machine, double speed, double dx, double dy, double current) {
  std::vector<double> state(static_cast<std::size_t>(machine.stateSize()), 0.0);
  machine.initialise(state.data());
  state[0] += dx;
  state[static_cast<std::size_t>(machine.rotor().modes())] += dy;
  Inputs<double> in;
  in.shaft = Shaft<double>::at(0.0, speed, 0.0);
  in.far_from_contact = true;
  for (auto& i : in.force_current) i = {current, current};
  const double rest[4] = {0.0, 0.0, 0.0, 0.0}, currents[4] = {current, current, current, current};
  machine.electrics().set(rest, rest, currents, state.data() + machine.electricsOffset());
  Observation<double> seen;
  machine.observe(in, state.data(), nullptr, seen);
  Vec2<double> signal[2];
  machine.signals(in.shaft, state.data(), signal);
  Look look{};
  for (int a = 0; a < 4; ++a) {
    const auto part = [&](const Vec2<double>* v) { return a % 2 == 0 ? v[a / 2].x : v[a / 2].y; };
    look.force[a] = part(seen.bearing_force);
    look.position[a] = part(seen.amb_position);
    look.signal[a] = part(signal);
  }
  return look;
}

using Complex = std::complex<double>;

/// C(z) from a translation of both ends' signals of an axis (x 0, y 1) to the command of axis `a`.
Complex translationGain(const ControllerMatrices& m, int a, Complex z) {
  const Eigen::Index n = m.a.rows();
  const Eigen::VectorXd in = m.b.col(a % 2) + m.b.col(2 + a % 2);
  const double direct = m.d(a, a % 2) + m.d(a, 2 + a % 2);
  if (n == 0) return -direct;
  const Eigen::MatrixXcd resolvent = z * Eigen::MatrixXcd::Identity(n, n) - m.a.cast<Complex>();
  const Eigen::VectorXcd states = solveLu(resolvent, Eigen::VectorXcd(in.cast<Complex>()));
  return -(m.c.row(a).cast<Complex>() * states)(0) - direct;
}

/// Leaves out the states that no command and no other state sees: integrators without a gain.
void dropUnseen(ControllerMatrices& m) {
  for (bool found = true; found;) {
    found = false;
    const Eigen::Index n = m.a.rows();
    for (Eigen::Index k = 0; k < n && !found; ++k) {
      const double seen = m.c.col(k).cwiseAbs().sum() + m.a.col(k).cwiseAbs().sum() - std::fabs(m.a(k, k));
      if (seen > 0.0) continue;
      found = true;
      const auto keep = [&](const Eigen::MatrixXd& matrix, bool rows, bool columns) {
        Eigen::MatrixXd out(matrix.rows() - (rows ? 1 : 0), matrix.cols() - (columns ? 1 : 0));
        for (Eigen::Index r = 0; r < out.rows(); ++r)
          for (Eigen::Index c = 0; c < out.cols(); ++c)
            out(r, c) = matrix(rows && r >= k ? r + 1 : r, columns && c >= k ? c + 1 : c);
        return out;
      };
      m.a = keep(m.a, true, true);
      m.b = keep(m.b, true, false);
      m.c = keep(m.c, false, true);
    }
  }
}

}  // namespace

std::array<AxisSlopes, 4> axisSlopes(const Machine<double>& machine, double speed) {
  std::array<AxisSlopes, 4> slopes;
  const double d = displacement_step_m, i = current_step_A;
  const Look more = lookAt(machine, speed, 0.0, 0.0, i), less = lookAt(machine, speed, 0.0, 0.0, -i);
  for (int a = 0; a < 4; ++a) {
    const double dx = a % 2 == 0 ? d : 0.0, dy = a % 2 == 0 ? 0.0 : d;
    const Look up = lookAt(machine, speed, dx, dy, 0.0), down = lookAt(machine, speed, -dx, -dy, 0.0);
    const double moved = up.position[a] - down.position[a];
    slopes[static_cast<std::size_t>(a)] = {(more.force[a] - less.force[a]) / (2.0 * i),
                                           (up.force[a] - down.force[a]) / moved,
                                           (up.signal[a] - down.signal[a]) / moved};
  }
  return slopes;
}

ControllerMatrices controllerMatrices(const Machine<double>& machine, double speed) {
  // without the converters: they are no linear system
  const Controller<double> controller(machine.rig(), machine.controlOptions(), SignalChain());
  const auto extra = static_cast<Eigen::Index>(controller.memorySize());
  const Eigen::Index n = 12 + extra;
  ControllerMatrices m;
  m.a.resize(n, n);
  m.b.resize(n, 4);
  m.c.resize(4, n);
  m.d.resize(4, 4);
  for (Eigen::Index k = 0; k < n + 4; ++k) {  // one state or signal is 1, all others are 0: the columns
    Eigen::VectorXd state = Eigen::VectorXd::Zero(n);
    double signal[4] = {0.0, 0.0, 0.0, 0.0}, command[4];
    (k < n ? state[k] : signal[k - n]) = 1.0;
    PidMemory<double> pid[4];
    for (int a = 0; a < 4; ++a) pid[a] = {state[3 * a], state[3 * a + 1], state[3 * a + 2]};
    std::vector<double> memory(state.data() + 12, state.data() + n);
    controller.sample(signal, speed, pid, memory.data(), command);
    Eigen::VectorXd next(n);
    for (int a = 0; a < 4; ++a) next.segment(3 * a, 3) << pid[a].previous_signal, pid[a].derivative, pid[a].integral;
    for (Eigen::Index i = 0; i < extra; ++i) next[12 + i] = memory[static_cast<std::size_t>(i)];
    const Eigen::Map<const Eigen::Vector4d> out(command);
    if (k < n) {
      m.a.col(k) = next;
      m.c.col(k) = out;
    } else {
      m.b.col(k - n) = next;
      m.d.col(k - n) = out;
    }
  }
  dropUnseen(m);
  return m;
}

ControlPath controlPath(const Machine<double>& machine, double speed, int axis, double sensor_gain) {
  AMB_ROTOR_CHECK(machine.ambModel() == AmbModel::linear, "a bearing with a controller");
  const Rig<double>& rig = machine.rig();
  ControlPath path;
  path.sample_rate_hz = rig.controller.sample_rate_hz;
  path.delay_s = rig.controller.delay_s;
  path.amplifier_rate = radPerSecond(rig.amb.amplifier_bandwidth_hz);
  path.relaxation_weights = machine.relaxationWeights();
  path.relaxation_rates = machine.relaxationRates();
  const auto& electrics = machine.electrics();
  path.sensor = [&electrics, sensor_gain](double w) { return sensor_gain * electrics.filterResponse(w); };
  if (electrics.coils()) path.motional_gain = electrics.coil().motionalGain();
  path.controller = [matrices = controllerMatrices(machine, speed), axis](Complex z) {
    return translationGain(matrices, axis, z);
  };
  return path;
}

std::vector<std::array<EquivalentBearing, 4>> equivalentBearings(const Machine<double>& machine, double speed,
                                                                 const std::vector<double>& frequencies_hz) {
  const auto slopes = axisSlopes(machine, speed);
  std::vector<std::array<EquivalentBearing, 4>> rows(frequencies_hz.size());
  for (int axis = 0; axis < 4; ++axis) {
    const auto a = static_cast<std::size_t>(axis);
    const ControlPath path = controlPath(machine, speed, axis, slopes[a].sensor_gain);
    for (std::size_t i = 0; i < rows.size(); ++i)
      rows[i][a] = equivalentBearing(pathResponse(path, frequencies_hz[i]), slopes[a].ki, slopes[a].ks,
                                     frequencies_hz[i]);
  }
  return rows;
}

}  // namespace amb_rotor
