#include "amb_rotor/validation/common_gain.hpp"

#include <algorithm>
#include <cmath>
#include <string>

namespace amb_rotor {
namespace {

constexpr int sensors = 4;
const char* const current_stiffness = "amb.current_stiffness_N_per_A";
const char* const gain = "sensor_gain_error.";
/// Loads, and displacements that turn with the shaft, of the rig and of effects; a plane among an effect's numbers is none.
const char* const loads[] = {"unbalance.moment_kg_m", "static_load.", "couple_unbalance.", "shaft_bow.", "sensor_runout."};
const std::string plane = "z_m";

bool begins(const std::string& name, const char* with) { return name.rfind(with, 0) == 0; }

bool isPlane(const std::string& name) {
  return name.size() >= plane.size() && name.compare(name.size() - plane.size(), plane.size(), plane) == 0;
}

}  // namespace

Eigen::VectorXd alongCommonGain(const FitSpace& space, const Eigen::VectorXd& x) {
  Eigen::VectorXd out = Eigen::VectorXd::Zero(x.size());
  int gains = 0;
  bool stiffness = false;
  for (int k = 0; k < space.size(); ++k) {
    const std::string& name = space.coordinates()[k].name;
    const bool is_gain = begins(name, gain), is_stiffness = name == current_stiffness;
    const bool is_load = !isPlane(name) && std::any_of(std::begin(loads), std::end(loads), [&](const char* one) { return begins(name, one); });
    if (is_gain || is_stiffness || is_load) out[k] = x[k];
    gains += is_gain ? 1 : 0;
    stiffness = stiffness || is_stiffness;
  }
  return gains == sensors && stiffness ? out : Eigen::VectorXd(Eigen::VectorXd::Zero(x.size()));
}

PullOfBeliefs pullAlong(const FitSpace& space, const Eigen::VectorXd& x, const Eigen::VectorXd& direction) {
  double pull = 0.0, bend = 0.0;
  for (int k = 0; k < space.nuisances(); ++k) {
    const Coordinate& c = space.coordinates()[k];
    const double along = direction[k] / c.prior_std;
    pull += along * (c.prior_mean - x[k]) / c.prior_std;
    bend += along * along;
  }
  return bend > 0.0 ? PullOfBeliefs{pull / bend, 1.0 / std::sqrt(bend)} : PullOfBeliefs{};
}

void widenAlong(const Eigen::VectorXd& deviation, Eigen::MatrixXd& covariance) {
  double known = 1.0;  // the least share of its variance along the direction that a coordinate has already
  for (long k = 0; k < deviation.size(); ++k)
    if (deviation[k] != 0.0) known = std::min(known, covariance(k, k) / (deviation[k] * deviation[k]));
  if (deviation.allFinite()) covariance += (1.0 - known) * deviation * deviation.transpose();
}

}  // namespace amb_rotor
