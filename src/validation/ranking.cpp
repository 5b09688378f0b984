#include "amb_rotor/validation/ranking.hpp"

#include <algorithm>
#include <cmath>

namespace amb_rotor {
namespace {

/// Candidates whose evidence is this close explain the runs as well.
constexpr double twin_share = 0.03, twin_evidence = 8.0;

}  // namespace

double excessWithoutContact(const CandidateErrors& errors) {
  const double error = errors.validation_error_free;
  return error < 0.0 ? 0.0 : std::max(0.0, error * error - 1.0);
}

void markConfounded(std::vector<Candidate>& ranking) {
  for (auto& one : ranking) {
    one.confounded_with.clear();
    if (!one.excited || one.evidence <= least_evidence) continue;
    for (const auto& other : ranking)
      if (other.effect != one.effect && other.excited &&
          std::fabs(other.evidence - one.evidence) < std::max(twin_evidence, twin_share * one.evidence))
        one.confounded_with.push_back(other.effect);
  }
}

void order(std::vector<Candidate>& ranking) {
  std::stable_sort(ranking.begin(), ranking.end(), [](const Candidate& a, const Candidate& b) {
    return a.borne_out != b.borne_out ? a.borne_out : a.evidence > b.evidence;
  });
  markConfounded(ranking);
}

void notBorneOut(std::vector<Candidate>& ranking, const std::string& effect) {
  for (auto& c : ranking)
    if (c.effect == effect) c.borne_out = false;
  order(ranking);
}

void takeBetter(std::vector<Candidate>& ranking, const Candidate& anew) {
  for (auto& c : ranking)
    if (c.effect == anew.effect && anew.evidence > c.evidence) c = anew;
  order(ranking);
}

void scaleToAllWindows(CandidateErrors& errors, double reference, double reference_sampled) {
  if (errors.validation_error_contact < 0.0 || reference <= 0.0 || reference_sampled <= 0.0) return;
  errors.validation_error_contact *= reference / reference_sampled;
}

bool lawLeavesLess(const CandidateErrors& baseline, const Unexplained& law, const CandidateErrors& adopted, double share) {
  return !law.terms.empty() && excessWithoutContact(baseline) * (1.0 - law.held_out_gain) <
                                   share * excessWithoutContact(adopted);
}

bool leavesMoreThanDetails(const CandidateErrors& baseline, const CandidateErrors& adopted) {
  constexpr double own_details = 1.0 / 3.0;
  return excessWithoutContact(adopted) > own_details * excessWithoutContact(baseline);
}

void preferLaw(Diagnosis& diagnosis, const Unexplained& law) {
  for (const auto& step : diagnosis.steps) diagnosis.withdrawn.push_back(step.added);
  diagnosis.steps.clear();
  diagnosis.experiments.clear();
  for (auto& candidate : diagnosis.ranking) candidate.experiment.clear();
  diagnosis.rivals.clear();
  diagnosis.unexplained = law;
}

}  // namespace amb_rotor
