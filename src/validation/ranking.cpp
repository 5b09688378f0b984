#include "amb_rotor/validation/ranking.hpp"

#include <algorithm>
#include <cmath>

namespace amb_rotor {
namespace {

/// Candidates whose evidence is this close explain the runs as well.
constexpr double twin_share = 0.03, twin_evidence = 8.0;
/// Share of the validation runs' chi2 that must fall.
constexpr double least_validation_drop = 0.004;
/// What shows in runs to fit mostly (a current limit that one of them reaches): of what those leave above the noise so much must
/// go, the square of which is so much of the noise's, and the runs to validate must agree by this share of theirs.
constexpr double most_of_fit = 2.0 / 3.0, plain_in_fit = 0.02, agreeing_drop = 0.001;
/// Runs to validate that stand at their floor may excite nothing of what is missing (the only chirp of a rotor that turns is one to fit):
/// where those to fit are plainly above it, and an effect leaves next to nothing of that, they need not agree.
constexpr double nearly_all_of_fit = 0.95;
/// Through contact a second effect must take this share: windows there never all come down to the floor, and an effect that is
/// missing takes most of what is above it.
constexpr double least_further_contact_share = 0.4;
/// Offsets in the loop stand for a force where they lie so many deviations from the belief, and the force takes that below this
/// share while the runs to validate stay as near. The four offsets that a rig's runs share lie as far by chance in one of 1400 (chi2).
constexpr double far_offsets = 2.2, near_offsets = 0.7, as_near = 1.002;

/// A constant force and an offset that the controller takes for the position differ by next to nothing but what is believed of
/// the offset: each run's own makes up for the force, and the error stays.
bool sparesOffsets(const CandidateErrors& before, const CandidateErrors& after) {
  return before.offset_deviations > far_offsets && after.offset_deviations >= 0.0 &&
         after.offset_deviations < near_offsets * before.offset_deviations &&
         after.validation_error_free < as_near * before.validation_error_free;
}

/// Deviations of a number of the rig that is at home, and times the error through contact that count as near: windows there come down
/// to somewhat other floors.
constexpr double at_home = 3.0, contact_as_near = 1.01;

bool leavesMoreThan(double share, const CandidateErrors& baseline, const CandidateErrors& adopted) {
  return excessWithoutContact(adopted) > share * excessWithoutContact(baseline);
}

}  // namespace

bool isAsNear(const CandidateErrors& before, const CandidateErrors& after) {
  const auto near = [](double was, double is, double times) { return was < 0.0 || (is >= 0.0 && is < times * was); };
  return near(before.validation_error_free, after.validation_error_free, as_near) &&
         near(before.validation_error_contact, after.validation_error_contact, contact_as_near);
}

bool sparesBelief(const OfBelief& before, const OfBelief& after) {
  return before.deviations > far_by_chance && after.deviations < at_home && isAsNear(before.errors, after.errors);
}

double excessWithoutContact(const CandidateErrors& errors) {
  const double error = errors.validation_error_free;
  return error < 0.0 ? 0.0 : std::max(0.0, error * error - 1.0);
}

bool showsInFitOnly(const CandidateErrors& errors) {
  const auto isAtFloor = [](double error) { return error < 0.0 || error * error - 1.0 < plain_in_fit; };  // below 0: no such runs
  return errors.fit_error * errors.fit_error - 1.0 > plain_in_fit && isAtFloor(errors.validation_error_free) &&
         isAtFloor(errors.validation_error_contact);
}

bool bornOut(const CandidateErrors& before, const CandidateErrors& after, bool first) {
  const auto better = [](double was, double is, double share, double least) {
    if (was < 0.0 || is < 0.0) return false;
    const double drop = was * was - is * is, above = was * was - 1.0;
    return drop > least * was * was && drop > share * above;
  };
  const double fit_excess = before.fit_error * before.fit_error - 1.0;
  const double fit_drop = before.fit_error * before.fit_error - after.fit_error * after.fit_error;
  const double least = fit_excess > plain_in_fit && fit_drop > most_of_fit * fit_excess ? agreeing_drop : least_validation_drop;
  if (sparesOffsets(before, after)) return true;
  if (showsInFitOnly(before) && fit_drop > nearly_all_of_fit * fit_excess && isAsNear(before, after)) return true;
  return better(before.validation_error_free, after.validation_error_free, least_excess_share, least) ||
         better(before.validation_error_contact, after.validation_error_contact,
                first ? least_excess_share : least_further_contact_share, least_validation_drop);
}

void markConfounded(std::vector<Candidate>& ranking) {
  for (auto& one : ranking) {
    one.confounded_with.clear();
    if (!one.excited || one.evidence <= least_evidence || !one.beside.empty()) continue;
    for (const auto& other : ranking)
      if (other.effect != one.effect && other.excited && other.beside.empty() &&
          std::fabs(other.evidence - one.evidence) < std::max(twin_evidence, twin_share * one.evidence))
        one.confounded_with.push_back(other.effect);
  }
}

void order(std::vector<Candidate>& ranking) {
  std::stable_sort(ranking.begin(), ranking.end(), [](const Candidate& a, const Candidate& b) {
    return a.borne_out != b.borne_out ? a.borne_out : a.evidence > b.evidence;
  });
  const auto alone = [](const Candidate& c) { return c.beside.empty(); };
  const auto leader = std::find_if(ranking.begin(), ranking.end(), alone);
  if (leader != ranking.end()) {
    std::rotate(ranking.begin(), leader, leader + 1);
    std::stable_partition(ranking.begin() + 1, ranking.end(), [&](const Candidate& c) { return !alone(c); });
  }
  markConfounded(ranking);
}

void notBorneOut(std::vector<Candidate>& ranking, const std::string& effect) {
  for (auto& c : ranking)
    if (c.effect == effect) c.borne_out = false;
  order(ranking);
}

void standingFirst(Diagnosis& diagnosis) {
  std::vector<Candidate>& ranking = diagnosis.ranking;
  const auto& gone = diagnosis.withdrawn;
  if (ranking.empty() || std::find(gone.begin(), gone.end(), ranking[0].effect) == gone.end()) return;
  auto to = ranking.begin();
  for (const auto& step : diagnosis.steps) {
    const auto own = std::find_if(to, ranking.end(), [&](const Candidate& c) { return c.effect == step.added; });
    if (own == ranking.end()) continue;
    std::rotate(to, own, own + 1);
    ++to;
  }
}

void takeAnew(std::vector<Candidate>& ranking, const Candidate& anew) {
  for (auto& c : ranking)
    if (c.effect == anew.effect) c = anew;
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
  return leavesMoreThan(1.0 / 3.0, baseline, adopted);
}

bool leavesMoreThanATrace(const CandidateErrors& baseline, const CandidateErrors& adopted) { return leavesMoreThan(0.1, baseline, adopted); }

void preferLaw(Diagnosis& diagnosis, const Unexplained& law) {
  for (const auto& step : diagnosis.steps) diagnosis.withdrawn.push_back(step.added);
  diagnosis.steps.clear();
  diagnosis.experiments.clear();
  for (auto& candidate : diagnosis.ranking) candidate.experiment.clear();
  diagnosis.rivals.clear();
  diagnosis.unexplained = law;
}

}  // namespace amb_rotor
