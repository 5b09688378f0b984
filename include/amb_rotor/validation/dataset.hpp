#pragma once
// Measurement data sets, format amb-dataset/1; doc/formats.md. A data set is a folder with dataset.yaml
// (the rig as believed, the channels, the runs) and one table a run. What was really in a tutorial rig
// (truth.yaml) is never read.
//
// Channels of four sensors: index = 2 * end + axis, that is ax, ay, bx, by.
#include <string>
#include <vector>

#include "amb_rotor/model/model.hpp"
#include "amb_rotor/model/yaml_document.hpp"

namespace amb_rotor {

enum class ChannelMeaning { displacement, control_current, excitation_current, tacho };

/// A column of the tables.
struct Channel {
  std::string name;  ///< of the column, with its unit: ax_um
  ChannelMeaning meaning = ChannelMeaning::displacement;
  int end = 0;               ///< 0 a, 1 b (not tacho)
  int axis = 0;              ///< 0 x, 1 y (not tacho)
  double unit_factor = 1.0;  ///< a cell times this is SI
  double noise_rms = 0.0;    ///< SI, before rounding; displacement and control current
  double resolution = 0.0;   ///< SI
  double threshold = 0.0;    ///< tacho: the pulse is there above it, in the column's own unit

  int index() const { return 2 * end + axis; }
  /// Standard deviation of a residual: noise and rounding together [SI]. Excitation, tacho: 0.
  double noise() const;
};

enum class RunKind { step, chirp, steady, run_up, coast_down, rub, drop };
enum class RunUse {
  fit,      ///< for choosing and fitting
  validate  ///< only for judging
};

struct RunEvent {
  double time_s = 0.0;
  bool amb_on = false;  ///< amb_on, else amb_off
};

struct Run {
  std::string id;
  std::string file;  ///< relative to the data set's folder
  RunKind kind = RunKind::steady;
  double sample_rate_hz = 0.0;
  bool speed_from_tacho = false;  ///< the speed is in the pulses; else:
  double speed_hz = 0.0;          ///< constant, as the owner believes
  std::vector<RunEvent> events;   ///< in the order of their times
  RunUse use = RunUse::fit;
  std::vector<Unbalance<double>> unbalance;  ///< trial weights, beside the rig's

  /// Runs with contact are predicted in windows, the others in one piece.
  bool holdsContact() const { return kind == RunKind::rub || kind == RunKind::drop; }
};

struct Dataset {
  std::string name;
  std::string folder;
  Model belief;  ///< of rotor model rigid_beam, without effects
  std::vector<Channel> channels;
  std::vector<Run> runs;

  const Run* findRun(const std::string& id) const;
  /// The channel of a meaning; index: as Channel::index(), not used for tacho. Null where it is absent.
  const Channel* findChannel(ChannelMeaning meaning, int index = 0) const;
};

/// A run's table in SI. A vector of an absent channel is empty, all others are as long as time_s.
struct RunTable {
  std::vector<double> time_s;  ///< from the first row on, which is 0
  double begins_s = 0.0;       ///< the first row's time in the file: a run's events count by the file's clock
  std::vector<double> tacho;  ///< in the column's unit; compare with Channel::threshold
  std::vector<double> displacement_m[4];
  std::vector<double> current_A[4];
  std::vector<double> excitation_A[4];
};

/// Reads dataset.yaml of the folder and checks it: the rig's rules, the channels, that each run's file is
/// there. Throws InputError with all faults. A data set of kind `modes` is another thing: modes_dataset.hpp.
Dataset readDataset(const std::string& folder);

/// The model as a data set's owner trusts it: where it says nothing of how sure its numbers are, the data set does.
Model trustedAs(Model model, const Dataset& dataset);

/// Reads the table of a run. Throws InputError with all faults: missing, unknown or doubled columns, cells
/// that are no finite numbers (with their line), time that does not rise or has gaps, a sample rate that
/// t_s contradicts, a cut or damaged file.
RunTable readRun(const Dataset& dataset, const Run& run);

/// Names as in files.
const char* runKindName(RunKind kind);
const char* channelMeaningName(ChannelMeaning meaning);

/// Path of dataset.yaml in a folder; `folder` may name the file itself.
std::string datasetFile(const std::string& folder);

/// Whether the data set in the folder is of kind `modes`. Throws InputError if it cannot be read.
bool isModesDataset(const std::string& folder);

/// What the two kinds of data sets share: format, name and rig, with the rig's rules checked.
/// Returns the belief.
Model readDatasetHead(YamlMap& root);

/// The keys that the runs of both kinds share: id and file (there, both of no run in `before`), use.
struct RunHead {
  std::string id;
  std::string file;
  RunUse use = RunUse::fit;
};
RunHead readRunHead(YamlMap& run, const std::string& folder, std::vector<RunHead>& before);

}  // namespace amb_rotor
