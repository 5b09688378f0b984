// amb_rotor._core: reduction of a flexible rotor on its bearings.
#include <filesystem>

#include "amb_rotor/common/linear_algebra.hpp"
#include "amb_rotor/common/units.hpp"
#include "amb_rotor/machine/model_loading.hpp"
#include "amb_rotor/model/model_writer.hpp"
#include "amb_rotor/rotor/balanced_truncation.hpp"
#include "amb_rotor/rotor/rotor_geometry.hpp"
#include "bind.hpp"

namespace py = pybind11;

namespace amb_rotor {
namespace {

/// Magnitudes of the transfer functions, [frequency][output][input], and the largest singular value of their
/// difference at each frequency; in m/N. Without a reduced system only `before`.
struct Responses {
  std::vector<double> before, after, error;
};

void append(const Eigen::MatrixXcd& h, std::vector<double>& out) {
  for (Eigen::Index row = 0; row < h.rows(); ++row)
    for (Eigen::Index column = 0; column < h.cols(); ++column) out.push_back(std::abs(h(row, column)));
}

Responses responses(const StateSpace& full, const StateSpace* reduced,
                    const std::vector<double>& frequencies_hz) {
  Responses out;
  for (double hz : frequencies_hz) {
    const std::complex<double> s(0.0, radPerSecond(hz));
    const Eigen::MatrixXcd before = full.transfer(s);
    append(before, out.before);
    if (reduced == nullptr) continue;
    const Eigen::MatrixXcd after = reduced->transfer(s);
    append(after, out.after);
    out.error.push_back(spectralNorm(before - after));
  }
  return out;
}

/// The rotor of a model as it stands on its magnetic bearings: net stiffness and damping of the linear law.
class SupportedRotor {
 public:
  SupportedRotor(const Model& model, double speed_hz)
      : speed_(radPerSecond(speed_hz)), both_(speed_hz != 0.0) {
    if (model.rotor_model != RotorModel::flexible)
      throw InputError({{"", 0, "rotor.model", "", "must be flexible: a rigid rotor has nothing to reduce"}});
    const auto path = std::filesystem::path(model.folder) / model.rotor_geometry;
    rotor_ = std::make_unique<FlexibleRotor>(loadRotorGeometry(path.string()));
    const auto& rig = model.rig;
    const bool linear = model.amb_model == AmbModel::linear;
    stiffness_ = linear ? rig.amb.current_stiffness_N_per_A * rig.controller.kp_A_per_m -
                              rig.amb.displacement_stiffness_N_per_m
                        : rig.amb.stiffness_N_per_m;
    damping_ =
        linear ? rig.amb.current_stiffness_N_per_A * rig.controller.kd_A_s_per_m : rig.amb.damping_N_s_per_m;
    for (int end = 0; end < 2; ++end) {
      supports_.push_back(isotropicSupport(rig.planes.amb[end], stiffness_, damping_));
      forces_.push_back(rig.planes.amb[end]);
      sensors_.push_back(rig.planes.sensor[end]);
    }
  }
  const FlexibleRotor& rotor() const { return *rotor_; }
  StateSpace system(const ReducedRotor& rotor) const {
    return rotorStateSpace(rotor, supports_, speed_, forces_, sensors_, both_);
  }
  double stiffness() const { return stiffness_; }
  double damping() const { return damping_; }

 private:
  double speed_;
  bool both_;
  std::unique_ptr<FlexibleRotor> rotor_;
  std::vector<RotorSupport> supports_;
  std::vector<double> forces_, sensors_;
  double stiffness_ = 0.0, damping_ = 0.0;
};

}  // namespace

void bindReduce(py::module_& m) {
  m.def(
      "reduce_rotor",
      [](const Model& model, const std::string& method, int order, double speed_hz,
         const std::vector<double>& frequencies_hz) {
        const SupportedRotor supported(model, speed_hz);
        const int per_mode = speed_hz != 0.0 ? 4 : 2;  // states of a mode: two a plane
        if (method != "balanced" && order % per_mode != 0)
          throw InputError(
              {{"", 0, "--order", std::to_string(order),
                "must be a multiple of " + std::to_string(per_mode) + ": a mode has so many states"}});
        StateSpace full, reduced;
        Eigen::VectorXd hankel;
        double bound = 0.0;
        Responses seen;
        {
          const py::gil_scoped_release release;
          full = supported.system(allModes(supported.rotor()));
          const int states = static_cast<int>(full.a.rows());
          if (order < 0 || order > states)
            throw InputError(
                {{"", 0, "--order", std::to_string(order),
                  "must be from 1 to " + std::to_string(states) + ", the states of the full rotor"}});
          if (order > 0 && method == "balanced") {
            BalancedSystem balanced = balancedTruncation(full, order);
            reduced = std::move(balanced.system);
            hankel = std::move(balanced.hankel);
            bound = balanced.error_bound;
          } else {
            hankel = hankelSingularValues(full);
          }
          if (order > 0 && method == "modal")
            reduced = supported.system(reduceModal(supported.rotor(), order / per_mode));
          if (order > 0 && method == "balanced_rotor")
            reduced = supported.system(reduceBalanced(supported.rotor(), keptPlanes(model), order / per_mode));
          seen = responses(full, order > 0 ? &reduced : nullptr, frequencies_hz);
        }
        py::dict d;
        using Method = RotorReduction::Method;
        const RotorReduction& stated = model.reduction;
        d["model_reduction"] = stated.method == Method::by_frequency
                                   ? py::object(py::none())
                                   : py::object(py::str(std::string(reductionName(stated.method)) + ", " +
                                                        std::to_string(stated.modes) + " modes"));
        d["states"] = full.a.rows();
        d["order"] = order;
        d["hankel_m_per_N"] = ownedArray(std::vector<double>(hankel.data(), hankel.data() + hankel.size()));
        d["position_m_per_N"] = py::none();
        if (method == "balanced_rotor") {
          const Eigen::VectorXd position = positionSingularValues(supported.rotor(), keptPlanes(model));
          d["position_m_per_N"] = ownedArray(std::vector<double>(position.data(), position.data() + position.size()));
        }
        d["support_stiffness_N_per_m"] = supported.stiffness();
        d["support_damping_N_s_per_m"] = supported.damping();
        const std::vector<py::ssize_t> shape = {static_cast<py::ssize_t>(frequencies_hz.size()),
                                                static_cast<py::ssize_t>(full.c.rows()),
                                                static_cast<py::ssize_t>(full.b.cols())};
        d["before_m_per_N"] = ownedArray(std::move(seen.before), shape);
        if (order == 0) return d;
        d["error_bound_m_per_N"] =
            method == "balanced" ? py::object(py::float_(bound)) : py::object(py::none());
        d["after_m_per_N"] = ownedArray(std::move(seen.after), shape);
        d["error_m_per_N"] = ownedArray(std::move(seen.error));
        return d;
      },
      py::arg("model"), py::arg("method"), py::arg("order"), py::arg("speed_hz"), py::arg("frequencies_hz"),
      "Hankel singular values, and the transfer functions from forces at the magnetic bearings to "
      "displacements "
      "at the sensors, before and after a reduction to `order` states; order 0: only before.");
}

}  // namespace amb_rotor
