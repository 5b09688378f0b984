// A run ends where the rotor reaches a magnet, and says which, when and how far.
#include <gtest/gtest.h>

#include <cmath>

#include "amb_rotor/machine/model_loading.hpp"
#include "../support/models.hpp"

namespace amb_rotor {
namespace {

using namespace testing_support;

constexpr double weight_m_s2 = 9.81;

/// Auxiliary bearings that hold nothing, so that a rotor without power falls onto its magnets.
Model withoutFloor(Model model) {
  model.rig.auxiliary_bearing.stiffness_N_per_m = 1.0;
  model.rig.auxiliary_bearing.damping_N_s_per_m = 0.0;
  model.rig.gravity_m_s2 = weight_m_s2;
  return model;
}

/// A rotor in the middle that falls from the start on.
Scenario falling(double record_rate_hz, double duration_s = 0.05) {
  return bearingsOff(from(constantSpeed(0.0, duration_s, record_rate_hz), {0.0, 0.0, 0.0, 0.0}, {}), 0.0);
}

/// What is seen of a fall through an air gap: at a sample of the controller, at most one after the rotor is there.
/// @param off  share by which the fall may be another: the auxiliary bearing's 1 N/m makes 1e-7
void expectFall(const Simulation& run, double air_gap_m, double sample_rate_hz, double off = 1e-5) {
  ASSERT_EQ(run.outcome.status, RunStatus::magnet_hit) << run.outcome.reason;
  ASSERT_TRUE(run.outcome.magnet_hit.has_value());
  const MagnetHit& hit = *run.outcome.magnet_hit;
  const double there = std::sqrt(2.0 * air_gap_m / weight_m_s2);
  EXPECT_GE(hit.time_s, there * (1.0 - off));
  EXPECT_LE(hit.time_s, there + 1.0 / sample_rate_hz);
  EXPECT_NEAR(hit.displacement_m, 0.5 * weight_m_s2 * hit.time_s * hit.time_s, off * air_gap_m);
  EXPECT_EQ(hit.air_gap_m, air_gap_m);
  EXPECT_EQ(run.outcome.time_s, hit.time_s);
  EXPECT_EQ(run.final_state.time, hit.time_s);
  ASSERT_FALSE(run.trajectory.time_s.empty()) << "what was reached is kept";
  EXPECT_LE(run.trajectory.time_s.back(), hit.time_s);
}

TEST(MagnetHit, AFallEndsAtTheAirGapWhateverIsRecorded) {
  const Model model = withoutFloor(levitated());
  for (const double record_rate_hz : {20.0, 10000.0})
    expectFall(simulate(model, falling(record_rate_hz)), model.rig.amb.air_gap_m, model.rig.controller.sample_rate_hz);
}

TEST(MagnetHit, InModalCoordinatesAsByTheEventStepper) {
  const Model model =
      withoutFloor(loadModel(std::string(AMB_ROTOR_SOURCE_DIR) + "/config/thesis/flexible_model.yaml"));
  RunOptions options;
  const auto modal = simulate(model, falling(500.0), options);
  options.modal = false;
  const auto general = simulate(model, falling(500.0), options);
  EXPECT_EQ(modal.outcome.path, "modal coordinates");
  for (const Simulation* run : {&modal, &general})
    // the weight is the rig's mass's, the inertia the geometry's, 0.05 % less
    expectFall(*run, model.rig.amb.air_gap_m, model.rig.controller.sample_rate_hz, 1e-3);
  EXPECT_EQ(modal.outcome.time_s, general.outcome.time_s);
}

TEST(MagnetHit, InModalCoordinatesAtTheMagnetsOfATiltedRotor) {
  // end b is 0.1 mm lower at the magnets, more at the sensors; it falls through less
  const Model model =
      withoutFloor(loadModel(std::string(AMB_ROTOR_SOURCE_DIR) + "/config/thesis/flexible_model.yaml"));
  const double low = 0.1e-3, gap = model.rig.amb.air_gap_m;
  Scenario scenario = falling(500.0);
  scenario.initial_displacement_m = {0.0, 0.0, 0.0, -low / model.rig.planes.amb[1]};  // slope of y along z
  const auto run = simulate(model, scenario);
  ASSERT_EQ(run.outcome.status, RunStatus::magnet_hit) << run.outcome.reason;
  EXPECT_EQ(run.outcome.path, "modal coordinates");
  EXPECT_EQ(run.outcome.magnet_hit->end, 1);
  const double fallen = 0.5 * weight_m_s2 * run.outcome.time_s * run.outcome.time_s;
  EXPECT_NEAR(run.outcome.magnet_hit->displacement_m, low + fallen, 1e-3 * gap);  // mass as above
}

TEST(MagnetHit, SaysWhichBearingAndHowFar) {
  // tilted, so that end b is the lower one; the gap is the effect's, as the force is
  const double gap = 0.5e-3;
  const Model model = with(withoutFloor(levitated()), "magnetic_nonlinearity", {2.5, gap});
  Scenario scenario = falling(1000.0);
  scenario.initial_displacement_m = {0.0, 0.0, 0.0, -1e-3};  // slope of y along z
  const auto run = simulate(model, scenario);
  ASSERT_EQ(run.outcome.status, RunStatus::magnet_hit);
  EXPECT_EQ(run.outcome.magnet_hit->end, 1);
  EXPECT_EQ(run.outcome.magnet_hit->air_gap_m, gap);
  EXPECT_NEAR(run.outcome.magnet_hit->time_s, std::sqrt(2.0 * (gap - 0.096e-3) / weight_m_s2), 1e-4);
  for (const char* word : {"bearing b", "0.0005"})
    EXPECT_NE(run.outcome.reason.find(word), std::string::npos) << run.outcome.reason;
}

TEST(MagnetHit, AnyDirectionCounts) {
  // neither x nor y alone reaches the gap
  Model model = withoutFloor(levitated());
  model.rig.gravity_m_s2 = 0.0;
  const double share = 0.8 * model.rig.amb.air_gap_m;
  const auto run = simulate(model, bearingsOff(from(constantSpeed(0.0, 0.01), {share, share, 0.0, 0.0}, {}), 0.0));
  ASSERT_EQ(run.outcome.status, RunStatus::magnet_hit);
  EXPECT_EQ(run.outcome.time_s, 0.0) << "where it begins behind its gap, too";
  EXPECT_EQ(run.trajectory.time_s.size(), 1u);
}

TEST(MagnetHit, AnAuxiliaryBearingPreventsIt) {
  Model model = levitated();
  model.rig.gravity_m_s2 = weight_m_s2;
  const auto run = simulate(model, falling(1000.0));
  EXPECT_EQ(run.outcome.status, RunStatus::ok) << run.outcome.reason;
  EXPECT_FALSE(run.trajectory.contacts.empty());
}

TEST(MagnetHit, ARunInThatEndsThereSaysSo) {
  Model model = withoutFloor(levitated());
  model.rig.controller.kp_A_per_m = 0.0;  // nothing holds it
  const auto run = simulate(model, constantSpeed(0.0, 0.1));
  ASSERT_EQ(run.outcome.status, RunStatus::magnet_hit);
  EXPECT_EQ(run.outcome.reason.rfind("run-in: ", 0), 0u) << run.outcome.reason;
  EXPECT_LT(run.outcome.magnet_hit->time_s, 0.0);
}

TEST(MagnetHit, SpringsAndDampersHaveNoMagnets) {
  Model model = withoutFloor(springBeam(1e4, 1.0));
  const auto run = simulate(model, from(constantSpeed(0.0, 0.05, 1000.0), {2e-3, 0.0, 0.0, 0.0}, {}));
  EXPECT_EQ(run.outcome.status, RunStatus::ok) << run.outcome.reason;
}

TEST(MagnetHit, GapsAreThoseBetweenRotorAndStator) {
  // rotor and stator move together: no gap changes
  const Model model = with(levitated(), "foundation_resonance", {30.0, 50.0, 0.03});
  const Machine<double> machine({&model});
  std::vector<double> state(static_cast<std::size_t>(machine.stateSize()), 0.0);
  machine.initialise(state.data());
  for (std::size_t i = 0; i < state.size(); ++i) state[i] += 1e-4 * static_cast<double>(i + 1);
  Vec2<double> position[2];
  machine.atMagnets(state.data(), position);
  Observation<double> seen;
  machine.observe(Inputs<double>(), state.data(), nullptr, seen);
  for (int end = 0; end < 2; ++end) {
    EXPECT_EQ(position[end].x, seen.amb_position[end].x);
    EXPECT_EQ(position[end].y, seen.amb_position[end].y);
    EXPECT_NE(position[end].x, machine.rotor().at(end, state.data()).x) << "the stator has moved";
  }
}

}  // namespace
}  // namespace amb_rotor
