// Refuses a sample rate at which the loop is unstable though it is stable when it is sampled faster. Declared by the model's
// rules; here, because it closes the loop with the controller, filters and coils that runs have.
//
// The loop of a rigid rotor (x, b) at standstill with the two bearings of one plane, from one sample to the next, exactly:
//   m x'' = Fa + Fb,  It b'' = za Fa + zb Fb,  F = Ki i + Ks (x + z b)
//   i' = wa (u - i), or of coils magnetic_bearing/coil.hpp;  anti-alias filters magnetic_bearing/electrics.hpp
//   u = the command of magnetic_bearing/controller.hpp on the signal x + s b, delay_s after its sample, held for a period
// A loop that is unstable at any rate (no gain, not enough of it, too long a delay) is physics, and no fault of the file.
// Symbols: z, s planes of magnets and sensors [m]; wa amplifier [rad/s]. Left out: state-space laws and biquads, whose
// numbers belong to their rate; unbalance force rejection, limits of current and voltage, converters, effects, bending modes, spin.
#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "amb_rotor/common/linear_algebra.hpp"
#include "amb_rotor/common/units.hpp"
#include "amb_rotor/magnetic_bearing/controller.hpp"
#include "amb_rotor/magnetic_bearing/electrics.hpp"
#include "amb_rotor/model/model_rules.hpp"
#include "amb_rotor/model/yaml_document.hpp"

namespace amb_rotor {
namespace {

/// How many times faster, first and at most, with delay lines of at most so many samples (the matrices are of that order).
constexpr int times_faster = 8, most_times_faster = 1 << 17, longest_line = 40;
/// Above the round-off of eigenvalues of 1, far below any growth that can be seen.
constexpr double growth_tolerance = 1e-7;
/// Of states and commands when columns are taken: far below the voltage limit.
constexpr double probe = 1e-9;

/// Whether the law says what it does at other rates.
bool isOfAnyRate(const ControlOptions& control) {
  if (control.type != ControllerType::pid) return false;
  for (const auto* channel : {&control.main, &control.tilt})
    for (const ControllerSection& section : channel->sections)
      if (section.type == SectionType::biquad) return false;
  return true;
}

ControlOptions withoutRejection(const Model& model) {
  ControlOptions options = model.control;
  options.unbalance_rejection.reset();
  return options;
}

Rig<double> sampledAt(const Model& model, int faster) {
  Rig<double> rig = model.rig;
  rig.controller.sample_rate_hz *= faster;
  return rig;
}

class SampledLoop {
 public:
  SampledLoop(const Model& model, int faster)
      : rig_(sampledAt(model, faster)),
        tilts_(model.rotor_model != RotorModel::rigid_mass),
        controller_(rig_, withoutRejection(model), SignalChain()),
        electrics_(rig_, model.signal_chain, model.coil) {
    const double period = controller_.period(), delay = rig_.controller.delay_s;
    line_ = static_cast<int>(std::floor(delay / period + 1e-9));
    const double rest = std::max(0.0, delay - line_ * period);
    before_ = matrixExponential(rest * motion());
    after_ = matrixExponential((period - rest) * motion());
    const double own = rig_.controller.ki_A_per_m_s;
    integrates_[0] = own > 0.0;
    integrates_[1] = (model.control.decoupled ? model.control.tilt.ki_A_per_m_s : own) > 0.0;
  }

  /// The largest growth of a motion from one sample to the next.
  double growth() const {
    const int n = continuous() + memory() + 2 * (line_ + 1);
    Eigen::MatrixXd map(n, n);
    for (int i = 0; i < n; ++i) map.col(i) = step(Eigen::VectorXd::Unit(n, i));
    if (!map.allFinite()) return std::numeric_limits<double>::infinity();  // beyond all numbers within a sample
    return generalEigenvalues(map).cwiseAbs().maxCoeff();
  }

 private:
  static constexpr int rotor = 4, ends = 2;  ///< x, b, x', b'; the axes ax, bx
  static constexpr int of_pid = 6;           ///< derivative, signal, integral of each

  /// Rotor, filters and coils, currents of the amplifiers.
  int continuous() const { return rotor + electrics_.size() + ends; }
  int memory() const { return of_pid + static_cast<int>(controller_.memorySize()); }

  /// Displacements and velocities at two planes, on the axes ax, ay, bx, by.
  void at(const double planes[2], const double* y, double place[4], double velocity[4]) const {
    for (int end = 0; end < ends; ++end) {
      const double arm = tilts_ ? planes[end] : 0.0;
      place[2 * end] = y[0] + arm * y[1];
      velocity[2 * end] = y[2] + arm * y[3];
      place[2 * end + 1] = velocity[2 * end + 1] = 0.0;
    }
  }

  Eigen::VectorXd slope(const Eigen::VectorXd& y, const double command[ends]) const {
    Eigen::VectorXd out = Eigen::VectorXd::Zero(y.size());
    double signal[4], place[4], velocity[4], unused[4], current[4] = {}, target[4] = {command[0], 0.0, command[1], 0.0};
    at(rig_.planes.sensor, y.data(), signal, unused);
    at(rig_.planes.amb, y.data(), place, velocity);
    const double* own = y.data() + rotor;
    electrics_.rates(signal, velocity, target, own, out.data() + rotor);
    const int amplifiers = rotor + electrics_.size();
    for (int end = 0; end < ends; ++end) {
      current[2 * end] = y[amplifiers + end];
      out[amplifiers + end] = radPerSecond(rig_.amb.amplifier_bandwidth_hz) * (command[end] - y[amplifiers + end]);
    }
    electrics_.currents(own, current);
    out[0] = y[2];
    out[1] = y[3];
    for (int end = 0; end < ends; ++end) {
      const double force = rig_.amb.current_stiffness_N_per_A * current[2 * end] +
                           rig_.amb.displacement_stiffness_N_per_m * place[2 * end];
      out[2] += force / rig_.rotor.mass_kg;
      if (tilts_) out[3] += rig_.planes.amb[end] * force / rig_.rotor.transverse_inertia_kg_m2;
    }
    if (!tilts_) out[1] = -y[1], out[3] = -y[3];  // no tilt: what is not there dies out
    return out;
  }

  /// Of what is continuous and the two held commands.
  Eigen::MatrixXd motion() const {
    const int n = continuous();
    Eigen::MatrixXd a = Eigen::MatrixXd::Zero(n + ends, n + ends);
    for (int k = 0; k < n + ends; ++k) {
      Eigen::VectorXd y = Eigen::VectorXd::Zero(n);
      double command[ends] = {};
      (k < n ? y[k] : command[k - n]) = probe;
      a.col(k).head(n) = slope(y, command) / probe;
    }
    return a;
  }

  Eigen::VectorXd step(const Eigen::VectorXd& from) const {
    const int n = continuous();
    Eigen::VectorXd to = from, held(n + ends);
    double* own = to.data() + n;
    double* line = own + memory();  // commands, the latest first, a and b of each
    const double oldest[ends] = {line[2 * line_], line[2 * line_ + 1]};

    double signal[4], unused[4], command[4];
    at(rig_.planes.sensor, from.data(), signal, unused);
    electrics_.filtered(from.data() + rotor, signal);
    PidMemory<double> pid[4];
    for (int end = 0; end < ends; ++end)
      pid[2 * end] = {own[3 * end], own[3 * end + 1], integrates_[end] ? own[3 * end + 2] : 0.0};
    controller_.sample(signal, 0.0, pid, own + of_pid, command);
    for (int end = 0; end < ends; ++end) {
      own[3 * end] = pid[2 * end].previous_signal;
      own[3 * end + 1] = pid[2 * end].derivative;
      own[3 * end + 2] = integrates_[end] ? pid[2 * end].integral : 0.0;
    }

    for (int i = 2 * line_ + 1; i >= 2; --i) line[i] = line[i - 2];
    line[0] = command[0], line[1] = command[2];
    held.head(n) = from.head(n);
    held.tail(ends) << oldest[0], oldest[1];
    held = before_ * held;
    held.tail(ends) << line[2 * line_], line[2 * line_ + 1];
    held = after_ * held;
    to.head(n) = held.head(n);
    return to;
  }

  Rig<double> rig_;
  bool tilts_;
  Controller<double> controller_;
  Electrics<double> electrics_;
  bool integrates_[ends] = {};
  int line_ = 0;
  Eigen::MatrixXd before_, after_;
};

}  // namespace

void checkSampleTime(const Model& model, std::vector<Fault>& faults) {
  if (model.amb_model != AmbModel::linear || !isOfAnyRate(model.control)) return;
  const double rate = model.rig.controller.sample_rate_hz;
  const double grown = SampledLoop(model, 1).growth();
  if (!(grown > 1.0 + growth_tolerance)) return;
  // a rate far too low is stable only at one that is far higher
  const double samples = std::max(1.0, std::ceil(model.rig.controller.delay_s * rate));
  int faster = std::max(2, std::min(times_faster, static_cast<int>(longest_line / samples)));
  while (!(SampledLoop(model, faster).growth() < 1.0 - growth_tolerance)) {
    faster *= 2;
    if (faster > most_times_faster || model.rig.controller.delay_s * rate * faster > longest_line) return;
  }
  faults.push_back({"", 0, "rig.controller.sample_rate_hz", numberText(rate),
                    "is too low: the loop grows by " +
                        (std::isfinite(grown) ? numberText(std::round(1e4 * (grown - 1.0)) / 100.0) : "any number of") +
                        " % a sample, and is stable at " + numberText(faster * rate) + " Hz"});
}

}  // namespace amb_rotor
