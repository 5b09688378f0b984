// Runs of the generator of data sets.
#include <gtest/gtest.h>

#include <algorithm>

#include "../../src/validation/make_dataset_parts.hpp"

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

}  // namespace
}  // namespace amb_rotor::making
