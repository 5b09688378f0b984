// Runs of the generator of data sets.
#include <gtest/gtest.h>

#include <algorithm>

#include "../../src/validation/make_dataset_parts.hpp"
#include "amb_rotor/effects/catalogue.hpp"

namespace amb_rotor::making {
namespace {

/// A foundation that rings for seconds after it was loaded, at half its run-in still by 3 % of its sag: a standing machine has settled
/// when nothing moves, not when its first run-in is over.
TEST(MadeRuns, AStandingMachineBeginsWhereNothingMoves) {
  Dice dice(5);
  TrueMachine machine{drawBelief(dice, true, false), {}};
  ASSERT_GT(machine.model.rig.gravity_m_s2, 0.0);
  machine.model.effects.push_back({"foundation_resonance", {100.0, 40.0, 0.02}});
  RunPlan plan;
  plan.samples = 1000;
  const Signals signals = runMachine(machine, plan, nullptr);
  ASSERT_TRUE(signals.sound);
  for (int c = 0; c < 4; ++c) {
    const auto [least, most] = std::minmax_element(signals.rows[c].begin(), signals.rows[c].end());
    EXPECT_LT(*most - *least, 1e-8) << "channel " << c;  // coordinates to 2e-9 either way, a sensor's arm in
  }
}

/// Windows of the machine without a bending mode begin where the rotor of the one with it is, and goes: a mode of no shape changes nothing
/// (velocities once came from where the mode's coordinate was, and sets through contact had modes of no size).
TEST(MadeRuns, WindowsBeginWhereAMachineOfMoreCoordinatesIs) {
  Dice dice(5);
  const TrueMachine rigid{drawBelief(dice, true, false), {}};
  TrueMachine bent = rigid;
  const EffectSchema& schema = *effectCatalogue().find("shaft_flexibility");
  EffectSetting mode{schema.id, std::vector<double>(schema.parameters.size(), 0.0)};
  mode.values[schema.indexOf("frequency_hz")] = 400.0;
  mode.values[schema.indexOf("damping_ratio")] = 0.01;
  bent.model.effects.push_back(mode);
  RunPlan drop;
  drop.samples = 1000;
  drop.speed_hz = drop.end_speed_hz = 40.0;
  drop.run.kind = RunKind::drop;
  drop.run.events = {{0.01, false}};
  const Signals whole = runMachine(bent, drop, nullptr);
  ASSERT_TRUE(whole.sound && whole.touched);
  const Signals windows = runWindows(rigid, drop, whole);
  ASSERT_EQ(windows.angle.size(), whole.angle.size());
  for (int c = 0; c < 4; ++c)
    for (std::size_t i = 0; i < whole.angle.size(); ++i)
      ASSERT_NEAR(windows.rows[c][i], whole.rows[c][i], 1e-8) << "channel " << c << ", sample " << i;  // impacts enlarge 1e-10
}

}  // namespace
}  // namespace amb_rotor::making
