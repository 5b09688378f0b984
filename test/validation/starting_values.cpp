// Where candidates start: inside their limits, with the physics that the header says, and refused where the runs cannot
// show them.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "../support/models.hpp"
#include "amb_rotor/common/units.hpp"
#include "amb_rotor/effects/catalogue.hpp"
#include "amb_rotor/validation/fit.hpp"
#include "amb_rotor/validation/starts.hpp"

namespace amb_rotor {
namespace {

using namespace testing_support;

constexpr double bias = 2.5, peak_current = 1.2;

Model belief() {
  Model model = withUnbalance(levitated(), 2e-5, 0.3);
  model.rig.rotor.polar_inertia_kg_m2 = 0.002;
  model.rig.amb.bias_current_A = bias;
  return model;
}

Recording recording(RunKind kind, bool standstill) {
  Recording rec;
  rec.run.id = "one";
  rec.run.kind = kind;
  rec.run.sample_rate_hz = 1e4;
  rec.samples = 100;
  rec.standstill = standstill;
  rec.measured.assign(rec.samples * predicted_channels, 0.0);
  rec.measured[50 * predicted_channels + 6] = -peak_current;
  return rec;
}

std::vector<std::vector<double>> starts(const std::string& effect, const Model& model,
                                        const std::vector<Recording>& recordings, std::string* why = nullptr) {
  std::string reason;
  const auto out = startingValues(effect, model, recordings, reason);
  EXPECT_EQ(out.empty(), !reason.empty()) << effect << ": a refusal has a reason, a start has none";
  if (why != nullptr) *why = reason;
  return out;
}

/// A run of 0.8 s whose shaft slows down from a speed by W' = -decay W - constant.
Recording slowing(double speed_rad_s, double decay_per_s, double constant_rad_s2) {
  Recording rec = recording(RunKind::steady, false);
  rec.samples = 8000;
  rec.pulses.state = TachoState::turning;
  constexpr double step_s = 1e-6;
  double angle = 0.0, speed = speed_rad_s;
  for (long i = 0; i < 800000; ++i) {
    const double before = angle, half = speed - 0.5 * step_s * (decay_per_s * speed + constant_rad_s2);
    angle += half * step_s;
    speed -= step_s * (decay_per_s * half + constant_rad_s2);
    const double turns = std::floor(angle / two_pi);
    if (turns <= std::floor(before / two_pi)) continue;
    rec.pulses.time.push_back((i + (two_pi * turns - before) / (angle - before)) * step_s);
    rec.pulses.turn.push_back(static_cast<long>(turns) - 1);
  }
  return rec;
}

TEST(StartingValuesTest, DragStartsWhereThePulsesSlowDown) {
  // 9 % of the speed are lost and with them three turns: from no drag at all a fit does not come there
  constexpr double decay = 0.07, constant = 20.0;
  const Model rig = belief();
  const auto found = starts("spin_drag", rig, {slowing(300.0, decay, constant), slowing(600.0, decay, constant)});
  ASSERT_EQ(found.size(), 1u);
  // a parabola through the angle of a decay takes its mean rate, to the square of what is lost
  EXPECT_NEAR(found[0][0], decay, 0.03 * decay);
  EXPECT_NEAR(found[0][1], constant * rig.rig.rotor.polar_inertia_kg_m2, 0.03 * constant * rig.rig.rotor.polar_inertia_kg_m2);
  const auto steady = starts("spin_drag", rig, {slowing(300.0, 0.0, 0.0)});
  ASSERT_EQ(steady.size(), 1u);
  EXPECT_EQ(steady[0][0], 0.0);
  EXPECT_EQ(steady[0][1], 0.0);
}

TEST(StartingValuesTest, AFreeSpinBeginsWhereItsPulsesSay) {
  // the pulses of an integration by steps; 1e-7: its step of 1e-6 s squared, over 0.8 s, with room
  for (const FreeSpin spin : {FreeSpin{0.5, 20.0}, FreeSpin{0.0, 20.0}, FreeSpin{0.5, 0.0}}) {
    Recording rec = slowing(300.0, spin.decay_per_s, spin.constant_rad_s2);
    rec.speed_rad_s = 290.0;  // whatever a straight line said
    double angle0 = 0.0, speed = 0.0;
    rec.startOfSpin(spin, angle0, speed);
    EXPECT_NEAR(speed, 300.0, 1e-7 * 300.0);
    EXPECT_NEAR(angle0, -two_pi, 1e-6) << "the first pulse is the end of the first turn";
    const double last = rec.pulses.time.back();
    EXPECT_NEAR(angle0 + speed * spin.reach(last) - spin.constant_rad_s2 * spin.lost(last),
                two_pi * static_cast<double>(rec.pulses.turn.back()), 1e-5);
  }
}

TEST(StartingValuesTest, DifferencesOfADragTurnTheShaftByLittle) {
  // columns over steps that turn it by more are no derivatives: torques ended 57 of their deviations off
  constexpr double fast_rad_s = 2000.0, longest_s = 2.0, allowed_rad = 0.02;
  Model rig = belief();
  for (const double inertia : {1e-5, 1e-3, 1.0}) {
    rig.rig.rotor.polar_inertia_kg_m2 = inertia;
    const FitSpace space(rig, {{"spin_drag", {0.05, inertia}}});
    int found = 0;
    for (const Coordinate& c : space.coordinates()) {
      const double step = step_without_contact * c.scale, time = 0.5 * longest_s * longest_s;
      double slower_rad_s2 = 0.0;
      if (c.name == "spin_drag.decay_per_s") slower_rad_s2 = step * fast_rad_s;
      if (c.name == "spin_drag.torque_N_m") slower_rad_s2 = step / inertia;
      if (slower_rad_s2 == 0.0) continue;
      ++found;
      EXPECT_LT(slower_rad_s2 * time, allowed_rad) << c.name << ", inertia " << inertia;
    }
    EXPECT_EQ(found, 2);
  }
}

TEST(StartingValuesTest, AFallingFrictionStartsAtWhatWasSeenOfIt) {
  const Model rig = belief();
  const double mu = rig.rig.auxiliary_bearing.friction_coefficient;
  std::string unused;
  const auto of = [&](double seen) {
    return startingValues("velocity_dependent_friction", rig, {recording(RunKind::drop, false)}, unused, {0.0, seen});
  };
  ASSERT_EQ(of(0.25 * mu).size(), of(0.0).size() + 1);
  EXPECT_EQ(of(0.25 * mu).back()[1], 0.25 * mu);
  EXPECT_EQ(of(0.9 * mu), of(0.0)) << "about as believed";
}

/// A contact alone goes down to a twentieth of what is believed of it: a mount of a three-hundredth is told by how deep the rotor rests.
TEST(StartingValuesTest, AVerySoftMountStartsAtWhatCarriesTheRotor) {
  Model rig = belief();
  rig.rig.gravity_m_s2 = 9.81;
  const double kc = rig.rig.auxiliary_bearing.stiffness_N_per_m, wanted = kc / 300.0;  // of contact and mount in series
  const double depth_m = 0.5 * rig.rig.rotor.mass_kg * rig.rig.gravity_m_s2 / wanted;
  Recording rests = recording(RunKind::drop, false);
  for (long i = 0; i < rests.samples; ++i)
    for (const int y : {1, 3}) rests.measured[i * predicted_channels + y] = -(rig.rig.auxiliary_bearing.clearance_m + depth_m);
  std::string unused;
  const auto of = [&](double seen) { return startingValues("compliant_mount", rig, {rests}, unused, {seen, 0.0}); };
  const auto inSeries = [&](double mount) { return 1.0 / (1.0 / mount + 1.0 / kc); };
  for (const auto& start : of(0.05 * kc)) EXPECT_NEAR(inSeries(start[0]), wanted, 1e-9 * wanted);
  for (const auto& start : of(0.2 * kc)) EXPECT_NEAR(inSeries(start[0]), 0.2 * kc, 1e-9 * kc) << "the model's own contact is not at its end";
  rig.rig.gravity_m_s2 = 0.0;
  for (const auto& start : of(0.05 * kc)) EXPECT_NEAR(inSeries(start[0]), 0.05 * kc, 1e-9 * kc) << "nothing weighs on it";
}

TEST(StartingValuesTest, EveryEffectStartsInsideItsLimits) {
  const std::vector<Recording> all = {recording(RunKind::steady, false), recording(RunKind::drop, false)};
  int effects = 0;
  for (const EffectSchema& schema : effectCatalogue().all()) {
    if (schema.only_by_name) continue;
    const auto values = starts(schema.id, belief(), all);
    ASSERT_FALSE(values.empty()) << schema.id;
    ++effects;
    for (const auto& start : values) {
      ASSERT_EQ(start.size(), schema.parameters.size()) << schema.id;
      for (std::size_t i = 0; i < start.size(); ++i) {
        EXPECT_GE(start[i], schema.parameters[i].lower) << schema.id << "." << schema.parameters[i].name;
        EXPECT_LE(start[i], schema.parameters[i].upper) << schema.id << "." << schema.parameters[i].name;
      }
    }
    // no two starts are the same: each costs a fit
    auto sorted = values;
    std::sort(sorted.begin(), sorted.end());
    EXPECT_EQ(std::adjacent_find(sorted.begin(), sorted.end()), sorted.end()) << schema.id;
  }
  EXPECT_GE(effects, 26);
}

TEST(StartingValuesTest, RefusesWhatTheRunsCannotShow) {
  std::string why;
  const std::vector<Recording> free = {recording(RunKind::steady, false)};
  const std::vector<Recording> still = {recording(RunKind::chirp, true)};
  for (const EffectSchema& schema : effectCatalogue().all())
    if (schema.needs_contact) {
      EXPECT_TRUE(starts(schema.id, belief(), free, &why).empty()) << schema.id;
      EXPECT_EQ(why, "no run holds contact") << schema.id;
    }
  for (const char* turning : {"couple_unbalance", "gyroscopic_coupling", "cross_coupled_stiffness", "spin_drag",
                              "shaft_crack", "shaft_bow", "sensor_runout"}) {
    EXPECT_TRUE(starts(turning, belief(), still, &why).empty()) << turning;
    EXPECT_EQ(why, "no run turns") << turning;
    EXPECT_FALSE(starts(turning, belief(), free).empty()) << turning;
  }
  Model equivalent = belief();
  equivalent.amb_model = AmbModel::equivalent;
  EXPECT_TRUE(starts("control_delay", equivalent, free, &why).empty());
  Model silent = belief();
  silent.rig.amb.bias_flux_density_T = 0.0;
  EXPECT_TRUE(starts("magnetic_saturation", silent, free, &why).empty());
}

/// To first order a crack's stiffness goes with 1, once and twice the turn, each with its phase: one at 45 degrees between the starts
/// promised a hundredth of what it takes where they were quarters of a turn apart, all of one phase twice a turn.
TEST(StartingValuesTest, ACracksStartsAreOfAllPhasesOnceAndTwiceATurn) {
  const auto cracks = starts("shaft_crack", belief(), {recording(RunKind::steady, false)});
  for (double phase = 0.0; phase < two_pi; phase += 0.1)
    for (const double times : {1.0, 2.0}) {
      double along = 0.0;
      for (const auto& crack : cracks) along = std::max(along, std::fabs(std::cos(times * (crack[1] - phase))));
      EXPECT_GT(along, 0.7) << times << " times the turn, " << phase;
    }
}

TEST(StartingValuesTest, AHertzianStartStoresTheEnergyOfTheLinearLaw) {
  const Model model = belief();
  const double k = model.rig.auxiliary_bearing.stiffness_N_per_m;
  constexpr double depth = 6e-6;
  Recording rub = recording(RunKind::rub, false);
  for (long i = 40; i < 60; ++i)  // both ends alike, so that the tilt is none
    for (const int x : {0, 2}) rub.measured[i * predicted_channels + x] = model.rig.auxiliary_bearing.clearance_m + depth;
  std::vector<double> depths;
  for (const auto& start : starts("hertzian_contact", model, {rub})) {
    // 2/5 kh d^(5/2) = 1/2 k d^2 gives the depth d at which both store the same
    depths.push_back(std::pow(1.25 * k / start[0], 2.0));
    const double hertz = 0.4 * start[0] * std::pow(depths.back(), 2.5), linear = 0.5 * k * depths.back() * depths.back();
    EXPECT_NEAR(hertz / linear, 1.0, 1e-12);
  }
  ASSERT_EQ(depths.size(), 3u);  // what the recording shows, and less
  EXPECT_NEAR(depths[1], 0.4 * depths[0], 1e-12);
  EXPECT_NEAR(depths[2], 0.15 * depths[0], 1e-12);
  EXPECT_NEAR(depths[0], depth, 1e-12);
}

TEST(StartingValuesTest, RingsStartWhereTheWeightsFrictionBringsThemToSpeed) {
  Model model = belief();
  model.rig.auxiliary_bearing.friction_coefficient = 0.2;
  Recording drop = recording(RunKind::drop, false);
  drop.speed_rad_s = 800.0;
  Recording faster = recording(RunKind::steady, false);
  faster.speed_rad_s = 2000.0;  // it does not touch
  const auto& rotor = model.rig.rotor;
  const double torque = 0.2 * rotor.mass_kg * standard_gravity_m_s2 * model.rig.auxiliary_bearing.rotor_radius_m;
  std::vector<double> seconds;
  for (const auto& start : starts("inner_ring_spin", model, {faster, drop})) {
    seconds.push_back(start[0] * 800.0 / torque);  // J W = T t
    EXPECT_LT(start[1], torque) << "or the ring would stand";
  }
  ASSERT_FALSE(seconds.empty());
  const auto range = std::minmax_element(seconds.begin(), seconds.end());
  EXPECT_NEAR(*range.first, 3e-3, 1e-9);
  EXPECT_NEAR(*range.second, 0.3, 1e-9);
}

TEST(StartingValuesTest, ABendingModeIsNoLargerThanAShapeCanBe) {
  EXPECT_EQ(usableShare("static_load", 50.0), 50.0);
  EXPECT_EQ(usableShare("static_load", -50.0), -50.0);
  EXPECT_EQ(usableShare("shaft_flexibility", 50.0), 4.0);
  EXPECT_EQ(usableShare("shaft_flexibility", 0.7), 0.7);
  EffectSetting mode = {"shaft_flexibility", starts("shaft_flexibility", belief(), {recording(RunKind::steady, false)})[0]};
  const EffectSetting before = mode;
  scaleStart(mode, 50.0);  // a force goes in by the shape, the motion comes out by it: twice the shape, four times the share
  EXPECT_NEAR(mode.values[6], 2.0 * before.values[6], 1e-12);
  EXPECT_EQ(mode.values[0], before.values[0]) << "the frequency stays";
}

TEST(StartingValuesTest, ACurrentLimitStartsOnEitherSideOfTheLargestCurrentSeen) {
  const auto values = starts("current_saturation", belief(), {recording(RunKind::steady, false)});
  int below = 0, above = 0;
  for (const auto& start : values) {
    EXPECT_GT(start[0], bias);
    EXPECT_LT(start[0], bias + 1.2 * peak_current);
    ++(start[0] < bias + peak_current ? below : above);
  }
  EXPECT_GE(below, 3);
  EXPECT_GE(above, 1) << "for a belief that would ask for more than the rig did";
  // a rig whose stated limit is below all of these cannot show another one
  Model limited = belief();
  limited.rig.amb.max_current_A = bias + 0.5 * peak_current;
  EXPECT_TRUE(starts("current_saturation", limited, {recording(RunKind::steady, false)}).empty());
}

/// Two free bodies move against each other as one of mass mu by a force between them: a = F/m + F/M = F/mu.
TEST(StartingValuesTest, AStatorThatARotorsMassHasStoodInForTakesTheRestOfIt) {
  constexpr double believed_kg = 4.4, stood_kg = 3.5;
  EffectSetting stator = {"foundation_resonance", {1e6, 22.0, 0.03}};
  ASSERT_TRUE(isSizedByWhatStoodIn(stator.id));
  sizeByWhatStoodIn(stator, believed_kg, stood_kg);
  EXPECT_NEAR(1.0 / believed_kg + 1.0 / stator.values[0], 1.0 / stood_kg, 1e-12);
  EXPECT_EQ(effectCatalogue().find(stator.id)->parameters[0].name, "mass_kg");
  EXPECT_EQ(effectCatalogue().find(stator.id)->mimic, "rotor.mass_kg");
}

TEST(StartingValuesTest, TheBendingShapeIsThatOfAFreeBeam) {
  // The first bending mode of a free uniform beam has its nodes at 0.2242 of the length from each end (zeros of
  // cosh s + cos s - 0.98250 (sinh s + sin s), s = 4.73004 z/L) and -0.6078 of its end value at the middle.
  Model model = belief();
  const double length = 2.0 * 0.575 * (model.rig.planes.aux[1] - model.rig.planes.aux[0]);
  model.rig.planes.amb[0] = -0.5 * length + 0.2241575 * length;
  model.rig.planes.amb[1] = -model.rig.planes.amb[0];
  model.rig.unbalance[0].plane_z_m = 0.0;
  for (const auto& start : starts("shaft_flexibility", model, {recording(RunKind::steady, false)})) {
    const double scale = 1.4;  // the shape at a free end
    EXPECT_NEAR(start[2], 0.0, 1e-5 * scale);
    EXPECT_NEAR(start[3], 0.0, 1e-5 * scale);
    EXPECT_NEAR(start[4], start[5], 1e-7) << "sensors at +-z";
    EXPECT_NEAR(start[6], start[7], 1e-7) << "auxiliary bearings at +-z";
    EXPECT_GT(start[6], start[4]) << "further out";
    EXPECT_NEAR(start[8] / scale, -0.6078, 1e-4) << "the middle moves the other way";
  }
}

TEST(StartingValuesTest, AnEffectOfOnesOwnStartsAtSeveralPlacesOfItsShape) {
  EffectSchema schema;
  schema.id = "own";
  const auto add = [&](const char* name, double lower, double upper, double typical, double neutral, ParameterRole role) {
    schema.parameters.push_back({name, "1", lower, upper, typical, neutral, role, "m"});
  };
  add("size", -1e30, 1e30, 4.0, 0.0, ParameterRole::plain);
  add("width", 1e-6, 1e-3, 1e-5, std::nan(""), ParameterRole::plain);
  add("plane", -0.2, 0.2, 0.1, std::nan(""), ParameterRole::fixed);
  const auto all = startsOfOwnEffect(schema);
  EXPECT_EQ(all[0], (std::vector<double>{0.0, 1e-5, 0.1})) << "first where it does nothing";
  std::vector<double> widths;
  bool typical = false, turned = false;
  for (const auto& start : all) {
    ASSERT_EQ(start.size(), 3u);
    EXPECT_EQ(start[2], 0.1) << "what is fixed stays";
    typical = typical || start[0] == 4.0;
    turned = turned || start[0] == -4.0;
    if (start[0] == 0.0) widths.push_back(start[1]);
    for (std::size_t i = 0; i < start.size(); ++i) {
      EXPECT_GE(start[i], schema.parameters[i].lower);
      EXPECT_LE(start[i], schema.parameters[i].upper);
    }
  }
  EXPECT_TRUE(typical && turned);
  ASSERT_GE(widths.size(), 5u);
  std::sort(widths.begin(), widths.end());
  EXPECT_GT(widths.back() / widths.front(), 100.0) << "by ratios across three decades";
  auto sorted = all;
  std::sort(sorted.begin(), sorted.end());
  EXPECT_EQ(std::adjacent_find(sorted.begin(), sorted.end()), sorted.end());
}

}  // namespace
}  // namespace amb_rotor
