#pragma once
// One diagnosis: what stands, what has been adopted, what is asked next. diagnosis.cpp has its course, diagnoser_adoption.cpp what is
// taken into the model and out of it again, diagnoser_exchange.cpp when one of it gives way to another effect,
// diagnoser_laws.cpp when a law stands in its place.
#include <optional>
#include <string>
#include <vector>

#include "amb_rotor/validation/diagnosis.hpp"
#include "amb_rotor/validation/unexplained.hpp"
#include "candidates.hpp"

namespace amb_rotor {

/// Validation error through contact over which a residual counts as structured.
constexpr double structured_contact_error = 1.6;

class Diagnoser {
 public:
  Diagnoser(const Model& model, const Dataset& dataset, const DiagnosisOptions& options);

  Diagnosis run();

 private:
  void progress(double share, const std::string& what) const {
    if (options_.progress) options_.progress(share, what);
  }
  void referWithoutContact(const Trial& free, const Trial& all);
  void baseline(Diagnosis& out);
  void compareAll(Diagnosis& out) const;
  std::vector<Trial> screen(double from, double to, bool contact_may_wait);
  Candidate valued(const Trial& trial) const;
  void rank(const std::vector<Trial>& trials, Diagnosis& out) const;
  bool earns(const Trial& trial) const;
  bool promises(const Trial& trial) const;
  bool isTold(const Trial& trial) const;
  bool bornOutWithin(const CandidateErrors& before) const;
  Trial jointly(Settings from, Eigen::VectorXd own, const std::vector<LocalState>& local, Through through, int iterations) const;
  Trial ofLikeliestGain(Trial trial, Through through, int iterations) const;
  void join(int iterations);
  void joinLate(Diagnosis& out);
  bool staysAstrayThroughContact(const Trial& adopted) const;
  void adopt(const Settings& effects, const Trial& start, Diagnosis& out);
  void write(Diagnosis& out);
  const Trial* adoptBest(const std::vector<Trial>& trials, double share, Diagnosis& out);
  void refer();
  std::vector<std::string> notAdopted() const;
  std::vector<std::string> foreseeTheRest();
  bool oneIsForeseen();
  bool isMoreForeseen();
  Trial fitWithout(const Settings& rest, Through through) const;
  bool keepsItsPlace(const Settings& others) const;
  bool withdraw(Diagnosis& out);
  /// What an attempt that fails puts back.
  struct Stood {
    Trial joint;
    bool joined;
    CandidateErrors errors;
    Settings adopted;
    decltype(Diagnosis::steps) steps;
    decltype(Diagnosis::withdrawn) withdrawn;
  };
  Stood stood(const Diagnosis& out) const { return {joint_, joined_, errors_, adopted_, out.steps, out.withdrawn}; }
  void putBack(const Stood& before, Diagnosis& out);
  /// An effect looked at beside all adopted ones but one, and the model without either.
  struct Instead {
    Trial trial, without;
    std::size_t place;  ///< of the one left out
  };
  bool leavesNothing() const;
  bool hasRivals(const Diagnosis& so_far) const;
  Instead lookInstead(const Diagnosis& so_far, bool rivals_alone);
  bool exchange(Diagnosis& out);
  std::vector<Settings> pairsInstead(const std::vector<EffectSetting>& away, const std::vector<Trial>& trials, const Trial& alone) const;
  Trial oneBesideOther(const Settings& pair, const std::vector<Trial>& trials, const FitEffort& effort) const;
  bool exchangeForTwo(const std::vector<Trial>& trials, Diagnosis& out);
  void lookAgain(Diagnosis& out) const;
  bool cleanWithoutContact() const;
  bool clean() const;
  bool hurried() const { return candidates_.limit().isUp(); }
  bool throughAll() const { return joined_ && candidates_.haveContact(); }  ///< whether the model is fitted through contact, too
  bool strained() const;
  bool structured() const;
  std::optional<LeftOpen> leftOpen(Through through, double error) const;
  std::optional<LeftOpen> structureLeftOpen() const;
  std::optional<LeftOpen> littleLeftOpen() const;
  std::optional<LeftOpen> moreLeftOpen() const;
  UnexplainedSearch lawsBeside(const Trial& trial) const;
  Unexplained lawBesideNone(LawEffort effort);  ///< beside the belief alone
  Unexplained lawBesideAdopted(LawEffort effort) const;
  bool lawIsPlain(double share);
  bool lawOutshines(const std::vector<Trial>& trials, double share);
  bool lawIsLeft();
  bool lawLeavesAsLittle() const;
  bool lawLeavesLess();
  void standBy(Diagnosis& out);
  bool adoptPair(const std::vector<Trial>& trials, double share, double least, Diagnosis& out);

  Candidates candidates_;
  DiagnosisOptions options_;
  std::vector<std::string> names_;
  Settings adopted_;
  References references_;
  Trial first_;             ///< the belief, as the baseline left it
  CandidateErrors begun_;   ///< its
  References begin_;        ///< its
  std::optional<UnexplainedSearch> search_;  ///< beside it
  std::optional<Unexplained> law_;           ///< what that has found
  Trial joint_;             ///< the model as it stands, fitted to all runs
  bool joined_ = true;      ///< those with contact are among them
  bool referred_ = false;   ///< whether references_ are of that model
  CandidateErrors errors_;  ///< its
  bool contact_waited_ = false;  ///< in the last screening
  std::string explains_contact_;  ///< in the last screening
  bool none_near_ = false;       ///< the same
};

}  // namespace amb_rotor
