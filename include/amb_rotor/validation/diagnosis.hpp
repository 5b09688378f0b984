#pragma once
// Which effect is missing: every candidate of the catalogue refitted with the nuisance, ranked by evidence on the
// runs to fit, judged on the runs to validate; then adopted one after the other while that pays.
#include <string>
#include <vector>

#include "amb_rotor/validation/compare.hpp"

namespace amb_rotor {

struct CandidateErrors {
  double fit_error = 0.0, validation_error = 0.0;
  double validation_error_free = -1.0, validation_error_contact = -1.0;  ///< below 0: no such runs
};

struct Candidate {
  std::string effect;
  std::vector<FittedParameter> parameters;
  CandidateErrors errors;
  double evidence = 0.0;                     ///< half the drop of the BIC against the baseline
  std::vector<std::string> confounded_with;  ///< others that explain the runs to fit about as well
  std::string experiment;                    ///< what would part them
  bool excited = true;                       ///< false: these runs cannot show it
  bool plausible = true;                     ///< parameters inside their physical range, not at a limit
  std::string note;
};

struct DiagnosisStep {
  std::string added;
  std::vector<FittedParameter> parameters;
  CandidateErrors errors;
};

struct HypothesisTerm {
  std::string term;       ///< e.g. "x * |x|^2" in the grammar of doc/formats.md
  double coefficient = 0.0, std = 0.0;
};

struct Unexplained {
  std::vector<std::string> depends_on;  ///< position, velocity, spin speed, shaft angle, control current, time
  std::string shape;
  std::vector<HypothesisTerm> terms;    ///< at most three; a hypothesis
  double held_out_gain = 0.0;           ///< share of the unexplained error that the terms take away on held-out runs
};

struct Diagnosis {
  std::string verdict;  ///< effect, none, unknown
  double noise_floor = 1.0;
  CandidateErrors baseline;
  std::vector<FittedParameter> nuisance;
  std::vector<Candidate> ranking;
  std::vector<DiagnosisStep> steps;
  std::vector<std::string> withdrawn;   ///< adopted on the way, needless beside what was adopted later
  Unexplained unexplained;
  std::vector<std::string> sentences;   ///< where the baseline fails, readable in one look
  Model adopted;                        ///< the belief with all steps and the refitted nuisance
  std::vector<std::string> remarks;
  double seconds = 0.0;
};

struct DiagnosisOptions {
  std::vector<std::string> candidates;  ///< empty: the whole catalogue
  int threads = 0;
  int most_steps = 3;
  Progress progress;
};

Diagnosis diagnose(const Model& model, const Dataset& dataset, const DiagnosisOptions& options = {});

}  // namespace amb_rotor
