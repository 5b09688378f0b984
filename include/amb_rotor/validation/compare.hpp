#pragma once
// Model against measurement: predictions of every run with the nuisance refitted, and where they fail.
// Errors are root mean square residuals over their noise (1: the floor), as doc/formats.md defines them.
#include <functional>
#include <map>
#include <string>
#include <vector>

#include "amb_rotor/validation/coordinates.hpp"
#include "amb_rotor/validation/recording.hpp"

namespace amb_rotor {

/// Called with a share done (0..1) and what is being done; may be empty.
using Progress = std::function<void(double, const std::string&)>;

struct SpeedError {
  double speed_hz, error;
};

struct ErrorBreakdown {
  double error = -1.0;         ///< over all runs, which weigh equally; below 0: there are none
  double error_free = -1.0;    ///< over runs in one piece; below 0: there are none
  double error_contact = -1.0; ///< over runs in windows of 10 ms; below 0: there are none
  double noise_floor = 1.0;
  std::map<std::string, double> by_run;      ///< run id
  std::map<std::string, double> by_channel;  ///< ax, ay, bx, by, iax, iay, ibx, iby
  std::map<std::string, double> by_regime;   ///< standstill, steady, speed_change, excited, contact, after_contact, amb_off
  std::map<int, double> by_harmonic;         ///< order with sign, backward negative: error that a removal of it would take away
  std::vector<SpeedError> by_speed;          ///< in bins of speed
  std::string worst;                         ///< the worst cell in a sentence
};

/// One run's measured and predicted channels, for pictures. Rows: predicted_channels each instant.
struct PredictedRun {
  std::string id;
  std::string use;              ///< fit or validate
  std::string kind;
  double sample_rate_hz = 0.0;
  double error = 0.0;
  std::vector<double> measured, predicted;   ///< samples * predicted_channels, SI
  std::vector<double> angle_rad, speed_rad_s;  ///< a value each instant
  std::array<double, predicted_channels> noise{};
};

struct Comparison {
  ErrorBreakdown errors;              ///< over all runs
  ErrorBreakdown validation_errors;   ///< over the runs to validate
  std::vector<FittedParameter> nuisance;
  std::vector<PredictedRun> runs;
  Model model;                        ///< with the refitted nuisance
  std::vector<std::string> remarks;   ///< on the data
};

struct CompareOptions {
  bool refit = true;   ///< fit the nuisance on the runs to fit; else the model as it stands
  int threads = 0;     ///< 0: all cores
  Progress progress;
};

/// @throw InputError: a broken data set, or a model that does not fit it
Comparison compare(const Model& model, const Dataset& dataset, const CompareOptions& options = {});

}  // namespace amb_rotor
