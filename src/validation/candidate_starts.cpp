// Which of an effect's starts a look follows: without contact by what is foreseen of them, through contact by how they stand there.
#include <tbb/parallel_for.h>

#include <algorithm>
#include <numeric>

#include "amb_rotor/effects/catalogue.hpp"
#include "amb_rotor/validation/ranking.hpp"
#include "amb_rotor/validation/starts.hpp"
#include "candidates.hpp"
#include "foreseen.hpp"
#include "seen_shapes.hpp"

namespace amb_rotor {
namespace {

/// A start whose gain is foreseen at so many times less than what would bring it near the leader is not taken seriously:
/// one look, and no steps to come near.
constexpr double foreseen_short = 3.0;
/// Mean square over the noise below which little is off without contact.
constexpr double at_noise = 1.03;
/// Of the hills of a scan so many are followed.
constexpr std::size_t followed_hills = 4;
/// Of so many starts that stand best at some windows an effect which asks for all windows goes on.
constexpr std::size_t told_by_all = 3;
/// Without contact one start is enough where its gain is so many times the next one's.
constexpr double clearly_better = 2.0;
/// Times what the reference leaves beyond which the best start of an effect is not followed where the reference is next to the floor.
constexpr double from_afar = 2.0;

/// Whether a nuisance lies so far below its belief that it may stand in for an effect.
bool isTakenForLess(const FitSpace& space, const Eigen::VectorXd& x, int nuisance) {
  if (nuisance < 0) return false;
  const Coordinate& c = space.coordinates()[nuisance];
  return x[nuisance] < c.prior_mean - far_by_chance * c.prior_std;
}

}  // namespace

Candidates::Starts Candidates::startsOf(const std::string& effect, const Settings& adopted, const Trial& reference,
                                        std::string& note) const {
  SeenContact seen;
  if (needsContact(effect)) {
    const auto bearing = reference.space->model(reference.fit.x).rig.auxiliary_bearing;
    seen = {bearing.stiffness_N_per_m, bearing.friction_coefficient};
  }
  Starts out;
  for (const auto& values : startingValues(effect, belief_, recordings_, note, seen)) {
    out.settings.push_back(adopted);
    out.settings.back().push_back({effect, values});
  }
  // from the refitted nuisance, and from the belief where a wrong model has pulled it far away, or just what stands in for the effect
  out.nuisances = {reference.nuisance()};
  Eigen::VectorXd back = out.nuisances[0];
  const bool far = returnToBelief(*reference.space, back);
  const std::string& mimic = effectCatalogue().find(effect)->mimic;
  const int stand_in = reference.space->nuisanceNamed(mimic);
  if (isSizedByWhatStoodIn(effect) ? isTakenForLess(*reference.space, reference.fit.x, stand_in) : !mimic.empty()) {
    if (stand_in >= 0) back[stand_in] = reference.space->coordinates()[stand_in].prior_mean;
    if (needsContact(effect)) out.nuisances.clear();
    out.nuisances.push_back(back);
  } else if (far) {
    out.nuisances.push_back(reference.space->start().head(reference.space->nuisances()));
  }
  return out;
}

std::vector<Candidates::Start> Candidates::promisingFree(std::vector<Settings>& starts,
                                                         const std::vector<Eigen::VectorXd>& nuisances,
                                                         const References& references, const Leaders& leaders,
                                                         bool& serious) const {
  std::vector<std::size_t> order(starts.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::size_t followed = starts.size();
  const bool mimicked = !effectCatalogue().find(starts[0].back().id)->mimic.empty() && nuisances.size() > 1;
  Settings at_belief = starts[0];
  const auto known = references.promises.find(starts[0].back().id);
  const bool promised = known != references.promises.end();
  // at the noise the first order tells, and what cannot be worth its place there is asked for its rank only
  const bool little_off = references.free.fit.squares < at_noise * references.free.fit.count;
  const double asked = std::max(in_reach * leaders.free_drop, little_off ? least_evidence : 0.0);
  const auto mayComeNear = [&](double foreseen) { return foreseen_short * foreseen > asked; };
  if (starts.size() == 1 && promised && isToldByPromise(starts[0].back().id)) serious = mayComeNear(known->second.evidence);
  if (starts.size() > 1) {
    const bool same = promised && nuisances[0] == references.free.nuisance() && known->second.gains.size() == starts.size();
    const auto gains = same ? known->second.gains : gainsOf(belief_, starts, nuisances[0], references);
    if (startsAreAScan(starts[0].back().id)) {  // the tops of its hills
      order.clear();
      for (std::size_t i = 0; i < gains.size(); ++i)
        if ((i == 0 || gains[i].gain >= gains[i - 1].gain) && (i + 1 == gains.size() || gains[i].gain > gains[i + 1].gain))
          order.push_back(i);
      std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) { return gains[a].gain > gains[b].gain; });
      followed = std::min(order.size(), followed_hills);
    } else {
      std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) { return gains[a].gain > gains[b].gain; });
      if (hasShapes(starts[0].back().id)) {  // of each frequency the better shape: two of one hill would leave the others out
        std::vector<std::size_t> different;
        for (const std::size_t i : order)
          if (std::none_of(different.begin(), different.end(), [&](std::size_t d) { return starts[d].back().values[0] == starts[i].back().values[0]; }))
            different.push_back(i);
        order = std::move(different);
      }
      followed = order.size() < 2 || gains[order[0]].gain > clearly_better * gains[order[1]].gain ? 1 : std::min(order.size(), followed_starts);
    }
    double foreseen = gains[order[0]].gain;  // 0: at a start of no size nothing is foreseen
    if (mimicked) {  // where what stands in for the effect is as believed, another size of it does best
      const bool sized = isSizedByWhatStoodIn(starts[0].back().id);
      std::vector<Settings> there = starts;
      const double stood_kg = references.free.space->model(references.free.fit.x).rig.rotor.mass_kg;
      for (std::size_t i = 0; sized && i < there.size(); ++i) sizeByWhatStoodIn(there[i].back(), belief_.rig.rotor.mass_kg, stood_kg);
      const auto others = gainsOf(belief_, there, nuisances[1], references);
      const auto best = std::max_element(others.begin(), others.end(), [](const StartGain& a, const StartGain& b) { return a.gain < b.gain; });
      foreseen = std::max(foreseen, best->gain);
      at_belief = there[best - others.begin()];
      if (!sized) scaleStart(at_belief.back(), best->share);
    }
    serious = !(foreseen > 0.0) || mayComeNear(foreseen);
    if (!serious && leaders.only_serious) return {};
    if (!serious) followed = 1;
    for (std::size_t i = 0; i < starts.size(); ++i)
      if (gains[i].gain > 0.0 || !isNested(starts[i].back().id)) scaleStart(starts[i].back(), gains[i].share);
  }
  starts.push_back(std::move(at_belief));
  std::vector<Start> out;
  for (std::size_t i = 0; i < followed; ++i) out.emplace_back(&starts[order[i]], &nuisances[0]);
  // behind a leader that leaves nothing the rank is all that is asked
  if (leaders.free_settled && !mimicked && !leaders.mayLead(starts[0].back().id, references)) return out;
  for (std::size_t n = 1; n < nuisances.size(); ++n) out.emplace_back(mimicked ? &starts.back() : &starts[order[0]], &nuisances[n]);
  return out;
}

std::vector<Trial> Candidates::standing(const std::vector<Start>& these, const References& references, bool every_effect) const {
  std::vector<Trial> out(these.size());
  tbb::parallel_for(std::size_t{0}, these.size(), [&](std::size_t i) {
    FitEffort effort = {Through::contact, 0, false, true, start_stride};
    effort.every_effect = every_effect;
    out[i] = fit(*these[i].first, these[i].second, references.contact.local, effort, &references.prior);
  });
  return out;
}

Trial Candidates::bestStanding(const std::string& effect, const Settings& adopted, const References& references) const {
  Trial best;
  best.fit.finite = false;
  if (isNested(effect)) return best;
  const Starts all = startsOf(effect, adopted, references.contact, best.note);
  std::vector<Start> these;
  for (const auto& start : all.settings) these.emplace_back(&start, &all.nuisances[0]);
  std::vector<double> levels;
  for (Trial& one : standing(these, references, references.sparse.stride > 1)) {
    levels.push_back(one.level());
    if (one.usable() && (!best.usable() || one.level() < best.level())) best = std::move(one);
  }
  best.start_levels = std::move(levels);
  best.stands = true;
  return best;
}

std::vector<Candidates::Start> Candidates::promisingThroughContact(const std::vector<Settings>& starts,
                                                                   const std::vector<Eigen::VectorXd>& nuisances,
                                                                   const References& references, const Leaders& leaders,
                                                                   const std::vector<double>& levels) const {
  if (starts.size() * nuisances.size() <= followed_starts) {
    std::vector<Start> all;
    for (const auto& nuisance : nuisances)
      for (const auto& start : starts) all.emplace_back(&start, &nuisance);
    return all;
  }
  const bool settled = leaders.settles(references), near_floor = !plainlyOffThroughContact(references);
  // where each start stands by itself says which are worth a fit
  using Seen = std::pair<double, Start>;
  const auto glance = [&](const std::vector<Start>& these, std::vector<Seen>& seen) {
    const std::vector<Trial> trials = standing(these, references, (settled || near_floor) && references.sparse.stride > 1);
    for (std::size_t i = 0; i < these.size(); ++i) seen.emplace_back(trials[i].level(), these[i]);
    std::stable_sort(seen.begin(), seen.end(), [](const Seen& a, const Seen& b) { return a.first < b.first; });
  };
  std::vector<Seen> seen;
  std::vector<Start> these;
  for (const auto& start : starts) these.emplace_back(&start, &nuisances[0]);
  if (levels.size() == starts.size()) {
    for (std::size_t i = 0; i < starts.size(); ++i) seen.emplace_back(levels[i], these[i]);
    std::stable_sort(seen.begin(), seen.end(), [](const Seen& a, const Seen& b) { return a.first < b.first; });
    if (strideOver(starts[0], start_stride) == 1) {  // these are of some windows, where all tell more
      these.clear();
      for (std::size_t i = 0; i < std::min(seen.size(), told_by_all); ++i) these.push_back(seen[i].second);
      seen.clear();
    }
  }
  if (seen.empty()) glance(these, seen);
  const double above = seen[0].first / references.contact.level();
  if ((near_floor && above > from_afar) || (settled && above > not_in_sight)) return {};
  if (settled) return {seen[0].second};
  if (seen.size() > followed_starts) seen.resize(followed_starts);
  these.clear();
  for (const Seen& one : seen)
    for (std::size_t n = 1; n < nuisances.size(); ++n) these.emplace_back(one.second.first, &nuisances[n]);
  glance(these, seen);
  std::vector<Start> out;  // each start once, with the nuisance that suits it
  for (const Seen& one : seen)
    if (std::none_of(out.begin(), out.end(), [&](const Start& s) { return s.first == one.second.first; })) out.push_back(one.second);
  for (const Seen& one : seen)  // and the best with another nuisance: what a glance says of that is little
    if (one.second.first == out[0].first && one.second.second != out[0].second) {
      out.push_back(one.second);
      break;
    }
  return out;
}

}  // namespace amb_rotor
