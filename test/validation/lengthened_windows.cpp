// Effects through contact in whose fits windows of the usual length go astray.
#include <gtest/gtest.h>

#include <cmath>

#include "../support/made_sets.hpp"
#include "amb_rotor/validation/diagnosis.hpp"

namespace amb_rotor {
namespace {

TEST(LengthenedWindows, ABearingThatIsFarAsideIsFoundThroughManyImpacts) {
  // Offsets of up to 70 um at a contact of 1.4e8 N/m, some ten impacts in a window: with windows of 10 ms alone the fit ended
  // 4 to 11 um beside them, at 8 times the noise.
  const MadeSet& set = madeSet(4300147, "auxiliary_bearing_misalignment", 0.0, true, {"chirp_1", "rub_1", "drop_1", "rub_2", "chirp_4"});
  const EffectSetting truth = set.truth().effects.at(0);
  DiagnosisOptions options;
  options.candidates = {truth.id};
  const Diagnosis found = diagnose(set.dataset.belief, set.dataset, options);
  EXPECT_EQ(found.verdict, "effect");
  ASSERT_EQ(found.steps.size(), 1u);
  EXPECT_LT(found.steps[0].errors.validation_error_contact, 1.1) << "the noise, and starts of windows that the fit may choose";
  ASSERT_EQ(found.steps[0].parameters.size(), truth.values.size());
  for (std::size_t k = 0; k < truth.values.size(); ++k) {
    const auto& parameter = found.steps[0].parameters[k];
    EXPECT_NEAR(parameter.value, truth.values[k], 3.0 * parameter.std) << parameter.name;
  }
}

}  // namespace
}  // namespace amb_rotor
