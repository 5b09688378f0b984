#pragma once
// Blind data sets of our own: a rig drawn at random, a hidden effect, recordings in format amb-dataset/1 beside their
// truth (amb-truth/1). Made with the event-accurate integrator, never with the lanes that a diagnosis uses.
// doc/blind_sets.md.
#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "amb_rotor/model/model.hpp"

namespace amb_rotor {

struct MakeDatasetOptions {
  std::uint64_t seed = 1;
  std::vector<std::string> effects;  ///< of the catalogue, one of hiddenLaws(), or "none"; empty: drawn
  double strength = 0.0;             ///< simulated difference over the noise, rms; 0: drawn from 2 to 20
  bool contact = false;              ///< with runs of kind rub and drop, also where no effect asks for them
  std::string out;                   ///< folder to write
  std::vector<std::string> runs;     ///< only these of the set's runs, by id (chirp_1, steady_2, ...); empty: all
  FrictionLaw friction_law = FrictionLaw::regularised;  ///< of the rig and of the truth
};

struct MadeDataset {
  std::string verdict;               ///< effect, none, unknown: what a diagnosis should say
  std::string law;                   ///< of no catalogue; empty: none
  std::vector<std::string> depends_on;  ///< what that law depends on
  Model belief, truth;
  double difference = 0.0;           ///< true machine against the one without its effects, over the noise, rms
  std::map<std::string, double> floor;  ///< run id: residual of the true model over the noise
};

/// Laws of no catalogue, which live in the generator alone.
std::vector<std::string> hiddenLaws();

/// Makes and writes a data set; the same options give the same files.
/// @throw InputError: an unknown effect, a law of no catalogue beside set-valued friction, effects that no drawn rig can carry, a run that is not there or none to fit, a folder that cannot be written
MadeDataset makeDataset(const MakeDatasetOptions& options);

}  // namespace amb_rotor
