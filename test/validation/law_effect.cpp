// Effects of files in the machine: equal to the effects of the catalogue that say the same, to a conserved energy and to a
// closed form. (Found by a diagnosis where nothing in the catalogue explains a recording: test/python/test_new_effect.py.)
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "../support/models.hpp"
#include "amb_rotor/effects/force_law.hpp"
#include "amb_rotor/effects/force_law_at_plane.hpp"
#include "amb_rotor/effects/force_law_of_tilt.hpp"
#include "amb_rotor/model/effect_file.hpp"

namespace amb_rotor {
namespace {

using namespace testing_support;

/// Puts an effect with one law into the program's catalogue.
const EffectSchema& known(const std::string& id, const std::string& place, const std::vector<std::string>& parameters,
                          const std::string& x, const std::string& y) {
  std::string text = "format: amb-effect/1\neffect: " + id + "\nsummary: \"of a test\"\nexcited_by: \"anything\"\nplace: " +
                     place + "\nparameters:\n";
  for (const auto& name : parameters)
    text += "  - {name: " + name + ", unit: \"1\", lower: -1.0e20, upper: 1.0e20, typical: 1.0, neutral: 0.0, meaning: \"m\"}\n";
  const bool signal = place == "sensors";
  text += std::string("law:\n  ") + (signal ? "signal_x_m" : "force_x_N") + ": \"" + x + "\"\n  " +
          (signal ? "signal_y_m" : "force_y_N") + ": \"" + y + "\"\n";
  FaultList faults(id);
  const YamlNode document = parseYaml(text, faults);
  YamlMap root(&document, "", faults);
  const EffectSchema schema = readEffect(root, document);
  faults.throwIfAny();
  const EffectSchema* added = effectCatalogue().add(schema);
  EXPECT_NE(added, nullptr) << id;
  return *added;
}

/// A rotor that turns, tilts and is excited, without contact.
Scenario lively() {
  Scenario scenario = from(constantSpeed(40.0, 0.05), {2e-5, 0.0, 1e-4, -2e-4}, {0.01, 0.0, 0.1, 0.0});
  scenario.excitations.push_back(currentPulse(0.5, 0.01, 0.02));
  return scenario;
}

/// Largest difference of the sensors' signals of two models, over the larger one's own size.
double difference(const Model& one, const Model& other, const Scenario& scenario) {
  const Simulation a = simulate(one, scenario), b = simulate(other, scenario);
  EXPECT_EQ(a.outcome.status, RunStatus::ok);
  EXPECT_EQ(b.outcome.status, RunStatus::ok);
  double most = 0.0, size = 0.0;
  for (int axis = 0; axis < 4; ++axis)
    for (std::size_t i = 0; i < a.trajectory.time_s.size(); ++i) {
      most = std::max(most, std::fabs(a.trajectory.displacement_m[axis][i] - b.trajectory.displacement_m[axis][i]));
      size = std::max(size, std::fabs(a.trajectory.displacement_m[axis][i]));
    }
  return most / size;
}

// Forces that differ by roundings only; the integrator's steps then differ by as little, and the motion
// forgets.
constexpr double law_roundings = 1e-9;

TEST(LawEffectTest, AtTheBearingsItIsTheEffectThatSaysTheSame) {
  known("test_cubic", "magnetic_bearings", {"c", "q"}, "c * (x^2 + y^2) * x - q * speed * y",
        "c * (x^2 + y^2) * y + q * speed * x");
  const Model base = withUnbalance(levitated(), 4e-5, 0.3, 0.02);
  std::vector<double> terms(effects::ForceLaw::term_count + 2, 0.0);
  terms.back() = 0.05;  // the width of a step that is not there
  terms[effects::ForceLaw::position_cube] = -2e13;
  terms[effects::ForceLaw::cross_speed] = 40.0;
  const Model hand = with(base, "force_law", terms), law = with(base, "test_cubic", {-2e13, 40.0});
  EXPECT_GT(difference(base, hand, lively()), 0.01) << "it changes the motion";
  EXPECT_LT(difference(hand, law, lively()), law_roundings);
}

TEST(LawEffectTest, AtTheRotorItIsALoadThere) {
  known("test_load", "rotor", {"f", "z_m"}, "0.3 * f", "f");
  const Model base = levitated();
  EXPECT_GT(difference(base, with(base, "test_load", {-12.0, 0.0}), lively()), 0.01);
  EXPECT_LT(
      difference(with(base, "static_load", {-3.6, -12.0}), with(base, "test_load", {-12.0, 0.0}), lively()),
      law_roundings);
}

TEST(LawEffectTest, AtOnePlaneItIsTheLawOfTermsThere) {
  known("test_plane_law", "rotor", {"c", "q", "f", "z_m"}, "c * (x^2 + y^2) * x - q * speed * vx + f * cos(3 * angle)",
        "c * (x^2 + y^2) * y - q * speed * vy + f * sin(3 * angle)");
  const Model base = withUnbalance(levitated(), 4e-5, 0.3, 0.02);
  using effects::LawTerms;
  std::vector<double> terms(LawTerms::plane_term_count, 0.0);
  terms[LawTerms::position_cube] = -2e13;
  terms[LawTerms::velocity_speed] = -0.05;
  terms[LawTerms::thrice_cosine] = 2.0;
  for (const double z_m : {-0.03, 0.07}) {
    std::vector<double> there = terms;
    there.insert(there.end(), {50.0, z_m});
    const Model hand = with(base, "force_law_at_plane", there), law = with(base, "test_plane_law", {-2e13, 0.05, 2.0, z_m});
    EXPECT_GT(difference(base, hand, lively()), 0.01) << "it changes the motion";
    EXPECT_LT(difference(hand, law, lively()), law_roundings);
    // it stands on the stator: where that moves, it pushes back
    const auto on = [](const Model& model) { return with(model, "foundation_resonance", {30.0, 60.0, 0.05}); };
    EXPECT_GT(difference(hand, on(hand), lively()), 0.01) << "the stator moves";
    EXPECT_LT(difference(on(hand), on(law), lively()), law_roundings);
  }
}

TEST(LawEffectTest, OfTheTiltItIsTheLawOfTermsAgainstIt) {
  known("test_tilt_law", "tilt", {"c", "q", "f"}, "c * (x^2 + y^2) * x - q * speed * vx + f * cos(3 * angle)",
        "c * (x^2 + y^2) * y - q * speed * vy + f * sin(3 * angle)");
  const Model base = withUnbalance(levitated(), 4e-5, 0.3, 0.02);
  using effects::LawTerms;
  std::vector<double> terms(LawTerms::plane_term_count + 1, 0.0);
  terms[LawTerms::position_cube] = -2e13;
  terms[LawTerms::velocity_speed] = -0.05;
  terms[LawTerms::thrice_cosine] = 2.0;
  const Model hand = with(base, "force_law_of_tilt", terms), law = with(base, "test_tilt_law", {-2e13, 0.05, 2.0});
  EXPECT_GT(difference(base, hand, lively()), 0.01) << "it changes the motion";
  EXPECT_LT(difference(hand, law, lively()), law_roundings);
}

/// -k (p_b - p_a)/2 at b and its opposite at a is -k p at each bearing and k (p_a + p_b)/2 at both: 2 k p amid them.
TEST(LawEffectTest, AStiffnessAgainstTheTiltIsOneAtTheBearingsWithoutThatAtTheMiddle) {
  known("test_tilt_spring", "tilt", {"k"}, "-k * x", "-k * y");
  known("test_bearing_spring", "magnetic_bearings", {"k"}, "-k * x", "-k * y");
  known("test_middle_spring", "rotor", {"k", "z_m"}, "-k * x", "-k * y");
  const Model base = withUnbalance(levitated(), 4e-5, 0.3, 0.02);
  const double stiffness = 6e3, middle_m = 0.5 * (base.rig.planes.amb[0] + base.rig.planes.amb[1]);
  const Model tilt = with(base, "test_tilt_spring", {stiffness});
  const Model parts = with(with(base, "test_bearing_spring", {stiffness}), "test_middle_spring", {-2.0 * stiffness, middle_m});
  EXPECT_GT(difference(base, tilt, lively()), 0.01);
  EXPECT_LT(difference(tilt, parts, lively()), law_roundings);
}

TEST(LawEffectTest, AtTheSensorsItIsARunout) {
  known("test_runout", "sensors", {"r", "p"}, "(1 - end) * r * cos(angle + p)", "(1 - end) * r * sin(angle + p)");
  const Model base = withUnbalance(levitated(), 4e-5, 0.3, 0.02);
  std::vector<double> runout(8, 0.0);
  runout[0] = 5e-6;
  runout[1] = 0.7;
  EXPECT_GT(difference(base, with(base, "test_runout", {5e-6, 0.7}), lively()), 0.01);
  EXPECT_LT(difference(with(base, "sensor_runout", runout), with(base, "test_runout", {5e-6, 0.7}), lively()),
            law_roundings);
}

TEST(LawEffectTest, ACubicSpringKeepsItsEnergy) {
  // m x'' = -2 (k x + c x^3), no damping: m v^2/2 + k x^2 + c x^4/2 is constant; largest x from it in closed form.
  known("test_spring", "magnetic_bearings", {"c"}, "-c * (x^2 + y^2) * x", "-c * (x^2 + y^2) * y");
  constexpr double k = 5e5, c = 5e13, v0 = 0.1;
  const Model model = with(springMass(2.0 * k, 0.0), "test_spring", {c});
  Scenario scenario = from(constantSpeed(0.0, 0.1, 1e5), {0.0, 0.0}, {v0, 0.0});
  const Simulation run = simulate(model, scenario);
  ASSERT_EQ(run.outcome.status, RunStatus::ok);
  const double m = model.rig.rotor.mass_kg, energy = 0.5 * m * v0 * v0;
  const double square = (-k + std::sqrt(k * k + 2.0 * c * energy)) / c;  // c/2 s^2 + k s - E = 0
  const double linear = std::sqrt(energy / k);
  EXPECT_LT(std::sqrt(square), 0.9 * linear) << "the cube matters";
  // sampled at 100 kHz, some 200 samples a swing: the largest sample misses the peak by less than 1 in 5000
  EXPECT_NEAR(largest(run.trajectory.displacement_m[0]) / std::sqrt(square), 1.0, 3e-4);
  EXPECT_NEAR(largest(run.trajectory.displacement_m[0], run.trajectory.time_s.size() / 2) / std::sqrt(square), 1.0, 3e-4)
      << "still in the second half";
}

TEST(LawEffectTest, AForceOfFixedFrequencyHasItsForcedResponse) {
  // 2 f cos(w t) on a mass: amplitude 2 f / |k - m w^2 + i w d|
  known("test_hum", "magnetic_bearings", {"f", "hz"}, "f * cos(2 * pi * hz * time)", "0");
  constexpr double k = 1e6, d = 2000.0, f = 10.0, hz = 50.0;
  const Model model = with(springMass(k, d), "test_hum", {f, hz});
  const Simulation run = simulate(model, constantSpeed(0.0, 0.3));
  ASSERT_EQ(run.outcome.status, RunStatus::ok);
  const double w = two_pi * hz, m = model.rig.rotor.mass_kg;
  std::vector<double> phase;
  for (double t : run.trajectory.time_s) phase.push_back(w * t);
  const auto response = order(phase, run.trajectory.displacement_m[0], 1.0, run.trajectory.time_s.size() / 2);
  const std::complex<double> exact = 2.0 * f / std::complex<double>(k - m * w * w, w * d);
  // by then the free motion has died away by exp(-300 * 0.15) = 1e-20; the integrator's tolerance is 1e-8
  EXPECT_NEAR(std::abs(response / exact - 1.0), 0.0, 1e-5);
}

}  // namespace
}  // namespace amb_rotor
