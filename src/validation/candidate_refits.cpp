// Fits through contact that go on from a look at an effect, before everything is fitted together.
#include "candidates.hpp"

namespace amb_rotor {
namespace {

/// Mean square over the noise through contact beyond which windows begin anew, so many times at most.
constexpr double astray = 1.5;
constexpr int fresh_rounds = 2;
/// Iterations through contact alone before everything is fitted together.
constexpr int contact_iterations = 12;

/// On some of the windows, with few unknowns.
const FitEffort contact_effort = {Through::contact, contact_iterations, false, true};

std::vector<LocalState> begunAnew(std::vector<LocalState> local) {
  for (auto& state : local) state = amb_rotor::begunAnew(state);
  return local;
}

}  // namespace

Trial Candidates::approach(const Settings& effects, const Trial& start, const QuadraticPrior& prior) const {
  const Eigen::VectorXd own = start.nuisance();
  Trial near = fit(effects, &own, start.local, contact_effort, &prior);
  // windows whose starts the way here has led astray hold the rest where it is: they begin anew
  for (int round = 0; round < fresh_rounds && near.fit.finite && near.fit.squares > astray * near.fit.count; ++round) {
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

}  // namespace amb_rotor
