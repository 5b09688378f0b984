#include "foreseen.hpp"

#include <algorithm>
#include <cmath>

#include "amb_rotor/effects/catalogue.hpp"
#include "amb_rotor/validation/starts.hpp"
#include "amb_rotor/validation/term_search.hpp"
#include "seen_shapes.hpp"

namespace amb_rotor {
namespace {

/// Share of a start at which all candidates are linearised together: near neutral, where none hides another.
constexpr double next_to_neutral = 0.01;
/// Difference of chi2 that moves no promise.
constexpr double next_to_nothing = 1.0;

/// Drop of chi2 by some of the coordinates.
double dropOf(const Eigen::MatrixXd& h, const Eigen::VectorXd& g, const std::vector<int>& chosen) {
  const Eigen::VectorXd step = solveFor(h, g, chosen);
  double drop = 0.0;
  for (std::size_t i = 0; i < chosen.size(); ++i) drop += step[static_cast<long>(i)] * g[chosen[i]];
  return std::isfinite(drop) ? drop : 0.0;
}

bool knowsTheAngle(const std::string& effect) {
  const auto& parameters = effectCatalogue().find(effect)->parameters;
  return std::any_of(parameters.begin(), parameters.end(), [](const ParameterSchema& p) { return p.role == ParameterRole::phase; });
}

bool isSize(const ParameterSchema& p) { return p.role == ParameterRole::plain || p.role == ParameterRole::reciprocal; }

std::vector<std::vector<double>> startsOf(const std::string& effect, const Candidates& candidates) {
  std::string unused;
  return startingValues(effect, candidates.belief(), candidates.recordings(), unused);
}

}  // namespace

EffectSetting nextToNothing(EffectSetting effect) {
  scaleStart(effect, next_to_neutral);
  const auto& parameters = effectCatalogue().find(effect.id)->parameters;
  for (std::size_t i = 0; i < parameters.size(); ++i)
    if (isSize(parameters[i]) && std::isfinite(parameters[i].neutral))
      effect.values[i] = parameters[i].neutral + next_to_neutral * (effect.values[i] - parameters[i].neutral);
  return effect;
}

FirstOrder::FirstOrder(const Trial& all, const std::vector<std::string>& effects)
    : h_(all.fit.normal.h), g_(all.fit.normal.g), chi2_(all.fit.normal.chi2), count_(std::max(2.0, all.fit.count)) {
  const FitSpace& space = *all.space;
  for (int k = 0; k < space.size(); ++k) {
    const Coordinate& c = space.coordinates()[k];
    if (c.prior_std > 0.0) {
      const double weight = 1.0 / (c.prior_std * c.prior_std);
      h_(k, k) += weight;
      g_[k] -= weight * (all.fit.x[k] - c.prior_mean);
    }
    const std::string effect = c.name.substr(0, c.name.find('.'));
    const bool asked = k >= space.nuisances() && std::find(effects.begin(), effects.end(), effect) != effects.end();
    (asked ? own_[effect] : base_).push_back(k);
  }
  before_ = dropOf(h_, g_, base_);
}

double FirstOrder::evidence(const std::vector<std::string>& effects) const {
  std::vector<int> chosen = base_;
  for (const auto& effect : effects) {
    const std::vector<int>& own = own_.at(effect);
    chosen.insert(chosen.end(), own.begin(), own.end());
  }
  const double drop = dropOf(h_, g_, chosen) - before_;
  const double level = std::max(1.0, (chi2_ - before_ - drop) / count_);
  return 0.5 * (drop / level - static_cast<double>(chosen.size() - base_.size()) * std::log(count_));
}

Trial allAtOnce(const Candidates& candidates, const Settings& adopted, const References& references, std::vector<std::string>& effects) {
  Settings all = adopted;
  std::vector<std::string> linear;
  for (const std::string& effect : effects) {
    if (!isNested(effect) || needsContact(effect)) continue;
    const auto values = startsOf(effect, candidates);
    if (values.empty()) continue;
    all.push_back(nextToNothing({effect, values[0]}));
    linear.push_back(effect);
  }
  effects = std::move(linear);
  const Eigen::VectorXd nuisance = references.free.nuisance();
  return candidates.fit(all, &nuisance, references.free.local, {Through::free, 0, false, true});
}

std::vector<Model> modelsOf(const Model& belief, const std::vector<Settings>& starts, const Eigen::VectorXd& nuisance) {
  std::vector<Model> models;
  for (const auto& start : starts) {
    const FitSpace space(belief, start);
    Eigen::VectorXd x = space.start();
    x.head(nuisance.size()) = nuisance;
    models.push_back(space.model(x));
  }
  return models;
}

std::vector<StartGain> gainsOf(const Model& belief, const std::vector<Settings>& starts, const Eigen::VectorXd& nuisance,
                               const References& references) {
  const bool phase = knowsTheAngle(starts[0].back().id);
  auto gains = references.screen->gains(modelsOf(belief, starts, nuisance), phase, !phase);
  for (std::size_t i = 0; i < gains.size(); ++i) {  // what a start gains at the size that it can have
    const double usable = usableShare(starts[i].back().id, gains[i].share);
    if (usable == gains[i].share) continue;
    const double part = usable / gains[i].share;
    gains[i] = {gains[i].gain * part * (2.0 - part), usable};
  }
  return gains;
}

namespace {

/// Whether an effect's one number stands in the place of one of the rig, and is that.
bool standsAtBelief(const EffectSetting& effect, const Model& belief) {
  const auto& parameters = effectCatalogue().find(effect.id)->parameters;
  if (parameters.size() != 1) return false;
  bool same = false;
  Rig<double>::visit(belief.rig, [&](const char* name, const double& value) {
    if (parameters[0].replaces == name) same = effect.values[0] == value;
  });
  return same;
}

/// Whether a number says where along the shaft an effect acts: no value of it makes the effect vanish.
bool isPlace(const ParameterSchema& p) { return p.name == "z_m" || p.name == "plane_z_m"; }

/// Whether an effect does nothing with these values.
bool vanishes(const EffectSetting& effect, const Model& belief) {
  if (standsAtBelief(effect, belief)) return true;
  bool any = false;
  const auto& parameters = effectCatalogue().find(effect.id)->parameters;
  for (std::size_t i = 0; i < parameters.size(); ++i) {
    const ParameterSchema& p = parameters[i];
    if ((!isSize(p) && p.role != ParameterRole::amplitude) || !std::isfinite(p.neutral) || isPlace(p)) continue;
    if (effect.values[i] != p.neutral) return false;
    any = true;
  }
  return any;
}

/// With an effect that acts at a place along the shaft also that effect at either magnetic bearing: where it does nothing it does
/// not show where it would act.
std::vector<Settings> alongTheShaft(const Model& belief, const Settings& start) {
  std::vector<Settings> out = {start};
  const auto& parameters = effectCatalogue().find(start.back().id)->parameters;
  const auto found = std::find_if(parameters.begin(), parameters.end(), isPlace);
  const long place = found == parameters.end() ? -1 : found - parameters.begin();
  for (const double z : belief.rig.planes.amb)
    if (place >= 0) {
      out.push_back(start);
      out.back().back().values[place] = z;
    }
  return out;
}

/// The model as it stands with an effect that does nothing there, each of its numbers moved by a little.
std::vector<Model> movedByLittle(const Model& belief, const Settings& start, const Eigen::VectorXd& nuisance) {
  const FitSpace space(belief, start);
  Eigen::VectorXd x = space.start();
  x.head(nuisance.size()) = nuisance;
  const std::string own = start.back().id + ".";
  std::vector<Model> out;
  for (int k = space.nuisances(); k < space.size(); ++k) {
    const Coordinate& c = space.coordinates()[k];
    if (c.name.rfind(own, 0) != 0) continue;
    Eigen::VectorXd moved = x;
    const double step = step_without_contact * c.scale;
    moved[k] += x[k] + step <= c.upper ? step : -step;
    out.push_back(space.model(moved));
  }
  return out;
}

}  // namespace

void foresee(const Candidates& candidates, const std::vector<std::string>& names, const Settings& adopted, References& references) {
  const Eigen::VectorXd nuisance = references.free.nuisance();
  const double count = std::max(2.0, references.free.fit.count);
  for (const std::string& effect : names) {
    if (needsContact(effect) || references.promises.count(effect) > 0) continue;
    Promise promise;
    double gain = 0.0;
    for (const auto& values : startsOf(effect, candidates)) {
      Settings start = adopted;
      start.push_back({effect, values});
      if (!vanishes(start.back(), candidates.belief())) {
        promise.starts.push_back(std::move(start));
        continue;
      }
      std::vector<Model> moved;
      for (const Settings& at : alongTheShaft(candidates.belief(), start))
        for (Model& model : movedByLittle(candidates.belief(), at, nuisance)) moved.push_back(std::move(model));
      gain = std::max(gain, references.screen->gainTogether(moved, !knowsTheAngle(effect)));
    }
    promise.sized = promise.starts.size();
    addSeenShapes(candidates.belief(), nuisance, references, promise.starts);
    if (!promise.starts.empty()) promise.gains = gainsOf(candidates.belief(), promise.starts, nuisance, references);
    for (const StartGain& one : promise.gains) gain = std::max(gain, one.gain);
    const double parameters = static_cast<double>(effectCatalogue().find(effect)->parameters.size());
    promise.evidence = gain - 0.5 * parameters * std::log(count);
    if (gain > 0.0) references.promises[effect] = std::move(promise);
  }
}

std::map<std::string, Promise> stillPromised(const References& before, const Trial& free) {
  const Settings adopted = free.effects();
  const auto isThere = [](const EffectSetting& one) { return needsContact(one.id); };
  if (!before.free.effects().empty() || !std::all_of(adopted.begin(), adopted.end(), isThere) ||
      std::fabs(free.fit.chi2 - before.free.fit.chi2) > next_to_nothing)
    return {};
  std::map<std::string, Promise> out = before.promises;
  for (auto& one : out)
    for (Settings& start : one.second.starts) start.insert(start.begin(), adopted.begin(), adopted.end());
  return out;
}

bool hasASmallStart(const std::string& effect) { return isNested(effect) && effectCatalogue().find(effect)->mimic.empty(); }

bool isToldByPromise(const std::string& effect) {
  return hasASmallStart(effect) && !effectCatalogue().find(effect)->held_as_offset;
}

}  // namespace amb_rotor
