// Runs that are measured to stay inside their clearance are predicted without contact.
#include <gtest/gtest.h>

#include "../support/made_sets.hpp"

namespace amb_rotor {
namespace {

const MadeSet& set() { return madeSet(21, "none", 0.0, true); }

const Recording& steadyRun() { return set().recordings.at(static_cast<std::size_t>(set().runs(RunUse::fit, false).front())); }

TEST(RunsInsideTest, WhatIsMeasuredInsideIsPredictedWithoutContact) {
  std::size_t inside = 0, free = 0;
  for (const Recording& rec : set().recordings) {
    EXPECT_FALSE(rec.stays_inside && rec.holdsContact()) << rec.run.id;
    inside += rec.stays_inside;
    free += !rec.holdsContact();
  }
  EXPECT_GT(2 * inside, free);
  const Recording& rec = steadyRun();
  const Model truth = set().truth();
  EXPECT_EQ(stretchOf(rec, truth).contact_step_s, 0.0);
  Recording touching = rec;
  touching.stays_inside = false;
  EXPECT_GT(stretchOf(touching, truth).contact_step_s, 0.0);
  // out of contact it is the same motion, step by step
  EXPECT_EQ(predictedBy(truth, rec), predictedBy(truth, touching));
  // less than the motion takes: it would touch
  Model narrow = truth;
  narrow.rig.auxiliary_bearing.clearance_m = 1e-7;
  EXPECT_EQ(predictedBy(narrow, rec), predictedBy(truth, rec)) << "contact is left out";
  EXPECT_NE(predictedBy(narrow, touching), predictedBy(truth, rec));
}

TEST(RunsInsideTest, WhatComesNearTheClearanceOrIsNotMeasuredIsNotInside) {
  Recording rec = steadyRun();
  Model belief = set().dataset.belief;
  ASSERT_TRUE(staysInside(rec, belief));
  double most = 0.0;
  for (long i = 0; i < rec.samples; ++i)
    for (const double z : belief.rig.planes.aux) most = std::max(most, radiusAt(&rec.measured[i * predicted_channels], belief, z));
  belief.rig.auxiliary_bearing.clearance_m = 1.2 * most;
  EXPECT_FALSE(staysInside(rec, belief)) << "its sensors may be out by that";
  belief.rig.auxiliary_bearing.clearance_m = 2.0 * most;
  EXPECT_TRUE(staysInside(rec, belief));
  belief.rig.controller.kp_A_per_m *= 0.01;
  EXPECT_FALSE(staysInside(rec, belief)) << "without contact the belief would fly away";
  rec.noise[2] = 0.0;
  EXPECT_FALSE(staysInside(rec, set().dataset.belief)) << "nobody measured bx";
}

TEST(RunsInsideTest, TheShaftIsAStraightLineThroughItsSensors) {
  Model model;
  model.rig.planes.sensor[0] = -0.1;
  model.rig.planes.sensor[1] = 0.1;
  const double displacement[4] = {1e-5, 2e-5, 3e-5, -2e-5};
  EXPECT_DOUBLE_EQ(radiusAt(displacement, model, -0.1), std::hypot(1e-5, 2e-5));
  EXPECT_DOUBLE_EQ(radiusAt(displacement, model, 0.0), 2e-5);
  EXPECT_DOUBLE_EQ(radiusAt(displacement, model, 0.2), std::hypot(4e-5, -4e-5));
}

}  // namespace
}  // namespace amb_rotor
