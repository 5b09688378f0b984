#pragma once
// Which effect is missing: every candidate of the catalogue refitted with the nuisance, ranked by evidence on the
// runs to fit, judged on the runs to validate; then adopted one after the other while that pays.
#include <optional>
#include <string>
#include <vector>

#include "amb_rotor/model/effect_file.hpp"
#include "amb_rotor/model/scenario.hpp"
#include "amb_rotor/validation/compare.hpp"

namespace amb_rotor {

struct CandidateErrors {
  double fit_error = 0.0, validation_error = 0.0;
  double validation_error_free = -1.0, validation_error_contact = -1.0;  ///< below 0: no such runs
  /// Root mean square, over what is believed of them, of the sensors' offsets that the controller takes for the position (runs to
  /// validate, without contact): by chance 1. Below 0: there are none.
  double offset_deviations = -1.0;
};

struct Candidate {
  std::string effect;
  std::vector<FittedParameter> parameters;
  CandidateErrors errors;
  double evidence = 0.0;                     ///< half the drop of the BIC against the baseline
  std::vector<std::string> confounded_with;  ///< others that explain the runs to fit about as well
  std::string experiment;                    ///< what would part them
  bool excited = true;                       ///< false: these runs cannot show it
  bool borne_out = false;  ///< the runs to validate have become better by it: such come first
  bool plausible = true;                     ///< parameters inside their physical range, not at a limit
  std::string beside;                        ///< what was adopted when its evidence was found; empty: nothing, as for most
  std::string note;
};

/// A run that would part two effects which the runs to fit hardly part: validation/experiments.hpp.
struct Experiment {
  std::string effect, against;  ///< candidates of the ranking
  std::string name;             ///< e.g. slow_roll
  std::string what;             ///< in words
  Scenario scenario;
  double gravity_m_s2 = 0.0;    ///< of the rig in it
  std::vector<Unbalance<double>> trial_weights;  ///< beside the rig's unbalance
  double separation = 0.0;      ///< what the worse of the two leaves there after its own refit, over the noise, rms
  double evidence = 0.0;        ///< expected natural logarithm of the odds for the true one
};

struct DiagnosisStep {
  std::string added;
  std::vector<FittedParameter> parameters;
  CandidateErrors errors;
  bool only_with_next = false;  ///< it earns its place only together with the step after it; `errors` are those before
};

struct HypothesisTerm {
  std::string term;       ///< e.g. "x * |x|^2" in the grammar of doc/formats.md
  double coefficient = 0.0, std = 0.0;
};

struct Unexplained {
  std::vector<std::string> depends_on;  ///< position, velocity, spin speed, shaft angle, control current, time
  std::string shape;
  std::vector<HypothesisTerm> terms;    ///< at most three; a hypothesis
  double frequency_hz = 0.0;            ///< of terms that repeat in time; 0: none
  EffectLaw::Place place = EffectLaw::Place::magnetic_bearings;
  std::optional<double> plane_z_m = {}; ///< of the one plane of the rotor at which it acts, where that is its place
  double plane_std_m = 0.0;
  double step_width = 0.0;              ///< over which a step is rounded off, of a signal [m] or a current [A]; 0: the law has none
  double held_out_gain = 0.0;           ///< share of the unexplained error that the terms take away on held-out runs, at most 1
};

struct Diagnosis {
  std::string verdict;  ///< effect, none, unknown
  double noise_floor = 1.0;
  CandidateErrors baseline;
  std::vector<FittedParameter> nuisance;
  std::vector<Candidate> ranking;
  std::vector<Experiment> experiments;  ///< for each confounded pair, best first
  std::map<std::string, Model> rivals;  ///< of the candidates in `experiments`, as fitted
  std::vector<DiagnosisStep> steps;
  std::vector<std::string> withdrawn;   ///< adopted on the way, needless beside what was adopted later
  Unexplained unexplained;
  std::vector<std::string> sentences;   ///< where the baseline fails, readable in one look
  Model adopted;                        ///< the belief with all steps and the refitted nuisance
  std::optional<Comparison> before;     ///< the belief, its nuisance refitted, beside all runs; where asked for
  std::optional<Comparison> after;      ///< the same of `adopted`, where that has effects and keeps the rules of models
  std::vector<std::string> remarks;
  double seconds = 0.0;
  bool time_limit_reached = false;  ///< the search ended early for it
};

struct DiagnosisOptions {
  std::vector<std::string> candidates;  ///< empty: the whole catalogue
  int threads = 0;
  int most_steps = 3;
  bool comparisons = false;   ///< fill Diagnosis::before and after
  double time_limit_s = 0.0;  ///< after which nothing new is begun; a refit under way ends a third later. 0: none
  Progress progress;
};

/// What a diagnosis lacks in a data set: runs to fit an effect to, or to judge it by. Not empty: `diagnose` refuses it with these.
std::vector<Fault> lackingUses(const Dataset& dataset);

Diagnosis diagnose(const Model& model, const Dataset& dataset, const DiagnosisOptions& options = {});

}  // namespace amb_rotor
