// When a law of a few terms stands in the place of effects.
#include "amb_rotor/validation/ranking.hpp"
#include "diagnoser.hpp"

namespace amb_rotor {
namespace {

/// Of what the adopted effects leave above the floor a law may leave so much to stand in their place: where they leave
/// structure, and where they leave little.
constexpr double law_share = 0.8, doubtful_law_share = 0.5;
/// Validation error without contact under which nothing is left that a law could name better than the effects adopted.
constexpr double settled_error = 1.02;
/// Share of what is unexplained in the runs to validate that a law of one term must take to end the search at once.
constexpr double plain_gain = 0.95;
/// The same of a line of fixed frequency, of which the rotor's answer to its begin is no part.
constexpr double plain_line = 0.8;
/// Validation error without contact from which on a law is asked for before any effect is adopted, where no effect alone leaves less than
/// this share of what is above the noise.
constexpr double least_error_of_a_law = 1.03, explained_by_one = 0.05;
/// The same from which on one is asked for at the end where no effect has earned its place, and what it must take of what is left: noise
/// that is understated leaves as much, and no law takes that.
constexpr double least_error_left = 1.05, most_of_what_is_left = 0.5;

}  // namespace

UnexplainedSearch Diagnoser::lawsBeside(const Trial& trial) const {
  return {candidates_.recordings(), *trial.space, trial.fit.x, trial.local, candidates_.offsetStd()};
}

Unexplained Diagnoser::lawBesideNone(LawEffort effort) {
  if (!search_) search_ = lawsBeside(first_);
  return search_->law(effort);
}

Unexplained Diagnoser::lawBesideAdopted(LawEffort effort) const {
  progress(0.96, "a law beside what was adopted");
  Unexplained law = lawsBeside(joint_).law(effort);
  if (law.depends_on.empty() && law.shape.empty()) law.shape = "no law of one set of quantities takes what is left; more were not sought";
  return law;
}

/// Whether a plain law beside the belief alone leaves next to nothing: then no second effect is sought beside the first, and
/// where no effect earned its place, none that shows in contact only and no pair. Where an effect promises most of what is left it is
/// sought first.
bool Diagnoser::lawIsPlain(double share) {
  const bool plainly_left = errors_.validation_error_free > structured_error;
  if (!plainly_left && (adopted_.empty() || !leavesMoreThanDetails(begun_, errors_))) return false;
  if (hurried() || (!adopted_.empty() && (needsContact(adopted_.back().id) || oneIsForeseen()))) return false;
  progress(share - 0.02, "a law of a few terms");
  // an effect that leaves over a third of much is hardly all that is there, and a second looked at beside it takes longer than a law
  const bool much_left = adopted_.size() == 1 && leavesMoreThanDetails(begun_, errors_);
  Unexplained law = lawBesideNone(adopted_.empty() || much_left ? LawEffort::plain : LawEffort::foreseen);
  if (law.held_out_gain < (law.terms.empty() ? plain_line : plain_gain)) return false;
  law_ = std::move(law);
  return true;
}

/// Whether a plain law beside the belief alone leaves next to nothing without contact where every effect alone leaves far more there: then
/// none is fitted to contact, in which a law at large would move the rotor far.
bool Diagnoser::lawOutshines(const std::vector<Trial>& trials, double share) {
  if (!adopted_.empty() || hurried() || errors_.validation_error_free < least_error_of_a_law) return false;
  double least = excessWithoutContact(errors_);
  const double share_of_all = explained_by_one * least;
  for (const Trial& trial : trials)
    if (trial.usable() && !needsContact(trial.effect) && trial.errors.validation_error_free >= 0.0)
      least = std::min(least, excessWithoutContact(trial.errors));
  if (least < share_of_all) return false;
  progress(share - 0.02, "a law of a few terms");
  Unexplained law = lawBesideNone(LawEffort::foreseen);
  if (law.terms.empty() || law.held_out_gain < plain_gain) return false;
  if (excessWithoutContact(errors_) * (1.0 - law.held_out_gain) > doubtful_law_share * least) return false;
  law_ = std::move(law);
  return true;
}

/// Whether a law takes most of what is left beside the belief where no effect has earned its place and that is less than structure: numbers of
/// the rig make up for most of a dead zone.
bool Diagnoser::lawIsLeft() {
  if (!adopted_.empty() || law_ || hurried()) return false;
  if (errors_.validation_error_free < least_error_left || errors_.validation_error_free > structured_error) return false;
  progress(0.92, "a law of what is left");
  Unexplained law = lawBesideNone(LawEffort::whole);
  if (law.depends_on.empty() || law.held_out_gain < most_of_what_is_left) return false;
  law_ = std::move(law);
  return true;
}

/// Whether a plain law that is known leaves no more than the pair of effects that was adopted all the same.
bool Diagnoser::lawLeavesAsLittle() const {
  return law_ && law_->held_out_gain >= plain_gain && amb_rotor::lawLeavesLess(begun_, *law_, errors_, 1.0);
}

/// Whether a law of a few terms beside the belief alone leaves less than the effects adopted so far. Where these leave
/// little, it must be far less, and plain: laws of several terms bend, too.
bool Diagnoser::lawLeavesLess() {
  const bool much = errors_.validation_error_free > structured_error;
  if (errors_.validation_error_free < settled_error) return false;
  // the law is sought in runs without contact: it stands for no effect that shows in contact
  for (const auto& effect : adopted_)
    if (needsContact(effect.id)) return false;
  if (!much && clean() && adopted_.size() < 2 && !leavesMoreThanATrace(begun_, errors_)) return false;
  // the last word at a time limit: a stand-in that leaves much would hide what the unexplained depends on
  if (!law_ && hurried() && !(much && leavesMoreThanATrace(begun_, errors_))) return false;
  if (!law_) {
    progress(0.92, "a law in the place of effects");
    // next to the floor only a law that the measured path shows plainly is worth its search; effects that take less than two thirds of
    // little are hardly what is there
    const bool hardly = !clean() && leavesMoreThanDetails(begun_, errors_);
    law_ = lawBesideNone(much || hardly ? LawEffort::whole : clean() ? LawEffort::foreseen : LawEffort::plain);
  }
  return amb_rotor::lawLeavesLess(begun_, *law_, errors_, much ? law_share : doubtful_law_share);
}

/// The belief as it was, with the law beside it.
void Diagnoser::standBy(Diagnosis& out) {
  preferLaw(out, *law_);
  adopted_.clear();
  joint_ = first_;
  joined_ = true;
  errors_ = out.baseline;
}

}  // namespace amb_rotor
