// Fits through contact that go on from a look at an effect, before everything is fitted together.
#include <algorithm>
#include <cmath>

#include "amb_rotor/common/linear_algebra.hpp"
#include "amb_rotor/effects/catalogue.hpp"
#include "amb_rotor/machine/machine.hpp"
#include "candidate_hills.hpp"

namespace amb_rotor {
namespace {

/// Mean square over the noise through contact beyond which windows begin anew, so many times at most.
constexpr double astray = 1.5;
constexpr int fresh_rounds = 2;
/// The same for a fit to all runs whose windows begin anew at growing lengths, while each round leads on.
constexpr int settling_rounds = 4;
/// Steps to places where an effect acts alike at the slips of the runs.
constexpr int alike_rounds = 3;
/// Such places at most that widen deviations.
constexpr std::size_t most_alike = 8;
/// Drop of chi2 for which a fit to everything is worth another round.
constexpr double worth_anew = 20.0;
/// Held-out error through contact above which a fit at the noise is none of what is there: starts of windows are fitted.
constexpr double noise_level = 1.0;
/// Such fits along a valley at most, and a difference of chi2 that windows make by the hollows that they end in.
constexpr int valley_rounds = 3;
constexpr double rough = 100.0;
/// Standard deviations in the first step of a walk along a valley, of which each is twice the one before, steps to each side at
/// most, the rise of chi2 at which it ends (windows that end in one hollow or another make 30, a parabola 36 after two steps), and iterations that bring the
/// other unknowns to where they are best there.
constexpr double first_stride = 2.0, end_of_walk = 35.0;
/// Where a walk begins has them, too: the prior holds the rig a little beside where a fit to all runs has it, and windows that are not
/// fitted there stood 12600 of chi2 above all places.
constexpr int steps_of_walk = 6, walking_iterations = 5;
/// Depth of the hollow in which a walk begins from which on deviations are widened by it: finite differences make less.
constexpr double deep = 10.0;
/// Stated deviations so many times too small make the valley flat: the model stands in its middle.
constexpr double flat = 4.0;
/// Correlation of two of an effect's parameters from which on the valley that they lie in may be curved.
constexpr double curved = 0.97;
/// Length of the shortest windows that grow, as a share of the usual one, and iterations of the reference there.
constexpr double shortest_share = 0.25;
constexpr int short_iterations = 3;
/// Share of what the reference leaves above the noise that windows of half the length may leave for a look to go on.
constexpr double led_back = 0.7;
/// Drop of chi2 below which a fit stands where its windows have grown, as a share of it.
constexpr double as_grown = 0.01;
/// Iterations through contact alone before everything is fitted together.
constexpr int contact_iterations = 12;

/// On some of the windows, with few unknowns.
const FitEffort contact_effort = {Through::contact, contact_iterations, false, true};

/// Unknowns of the effect added last of those that only contact shows.
std::vector<int> ownThroughContact(const Trial& trial) {
  std::string effect;
  for (const EffectSetting& one : trial.effects())
    if (needsContact(one.id)) effect = one.id;
  std::vector<int> own;
  for (int k = trial.space->nuisances(); k < trial.space->size(); ++k)
    if (!effect.empty() && trial.space->coordinates()[k].name.rfind(effect + ".", 0) == 0) own.push_back(k);
  return own;
}

/// Largest correlation of two of them.
double closestCorrelation(const Trial& trial) {
  double closest = 0.0;
  const std::vector<int> own = ownThroughContact(trial);
  const Eigen::MatrixXd& c = trial.fit.covariance;
  for (const int i : own)
    for (const int j : own)
      if (i < j) closest = std::max(closest, std::fabs(c(i, j)) / std::sqrt(c(i, i) * c(j, j)));
  return closest;
}

/// One standard deviation of them along the line on which they are known least, the others and the nuisance carried along as
/// they hang on it.
Eigen::VectorXd leastKnown(const Trial& trial) {
  const std::vector<int> own = ownThroughContact(trial);
  if (own.empty()) return Eigen::VectorXd::Zero(trial.space->size());
  const Eigen::MatrixXd block = trial.fit.covariance(own, own);
  const Eigen::VectorXd deviations = block.diagonal().cwiseSqrt();
  if (!(deviations.minCoeff() > 0.0)) return Eigen::VectorXd::Zero(trial.space->size());  // at a limit, or not to be seen
  const Eigen::MatrixXd correlation = deviations.cwiseInverse().asDiagonal() * block * deviations.cwiseInverse().asDiagonal();
  const SymmetricEigen axes = symmetricEigen(correlation);
  const long last = correlation.rows() - 1;
  const Eigen::VectorXd along = std::sqrt(axes.values[last]) * deviations.cwiseProduct(axes.vectors.col(last));
  return trial.fit.covariance(Eigen::all, own) * Ldlt(block).solve(along);
}

bool hasRing(const Model& model) { return Machine<double>({&model}, Spin::prescribed).ringState() >= 0; }

/// The effects with the last of them where it does nothing; empty: there is no such place.
Settings withoutTheLast(Settings effects) {
  if (effects.empty() || !isNested(effects.back().id)) return {};
  const auto& parameters = effectCatalogue().find(effects.back().id)->parameters;
  for (std::size_t i = 0; i < parameters.size(); ++i) effects.back().values[i] = parameters[i].neutral;
  return effects;
}

/// Whether the stator's parts have motions of their own: fits through contact, in small steps, then take minutes.
bool movesByItself(const Model& model) { return hasRing(model) || Machine<double>({&model}, Spin::prescribed).mountState() >= 0; }

}  // namespace

bool isAstray(const Trial& trial) { return trial.fit.squares > astray * trial.fit.count; }

Trial Candidates::approach(const Settings& effects, const Trial& start, const QuadraticPrior& prior) const {
  const Eigen::VectorXd own = start.nuisance();
  Trial near = fit(effects, &own, start.local, contact_effort, &prior);
  if (limit_.isUp()) return near;
  const bool strayed = near.fit.finite && isAstray(near);
  const bool grown = start.grown > 0.0 && near.fit.finite && near.fit.chi2 > (1.0 - as_grown) * start.grown;
  if (strayed && !grown) {
    Trial longer = lengthened(near, contact_effort, &prior);
    if (longer.fit.finite && longer.fit.chi2 < near.fit.chi2) near = std::move(longer);
  }
  // windows whose starts the way here has led astray hold the rest where it is: they begin anew
  for (int round = 0; round < fresh_rounds && !grown && near.fit.finite && isAstray(near); ++round) {
    const Eigen::VectorXd at = near.nuisance();
    Trial more = fit(near.effects(), &at, begunAnew(near.local), contact_effort, &prior);
    if (!more.fit.finite || more.fit.chi2 >= near.fit.chi2) break;
    near = std::move(more);
  }
  const auto tryFrom = [&](const Settings& from, const Eigen::VectorXd& nuisance) {
    Trial more = fit(from, &nuisance, begunAnew(near.local), contact_effort, &prior);
    if (more.fit.finite && more.fit.chi2 < near.fit.chi2) near = std::move(more);
  };
  // a nuisance that an effect half found has pulled far away may hold it there (springs in series: one too soft, the
  // other too stiff): once more from the belief
  Eigen::VectorXd believed = near.nuisance();
  if (returnToBelief(*near.space, believed)) tryFrom(near.effects(), believed);
  // what has run against a limit on the way (a mount's mass, while its stiffness was wrong) is tried from a start again
  Settings away = near.effects();
  const Eigen::VectorXd nuisance = near.nuisance();
  for (EffectSetting& other : awayFromLimits(*near.space, near.fit.x, away.back())) {
    away.back() = std::move(other);
    tryFrom(away, nuisance);
  }
  // and where it acts alike, as far as that leads down
  for (int round = 0; round < alike_rounds && !limit_.isUp(); ++round) {
    const double before = near.fit.chi2;
    Settings elsewhere = near.effects();
    for (EffectSetting& other : actingAlike(elsewhere.back(), belief_, recordings_)) {
      elsewhere.back() = std::move(other);
      tryFrom(elsewhere, nuisance);
    }
    if (!(near.fit.chi2 < before - worth_anew)) break;
  }
  return near;
}

double Candidates::worstThroughContact(const Trial& trial) const {
  const FitProblem problem(recordings_, *trial.space, offset_std_);
  EvaluationOptions as_it_stands;
  as_it_stands.jacobian = false;
  std::vector<LocalState> local = trial.local;
  std::vector<RunResult> runs;
  problem.evaluate(trial.fit.x, fit_contact_, local, as_it_stands, &runs);
  double worst = 0.0;
  for (const RunResult& run : runs) worst = std::max(worst, run.mean_square);
  return worst;
}

Trial Candidates::lengthened(const Trial& from, FitEffort effort, const QuadraticPrior* prior, const Trial* against,
                             const std::function<int(double)>& longer) const {
  Trial at = from;
  double short_level = 0.0;
  for (const double share : {shortest_share, 0.5, 1.0}) {
    // a wrong effect leaves windows of half the length as far off as no effect leaves whole ones
    if (against != nullptr && share == 1.0 && !(at.fit.chi2 - at.fit.count < led_back * (against->fit.chi2 - against->fit.count)))
      return from;
    effort.window_s = share * contact_window_s;
    const Eigen::VectorXd x = at.nuisance();
    at = fit(at.effects(), &x, begunAnew(at.local), effort, prior);
    // windows of the usual length may have led to where shorter ones find no way on
    const Settings anew = share == shortest_share && prior != nullptr && isAstray(at) ? withoutTheLast(from.effects()) : Settings();
    if (!anew.empty() && !limit_.isUp()) {
      Trial other = fit(anew, &x, begunAnew(at.local), effort, prior);
      if (other.fit.finite && !(at.fit.finite && at.fit.chi2 <= other.fit.chi2)) at = std::move(other);
    }
    if (!at.fit.finite) break;
    if (share != shortest_share) continue;
    short_level = at.level();
    if (!longer) continue;
    const int begun = effort.iterations;
    effort.iterations = longer(short_level);
    if (effort.iterations == 0) return from;
    if (effort.iterations <= begun || at.fit.iterations < begun || limit_.isUp()) continue;
    const Eigen::VectorXd own = at.nuisance();  // an iteration over longer windows takes longer
    Trial more = fit(at.effects(), &own, at.local, effort, prior);
    if (more.fit.finite && more.fit.chi2 < at.fit.chi2) at = std::move(more);
  }
  at.grown = at.fit.chi2;
  at.short_level = short_level;
  return at;
}

void Candidates::referOverShortWindows(References& references) const {
  FitEffort effort = {Through::contact, short_iterations, false, true};
  effort.window_s = shortest_share * contact_window_s;
  const Trial& from = references.sparse;
  const Eigen::VectorXd at = from.nuisance();
  const Trial there = fit(from.effects(), &at, begunAnew(from.local), effort, &references.prior);
  if (there.fit.finite) references.short_level = there.level();
}

Trial Candidates::settled(Trial trial, int iterations) const {
  const FitEffort effort = {Through::all, iterations, true};
  const Settings effects = trial.effects();
  const bool touches = std::any_of(effects.begin(), effects.end(), [](const EffectSetting& one) { return needsContact(one.id); });
  for (int round = 0; round < (touches ? settling_rounds : 1) && !limit_.isUp() && trial.fit.finite && worstThroughContact(trial) > astray; ++round) {
    const Eigen::VectorXd at = trial.nuisance();
    Trial more = round == 0 ? fit(trial.effects(), &at, begunAnew(trial.local), effort) : lengthened(trial, effort, nullptr);
    if (!more.fit.finite || more.fit.chi2 > trial.fit.chi2 - worth_anew) break;
    trial = std::move(more);
  }
  return trial;
}

Trial Candidates::followed(Trial trial, const QuadraticPrior& prior, int iterations, double held_out_error) const {
  const Model model = trial.space->model(trial.fit.x);
  const auto liesElsewhere = [&] { return held_out_error > noise_level && worstThroughContact(trial) < astray; };
  if (!haveContact()) return trial;
  // three evaluations, without which a ring is stated too close: also where the time for more is long over; beside a ring a friction is
  // as good at other speeds as without
  if (movesByItself(model)) return hasRing(model) ? widenedAlike(widenedByHollows(std::move(trial), prior), prior) : trial;
  if (limit_.isUp()) return trial;
  const int rounds = closestCorrelation(trial) > curved || liesElsewhere() ? valley_rounds : 0;
  const int size = trial.space->size();
  Eigen::MatrixXd spread = Eigen::MatrixXd::Zero(size, size);
  for (int round = 0; round < rounds && trial.fit.finite && !limit_.isUp(); ++round) {
    const Eigen::VectorXd at = trial.nuisance();
    const Trial here = fit(trial.effects(), &at, trial.local, {Through::contact, walking_iterations}, &prior);
    Trial there = lengthened(here, {Through::contact, contact_iterations, true}, &prior);
    if (!there.fit.finite) break;
    const double drop = here.fit.chi2 - there.fit.chi2;
    if (std::fabs(drop) < rough) {
      const Eigen::VectorXd apart = there.fit.x - here.fit.x;
      spread += apart * apart.transpose();
    }
    if (drop < worth_anew) break;
    const Eigen::VectorXd lower = there.nuisance();
    Trial more = fit(there.effects(), &lower, there.local, {Through::all, iterations, true});
    if (!more.fit.finite || more.fit.chi2 >= trial.fit.chi2) break;
    trial = std::move(more);
  }
  trial.fit.covariance += spread;
  return widenedAlike(walked(std::move(trial), prior, iterations), prior);
}

namespace {

/// A valley bends: no coordinate is known better than it is apart at places of it, from where `trial` stands, over the root of
/// their rise above `here`, from where they were walked to.
void widenTo(const std::vector<Trial>& places, const Trial& here, Trial& trial) {
  for (const Trial& place : places) {
    const double rise = std::max(1.0, place.fit.chi2 - here.fit.chi2);
    for (long k = place.space->nuisances(); k < place.fit.x.size(); ++k) {
      const double apart = place.fit.x[k] - trial.fit.x[k];
      double& variance = trial.fit.covariance(k, k);
      variance = std::max(variance, apart * apart / rise);
    }
  }
}

}  // namespace

Trial Candidates::widenedByHollows(Trial trial, const QuadraticPrior& prior) const {
  const Eigen::VectorXd deviation = leastKnown(trial);
  if (!deviation.allFinite() || !(deviation.norm() > 0.0)) return trial;
  const auto standing = [&](double deviations) {
    Trial at = trial;
    at.fit.x = trial.space->clamped(trial.fit.x + deviations * deviation);
    const Eigen::VectorXd nuisance = at.nuisance();
    FitEffort effort = {Through::contact, 0};
    effort.thorough = true;  // windows that begin wrong are no hollows
    return fit(at.effects(), &nuisance, at.local, effort, &prior);
  };
  const Trial here = standing(0.0);
  double depth = 1e300, mean = 0.0;
  for (const double side : {-first_stride, first_stride}) {
    const Trial there = standing(side);
    if (!here.fit.finite || !there.fit.finite) return trial;
    const Eigen::VectorXd way = there.fit.x - here.fit.x;
    const double off = there.fit.chi2 - here.fit.chi2 - way.dot(Ldlt(here.fit.covariance).solve(way));
    depth = std::min(depth, std::fabs(off));
    mean += 0.5 * off;
  }
  depth = std::min(depth, std::fabs(mean));  // a slope is no hollow
  if (depth > rough) trial.fit.covariance += depth * deviation * deviation.transpose();
  return trial;
}

Trial Candidates::widenedAlike(Trial trial, const QuadraticPrior& prior) const {
  const Settings found = trial.effects();
  const auto falling = std::find_if(found.begin(), found.end(),
                                    [&](const EffectSetting& one) { return !actingAlike(one, belief_, recordings_).empty(); });
  if (falling == found.end()) return trial;
  const std::size_t place_of = static_cast<std::size_t>(falling - found.begin());
  const auto fitFrom = [&](const Settings& effects, const Trial& at, int iterations) {
    const Eigen::VectorXd nuisance = at.nuisance();
    return fit(effects, &nuisance, at.local, {Through::contact, iterations}, &prior);
  };
  const Trial here = fitFrom(found, trial, walking_iterations);
  std::vector<Trial> places = {here};
  for (std::size_t from = 0; from < places.size() && places.size() < most_alike && !limit_.isUp(); ++from)
    for (EffectSetting& other : actingAlike(places[from].effects()[place_of], belief_, recordings_)) {
      const auto isThere = [&](const Trial& place) { return actsInOnePlace(place.effects()[place_of], other); };
      if (std::any_of(places.begin(), places.end(), isThere)) continue;
      Settings elsewhere = places[from].effects();
      elsewhere[place_of] = std::move(other);
      Trial place = fitFrom(elsewhere, places[from], walking_iterations);
      if (place.fit.finite && place.fit.chi2 - here.fit.chi2 < end_of_walk) places.push_back(std::move(place));
    }
  widenTo(places, here, trial);
  return trial;
}

Trial Candidates::walked(Trial trial, const QuadraticPrior& prior, int iterations) const {
  for (int round = 0; round < valley_rounds && trial.fit.finite && !limit_.isUp(); ++round) {
    const Eigen::VectorXd deviation = leastKnown(trial);
    if (!deviation.allFinite() || !(deviation.norm() > 0.0)) break;
    FitEffort effort = {Through::contact, 0};
    for (const int k : ownThroughContact(trial)) {
      const auto share = [&](int i) { return std::fabs(deviation[i]) / trial.space->coordinates()[i].scale; };
      if (effort.held < 0 || share(k) > share(effort.held)) effort.held = k;
    }
    const auto fitFrom = [&](Trial at) {
      const Eigen::VectorXd nuisance = at.nuisance();
      return fit(at.effects(), &nuisance, at.local, effort, &prior);
    };
    effort.iterations = walking_iterations;
    const Trial here = fitFrom(trial);
    std::vector<Trial> places = {here};  // that the runs hardly tell from here, in their order along the valley
    double hollow = end_of_walk;  // how much steeper than the parabola the ways out of here begin, as far as that is followed
    for (const double side : {-first_stride, first_stride}) {
      std::reverse(places.begin(), places.end());
      Eigen::VectorXd stride = side * deviation;
      for (int step = 0; step < steps_of_walk; ++step) {
        Trial next = places.back();
        const Eigen::VectorXd from = next.fit.x;
        next.fit.x = trial.space->clamped(from + stride);
        next = fitFrom(std::move(next));
        const double rise = next.fit.finite ? next.fit.chi2 - here.fit.chi2 : 0.0;
        if (step == 0) hollow = std::min(hollow, rise - first_stride * first_stride);
        if (!next.fit.finite || next.fit.chi2 - here.fit.chi2 > end_of_walk || next.fit.x[effort.held] == from[effort.held]) break;
        stride = 2.0 * (next.fit.x - from);
        places.push_back(std::move(next));
      }
    }
    const auto at = [&](const Trial& place) { return place.fit.x[effort.held]; };
    const auto lowest = std::min_element(places.begin(), places.end(),
                                         [](const Trial& a, const Trial& b) { return a.fit.chi2 < b.fit.chi2; });
    if (lowest->fit.chi2 < here.fit.chi2 - end_of_walk) {
      const Eigen::VectorXd own = lowest->nuisance();
      Trial more = fit(lowest->effects(), &own, lowest->local, {Through::all, iterations, true});
      if (more.fit.finite && more.fit.chi2 < trial.fit.chi2 - worth_anew) {
        trial = std::move(more);
        continue;
      }
    }
    // as far as a place is, over the root of its rise: one standard deviation where the valley is a parabola
    Eigen::VectorXd spread = deviation;
    for (const Trial& place : places) {
      const Eigen::VectorXd apart = (place.fit.x - here.fit.x) / std::sqrt(std::max(1.0, place.fit.chi2 - here.fit.chi2));
      if (std::fabs(apart[effort.held]) > std::fabs(spread[effort.held])) spread = apart;
    }
    if (std::fabs(spread[effort.held]) > flat * std::fabs(deviation[effort.held])) {
      const double middle = 0.5 * (at(places.front()) + at(places.back()));
      const auto nearest = std::min_element(places.begin(), places.end(), [&](const Trial& a, const Trial& b) {
        return std::fabs(at(a) - middle) < std::fabs(at(b) - middle);
      });
      const Eigen::VectorXd own = nearest->nuisance();
      FitEffort everything = {Through::all, iterations, true};
      everything.held = effort.held;
      Trial more = fit(nearest->effects(), &own, nearest->local, everything);
      if (more.fit.finite && more.fit.chi2 < trial.fit.chi2 + end_of_walk) {
        more.fit.covariance.row(effort.held).setZero();  // it stood where it was
        more.fit.covariance.col(effort.held).setZero();
        more.fit.covariance += spread * spread.transpose();
        widenTo(places, here, more);
        return more;
      }
    }
    // the envelope of a rough valley rises by the depth of its hollows where a place is no worse than this
    const double wider = std::sqrt(1.0 + std::max(0.0, hollow));
    if (hollow > deep && wider * std::fabs(deviation[effort.held]) > std::fabs(spread[effort.held])) spread = wider * deviation;
    trial.fit.covariance += spread * spread.transpose() - deviation * deviation.transpose();
    widenTo(places, here, trial);
    break;
  }
  return trial;
}

}  // namespace amb_rotor
