#pragma once
// Which law of up to three terms explains runs without contact best: as force at the bearings, at one plane of the rotor or
// against its tilt (effects/law_terms.hpp), or in the sensors' signals (effects/signal_law.hpp). The plane, and the width of a
// signal's step, is fitted along with the terms, from where the search is told to begin.
//
// Terms that promise most where everything is linearised about a point (term_search.hpp) are contenders only: a law that
// matters bends the motion, and next to no force |p|^2 p and |p|^3 p look alike. Each contender is fitted to an end, with
// the nuisance free within its belief; then they are compared. What one term leaves is linearised about it, and so on.
#include <Eigen/Core>
#include <algorithm>
#include <optional>
#include <string>
#include <vector>

#include "amb_rotor/validation/fit.hpp"
#include "amb_rotor/validation/start_screen.hpp"
#include "amb_rotor/validation/term_search.hpp"
#include "fitted_laws.hpp"
#include "law_place.hpp"

namespace amb_rotor {

/// A further term must take this share of what is above the noise; laws this close to each other count as equal.
constexpr double least_term_share = 0.05, equal_share = 0.01;
/// What the rotor answers to noise in its loop leaves above the noise, as a share of that: no term takes it.
constexpr double loop_floor = 0.015;
/// Share of what any three terms explain along the measured path that one set of quantities must explain to foresee a plain law.
constexpr double plain_by_one_set = 0.88;
/// Terms that a law may have. Contenders about a point without a law: single terms, pairs.
constexpr int most_terms = 3, first_singles = 3, first_pairs = 2;

class LawSearch {
 public:
  /// @param belief        the nuisance's start is its belief
  /// @param adopted       effects beside which the law stands; their numbers are fitted too
  /// @param frequency_hz  of the terms that repeat in time; 0: they take no part
  LawSearch(const std::vector<Recording>& recordings, const Model& belief, const std::vector<EffectSetting>& adopted,
            double frequency_hz, double offset_std_m, LawPlace place = {});

  const LawPlace& place() const { return place_; }
  int numberCoordinate() const { return number_; }  ///< of the plane, or of a step's width; -1: none
  const std::vector<int>& fitted() const { return fit_; }    ///< recordings: to fit, without contact
  const std::vector<int>& heldOut() const { return held_out_; }
  const FitSpace& space() const { return space_; }
  int first() const { return first_; }  ///< coordinate of the first term

  /// Sum of squares with the nuisance's priors; 1e300: not finite.
  double chi2(const Eigen::VectorXd& x, const std::vector<int>& which, std::vector<LocalState>& local, double* count) const;

  /// What shares of the unexplained are worth.
  struct Stakes {
    double count, least, tie;
    Stakes(double before, double residuals)
        : count(residuals), least(least_term_share * std::max(1.0, before - residuals)), tie(least * equal_share / least_term_share) {}
    bool nothingLeft(double chi2) const { return chi2 - (1.0 + loop_floor) * count < least; }
  };
  /// What the best law of one set of quantities leaves by its forces along the measured path: of chi2 above the noise, to hold
  /// places to each other, with the nuisance (and the adopted effects' numbers) beside it.
  struct Left {
    double above = 0.0;
    Eigen::VectorXd x = {};
    bool reads_angle = false;  ///< that law
  };
  /// Laws by the forces along the measured path, not fitted yet, and by how much the best lowers chi2 there.
  struct AlongPath {
    std::vector<Hypothesis> laws;
    double promised = 0.0, by_one_set = 0.0;  ///< the latter: the best law of one set of quantities
    Left left;                                ///< by such a law without terms that differ between the bearings
    /// Whether one set of quantities does there nearly what any three terms do: so do plain laws, but not two effects.
    bool foreseesPlain() const { return by_one_set >= plain_by_one_set * promised; }
  };
  /// Where a search has come to once it has looked along the measured path.
  struct Begun {
    Hypothesis without;  ///< no law
    Stakes stakes;
    AlongPath along;
    /// Once they were asked for; no term: there is none.
    std::optional<Hypothesis> plain_along_path, plain;
  };

  /// @param at  the model as it stands, without a law; `before` its chi2, `count` of how many residuals
  Begun begin(const Eigen::VectorXd& at, const std::vector<LocalState>& local, double before, double count);
  /// Chi2 above the noise of runs at standstill, without a law.
  double aboveAtStandstill(const Eigen::VectorXd& x, const std::vector<LocalState>& local) const;
  /// By the few terms that differ most.
  /// @param screen  at `nuisance`, see screenAt(); of any place
  Left leftByOneSet(const StartScreen& screen, const Eigen::VectorXd& nuisance, const Stakes& stakes) const;
  StartScreen screenAt(const Eigen::VectorXd& x, const std::vector<LocalState>& local) const;

  /// The one term, or the few of one set of quantities, that explains all but what a further one could earn, at the adopted
  /// effects' numbers of the begin, from its nuisance and from the believed one.
  const Hypothesis& plain(Begun& begun);
  /// The same among the laws along the measured path alone.
  const Hypothesis& plainAlongPath(Begun& begun);

  /// The best law: the plain one where there is one.
  Hypothesis best(Begun& begun);

  /// A law fitted to its end, with deviations that are robust against coloured noise.
  Hypothesis toItsEnd(const Hypothesis& law) const;

 private:
  bool linearise(const Eigen::VectorXd& x, std::vector<LocalState>& local, Eigen::MatrixXd& h, Eigen::VectorXd& g) const;
  void priors(Eigen::MatrixXd& h, Eigen::VectorXd& g) const;
  double followPath(const StartScreen& screen, const Eigen::VectorXd& x, const std::vector<int>& library, Eigen::MatrixXd& h,
                    Eigen::VectorXd& g) const;
  Eigen::VectorXd startAt(const Eigen::VectorXd& x) const;
  TermChoice bestOfSet(unsigned quantities, const std::vector<int>& library, const Eigen::MatrixXd& h, const Eigen::VectorXd& g,
                       const Stakes& stakes) const;
  TermChoice bestOfOneSet(const std::vector<int>& library, const Eigen::MatrixXd& h, const Eigen::VectorXd& g,
                          const Stakes& stakes) const;
  Left leftByOneSet(double above, const std::vector<int>& library, const Eigen::VectorXd& x, const Eigen::MatrixXd& h,
                    const Eigen::VectorXd& g, const Stakes& stakes) const;
  AlongPath alongPath(const Hypothesis& about, const Stakes& stakes) const;
  /// What best() is before sparing().
  Hypothesis ofTerms(Begun& begun);
  Hypothesis sparing(const Hypothesis& law, const Stakes& stakes);
  Hypothesis believed(const Hypothesis& about) const;
  Hypothesis plainByScreen(const Begun& begun);
  void refineBest(std::vector<Hypothesis>& these);
  std::vector<Hypothesis> contenders(const Hypothesis& about, int singles, int pairs, const Stakes& stakes,
                                     int instead = 0) const;
  FitResult fitTo(Hypothesis& law, FitOptions options) const;
  void refine(std::vector<Hypothesis>& these, int iterations);
  unsigned quantitiesIn(const std::vector<int>& terms) const;
  int quantityCount(const std::vector<int>& terms) const;
  const Hypothesis& chosen(const std::vector<Hypothesis>& these, const Stakes& stakes) const;

  std::vector<Hypothesis> screened(const Hypothesis& about) const;

  LawPlace place_;
  const std::vector<Recording>& recordings_;
  double offset_std_;
  FitSpace bare_, space_;  ///< without the law, and with it
  int first_ = 0, number_ = -1;
  double frequency_hz_;
  FitProblem problem_;
  std::vector<int> base_, library_, fit_, still_, turning_, held_out_;
  FittedLaws fitted_;
  std::vector<unsigned> quantities_;  ///< that each of the library depends on, as bits
};

}  // namespace amb_rotor
