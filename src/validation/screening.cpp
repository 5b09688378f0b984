#include "screening.hpp"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <optional>

#include "amb_rotor/validation/ranking.hpp"
#include "foreseen.hpp"

namespace amb_rotor {
namespace {

/// Candidates with less than this share of the leader's evidence are judged through contact on some windows only.
constexpr double rival_share = 0.3;
/// The same where the leader leaves nothing through contact.
constexpr double near_share = 0.9;
constexpr int judged_stride = 4;
/// Iterations by which a look is gone on from before none counts as near.
constexpr int further_iterations = 5;
/// See isInSight().
constexpr double half_way = 0.5, about_as_near = 1.03;
/// Evidence of a look at what all windows tell, over that of another, from which on it is followed first: it takes far longer. A wrong one
/// that is left far from the noise, and led nearer over windows that grow, takes minutes: it comes last.
constexpr double plainly_ahead = 2.0;
/// Shares of a screening at which looks are over, and fits to the end.
constexpr double looked_at = 0.6, fitted = 0.85;

bool holds(const Settings& settings, const std::string& name) {
  return std::any_of(settings.begin(), settings.end(), [&](const EffectSetting& s) { return s.id == name; });
}

/// The evidence that an effect had; 0: it was not looked at.
double evidenceOf(const std::string& name, const std::vector<Trial>& trials) {
  const auto found = std::find_if(trials.begin(), trials.end(), [&](const Trial& t) { return t.effect == name; });
  return found != trials.end() && found->usable() ? found->evidence : 0.0;
}

/// @param reach  share of the leader's evidence from which on a candidate through contact is judged on all windows
void judge(const Candidates& candidates, const Standing& standing, double reach, std::vector<Trial>& trials) {
  const References& references = standing.references;
  double sampled = -1.0;  // of the reference through contact, on the windows of `judged_stride`
  const auto sampledError = [&] {
    if (sampled < 0.0) {
      Trial reference = references.contact;
      sampled = candidates.judge(reference, true, Judging::glance, strideOver(standing.adopted, judged_stride)).validation_error_contact;
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
    t.errors = candidates.judge(t, contact, rival ? Judging::settled : Judging::glance, stride);
    if (contact && stride > 1) scaleToAllWindows(t.errors, standing.errors.validation_error_contact, sampledError());
    // the runs that this candidate was not fitted on count as the reference left them
    const FitResult& other = contact ? references.free.fit : references.contact.fit;
    if (candidates.haveContact() && references.through_contact)
      t.errors.fit_error =
          std::sqrt((t.stride * t.fit.squares + other.squares) / (t.stride * t.fit.count + other.count));
  }
}

/// Of an effect for which no time was left.
Trial notLookedAt(const std::string& name) {
  Trial out;
  out.effect = name;
  out.fit.finite = false;
  out.note = "not looked at: the time limit was reached";
  return out;
}

/// A look without contact, some iterations further: what is far from linear takes little of much at first.
Trial goneOn(const Candidates& candidates, Trial look, const References& references) {
  const Eigen::VectorXd own = look.nuisance();
  Trial more = candidates.fit(look.effects(), &own, look.local, {Through::free, further_iterations});
  if (!more.usable() || more.fit.chi2 >= look.fit.chi2) return look;
  more.evidence = candidates.evidence(more, references.free);
  more.others = std::move(look.others);
  return more;
}

/// What leads is then known when those come that cannot.
void mostPromisedFirst(std::vector<std::string>& names, const References& references) {
  const auto promised = [&](const std::string& name) {
    const auto found = references.promises.find(name);
    return found == references.promises.end() ? 0.0 : found->second.evidence;
  };
  std::stable_sort(names.begin(), names.end(), [&](const auto& a, const auto& b) { return promised(a) > promised(b); });
}

/// Where the reference is plainly off through contact, one short look at each candidate there. Full looks, which take long for
/// the wrong ones, end with the one that leaves nothing: `names` then come in the order in which that is likely.
std::vector<Trial> glimpses(const Candidates& candidates, std::vector<std::string>& names, const Standing& standing,
                            const Leaders& leaders) {
  const References& references = standing.references;
  std::vector<Trial> out;
  if (!candidates.haveContact() || names.size() < 2 || leaders.waits(references) || leaders.settles(references) ||
      !plainlyOffThroughContact(references) || references.sparse.stride == 1)  // beside a ring no look is short
    return out;
  Leaders settled = leaders, so_far = leaders;
  settled.through_contact = true;
  out.resize(names.size());
  // where each stands at the best of its starts, before any is fitted
  std::vector<Trial> stand(names.size());
  tbb::parallel_for(std::size_t{0}, names.size(), [&](std::size_t i) {
    stand[i] = candidates.limit().isUp() ? notLookedAt(names[i]) : candidates.bestStanding(names[i], standing.adopted, references);
  });
  const auto level = [&](std::size_t i) { return stand[i].usable() ? stand[i].level() / references.contact.level() : 1.0; };
  std::vector<std::size_t> order(names.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) { return level(a) < level(b); });
  const double nearest = stand[order[0]].usable() ? level(order[0]) : 0.0;
  const auto glimpse = [&](std::size_t i) {
    if (candidates.limit().isUp()) {
      out[i] = notLookedAt(names[i]);
    } else if (stand[i].usable() && !isInSight(level(i), nearest, so_far.through_contact)) {
      out[i] = std::move(stand[i]);
      out[i].fit.finite = false;
      out[i].note = comes_not_near;
    } else {
      out[i] = candidates.look(names[i], standing.adopted, references, settled, &stand[i]);
      out[i].start_levels = std::move(stand[i].start_levels);
    }
  };
  glimpse(order[0]);
  so_far.add(out[order[0]], references);
  tbb::parallel_for(std::size_t{1}, order.size(), [&](std::size_t k) { glimpse(order[k]); });
  names = contendersFirst(std::move(names), out);
  return out;
}

/// Which effects that were looked at without contact may be what is off there, the likeliest first: the best, which may show little (a
/// damping that turns with the rotor, where no bearing holds it), and those that have no size at which they do nothing, where the runs
/// speak neither for them nor against them (a current limit that only rubs reach).
std::vector<const Trial*> mayExplainContact(const std::vector<Trial>& trials) {
  const Trial* leader = nullptr;
  std::vector<const Trial*> out;
  for (const Trial& t : trials) {
    if (!t.usable()) continue;
    if (t.evidence > least_evidence) leader = leader == nullptr || t.evidence > leader->evidence ? &t : leader;
    else if (t.evidence > -least_evidence && !isNested(t.effect)) out.push_back(&t);
  }
  std::stable_sort(out.begin(), out.end(), [](const Trial* a, const Trial* b) { return a->evidence > b->evidence; });
  if (leader != nullptr) out.insert(out.begin(), leader);
  return out;
}

}  // namespace

bool isBelieved(const ExplainedContact& explained, double without_contact) {
  return explained.leaves_nothing || without_contact > least_evidence;
}

bool isInSight(double level, double nearest, bool settled) {
  return level <= (settled ? std::max(half_way, about_as_near * nearest) : not_in_sight);
}

void slowLast(std::vector<std::string>& names) {
  std::stable_partition(names.begin(), names.end(), [](const std::string& name) { return !needsContact(name); });
  std::stable_partition(names.begin(), names.end(),
                        [](const std::string& name) { return !effectCatalogue().find(name)->slow_to_predict; });
}

std::vector<std::string> likeliestFirst(std::vector<std::string> names, const std::vector<Trial>& trials) {
  const auto evidence = [&](const std::string& name) { return evidenceOf(name, trials); };
  std::stable_sort(names.begin(), names.end(), [&](const auto& a, const auto& b) { return evidence(a) > evidence(b); });
  slowLast(names);
  return names;
}

std::vector<std::string> contendersFirst(std::vector<std::string> names, const std::vector<Trial>& trials) {
  const auto evidence = [&](const std::string& name) { return evidenceOf(name, trials); };
  double best = 0.0;
  for (const Trial& t : trials)
    if (t.usable()) best = std::max(best, t.evidence);
  const auto others = std::stable_partition(names.begin(), names.end(),
                                            [&](const std::string& name) { return evidence(name) >= rival_share * best; });
  const auto more = [&](const std::string& a, const std::string& b) { return evidence(a) > evidence(b); };
  std::stable_sort(others, names.end(), more);
  const auto slow = std::stable_partition(names.begin(), others, [](const std::string& name) {
    const EffectSchema& schema = *effectCatalogue().find(name);
    return !schema.slow_to_predict && !schema.lasting;  // all windows at every look
  });
  const auto weighed = [&](const std::string& name) {
    if (!effectCatalogue().find(name)->lasting) return evidence(name);
    const bool far = std::any_of(trials.begin(), trials.end(), [&](const Trial& t) { return t.effect == name && isAstray(t); });
    return far ? 0.0 : evidence(name) / plainly_ahead;
  };
  std::stable_sort(slow, others, [&](const std::string& a, const std::string& b) { return weighed(a) > weighed(b); });
  return names;
}

Screening screen(Candidates& candidates, const std::vector<std::string>& names, const Standing& standing,
                 bool contact_may_wait, const std::function<void(double, const std::string&)>& progress) {
  References& references = standing.references;
  Screening out;
  std::vector<Trial>& trials = out.trials;
  Leaders leaders;
  leaders.contact_waits = contact_may_wait;
  leaders.only_serious = standing.ranked;
  std::vector<std::string> free, contact;
  for (const std::string& name : names) {
    if (holds(standing.adopted, name) || holds(candidates.belief().effects, name)) continue;
    (needsContact(name) ? contact : free).push_back(name);
  }
  foresee(candidates, free, standing.adopted, references);
  mostPromisedFirst(free, references);
  const double each = looked_at / std::max<std::size_t>(1, free.size() + contact.size());
  const auto look = [&](const std::string& name, const Leaders& at, const Trial* seen) {
    if (candidates.limit().isUp()) return seen != nullptr ? *seen : notLookedAt(name);
    progress(each * trials.size(), name);
    return candidates.look(name, standing.adopted, references, at, seen);
  };
  for (const std::string& name : free) {
    trials.push_back(look(name, leaders, nullptr));
    leaders.add(trials.back(), references);
  }
  if (standing.stand_in && leaders.noneNear(references)) {  // fits of wrong ones beside wrong ones take the longest
    // the best, and the one of which most is foreseen: what is far from linear has hardly begun
    const std::string most_promised = trials.empty() ? "" : trials[0].effect;
    std::stable_sort(trials.begin(), trials.end(), [](const Trial& a, const Trial& b) { return a.evidence > b.evidence; });
    for (std::size_t i = 0; i < trials.size() && leaders.noneNear(references); ++i) {
      if (!trials[i].usable() || (i > 0 && trials[i].effect != most_promised)) continue;
      leaders.add(trials[i] = goneOn(candidates, std::move(trials[i]), references), references);
    }
    out.none_near = leaders.noneNear(references);
    if (out.none_near) return out;
  }
  if (!contact.empty() && !references.through_contact && !leaders.waits(references)) candidates.referThroughContact(references);
  std::optional<ExplainedContact> explained;
  if (candidates.haveContact() && !contact.empty() && contact_may_wait && !leaders.waits(references) && plainlyOffThroughContact(references))
    for (const Trial* trial : mayExplainContact(trials)) {
      explained = candidates.explainsContact(*trial, references, trial->evidence > least_evidence);
      if (explained && !isBelieved(*explained, trial->evidence)) explained.reset();
      if (!explained) continue;
      leaders.explains_contact = true;
      out.explains_contact = trial->effect;
      break;
    }
  progress(each * trials.size(), "a glance at each through contact");
  std::vector<Trial> glimpsed = glimpses(candidates, contact, standing, leaders);
  const bool windows_grow = references.through_contact && !leaders.settles(references) && isAstray(references.sparse);
  if (contact.size() > 1 && windows_grow && !(references.short_level > 0.0) && !candidates.limit().isUp())
    candidates.referOverShortWindows(references);
  for (const std::string& name : contact) {
    const auto found = std::find_if(glimpsed.begin(), glimpsed.end(), [&](const Trial& t) { return t.effect == name; });
    const Trial* seen = found == glimpsed.end() ? nullptr : &*found;
    trials.push_back(seen != nullptr && leaders.settles(references) ? *seen : look(name, leaders, seen));
    leaders.add(trials.back(), references);
  }
  out.contact_waited = candidates.haveContact() && leaders.waits(references);
  candidates.finish(trials, references, leaders, [&](const std::string& name) { progress(looked_at, name + ", to the end"); });
  if (explained) {
    for (Trial& t : trials)
      if (t.effect == out.explains_contact && t.usable()) t.evidence += explained->evidence;
    std::stable_sort(trials.begin(), trials.end(), [](const Trial& a, const Trial& b) { return a.evidence > b.evidence; });
  }
  progress(fitted, "judging on the runs to validate");
  judge(candidates, standing, leaders.through_contact ? near_share : rival_share, trials);
  return out;
}

}  // namespace amb_rotor
