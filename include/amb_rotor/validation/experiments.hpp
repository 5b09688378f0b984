#pragma once
// Which run would part two fitted models that the runs to fit hardly part.
//
// Each feasible run is predicted with one model, which is then taken as what was measured, and the other is
// fitted to it:
//   c = d'd - g' (J'J + H)^-1 g,   g = J'd,
// d the difference over the noise, J the other model's sensitivities there (with the run's own offsets,
// drifts and, at standstill, its shaft angle free), H what the runs to fit and the stated uncertainty say of
// its numbers. c is what the wrong model cannot take away, to first order; both ways round, the lesser
// counts. Separation: sqrt(c / residuals), in units of the noise; expected evidence: c/2. A raw difference of
// two fitted models would promise too much: a refit takes most of it away. Feasible: no contact unless the
// pair needs it (0.8 of the clearance), speeds to 1.5 times the critical one, currents of the size that the
// recordings hold. Left out: what a run costs, and more than one run at a time.
#include <string>
#include <vector>

#include "amb_rotor/validation/diagnosis.hpp"
#include "amb_rotor/validation/fit.hpp"

namespace amb_rotor {

/// One of two models: its effect, its numbers as fitted, and the information on them (the inverse of their
/// covariance).
struct Rival {
  std::string effect;
  Model belief;  ///< that the fitted effects come on top of
  std::vector<EffectSetting> fitted;
  Eigen::VectorXd x;  ///< of FitSpace(belief, fitted)
  Eigen::MatrixXd information;
};

/// Runs that can be made on the rig, with amplitudes and speeds of its size; `contact`: rubs and drops
/// instead.
std::vector<Experiment> feasibleExperiments(const Model& belief, const std::vector<Recording>& recordings,
                                            bool contact);

/// The rig as it stands in an experiment: gravity and trial weights.
Model inExperiment(const Experiment& experiment, Model model);

/// An experiment as a recording, with nothing measured yet; noise and sample rate as in `like`.
Recording recordingOf(const Experiment& experiment, const Recording& like);

/// What a model's signals are in it, without noise: an entry for each channel and instant. Empty: not finite,
/// or `free` and the rotor comes near its auxiliary bearings.
std::vector<double> signalsOf(const Experiment& experiment, const Model& model, const Recording& like,
                              bool free);

/// The feasible experiments for a pair, best first, with their separation.
std::vector<Experiment> rankExperiments(const Rival& one, const Rival& other,
                                        const std::vector<Recording>& recordings, double offset_std_m);

/// Settings path=value (as of --set) that bring a model into an experiment.
std::vector<std::string> experimentOverrides(const Experiment& experiment, const Model& model);

}  // namespace amb_rotor
