#include "proposals.hpp"

#include <algorithm>
#include <cstdio>

#include "amb_rotor/common/linear_algebra.hpp"
#include "amb_rotor/model/model_rules.hpp"
#include "amb_rotor/validation/experiments.hpp"

namespace amb_rotor {
namespace {

/// Rivals of the chosen effect that are looked at, and experiments kept of a pair.
constexpr std::size_t most_rivals = 4, kept = 3;
/// Expected evidence below which an experiment does not part two models.
constexpr double parting_evidence = 12.0;

const Trial* find(const std::vector<Trial>& trials, const std::string& effect) {
  const auto at =
      std::find_if(trials.begin(), trials.end(), [&](const Trial& t) { return t.effect == effect; });
  return at == trials.end() || !at->usable() ? nullptr : &*at;
}

Rival rivalOf(const Model& belief, const Trial& trial) {
  Rival rival{trial.effect, belief, trial.effects(), trial.fit.x, {}};
  const long n = trial.fit.x.size();
  rival.information = Ldlt(trial.fit.covariance).solveColumns(Eigen::MatrixXd::Identity(n, n));
  if (!rival.information.allFinite()) rival.information = trial.fit.normal.h;
  return rival;
}

std::string sentenceOf(const std::vector<Experiment>& found) {
  const std::string& other = found.front().against;
  char text[96];
  std::snprintf(text, sizeof text, " (%s): the wrong one leaves %.2g times the noise there",
                found.front().name.c_str(), found.front().separation);
  if (found.front().evidence < parting_evidence)
    return "none of the runs tried would part it from " + other + "; the best of them is " +
           found.front().what + text;
  return "from " + other + ": " + found.front().what + text;
}

/// Whether a candidate's model can be run as fitted: a fit holds each parameter to its range, not the rules between them. Else
/// says so.
bool canBeRun(const Trial& trial, Diagnosis& out) {
  const std::vector<Fault> faults = checkModel(trial.space->model(trial.fit.x), effectCatalogue());
  if (faults.empty()) return true;
  out.remarks.push_back("no run is proposed to part " + trial.effect +
                        " from others: its model as fitted breaks a rule of models: " + faults[0].text());
  return false;
}

}  // namespace

void proposeExperiments(const Candidates& candidates, const std::vector<Trial>& trials,
                        const std::string& chosen, Diagnosis& out) {
  const auto leader = std::find_if(out.ranking.begin(), out.ranking.end(),
                                   [&](const Candidate& c) { return c.effect == chosen; });
  const Trial* own = find(trials, chosen);
  if (leader == out.ranking.end() || leader->confounded_with.empty() || own == nullptr || !canBeRun(*own, out)) return;
  std::size_t rivals = 0;
  for (const std::string& name : leader->confounded_with) {
    const Trial* other = find(trials, name);
    if (other == nullptr || rivals == most_rivals || !canBeRun(*other, out)) continue;
    ++rivals;
    std::vector<Experiment> found =
        rankExperiments(rivalOf(candidates.belief(), *own), rivalOf(candidates.belief(), *other),
                        candidates.recordings(), candidates.offsetStd());
    if (found.empty()) continue;
    if (found.size() > kept) found.resize(kept);
    leader->experiment += (leader->experiment.empty() ? "" : "; ") + sentenceOf(found);
    std::vector<Experiment> turned = found;
    for (auto& e : turned) std::swap(e.effect, e.against);
    for (auto& c : out.ranking)
      if (c.effect == name) c.experiment = sentenceOf(turned);
    for (const Trial* t : {own, other}) out.rivals.emplace(t->effect, t->space->model(t->fit.x));
    out.experiments.insert(out.experiments.end(), found.begin(), found.end());
  }
}

}  // namespace amb_rotor
