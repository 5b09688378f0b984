// Numbers that only contact shows, of effects that show without: the shapes of a bending mode at the auxiliary bearings.
//
// A fit to the runs without contact leaves them where it began. One to all runs would go on from there with all unknowns, among windows
// that a wrong shape leads astray, and ends beside the right shapes; so they come first, through contact alone, the rest held by what
// the runs without contact know of it. These know the products of the shapes at the sensors with those at the magnetic bearings, and hardly how
// they are shared; contact does, as it drives the mode by the same shape by which it is met. Two places are tried: where the fit has
// ended, and that of the same products whose shapes lie on one curve along the shaft.
#include <algorithm>

#include "amb_rotor/effects/catalogue.hpp"
#include "seen_shapes.hpp"

namespace amb_rotor {
namespace {

/// Iterations through contact that tell which of the two to follow, and without contact of the one on a curve.
constexpr int contact_glance = 4, iterations_on_curve = 6;
/// Chi2 by which that one may stand above the other without contact: its coordinates are straight nearby only.
constexpr double about_as_good = 35.0;

/// Whether it shows without contact, and some of its numbers do not.
bool holdsContactsNumbers(const EffectSetting& effect) {
  const auto& parameters = effectCatalogue().find(effect.id)->parameters;
  return !needsContact(effect.id) && std::any_of(parameters.begin(), parameters.end(), [](const ParameterSchema& p) { return p.needs_contact; });
}

/// All that a fit to the runs without contact knows.
QuadraticPrior knownTo(const Trial& free) { return {free.fit.normal.h, free.fit.x}; }

}  // namespace

Trial Candidates::withContactsNumbers(const Trial& free) const {
  const Settings effects = free.effects();
  const bool any = std::any_of(effects.begin(), effects.end(), holdsContactsNumbers);
  if (!any || needsContact(effects.back().id) || !haveContact() || !free.fit.finite) return free;
  const Eigen::VectorXd own = free.nuisance();
  const auto glanced = [&](const Trial& from) {
    const Eigen::VectorXd nuisance = from.nuisance();
    const QuadraticPrior prior = knownTo(from);
    return fit(from.effects(), &nuisance, from.local, {Through::contact, contact_glance, false, true}, &prior);
  };
  Trial begin = free, near = glanced(free);
  for (std::size_t i = 0; i < effects.size() && !limit_.isUp(); ++i) {
    if (!hasShapes(effects[i].id)) continue;
    const std::optional<EffectSetting> smooth = smoothMode(belief_, effects[i]);
    if (!smooth) continue;
    Settings other = effects;
    other[i] = *smooth;
    Trial elsewhere = fit(other, &own, free.local, {Through::free, iterations_on_curve});
    if (!elsewhere.fit.finite || elsewhere.fit.chi2 > free.fit.chi2 + about_as_good) continue;
    Trial there = glanced(elsewhere);
    if (!there.fit.finite || (near.fit.finite && near.fit.chi2 <= there.fit.chi2)) continue;
    begin = std::move(elsewhere);
    near = std::move(there);
  }
  Trial out = approach(near.effects(), near, knownTo(begin));
  return out.fit.finite ? out : free;
}

}  // namespace amb_rotor
