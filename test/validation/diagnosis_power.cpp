// What a diagnosis says of effects that it does not find.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>

#include "../support/made_sets.hpp"
#include "amb_rotor/validation/diagnosis.hpp"

namespace amb_rotor {
namespace {

TEST(DiagnosisPowerTest, AnAbsentEffectComesWithTheSizeThatWouldHaveBeenSeen) {
  const MadeSet& set = madeSet(31, "none", 0.0, false);
  DiagnosisOptions options;
  options.candidates = {"static_load"};
  const Diagnosis diagnosis = diagnose(set.dataset.belief, set.dataset, options);
  EXPECT_EQ(diagnosis.verdict, "none");
  ASSERT_EQ(diagnosis.ranking.size(), 1u);
  const Candidate& load = diagnosis.ranking[0];
  ASSERT_TRUE(load.excited);
  ASSERT_EQ(load.parameters[0].name, "force_x_N");
  const std::string says = "would have been seen from about force_x_N ";
  ASSERT_EQ(load.note.rfind(says, 0), 0u) << load.note;
  const double size = std::strtod(load.note.c_str() + says.size(), nullptr);
  // Evidence of 12 and two parameters against some 1e5 to 1e7 residuals: 24 + 2 ln N, hence 6.9 to 7.5 standard deviations;
  // two digits are written.
  EXPECT_GT(size, 6.5 * load.parameters[0].std);
  EXPECT_LT(size, 7.9 * load.parameters[0].std);
  EXPECT_LT(std::fabs(load.parameters[0].value), size);
  EXPECT_TRUE(diagnosis.withdrawn.empty());
}

/// An error as near to the noise as a clean set's leaves a law nothing to explain, though a little above one.
TEST(DiagnosisPowerTest, NoLawIsSoughtWhereTheErrorIsTheNoise) {
  const MadeSet& set = madeSet(34, "none", 0.0, false);
  DiagnosisOptions options;
  options.candidates = {"static_load"};
  std::string said;
  options.progress = [&](double, const std::string& what) { said += what + "; "; };
  const Diagnosis diagnosis = diagnose(set.dataset.belief, set.dataset, options);
  EXPECT_EQ(diagnosis.verdict, "none");
  EXPECT_GT(diagnosis.baseline.validation_error_free, 1.0);
  EXPECT_EQ(said.find("law"), std::string::npos) << said;
}

/// A nuisance that the runs put ten stated deviations away is named with it; one within them is not.
TEST(DiagnosisPowerTest, ABeliefThatIsFarOffIsSaid) {
  const MadeSet& set = madeSet(31, "none", 0.0, false);
  DiagnosisOptions options;
  options.candidates = {"static_load"};
  for (const double deviations : {0.0, 10.0}) {
    Model belief = set.dataset.belief;
    double share = 0.0;
    for (const auto& [name, uncertainty] : belief.uncertainty)
      if (name == "rotor.mass_kg") share = uncertainty;
    ASSERT_GT(share, 0.0);
    belief.rig.rotor.mass_kg *= std::exp(deviations * share);
    const Diagnosis diagnosis = diagnose(belief, set.dataset, options);
    EXPECT_EQ(diagnosis.verdict, "none");
    std::string strained;
    for (const std::string& sentence : diagnosis.sentences)
      if (sentence.find("stated deviations away") != std::string::npos) strained += sentence;
    EXPECT_EQ(strained.find("rotor.mass_kg") != std::string::npos, deviations > 5.0) << strained;
  }
}

}  // namespace
}  // namespace amb_rotor
