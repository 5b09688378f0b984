#include "screening.hpp"

#include <algorithm>
#include <cmath>
#include <map>

#include "amb_rotor/validation/ranking.hpp"

namespace amb_rotor {
namespace {

/// Candidates with less than this share of the leader's evidence are judged through contact on some windows only.
constexpr double rival_share = 0.3;
/// The same where the leader leaves nothing through contact.
constexpr double near_share = 0.9;
constexpr int judged_stride = 4;
/// Shares of a screening at which looks are over, and fits to the end.
constexpr double looked_at = 0.6, fitted = 0.85;

bool holds(const Settings& settings, const std::string& name) {
  return std::any_of(settings.begin(), settings.end(), [&](const EffectSetting& s) { return s.id == name; });
}

/// @param reach  share of the leader's evidence from which on a candidate through contact is judged on all windows
void judge(const Candidates& candidates, const Standing& standing, double reach, std::vector<Trial>& trials) {
  const References& references = standing.references;
  double sampled = -1.0;  // of the reference through contact, on the windows of `judged_stride`
  const auto sampledError = [&] {
    if (sampled < 0.0) {
      Trial reference = references.contact;
      sampled = candidates.judge(reference, true, false, strideOver(standing.adopted, judged_stride)).validation_error_contact;
    }
    return sampled;
  };
  for (auto& t : trials) {
    t.errors = standing.errors;  // what cannot be seen changes nothing
    if (!t.usable()) continue;
    const bool contact = needsContact(t.effect);
    if (contact && t.evidence < least_evidence) continue;  // its windows would cost much and change no verdict
    const bool rival = t.evidence > reach * trials[0].evidence;
    const int stride = rival ? 1 : strideOver(t.space->fitted(), judged_stride);
    t.errors = candidates.judge(t, contact, false, stride);
    if (contact && stride > 1) scaleToAllWindows(t.errors, standing.errors.validation_error_contact, sampledError());
    // the runs that this candidate was not fitted on count as the reference left them
    const FitResult& other = contact ? references.free.fit : references.contact.fit;
    if (candidates.haveContact())
      t.errors.fit_error =
          std::sqrt((t.stride * t.fit.squares + other.squares) / (t.stride * t.fit.count + other.count));
  }
}

}  // namespace

void slowLast(std::vector<std::string>& names) {
  std::stable_partition(names.begin(), names.end(), [](const std::string& name) { return !needsContact(name); });
  std::stable_partition(names.begin(), names.end(),
                        [](const std::string& name) { return !effectCatalogue().find(name)->slow_to_predict; });
}

std::vector<std::string> likeliestFirst(std::vector<std::string> names, const std::vector<Trial>& trials) {
  std::map<std::string, double> evidence;
  for (const Trial& t : trials)
    if (t.usable()) evidence[t.effect] = t.evidence;
  const auto of = [&](const std::string& name) {
    const auto found = evidence.find(name);
    return found == evidence.end() ? 0.0 : found->second;
  };
  std::stable_sort(names.begin(), names.end(), [&](const auto& a, const auto& b) { return of(a) > of(b); });
  slowLast(names);
  return names;
}

Screening screen(const Candidates& candidates, const std::vector<std::string>& names, const Standing& standing,
                 bool contact_may_wait, const std::function<void(double, const std::string&)>& progress) {
  const References& references = standing.references;
  Screening out;
  std::vector<Trial>& trials = out.trials;
  Leaders leaders;
  leaders.contact_waits = contact_may_wait;
  leaders.only_serious = standing.ranked;
  std::size_t leader = 0;
  bool asked = !candidates.haveContact() || !contact_may_wait;
  for (std::size_t n = 0; n < names.size(); ++n) {
    progress(looked_at * n / names.size(), names[n]);
    if (holds(standing.adopted, names[n]) || holds(candidates.belief().effects, names[n])) continue;
    if (needsContact(names[n]) && leaders.free_settled && !leaders.waits(references) && !asked) {
      asked = true;
      leaders.explains_contact = candidates.explainsContact(trials[leader], references);
    }
    trials.push_back(candidates.look(names[n], standing.adopted, references, leaders));
    const double before = leaders.free;
    leaders.add(trials.back(), references);
    if (leaders.free > before) leader = trials.size() - 1;
  }
  out.contact_waited = candidates.haveContact() && leaders.waits(references);
  candidates.finish(trials, references, leaders, [&](const std::string& name) { progress(looked_at, name + ", to the end"); });
  progress(fitted, "judging on the runs to validate");
  judge(candidates, standing, leaders.through_contact ? near_share : rival_share, trials);
  return out;
}

}  // namespace amb_rotor
