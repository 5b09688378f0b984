// What a screening looks at, and what it leaves out: on sets of the generator, with few runs and candidates.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <optional>

#include "../../src/validation/screening.hpp"
#include "../support/long_tests.hpp"
#include "../support/made_sets.hpp"
#include "amb_rotor/validation/ranking.hpp"

namespace amb_rotor {
namespace {

const std::vector<std::string> free_runs = {"chirp_1", "step_1", "steady_1", "steady_2", "chirp_4"};

/// Candidates beside a set's belief.
struct Beside {
  Candidates candidates;
  Settings adopted;
  References references;
  CandidateErrors errors;

  explicit Beside(const MadeSet& set) : candidates(set.dataset.belief, set.dataset) {
    Trial free = candidates.fit({}, nullptr, std::vector<LocalState>(set.recordings.size()), {Through::free, 10});
    references = candidates.referencesWithoutContact(free, free);
    const double level = std::max(1.0, free.fit.squares / free.fit.count);
    references.worth = 0.5 * least_excess_share * (free.fit.squares - free.fit.count) / level;
    errors = candidates.judge(free, false, Judging::anew);
  }
  Screening screened(const std::vector<std::string>& names, bool ranked, bool stand_in) {
    const Standing standing = {adopted, references, errors, ranked, stand_in};
    order.clear();
    return screen(candidates, names, standing, true, [this](double, const std::string& what) { order.push_back(what); });
  }
  std::vector<std::string> order;  ///< in which the last screening looked
};

const Trial& trialOf(const Screening& screening, const std::string& effect) {
  return *std::find_if(screening.trials.begin(), screening.trials.end(), [&](const Trial& t) { return t.effect == effect; });
}

TEST(ScreeningLooks, BesideOneThatLeavesNothingOnlyWhatPromisesAsMuchIsLookedAtAgain) {
  Beside beside(madeSet(3, "amplifier_lag", 1.5, false, free_runs));
  const std::vector<std::string> names = {"amplifier_lag", "static_load", "motor_magnetic_pull"};
  const Screening again = beside.screened(names, true, false);
  EXPECT_GT(trialOf(again, "amplifier_lag").evidence, 1000.0);
  for (const char* far : {"static_load", "motor_magnetic_pull"}) {
    EXPECT_FALSE(trialOf(again, far).usable()) << far;
    EXPECT_NE(trialOf(again, far).note.find("far less is foreseen"), std::string::npos) << trialOf(again, far).note;
  }
  for (const Trial& trial : beside.screened(names, false, false).trials) EXPECT_TRUE(trial.usable()) << trial.effect << ": the first time all are valued";
}

/// At one speed a bow and a runout are next to the same.
TEST(ScreeningLooks, ATwinOfOneThatLeavesNothingIsLookedAtAgain) {
  Beside beside(madeSet(3, "shaft_bow", 3.0, false, {"steady_1", "steady_4"}));
  const Screening again = beside.screened({"shaft_bow", "static_load", "sensor_runout"}, true, false);
  EXPECT_GT(trialOf(again, "shaft_bow").evidence, 1000.0);
  EXPECT_GT(trialOf(again, "sensor_runout").evidence, 1000.0);
  EXPECT_FALSE(trialOf(again, "static_load").usable());
}

TEST(ScreeningLooks, NothingIsFollowedBesideAStandInWhereNoneComesNear) {
  Beside beside(madeSet(3, "amplifier_lag", 1.5, false, free_runs));
  ASSERT_GT(beside.references.free.fit.squares, 2.0 * beside.references.free.fit.count) << "there is something to come near to";
  for (const bool stand_in : {true, false}) {
    const Screening without = beside.screened({"foundation_resonance", "motor_magnetic_pull"}, true, stand_in);
    EXPECT_EQ(without.none_near, stand_in);
    EXPECT_EQ(trialOf(without, "foundation_resonance").errors.validation_error_free >= 0.0, !stand_in) << "judged where it was followed only";
  }
  EXPECT_FALSE(beside.screened({"static_load", "amplifier_lag"}, true, true).none_near);
}

/// The first screening goes by what is promised: what cannot lead is then known by it.
TEST(ScreeningLooks, WhatPromisesMostComesFirstAndWhatPromisesLittleHasAGlance) {
  Beside beside(madeSet(3, "amplifier_lag", 1.5, false, free_runs));
  const Screening screening = beside.screened({"stiffness_anisotropy", "motor_magnetic_pull", "amplifier_lag"}, false, false);
  EXPECT_EQ(beside.order.front(), "amplifier_lag");
  for (const char* far : {"stiffness_anisotropy", "motor_magnetic_pull"}) {
    EXPECT_TRUE(trialOf(screening, far).usable()) << far;
    EXPECT_EQ(trialOf(screening, far).fit.iterations, 1) << far;
  }
}

/// A delay in the place of a lag leaves something, but an anisotropy promises next to nothing of what the delay takes.
TEST(ScreeningLooks, BesideALeaderThatLeavesSomethingWhatPromisesLittleOfItWaits) {
  Beside beside(madeSet(3, "amplifier_lag", 1.5, false, free_runs));
  const Screening again = beside.screened({"control_delay", "stiffness_anisotropy", "static_load", "magnetic_nonlinearity"}, true, false);
  EXPECT_GT(trialOf(again, "control_delay").evidence, 1000.0);
  EXPECT_GT(trialOf(again, "control_delay").fit.squares, 1.1 * trialOf(again, "control_delay").fit.count) << "it leaves something";
  EXPECT_FALSE(trialOf(again, "stiffness_anisotropy").usable());
  EXPECT_TRUE(trialOf(again, "static_load").usable()) << "offsets stand in for it: little is told by its promise";
  EXPECT_TRUE(trialOf(again, "magnetic_nonlinearity").usable()) << "no start of it is next to nothing: little is told by its promise";
}

/// A lag that makes eight times the noise is far from linear: two iterations do not come near what it makes.
TEST(ScreeningLooks, TheRightOneComesNearThoughItsFirstLookDoesNot) {
  Beside beside(madeSet(3, "amplifier_lag", 6.0, false, free_runs));
  ASSERT_GT(beside.references.free.fit.squares, 50.0 * beside.references.free.fit.count);
  const Screening screening = beside.screened({"static_load", "amplifier_lag"}, true, true);
  EXPECT_FALSE(screening.none_near);
  EXPECT_LT(trialOf(screening, "amplifier_lag").fit.squares, 1.1 * trialOf(screening, "amplifier_lag").fit.count);
}

TEST(ScreeningLooks, WhatIsThereThroughContactIsFittedWhenItIsAskedFor) {
  AMB_ROTOR_SKIP_UNLESS_LONG();
  Beside beside(madeSet(2700099, "auxiliary_bearing_misalignment", 0.0, true, {"chirp_1", "rub_1", "drop_1", "chirp_4", "rub_2"}));
  EXPECT_FALSE(beside.references.through_contact);
  beside.screened({"static_load"}, true, false);
  EXPECT_FALSE(beside.references.through_contact) << "nobody asked";
  const Screening screening = beside.screened({"static_load", "auxiliary_bearing_misalignment"}, true, false);
  EXPECT_TRUE(beside.references.through_contact);
  EXPECT_GT(trialOf(screening, "auxiliary_bearing_misalignment").evidence, 1000.0);
}

/// What the runs without contact leave open of gains is microns next to a clearance.
TEST(ScreeningLooks, ContactTellsWhatTheRunsWithoutLeaveOpenOfGains) {
  const MadeSet& set = madeSet(1100116, "sensor_gain_error", 4.0, true, {"chirp_1", "steady_1", "step_1", "drop_1", "rub_1"});
  Beside beside(set);
  const std::vector<LocalState>& local = beside.references.free.local;
  Trial gains = beside.candidates.fit({{"sensor_gain_error", {1.0, 1.0, 1.0, 1.0}}}, nullptr, local, {Through::free, 15});
  const int first = gains.space->nuisances();
  const double deviation = std::sqrt(gains.fit.covariance(first, first)), begun = gains.fit.x[first];
  ASSERT_GT(deviation, 0.002) << gains.space->coordinates()[first].name << " is known, and this shows nothing";
  gains.fit.x += 3.0 / deviation * gains.fit.covariance.col(first);
  const Eigen::VectorXd own = gains.nuisance();
  const auto ledTo = [&](const QuadraticPrior& prior) {
    return beside.candidates.fit(gains.effects(), &own, local, {Through::contact, 6, false, true}, &prior).fit.x[first];
  };
  EXPECT_NEAR(ledTo(beside.references.prior), gains.fit.x[first], 1e-12) << "that of the rig alone holds the gains";
  EXPECT_NEAR(ledTo({gains.fit.normal.h, gains.fit.x}), begun, deviation);
  // as far as that contact stands by it, asked whether they explain it
  beside.candidates.referThroughContact(beside.references);
  gains.fit.x += 12.0 / deviation * gains.fit.covariance.col(first);
  EXPECT_TRUE(beside.candidates.explainsContact(gains, beside.references, true).has_value());
}

/// A reference that a motor's pull has led to another Ki and mass has the first look begin on the wrong side.
TEST(ScreeningLooks, APullIsFoundOnTheSideWhereItIs) {
  const MadeSet& set = madeSet(2400082, "motor_magnetic_pull", 0.0, true, {"chirp_1", "chirp_2", "chirp_3", "steady_2", "step_1", "step_2"});
  const double truth = set.truth().effects.at(0).values[0];
  Beside beside(set);
  const Trial found = trialOf(beside.screened({"motor_magnetic_pull"}, false, false), "motor_magnetic_pull");
  EXPECT_NEAR(found.effects()[0].values[0], truth, 0.02 * std::fabs(truth));
}

/// A damping that turns with the rotor changes little while the bearings hold it, and much of what a rotor does that has been dropped.
TEST(ScreeningLooks, WhatShowsLittleWithoutContactAndExplainsItComesBeforeARing) {
  Beside beside(madeSet(59, "internal_damping", 0.4, true, {"steady_2", "drop_1", "drop_2", "rub_1", "steady_4"}));
  const Screening seen = beside.screened({"internal_damping", "inner_ring_spin"}, false, false);
  const Trial& damping = trialOf(seen, "internal_damping");
  const double without_contact = beside.candidates.evidence(damping, beside.references.free);
  ASSERT_GT(without_contact, beside.references.worth);
  ASSERT_LT(without_contact, 900.0) << "it is beyond doubt without contact, and this shows nothing";
  EXPECT_GT(damping.evidence, without_contact) << "what it explains through contact speaks for it, too";
  EXPECT_GT(beside.references.contact.fit.squares, 1.25 * beside.references.contact.fit.count);
  EXPECT_TRUE(seen.contact_waited);
  EXPECT_FALSE(trialOf(seen, "inner_ring_spin").usable());
}

/// Runs without contact speak neither for it nor against it, rubs for nothing else.
TEST(ScreeningLooks, ALimitThatOnlyRubsReachExplainsThem) {
  const MadeSet& set = madeSet(2900101, "current_saturation", 0.0, true, {"chirp_1", "steady_2", "rub_1", "drop_1", "steady_4"});
  Beside beside(set);
  const Screening seen = beside.screened({"static_load", "control_delay", "current_saturation", "velocity_dependent_friction"}, false, false);
  const Trial& limit = trialOf(seen, "current_saturation");
  ASSERT_LT(beside.candidates.evidence(limit, beside.references.free), least_evidence) << "it shows without contact, and this shows nothing";
  EXPECT_EQ(seen.explains_contact, "current_saturation");
  EXPECT_EQ(seen.trials.at(0).effect, "current_saturation");
  EXPECT_GT(limit.evidence, 1000.0);
  EXPECT_TRUE(seen.contact_waited);
}

/// What shows nowhere else bends to whatever is missing through contact: what it takes of that is no proof, what it leaves is.
TEST(ScreeningLooks, AFoundationTakesMostOfWhatARingLeavesButDoesNotExplainIt) {
  Beside beside(madeSet(61, "inner_ring_spin", 0.0, true, {"chirp_1", "steady_2", "drop_1", "rub_1", "steady_4"}));
  const Trial mode = beside.candidates.look("foundation_resonance", {}, beside.references, {});
  beside.candidates.referThroughContact(beside.references);
  const std::optional<ExplainedContact> explained = beside.candidates.explainsContact(mode, beside.references, true);
  ASSERT_TRUE(explained.has_value());
  EXPECT_GT(explained->evidence, 1000.0);
  EXPECT_FALSE(explained->leaves_nothing);
  EXPECT_FALSE(isBelieved(*explained, 4.0)) << "it shows nowhere else";
  EXPECT_TRUE(isBelieved(*explained, 2.0 * least_evidence));
  EXPECT_TRUE(isBelieved({explained->evidence, true}, 4.0));
}

/// How well windows know their starts hangs on the hollows that they end in; how many starts they have does not.
TEST(ScreeningLooks, HowWellTheSameStartsAreKnownIsNoEvidence) {
  Beside beside(madeSet(21, "none", 0.0, true, {"chirp_1", "rub_1"}));
  const auto standing = [&](const Settings& effects) {
    return beside.candidates.fit(effects, nullptr, beside.references.free.local, {Through::contact, 0, false, true}, &beside.references.prior);
  };
  const Trial without = standing({});
  Trial aside = standing({{"auxiliary_bearing_misalignment", {0.0, 0.0, 0.0, 0.0}}});
  ASSERT_EQ(aside.fit.normal.starts, without.fit.normal.starts);
  const double before = beside.candidates.evidence(aside, without);
  aside.fit.normal.occam -= 500.0;
  EXPECT_EQ(beside.candidates.evidence(aside, without), before);
  Trial mount = standing({{"compliant_mount", {1e7, 1e2, 0.2}}});
  ASSERT_GT(mount.fit.normal.starts, without.fit.normal.starts);
  const double dear = beside.candidates.evidence(mount, without);
  mount.fit.normal.occam -= 500.0;
  EXPECT_GT(beside.candidates.evidence(mount, without), dear + 200.0);
}

TEST(ScreeningLooks, NothingIsToBeHadThroughContactBesideTheRightModel) {
  // a window that one glance at the reference throws off would be worth some 800 to whatever is looked at
  const MadeSet& set = madeSet(57, "compliant_mount", 0.0, true, {"chirp_1", "rub_1", "drop_1"});
  Candidates candidates(set.dataset.belief, set.dataset);
  const std::vector<LocalState> fresh(set.recordings.size());
  const Trial free = candidates.fit({set.truth().effects.at(0)}, nullptr, fresh, {Through::free, 10});
  const Eigen::VectorXd own = free.nuisance();
  const Trial all = candidates.fit(free.effects(), &own, free.local, {Through::all, 10});
  References references = candidates.referencesWithoutContact(free, all);
  candidates.referThroughContact(references);
  ASSERT_FALSE(isAstray(references.contact));
  const Trial look = candidates.look("auxiliary_bearing_misalignment", all.effects(), references, Leaders());
  ASSERT_TRUE(look.usable());
  ASSERT_GT(look.stride, 1);
  EXPECT_LT(look.evidence, 0.0);
  // of Hertz's law, which has several starts, one is enough
  EXPECT_TRUE(candidates.look("hertzian_contact", all.effects(), references, Leaders()).others.empty());
}

TEST(ScreeningLooks, AtTheNoiseWhatCannotEarnItsPlaceHasOneLookAndIsNotLedNearer) {
  Beside beside(madeSet(21, "none", 0.0, true, {"chirp_1", "rub_1"}));
  const auto looked = [&](const char* effect, double squares, double worth) {
    References references = beside.references;
    references.free.fit.squares *= squares;
    references.worth = worth;
    return beside.candidates.look(effect, {}, references, Leaders());
  };
  EXPECT_TRUE(looked("foundation_resonance", 1.0, 0.0).others.empty());
  EXPECT_FALSE(looked("foundation_resonance", 1.1, 0.0).others.empty()) << "where something is off the first order tells less";
  const Trial left = looked("magnetic_nonlinearity", 1.0, 0.0), led = looked("magnetic_nonlinearity", 1.0, 1000.0);
  ASSERT_LT(left.evidence, -100.0) << "it begins at the reference, and this shows nothing";
  EXPECT_LT(led.fit.chi2, left.fit.chi2);
}

}  // namespace
}  // namespace amb_rotor
