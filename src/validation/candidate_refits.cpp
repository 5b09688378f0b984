// Fits through contact that go on from a look at an effect, before everything is fitted together.
#include <algorithm>
#include <cmath>

#include "amb_rotor/machine/machine.hpp"
#include "candidates.hpp"

namespace amb_rotor {
namespace {

/// Mean square over the noise through contact beyond which windows begin anew, so many times at most.
constexpr double astray = 1.5;
constexpr int fresh_rounds = 2;
/// Drop of chi2 for which a fit to everything is worth another round.
constexpr double worth_anew = 20.0;
/// Such fits along a valley at most, and a difference of chi2 that windows make by the hollows that they end in.
constexpr int valley_rounds = 3;
constexpr double rough = 100.0;
/// Correlation of two of an effect's parameters from which on the valley that they lie in may be curved.
constexpr double curved = 0.97;
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
  if (strayed) {
    Trial longer = lengthened(near, contact_effort, &prior);
    if (longer.fit.finite && longer.fit.chi2 < near.fit.chi2) near = std::move(longer);
  }
  // windows whose starts the way here has led astray hold the rest where it is: they begin anew
  for (int round = 0; round < fresh_rounds && near.fit.finite && isAstray(near); ++round) {
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
  near.strayed = strayed;
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

Trial Candidates::lengthened(const Trial& from, FitEffort effort, const QuadraticPrior* prior) const {
  Trial at = from;
  for (const double share : {0.25, 0.5, 1.0}) {
    effort.window_s = share * contact_window_s;
    const Eigen::VectorXd x = at.nuisance();
    at = fit(at.effects(), &x, begunAnew(at.local), effort, prior);
    if (!at.fit.finite) break;
  }
  return at;
}

Trial Candidates::settled(Trial trial, int iterations) const {
  const FitEffort effort = {Through::all, iterations, true};
  bool strayed = false;
  for (int round = 0; round < fresh_rounds && trial.fit.finite && worstThroughContact(trial) > astray; ++round) {
    const Eigen::VectorXd at = trial.nuisance();
    Trial more = round == 0 ? fit(trial.effects(), &at, begunAnew(trial.local), effort) : lengthened(trial, effort, nullptr);
    strayed = true;
    if (!more.fit.finite || more.fit.chi2 > trial.fit.chi2 - worth_anew) break;
    trial = std::move(more);
  }
  trial.strayed = strayed;
  return trial;
}

Trial Candidates::followed(Trial trial, const QuadraticPrior& prior, int iterations) const {
  const Model model = trial.space->model(trial.fit.x);
  if (!haveContact() || movesByItself(model) || !(trial.strayed || closestCorrelation(trial) > curved)) return trial;
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
  return trial;
}

}  // namespace amb_rotor
