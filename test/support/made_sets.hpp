#pragma once
// Data sets that the generator makes once for all tests of a program: event-accurate runs with noise, and their truth.
#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <filesystem>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "amb_rotor/validation/make_dataset.hpp"
#include "amb_rotor/validation/recording.hpp"
#include "amb_rotor/validation/stretches.hpp"

namespace amb_rotor {

struct MadeSet {
  MadeDataset made;
  Dataset dataset;
  std::vector<Recording> recordings;
  double offset_std_m = 0.0;

  /// Indices of the recordings of a use, with or without contact.
  std::vector<int> runs(RunUse use, bool contact) const {
    std::vector<int> which;
    for (int i = 0; i < static_cast<int>(recordings.size()); ++i)
      if (recordings[i].run.use == use && recordings[i].holdsContact() == contact) which.push_back(i);
    return which;
  }
  int indexOf(const std::string& id) const {
    for (int i = 0; i < static_cast<int>(recordings.size()); ++i)
      if (recordings[i].run.id == id) return i;
    return -1;
  }
  /// The true machine without uncertain numbers but the recordings' own.
  Model truth() const {
    Model model = made.truth;
    model.uncertainty.clear();
    return model;
  }
};

/// A set by its hidden effect or law ("none": nothing is hidden), or only some runs of it; made at the first call, gone with
/// the program.
inline const MadeSet& madeSet(std::uint64_t seed, const std::string& hidden, double strength, bool contact,
                              const std::vector<std::string>& runs = {}) {
  struct Store {
    std::filesystem::path folder =
        std::filesystem::temp_directory_path() / ("amb_rotor_made_sets_" + std::to_string(::getpid()));
    std::map<std::string, std::unique_ptr<MadeSet>> sets;
    ~Store() {
      std::error_code ignored;
      std::filesystem::remove_all(folder, ignored);
    }
  };
  static Store store;
  std::string name = hidden + "_" + std::to_string(seed) + "_" + std::to_string(strength) + (contact ? "_contact" : "");
  for (const auto& run : runs) name += "_" + run;
  auto& slot = store.sets[name];
  if (slot == nullptr) {
    slot = std::make_unique<MadeSet>();
    const std::string folder = (store.folder / name).string();
    slot->made = makeDataset({seed, {hidden}, strength, contact, folder, runs});
    slot->dataset = readDataset(folder);
    slot->recordings = prepareRecordings(slot->dataset);
    slot->offset_std_m = slot->dataset.belief.uncertainty.at("sensor.offset_m");
  }
  return *slot;
}

/// The first instants of a recording.
inline Recording beginningOf(Recording rec, long samples) {
  rec.samples = std::min(rec.samples, samples);
  rec.measured.resize(rec.samples * predicted_channels);
  return rec;
}

/// What a model's channels show in a recording, in lanes: samples * predicted_channels.
inline std::vector<double> predictedBy(const Model& model, const Recording& rec, double standstill_angle = 0.0) {
  std::vector<double> out(rec.samples * predicted_channels);
  std::vector<LaneJob> jobs = {jobOf(rec, model, standstill_angle)};
  jobs[0].out = out.data();
  predict(stretchOf(rec, model), jobs);
  EXPECT_TRUE(jobs[0].finite) << rec.run.id;
  return out;
}

/// The recording as it would be with another machine: what parts the two models is added, its noise stays.
inline Recording asOf(const Model& other, const Model& model, Recording rec, double standstill_angle = 0.0) {
  const std::vector<double> with = predictedBy(other, rec, standstill_angle),
                            without = predictedBy(model, rec, standstill_angle);
  for (std::size_t i = 0; i < with.size(); ++i) rec.measured[i] += with[i] - without[i];
  return rec;
}

/// What tells the quantities apart that a law may depend on: chirps, three speeds, and one of each to validate.
inline const std::vector<std::string> runs_that_tell_laws_apart = {"chirp_1",  "chirp_3", "steady_1", "steady_2",
                                                                   "steady_3", "chirp_4", "steady_4"};

inline std::vector<int> indicesToFit(const std::vector<Recording>& recordings) {
  std::vector<int> which;
  for (int i = 0; i < static_cast<int>(recordings.size()); ++i)
    if (recordings[i].run.use == RunUse::fit) which.push_back(i);
  return which;
}

/// Nothing is hidden, and nothing touches.
inline const MadeSet& cleanSet() { return madeSet(21, "none", 0.0, false); }

}  // namespace amb_rotor
