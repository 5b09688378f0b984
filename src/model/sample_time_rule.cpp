// Refuses a sample rate at which the loop is unstable though it is stable when it is sampled faster.
//
// The loop of a rigid rotor (x, b) at standstill with the two bearings of one plane, from one sample to the next, exactly:
//   m x'' = Fa + Fb,  It b'' = za Fa + zb Fb,  F = Ki i + Ks (x + z b),  i' = wa (u - i)
//   u = the command of magnetic_bearing/pid.hpp on the signal x + s b, delay_s after its sample, held for a period
// A loop that is unstable at any rate (no gain, not enough of it, too long a delay) is physics, and no fault of the file.
// Symbols: z, s planes of magnets and sensors [m]; wa amplifier [rad/s]. Left out: sections, other laws, filters, coils
// (such models are not checked), limits of the current, bending modes, spin.
#include <algorithm>
#include <cmath>
#include <vector>

#include "amb_rotor/common/linear_algebra.hpp"
#include "amb_rotor/common/units.hpp"
#include "amb_rotor/model/model_rules.hpp"
#include "control_text.hpp"

namespace amb_rotor {
namespace {

/// How many times faster, with delay lines of at most so many samples (the matrices are of that order).
constexpr int times_faster = 8, longest_line = 40;
/// Above the round-off of eigenvalues of 1, far below any growth that can be seen.
constexpr double growth_tolerance = 1e-7;

class SampledLoop {
 public:
  SampledLoop(const Model& model, int faster) : rig_(model.rig), tilts_(model.rotor_model != RotorModel::rigid_mass) {
    period_ = 1.0 / (rig_.controller.sample_rate_hz * faster);
    line_ = static_cast<int>(std::floor(rig_.controller.delay_s / period_ + 1e-9));
    rest_ = std::max(0.0, rig_.controller.delay_s - line_ * period_);
    pole_ = std::exp(-two_pi * rig_.controller.derivative_filter_hz * period_);
    before_ = matrixExponential(rest_ * motion());
    after_ = matrixExponential((period_ - rest_) * motion());
  }

  /// The largest growth of a motion from one sample to the next.
  double growth() const {
    const int n = mechanics + memory + 2 * (line_ + 1);
    Eigen::MatrixXd map(n, n);
    for (int i = 0; i < n; ++i) map.col(i) = step(Eigen::VectorXd::Unit(n, i));
    return generalEigenvalues(map).cwiseAbs().maxCoeff();
  }

 private:
  static constexpr int mechanics = 6, memory = 6;  ///< x, b, x', b', ia, ib; derivative, signal, integral of each

  /// Of mechanics and the two held commands.
  Eigen::MatrixXd motion() const {
    Eigen::MatrixXd a = Eigen::MatrixXd::Zero(mechanics + 2, mechanics + 2);
    a(0, 2) = a(1, 3) = 1.0;
    const double mass[2] = {rig_.rotor.mass_kg, rig_.rotor.transverse_inertia_kg_m2};
    for (int end = 0; end < 2; ++end) {
      const double arm[2] = {1.0, tilts_ ? rig_.planes.amb[end] : 0.0};
      for (int row = 0; row < 2; ++row) {
        for (int column = 0; column < 2; ++column)
          a(2 + row, column) += rig_.amb.displacement_stiffness_N_per_m * arm[row] * arm[column] / mass[row];
        a(2 + row, 4 + end) = rig_.amb.current_stiffness_N_per_A * arm[row] / mass[row];
      }
      a(4 + end, 4 + end) = -radPerSecond(rig_.amb.amplifier_bandwidth_hz);
      a(4 + end, 6 + end) = -a(4 + end, 4 + end);
    }
    if (!tilts_) a(1, 1) = a(3, 3) = -1.0;  // no tilt: what is not there dies out
    return a;
  }

  Eigen::VectorXd step(const Eigen::VectorXd& from) const {
    const auto& c = rig_.controller;
    Eigen::VectorXd to = from, held(mechanics + 2);
    double* line = to.data() + mechanics + memory;  // commands, the latest first, a and b of each
    const double oldest[2] = {line[2 * line_], line[2 * line_ + 1]};
    double latest[2];
    for (int end = 0; end < 2; ++end) {
      const double signal = from(0) + (tilts_ ? rig_.planes.sensor[end] * from(1) : 0.0);
      double* own = to.data() + mechanics + 3 * end;
      own[0] = pole_ * own[0] + (1.0 - pole_) * (signal - own[1]) / period_;
      own[1] = signal;
      if (c.ki_A_per_m_s > 0.0) own[2] += period_ * signal;
      else own[2] = 0.0;
      latest[end] = -(c.kp_A_per_m * signal + c.kd_A_s_per_m * own[0] + c.ki_A_per_m_s * own[2]);
    }
    for (int i = 2 * line_ + 1; i >= 2; --i) line[i] = line[i - 2];
    line[0] = latest[0], line[1] = latest[1];
    held.head(mechanics) = from.head(mechanics);
    held.tail(2) << oldest[0], oldest[1];
    held = before_ * held;
    held.tail(2) << line[2 * line_], line[2 * line_ + 1];
    held = after_ * held;
    to.head(mechanics) = held.head(mechanics);
    return to;
  }

  const Rig<double>& rig_;
  bool tilts_;
  double period_ = 0.0, rest_ = 0.0, pole_ = 0.0;
  int line_ = 0;
  Eigen::MatrixXd before_, after_;
};

}  // namespace

void checkSampleTime(const Model& model, std::vector<Fault>& faults) {
  if (model.amb_model != AmbModel::linear || !model.control.plain() || model.coil || model.signal_chain.anti_alias) return;
  const double rate = model.rig.controller.sample_rate_hz;
  const double grown = SampledLoop(model, 1).growth();
  if (!(grown > 1.0 + growth_tolerance)) return;
  const double samples = std::max(1.0, std::ceil(model.rig.controller.delay_s * rate));
  const int faster = std::max(2, std::min(times_faster, static_cast<int>(longest_line / samples)));
  if (!(SampledLoop(model, faster).growth() < 1.0 - growth_tolerance)) return;
  faults.push_back({"", 0, "rig.controller.sample_rate_hz", numberText(rate),
                    "is too low: the loop grows by " + numberText(std::round(1e4 * (grown - 1.0)) / 100.0) +
                        " % a sample, and is stable at " + numberText(faster * rate) + " Hz"});
}

}  // namespace amb_rotor
