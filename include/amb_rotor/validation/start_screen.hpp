#pragma once
// Which of several starts of an effect point where the data do: one prediction a start instead of a fit.
//
// The change that a start makes to the predicted channels is a direction D; the model's nuisance N (linearised once,
// about the reference) and the runs' offsets and drifts L may move with it. With everything over the noise and r the
// reference's residual, freed of N and L by least squares (priors counted), a share a of D takes at best
//   gain = (D'r)^2/(2 D'D),  a = D'r/D'D
// from half the sum of squares. Left out: that N's own directions change with the effect, and its strength beyond a.
#include <Eigen/Core>
#include <functional>
#include <vector>

#include "amb_rotor/validation/fit.hpp"

namespace amb_rotor {

/// A recording without contact at the reference.
struct ReferenceRun {
  const Recording& recording;
  double angle_rad;  ///< at standstill
  ShaftTurn turning;
  double run_in_s;   ///< that the point needs, see settledRunIn()
  const Eigen::VectorXd& offsets;        ///< in the lanes, see offsetsInLanes()
  const std::vector<double>& predicted;  ///< with these alone; samples * predicted_channels
};

struct StartGain {
  double gain = -1.0;
  double share = 0.0;  ///< a, by which the start would do best
};

/// Keeps samples * channels * (nuisances + 1) floats of each run: 50 MB for twelve runs of 15000 samples, four channels
/// and sixteen nuisances.
class StartScreen {
 public:
  /// @param recordings  must outlive this
  /// @param which       those of the runs without contact to be used
  /// @param space, x, local  the reference
  StartScreen(const std::vector<Recording>& recordings, const std::vector<int>& which, const FitSpace& space,
              const Eigen::VectorXd& x, const std::vector<LocalState>& local, double offset_std_m);

  /// @param starts        models of one structure
  /// @param either_sign   whether a < 0 is a start as well; otherwise its gain is 0
  /// @param standstill    whether runs at standstill count: not where the effect knows the shaft's angle
  /// @return for each; a gain of -1: its prediction did not stay finite
  std::vector<StartGain> gains(const std::vector<Model>& starts, bool either_sign, bool standstill) const;
  /// What the changes that these models make gain together, each by a share of its own and of either sign. 0: some do not stay
  /// finite.
  double gainTogether(const std::vector<Model>& moved, bool standstill) const;

  /// Of changes from the reference, the nuisance moved along: their products, and those with what is left.
  struct Freed {
    Eigen::MatrixXd squares;
    Eigen::VectorXd along;
    std::vector<bool> lost;  ///< those whose prediction did not stay finite
  };
  /// The changes that these models make.
  Freed freed(const std::vector<Model>& moved, bool standstill) const;

  /// Changes of a run's predicted channels, each of samples * predicted_channels or empty: none there. No changes at all: the
  /// run does not count.
  using Changes = std::function<std::vector<std::vector<double>>(const ReferenceRun&)>;
  /// Products, over all runs, of the columns nuisance, residual, then `count` changes, over the noise and with the runs'
  /// offsets and drifts eliminated; without the nuisance's priors.
  /// @param from_s  instants before it do not count
  Eigen::MatrixXd products(int count, const Changes& changes, double from_s = 0.0) const;

  /// Whether the prediction of every run about which all is linear stayed finite.
  bool isFinite() const;

  /// The nuisance's directions about the reference, for fits of more effects beside it; valid while this lives.
  FrozenColumns directions() const;

 private:
  struct Part {
    int recording;
    double angle_rad;
    ShaftTurn turning;
    double run_in_s;  ///< that the point needs, see settledRunIn()
    Eigen::VectorXd offsets;  ///< in the lanes, see offsetsInLanes()
    Eigen::MatrixXf columns;  ///< over the noise: nuisance, residual; samples * channels, instant by instant
    std::vector<double> predicted;
    bool lost = false;  ///< the prediction about which all is linear did not stay finite: the run takes no part
  };

  const std::vector<Recording>& recordings_;
  double offset_std_;
  Eigen::VectorXd prior_weight_, prior_pull_;
  std::vector<Part> parts_;
};

}  // namespace amb_rotor
