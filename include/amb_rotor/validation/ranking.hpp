#pragma once
// What candidates' errors and evidence amount to: a diagnosis's arithmetic, apart from its fits. Errors are rms of residuals
// over the noise (1: the floor), evidence is half the drop of the BIC.
#include <vector>

#include "amb_rotor/validation/diagnosis.hpp"

namespace amb_rotor {

/// Evidence below which an effect does not earn its place, whatever else.
constexpr double least_evidence = 12.0;

/// Error without contact over which a residual counts as structured.
constexpr double structured_error = 1.12;

/// Share of the excess over the floor (1) that an effect must take on the runs to validate.
constexpr double least_excess_share = 0.15;

/// Whether the runs to validate have become better by a share of what is above the floor: a wrong effect that bends a little
/// towards the right one does not do that. Where the runs to fit are plainly above the floor and lose most of that, those to
/// validate need only agree: it may show in them hardly; where the former lose nearly all of it and the latter stand at the floor, it need not.
/// @param first  no effect was adopted before, and this one is not yet refitted with everything: through contact less will do
bool bornOut(const CandidateErrors& before, const CandidateErrors& after, bool first);

/// Whether something is missing in the runs to fit that those to validate do not show: these stand at the floor.
bool showsInFitOnly(const CandidateErrors& errors);

/// Prior standard deviations by which chance hardly takes a nuisance from its belief.
constexpr double far_by_chance = 5.0;

/// A model by its errors and by how far a number of the rig lies from its belief, in the deviations stated of that.
struct OfBelief {
  double deviations;
  const CandidateErrors& errors;
};

/// Whether the runs to validate are left as near by the one as by the other, to what their noise makes of it.
bool isAsNear(const CandidateErrors& before, const CandidateErrors& after);

/// Whether a number of the rig that stands in for an effect where a model lacks it (less friction for one that falls with the slip,
/// where all slips are fast) lies farther from its belief than chance takes it, and comes home with the effect, and the runs to
/// validate are left as near: they show the same of both, and the belief decides.
bool sparesBelief(const OfBelief& before, const OfBelief& after);

/// Squares above the floor on the runs to validate without contact; 0 where there are none.
double excessWithoutContact(const CandidateErrors& errors);

/// Names with each candidate those whose evidence is within 3 % of its own, or 8.
void markConfounded(std::vector<Candidate>& ranking);

/// What the runs to validate bear out first, then by evidence; what was adopted beside others stands behind the first of those
/// that were valued alone. Names twins.
void order(std::vector<Candidate>& ranking);

/// A candidate that the runs to validate did not bear out after all stands behind those that they do.
void notBorneOut(std::vector<Candidate>& ranking, const std::string& effect);

/// Where what led the ranking was taken back, what stands leads, in its steps' order: it is what the diagnosis says.
void standingFirst(Diagnosis& diagnosis);

/// A candidate of the ranking that was valued anew, alone or beside others; order and twins follow.
void takeAnew(std::vector<Candidate>& ranking, const Candidate& anew);

/// An error through contact that was judged on some windows, in proportion to what the reference has on all of them and on
/// the same ones.
void scaleToAllWindows(CandidateErrors& errors, double reference, double reference_sampled);

/// Whether a law of a few terms beside the belief alone leaves less than the effects adopted so far: at most a share of
/// their excess, of which the held-out gain tells how much of the baseline's stays.
bool lawLeavesLess(const CandidateErrors& baseline, const Unexplained& law, const CandidateErrors& adopted, double share);

/// Whether one effect alone leaves more of the baseline's excess than its own details may be, a third: the right one takes nearly
/// all, one that bends towards something else does not.
bool leavesMoreThanDetails(const CandidateErrors& baseline, const CandidateErrors& adopted);

/// Whether effects leave over a tenth of what was above the floor without contact. A right one that shows leaves 0.01 of the noise above
/// the floor; noise in the loop may leave more.
bool leavesMoreThanATrace(const CandidateErrors& baseline, const CandidateErrors& adopted);

/// Effects that have only bent towards a law are taken back, with what was said about them; the law stays.
void preferLaw(Diagnosis& diagnosis, const Unexplained& law);

}  // namespace amb_rotor
