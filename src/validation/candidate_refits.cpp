// Fits through contact that go on from a look at an effect, before everything is fitted together.
#include <algorithm>
#include <cmath>

#include "amb_rotor/common/linear_algebra.hpp"
#include "amb_rotor/machine/machine.hpp"
#include "candidates.hpp"

namespace amb_rotor {
namespace {

/// Mean square over the noise through contact beyond which windows begin anew, so many times at most.
constexpr double astray = 1.5;
constexpr int fresh_rounds = 2;
/// Drop of chi2 for which a fit to everything is worth another round.
constexpr double worth_anew = 20.0;
/// Held-out error through contact above which a fit at the noise is none of what is there: starts of windows are fitted.
constexpr double noise_level = 1.0;
/// Such fits along a valley at most, and a difference of chi2 that windows make by the hollows that they end in.
constexpr int valley_rounds = 3;
constexpr double rough = 100.0;
/// Standard deviations in a step of a walk along a valley, steps to each side at most, the rise of chi2 at which it ends, and
/// iterations that bring the other unknowns to where they are best there.
constexpr double stride_of_walk = 4.0, end_of_walk = 16.0;
constexpr int steps_of_walk = 8, walking_iterations = 3;
/// Correlation of two of an effect's parameters from which on the valley that they lie in may be curved.
constexpr double curved = 0.97;
/// Share of what the reference leaves above the noise that windows of half the length may leave for a look to go on.
constexpr double led_back = 0.7;
/// Drop of chi2 below which a fit stands where its windows have grown, as a share of it.
constexpr double as_grown = 0.01;
/// Iterations through contact alone before everything is fitted together.
constexpr int contact_iterations = 12;

/// On some of the windows, with few unknowns.
const FitEffort contact_effort = {Through::contact, contact_iterations, false, true};

std::vector<LocalState> begunAnew(std::vector<LocalState> local) {
  for (auto& state : local) state = amb_rotor::begunAnew(state);
  return local;
}

/// Largest correlation of two parameters of a fit's last effect.
double closestCorrelation(const Trial& trial) {
  double closest = 0.0;
  const auto own = [&](int k) { return trial.space->coordinates()[k].name.rfind(trial.effect + ".", 0) == 0; };
  const Eigen::MatrixXd& c = trial.fit.covariance;
  for (int i = trial.space->nuisances(); i < trial.space->size(); ++i)
    for (int j = i + 1; j < trial.space->size(); ++j)
      if (own(i) && own(j)) closest = std::max(closest, std::fabs(c(i, j)) / std::sqrt(c(i, i) * c(j, j)));
  return closest;
}

/// One standard deviation of a fit's last effect along the line on which it is known least, the others and the nuisance
/// carried along as they hang on it.
Eigen::VectorXd leastKnown(const Trial& trial) {
  std::vector<int> own;
  for (int k = trial.space->nuisances(); k < trial.space->size(); ++k)
    if (trial.space->coordinates()[k].name.rfind(trial.effect + ".", 0) == 0) own.push_back(k);
  const Eigen::MatrixXd block = trial.fit.covariance(own, own);
  const Eigen::VectorXd deviations = block.diagonal().cwiseSqrt();
  if (!(deviations.minCoeff() > 0.0)) return Eigen::VectorXd::Zero(trial.space->size());  // at a limit, or not to be seen
  const Eigen::MatrixXd correlation = deviations.cwiseInverse().asDiagonal() * block * deviations.cwiseInverse().asDiagonal();
  const SymmetricEigen axes = symmetricEigen(correlation);
  const long last = correlation.rows() - 1;
  const Eigen::VectorXd along = std::sqrt(axes.values[last]) * deviations.cwiseProduct(axes.vectors.col(last));
  return trial.fit.covariance(Eigen::all, own) * Ldlt(block).solve(along);
}

/// Whether the stator's parts have motions of their own: fits through contact, in small steps, then take minutes.
bool movesByItself(const Model& model) {
  const Machine<double> machine({&model}, Spin::prescribed);
  return machine.mountState() >= 0 || machine.ringState() >= 0;
}

}  // namespace

bool isAstray(const Trial& trial) { return trial.fit.squares > astray * trial.fit.count; }

Trial Candidates::approach(const Settings& effects, const Trial& start, const QuadraticPrior& prior) const {
  const Eigen::VectorXd own = start.nuisance();
  Trial near = fit(effects, &own, start.local, contact_effort, &prior);
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
  if (leaveLimits(*near.space, near.fit.x, away.back())) tryFrom(away, near.nuisance());
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

Trial Candidates::lengthened(const Trial& from, FitEffort effort, const QuadraticPrior* prior, const Trial* against) const {
  Trial at = from;
  for (const double share : {0.25, 0.5, 1.0}) {
    // a wrong effect leaves windows of half the length as far off as no effect leaves whole ones
    if (against != nullptr && share == 1.0 && !(at.fit.chi2 - at.fit.count < led_back * (against->fit.chi2 - against->fit.count)))
      return from;
    effort.window_s = share * contact_window_s;
    const Eigen::VectorXd x = at.nuisance();
    at = fit(at.effects(), &x, begunAnew(at.local), effort, prior);
    if (!at.fit.finite) break;
  }
  at.grown = at.fit.chi2;
  return at;
}

Trial Candidates::settled(Trial trial, int iterations) const {
  const FitEffort effort = {Through::all, iterations, true};
  for (int round = 0; round < fresh_rounds && trial.fit.finite && worstThroughContact(trial) > astray; ++round) {
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
  if (!haveContact() || movesByItself(model) || !(closestCorrelation(trial) > curved || liesElsewhere())) return trial;
  const int size = trial.space->size();
  Eigen::MatrixXd spread = Eigen::MatrixXd::Zero(size, size);
  for (int round = 0; round < valley_rounds && trial.fit.finite; ++round) {
    const Eigen::VectorXd at = trial.nuisance();
    const Trial here = fit(trial.effects(), &at, trial.local, {Through::contact, 0}, &prior);
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
  return walked(std::move(trial), prior, iterations);
}

Trial Candidates::walked(Trial trial, const QuadraticPrior& prior, int iterations) const {
  for (int round = 0; round < valley_rounds && trial.fit.finite; ++round) {
    const Eigen::VectorXd deviation = leastKnown(trial);
    if (!deviation.allFinite() || !(deviation.norm() > 0.0)) break;
    FitEffort effort = {Through::contact, 0};
    for (int k = trial.space->nuisances(); k < trial.space->size(); ++k) {
      const auto share = [&](int i) { return std::fabs(deviation[i]) / trial.space->coordinates()[i].scale; };
      if (effort.held < 0 || share(k) > share(effort.held)) effort.held = k;
    }
    const auto fitFrom = [&](Trial at) {
      const Eigen::VectorXd nuisance = at.nuisance();
      return fit(at.effects(), &nuisance, at.local, effort, &prior);
    };
    const Trial here = fitFrom(trial);
    effort.iterations = walking_iterations;
    Trial lowest = here;
    double widest = 1.0;
    for (const double side : {-stride_of_walk, stride_of_walk}) {
      Trial there = here;
      for (int step = 1; step <= steps_of_walk; ++step) {
        there.fit.x = trial.space->clamped(there.fit.x + side * deviation);
        there = fitFrom(std::move(there));
        const double rise = there.fit.chi2 - here.fit.chi2;
        if (!there.fit.finite || rise > end_of_walk) break;
        if (there.fit.chi2 < lowest.fit.chi2) lowest = there;
        widest = std::max(widest, step * stride_of_walk / std::sqrt(std::max(1.0, rise)));
      }
    }
    if (lowest.fit.chi2 < here.fit.chi2 - worth_anew) {
      const Eigen::VectorXd own = lowest.nuisance();
      Trial more = fit(lowest.effects(), &own, lowest.local, {Through::all, iterations, true});
      if (more.fit.finite && more.fit.chi2 < trial.fit.chi2) {
        trial = std::move(more);
        continue;
      }
    }
    trial.fit.covariance += (widest * widest - 1.0) * deviation * deviation.transpose();
    break;
  }
  return trial;
}

}  // namespace amb_rotor
