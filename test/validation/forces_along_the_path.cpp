// What a small force does when it is taken along the measured path is what it does in the model: of a rig that it does not
// act on, the path is the one without it.
#include <gtest/gtest.h>

#include <cmath>

#include "../../src/validation/path_forces.hpp"
#include "../support/made_sets.hpp"
#include "amb_rotor/effects/catalogue.hpp"

namespace amb_rotor {
namespace {

/// Of the sensors in the loop.
const Eigen::VectorXd no_offsets = Eigen::VectorXd::Zero(2 * axis_count);

std::vector<double> predicted(const Recording& rec, const Model& model) {
  std::vector<double> out(rec.samples * predicted_channels);
  std::vector<LaneJob> jobs = {jobOf(rec, model, 0.0)};
  jobs[0].out = out.data();
  predict(stretchOf(rec, model), jobs);
  EXPECT_TRUE(jobs[0].finite);
  return out;
}

EffectSetting law(const char* term, double coefficient, const char* id = "force_law") {
  const EffectSchema* schema = effectCatalogue().find(id);
  EffectSetting effect{id, std::vector<double>(schema->parameters.size(), 0.0)};
  effect.values[schema->indexOf(term)] = coefficient;
  effect.values[schema->indexOf("time_frequency_hz")] = 50.0;
  if (effect.id == "force_law") effect.values[schema->indexOf("step_width_A")] = 0.05;
  return effect;
}

EffectSetting lawAtPlane(const char* term, double coefficient, double z_m) {
  EffectSetting effect = law(term, coefficient, "force_law_at_plane");
  effect.values.back() = z_m;
  return effect;
}

TEST(ForcesAlongThePath, ASmallForceDoesWhatItDoesInTheModel) {
  // 6 %: the noise of the path is a twentieth of the orbit of steady_3, and the forces, which must stand out of what the exact
  // propagation and the steps of a machine that is not linear differ by (5e-6 of the orbit), change the path by some hundredths; the cube of the path has more of both
  const Model model = cleanSet().truth();
  for (const char* id : {"chirp_1", "steady_3"}) {
    const Recording& rec = cleanSet().recordings.at(cleanSet().indexOf(id));
    // beside next to no force, so that both go by the steps of a machine that is not linear
    Model without = model;
    without.effects.push_back(law("position_N_per_m", -1e-12));
    const std::vector<double> base = predicted(rec, without), exact = predicted(rec, model);
    int number = 0;
    std::vector<EffectSetting> forces = {law("position_N_per_m", -3e3), law("velocity_N_s_per_m", -3.0),
                                         law("position_cube_N_per_m3", -3e12), law("thrice_cosine_N", 1.0),
                                         lawAtPlane("velocity_N_s_per_m", -4.0, 0.04), lawAtPlane("thrice_cosine_N", 1.5, -0.02),
                                         law("thrice_cosine_N", 1.5, "force_law_of_tilt")};
    // an unbalance next to the centre of mass tilts the rotor by no more than the noise
    if (std::string(id) == "chirp_1") forces.push_back(law("velocity_N_s_per_m", -4.0, "force_law_of_tilt"));
    for (const EffectSetting& force : forces) {
      ++number;
      Model with = model;
      with.effects.push_back(force);
      const std::vector<double> there = predicted(rec, with);
      const auto along = responsesAlongPath({rec, 0.0, {}, 0.0, no_offsets, exact}, model, {force});
      ASSERT_EQ(along.size(), 1u);
      ASSERT_EQ(along[0].size(), base.size());
      const long from = std::lround(0.1 * rec.run.sample_rate_hz);  // in which the force sets in
      double least = 1e300;
      for (int c : {0, 4}) {  // ax is driven in both
        double off = 0.0, whole = 0.0, mean = 0.0;
        for (long i = from; i < rec.samples; ++i) {
          const std::size_t at = i * predicted_channels + c;
          const double one = along[0][at] - (there[at] - base[at]);
          mean += one / (rec.samples - from);
          off += one * one;
          whole += std::pow(there[at] - base[at], 2);
        }
        off -= mean * mean * (rec.samples - from);  // the sensor's offset is in the path, and an unknown of every run
        EXPECT_LT(std::sqrt(off / whole), number == 3 ? 0.12 : 0.06) << id << ", channel " << c << ", force " << number;
        least = std::min(least, whole);
      }
      EXPECT_GT(least, 0.0);
    }
  }
}

TEST(ForcesAlongThePath, WithoutAnAmplifiersLagThereIsNoWayIn) {
  const Recording& rec = cleanSet().recordings.at(cleanSet().indexOf("steady_3"));
  const std::vector<double> base = predicted(rec, cleanSet().truth());
  Model coils = cleanSet().truth(), equivalent = coils;
  coils.coil.emplace();
  equivalent.amb_model = AmbModel::equivalent;
  for (const Model& model : {coils, equivalent})
    EXPECT_TRUE(responsesAlongPath({rec, 0.0, {}, 0.0, no_offsets, base}, model, {law("position_N_per_m", -300.0)})[0].empty());
}

TEST(ForcesAlongThePath, WithoutASensorThereIsNoPath) {
  Recording rec = cleanSet().recordings.at(cleanSet().indexOf("steady_3"));
  const std::vector<double> base = predicted(rec, cleanSet().truth());
  rec.noise[2] = 0.0;
  const auto along = responsesAlongPath({rec, 0.0, {}, 0.0, no_offsets, base}, cleanSet().truth(), {law("position_N_per_m", -300.0)});
  ASSERT_EQ(along.size(), 1u);
  EXPECT_TRUE(along[0].empty());
}

}  // namespace
}  // namespace amb_rotor
