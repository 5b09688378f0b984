// Fits through contact in which windows of the usual length go astray.
#include <gtest/gtest.h>

#include "../support/long_tests.hpp"
#include "../support/through_contact.hpp"

namespace amb_rotor {
namespace {

constexpr const char* misaligned = "auxiliary_bearing_misalignment";

/// Offsets of up to 70 um at a contact of 1.4e8 N/m: some ten impacts in a window of 10 ms.
struct FarAside : ThroughContact {
  FarAside() : ThroughContact{madeSet(4300147, misaligned, 0.0, true, {"chirp_1", "rub_1", "drop_1"})} {}
  EffectSetting truth = set.truth().effects.at(0);
};

class LengthenedWindows : public ::testing::Test {
 protected:
  static const FarAside& all() {
    static const FarAside once;
    return once;
  }
  const Candidates& candidates = all().candidates;
  const References& references = all().references;
  const EffectSetting& truth = all().truth;
};

TEST_F(LengthenedWindows, LeadToABearingThatIsFarAside) {
  AMB_ROTOR_SKIP_UNLESS_LONG();
  const FitEffort look = {Through::contact, 12, false, true};
  const Eigen::VectorXd own = references.contact.nuisance();
  const Trial astray = candidates.fit({{misaligned, {0.0, 0.0, 0.0, 0.0}}}, &own, references.contact.local, look, &references.prior);
  ASSERT_TRUE(isAstray(astray)) << "windows of the usual length find it alone, and this shows nothing";
  const Trial found = candidates.lengthened(astray, look, &references.prior);
  EXPECT_FALSE(isAstray(found));
  for (std::size_t k = 0; k < truth.values.size(); ++k)  // some ten deviations of a fit to all windows, 1 % of what was missing
    EXPECT_NEAR(found.effects()[0].values[k], truth.values[k], 7e-7) << k;
}

TEST_F(LengthenedWindows, ALookEndsBeforeTheyAreLongWhereHalfTheirLengthGainsNothing) {
  const FitEffort look = {Through::contact, 3, false, true};
  const Eigen::VectorXd own = references.contact.nuisance();
  const Trial begun = candidates.fit({{"velocity_dependent_friction", {0.3, 0.1, 1.0}}}, &own, references.contact.local, look, &references.prior);
  Trial unbeaten = references.of(begun);
  unbeaten.fit.chi2 = 0.0;
  const Trial same = candidates.lengthened(begun, look, &references.prior, &unbeaten);
  EXPECT_EQ(same.fit.chi2, begun.fit.chi2);
  EXPECT_EQ(same.grown, 0.0);
}

TEST_F(LengthenedWindows, ALookEndsWithTheShortestWhereTheyTellEnough) {
  const FitEffort look = {Through::contact, 1, false, true};
  const Eigen::VectorXd own = references.contact.nuisance();
  const Trial begun = candidates.fit({{"velocity_dependent_friction", {0.3, 0.1, 1.0}}}, &own, references.contact.local, look, &references.prior);
  References there = references;
  candidates.referOverShortWindows(there);
  EXPECT_GT(there.short_level, 1.0) << "the bearing is aside in windows of any length";
  double told = 0.0;
  const Trial same = candidates.lengthened(begun, look, &references.prior, nullptr, [&](double level) {
    told = level;
    return 0;
  });
  EXPECT_EQ(same.fit.chi2, begun.fit.chi2);
  EXPECT_EQ(same.grown, 0.0);
  EXPECT_GT(told, 0.5 * there.short_level) << "friction takes none of it";
}

TEST_F(LengthenedWindows, TheShortestHaveTheIterationsThatTheyAreWorth) {
  AMB_ROTOR_SKIP_UNLESS_LONG();
  const FitEffort look = {Through::contact, 1, false, true};
  const Eigen::VectorXd own = references.contact.nuisance();
  const Trial begun = candidates.fit({{misaligned, {0.0, 0.0, 0.0, 0.0}}}, &own, references.contact.local, look, &references.prior);
  const auto grown = [&](int longer) { return candidates.lengthened(begun, look, &references.prior, nullptr, [&](double) { return longer; }); };
  const Trial as_asked = grown(1), with_more = grown(4);
  EXPECT_EQ(with_more.short_level, as_asked.short_level) << "what was told is of the first iterations";
  EXPECT_LT(with_more.fit.chi2, 0.9 * as_asked.fit.chi2);
}

TEST_F(LengthenedWindows, WhatAllWindowsHaveToldOfARingIsFollowedThroughAll) {
  const FitEffort look = {Through::contact, 1, false, true};
  const Eigen::VectorXd own = references.contact.nuisance();
  std::vector<Trial> trials = {candidates.fit({{"inner_ring_spin", {4e-5, 0.003}}}, &own, references.contact.local, look, &references.prior)};
  ASSERT_EQ(trials[0].stride, 1);
  ASSERT_GT(references.sparse.stride, 1);
  trials[0].evidence = 1e4;
  Leaders leaders;
  leaders.through_contact = true;  // looks at other effects then need some windows only
  candidates.finish(trials, references, leaders, [](const std::string&) {});
  EXPECT_EQ(trials[0].stride, 1);
}

TEST_F(LengthenedWindows, AFitToAllRunsThatLeavesSomeAstrayGoesOnFromThere) {
  AMB_ROTOR_SKIP_UNLESS_LONG();
  // two thirds of the way: windows of 10 ms do not lead on from there
  EffectSetting near = truth;
  for (double& value : near.values) value *= 0.65;
  const Eigen::VectorXd own = references.contact.nuisance();
  Trial joint = candidates.fit({near}, &own, references.contact.local, {Through::all, 1, true});
  ASSERT_TRUE(isAstray(joint)) << "there is nothing to settle";
  const Trial settled = candidates.settled(joint, 8);
  EXPECT_FALSE(isAstray(settled)) << settled.fit.squares / settled.fit.count;
  // where it ended every run is at its noise, those to validate, too: there is no lower place, nor a flat valley
  const Trial followed = candidates.followed(settled, references.prior, 8, 0.9);
  EXPECT_LT(followed.fit.chi2, settled.fit.chi2 + 50.0);
  EXPECT_FALSE(isAstray(followed));
  // a tenth of the deviations that the runs support: the walk finds chi2 flat there, and says so
  Trial vain = settled;
  vain.fit.covariance *= 0.01;
  const Trial walked = candidates.walked(vain, references.prior, 8);
  const int parameters = vain.space->size() - vain.space->nuisances();
  const auto spread = [&](const Trial& trial) { return trial.fit.covariance.diagonal().tail(parameters).cwiseSqrt().maxCoeff(); };
  EXPECT_GT(spread(walked), 3.0 * spread(vain));
}

TEST(DiagnosisThroughContact, RefitsWhatALookHasBroughtDownBeforeTheRunsToValidateJudgeIt) {
  const MadeSet& set = madeSet(4300147, "auxiliary_bearing_misalignment", 0.0, true,
                               {"chirp_1", "chirp_4", "rub_1", "drop_1", "rub_2", "drop_2"});
  ASSERT_FALSE(set.runs(RunUse::validate, true).empty());
  DiagnosisOptions options;
  options.candidates = {"auxiliary_bearing_misalignment"};
  options.threads = 2;
  const Diagnosis found = diagnose(set.dataset.belief, set.dataset, options);
  EXPECT_EQ(found.verdict, "effect");
  ASSERT_EQ(found.steps.size(), 1u);
  EXPECT_GT(found.baseline.validation_error_contact, 5.0);
  EXPECT_LT(found.steps[0].errors.validation_error_contact, 1.0);  // starts of windows are fitted: below the noise
}

}  // namespace
}  // namespace amb_rotor
