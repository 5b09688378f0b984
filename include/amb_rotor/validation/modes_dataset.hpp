#pragma once
// Data sets of kind `modes`: natural frequencies measured under several conditions (a table of a thesis, a
// hammer test), without recordings in time. Format amb-dataset/1 with `kind: modes`; doc/formats.md.
#include <string>
#include <vector>

#include "amb_rotor/model/model.hpp"
#include "amb_rotor/validation/dataset.hpp"

namespace amb_rotor {

/// One row of a run's table: one measurement.
struct ModesPoint {
  std::string run;
  RunUse use = RunUse::fit;
  std::vector<double> condition;     ///< values of ModesDataset::conditions
  double speed_hz = 0.0;             ///< 0 where the table has no such column
  std::vector<double> frequency_hz;  ///< measured, rising
  std::vector<double> std_hz;        ///< standard deviation of each, above 0
};

struct ModesDataset {
  std::string name;
  std::string folder;
  Model belief;  ///< of rotor model rigid_beam, without effects
  /// The fields of the rig that were set, by their names out of Rig::visit: "amb.stiffness_N_per_m".
  std::vector<std::string> conditions;
  std::size_t mode_count = 0;
  std::vector<ModesPoint> points;  ///< run by run, row by row
};

/// Reads and checks a data set of kind modes with all its tables. Throws InputError with all faults.
ModesDataset readModesDataset(const std::string& folder);

/// A model at the condition of a point: the fields of the dataset's conditions set to the point's values.
/// Throws InputError where the model has no such field (another bearing model).
Model modelAt(const Model& model, const ModesDataset& dataset, const ModesPoint& point);

}  // namespace amb_rotor
