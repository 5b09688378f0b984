#pragma once
// What effects promise beside a model as it stands, to first order and without contact. Of an effect that vanishes: what its numbers
// gain together, each moved by a little. Of another: what its best start gains at the size at which it does best
// (amb_rotor/validation/start_screen.hpp). Of several effects at once: one evaluation of all; with h and g of the fit there and S
// the coordinates of the nuisance, of what is adopted and of the effects asked for, chi2 falls by g_S' h_S^-1 g_S.
//
// Left out: what grows faster than an effect's size. A promise says where a fit is worth its time, not what it will find.
#include <map>
#include <string>
#include <vector>

#include "candidates.hpp"

namespace amb_rotor {

/// Out of one evaluation of a model with all of some effects in it, each next to nothing.
class FirstOrder {
 public:
  /// @param all  the evaluation; `effects`: those that are asked for, all else counts as the model as it stands
  FirstOrder(const Trial& all, const std::vector<std::string>& effects);

  /// Half the drop of the BIC by these together.
  double evidence(const std::vector<std::string>& effects) const;
  /// Those that it knows.
  const std::map<std::string, std::vector<int>>& coordinates() const { return own_; }

 private:
  Eigen::MatrixXd h_;
  Eigen::VectorXd g_;
  std::vector<int> base_;
  std::map<std::string, std::vector<int>> own_;
  double chi2_, count_, before_;
};

/// That evaluation, for those of the effects that vanish somewhere and show without contact, named in `effects` on return.
Trial allAtOnce(const Candidates& candidates, const Settings& adopted, const References& references, std::vector<std::string>& effects);

/// The belief with each of these, at a nuisance.
std::vector<Model> modelsOf(const Model& belief, const std::vector<Settings>& starts, const Eigen::VectorXd& nuisance);

/// What starts of one effect, each with all that is adopted, gain without contact, with the share of their size at which they do;
/// a bending mode's start at the size that it can have.
std::vector<StartGain> gainsOf(const Model& belief, const std::vector<Settings>& starts, const Eigen::VectorXd& nuisance,
                               const References& references);

/// What each effect promises beside those adopted, into `references.promises` where it is not there yet. Left out: those that show in
/// contact only, and those of which no prediction stays finite.
void foresee(const Candidates& candidates, const std::vector<std::string>& names, const Settings& adopted, References& references);

/// Of the promises beside the belief alone those that hold beside what has been adopted since: all, where that shows through contact only
/// and the fit without contact has stayed where it was; else none.
/// @param free  the model as it stands, fitted to the runs without contact
std::map<std::string, Promise> stillPromised(const References& before, const Trial& free);

/// An effect that hardly acts: what may be 0 or 1 and then does nothing lies next to that.
EffectSetting nextToNothing(EffectSetting effect);

/// Whether a start next to nothing stands for an effect: not where it puts other numbers in place of the rig's, nor where one of the
/// rig's stands in for it.
bool hasASmallStart(const std::string& effect);

/// Whether little promised means little to be had: of such an effect, unless each run's offset stands in for it.
bool isToldByPromise(const std::string& effect);

}  // namespace amb_rotor
