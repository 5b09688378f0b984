// A rotor reduced by balanced truncation in runs, beside the full one: levitated, and dropped into auxiliary bearings that
// lie between nodes.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "../support/models.hpp"
#include "amb_rotor/machine/model_loading.hpp"
#include "amb_rotor/rotor/flexible_rotor.hpp"
#include "amb_rotor/rotor/rotor_geometry.hpp"

namespace amb_rotor {
namespace {

using namespace testing_support;

/// The thesis's rotor; auxiliary bearings at 0.141 m, no node of its geometry.
Model thesisRotor(RotorReduction reduction, double highest_hz) {
  Model model = withUnbalance(levitated(), 2e-5, 0.3, 0.02);
  model.rotor_model = RotorModel::flexible;
  model.rotor_geometry = std::string(AMB_ROTOR_SOURCE_DIR) + "/config/thesis/rotor.yaml";
  model.rig.gravity_m_s2 = 9.81;
  model.rig.planes.aux[0] = -0.141;
  model.rig.planes.aux[1] = 0.141;
  model.rig.auxiliary_bearing.damping_N_s_per_m = 3000.0;
  model.reduction = reduction;
  fillFlexibleModes(model, highest_hz);
  return model;
}

Trajectory runOf(const Model& model, const Scenario& scenario) {
  const Simulation run = simulate(model, scenario);
  EXPECT_EQ(run.outcome.status, RunStatus::ok) << run.outcome.reason;
  return run.trajectory;
}

double apart(const Trajectory& a, const Trajectory& b, double until_s) {
  double most = 0.0;
  for (int axis = 0; axis < 4; ++axis)
    for (std::size_t i = 0; i < a.time_s.size() && a.time_s[i] < until_s; ++i)
      most = std::max(most, std::fabs(a.aux_position_m[axis][i] - b.aux_position_m[axis][i]));
  return most;
}

TEST(MachineBalancedRotor, RunsAsTheFullOneLevitatedAndThroughContact) {
  const RotorReduction balanced = {RotorReduction::Method::balanced, 10}, rigid = {RotorReduction::Method::modal, 2};
  const FlexibleRotor rotor(loadRotorGeometry(std::string(AMB_ROTOR_SOURCE_DIR) + "/config/thesis/rotor.yaml"));
  for (const double z : rotor.grid().z) EXPECT_GT(std::fabs(std::fabs(z) - 0.141), 1e-4) << "a node";
  const Model full = thesisRotor({}, 1e12), kept = thesisRotor(balanced, 1e12), stiff = thesisRotor(rigid, 1e12);
  EXPECT_GT(full.flexible.mass.size(), 60u);
  ASSERT_EQ(kept.flexible.mass.size(), 10u);
  const Scenario scenario = bearingsOff(constantSpeed(60.0, 0.03), 0.005);
  const Trajectory right = runOf(full, scenario), own = runOf(kept, scenario), crude = runOf(stiff, scenario);
  ASSERT_GE(right.contacts.size(), 2u);
  double touch = 1.0, force = 0.0;
  for (const auto& span : right.contacts) touch = std::min(touch, span.from_s);
  for (const auto& normal : right.normal_force_N) force = std::max(force, largest(normal));
  EXPECT_GT(force, 50.0);
  const double clearance = full.rig.auxiliary_bearing.clearance_m;
  // before contact: what modes above the eight kept yield to the bearings' forces, 1e-10 m/N times some newtons
  EXPECT_LT(apart(own, right, touch), 1e-5 * clearance);
  // through contact: the first impact depends on the shaft's yielding at its plane, and each multiplies what is off
  EXPECT_LT(apart(own, right, touch + 3e-3), 2e-3 * clearance);
  EXPECT_GT(apart(crude, right, touch + 3e-3), 5.0 * apart(own, right, touch + 3e-3)) << "bending matters here";
}

TEST(MachineBalancedRotor, IsRefusedByNameWhereItCannotBe) {
  const auto keyOf = [](int modes) {
    try {
      thesisRotor({RotorReduction::Method::balanced, modes}, 1e12);
    } catch (const InputError& error) {
      return error.faults().front().key;
    }
    return std::string();
  };
  EXPECT_EQ(keyOf(65), "rotor.reduction.modes") << "more than the geometry has";
  EXPECT_EQ(keyOf(10), "");
}

}  // namespace
}  // namespace amb_rotor
