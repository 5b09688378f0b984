#pragma once
// The numbers that a fit may change, and the model that belongs to them.
//
// Nuisance: what the data set's `uncertainty` names, with its standard deviation as prior. Inertia, magnets' stiffnesses and
// unbalances as they are: a rotor without contact moves as it does where all of them grow by one factor, and what runs do not tell
// is then a straight valley, along which the beliefs alone decide. So are Ki and unbalance with a gain that all sensors share, which
// goes by its reciprocal. All else that is positive by its logarithm, contact's numbers among it.
// An effect's parameters: positive ones with a lower limit above 0 by their logarithm, those that are neutral at their upper limit
// by 1/sqrt (a half-order lag's corner: the motion is linear in it next to neutral), a sensor's gain by its reciprocal, an amplitude
// with its phase as a vector (a cos h p, a sin h p), h the phase's harmonic, all others as they are. Where friction
// mu_d + (mu_s - mu_d) exp(-v/v_s) is seen at one speed v alone, ln(mu_s - mu_d) - v/v_s is what the data fix: the rise goes by its
// logarithm, v_s by its reciprocal, and the valley is straight. A bias current goes by its quotient with the air gap, the slope of the
// magnets' force, which runs without contact tell some hundred times as closely as either: what differences through impacts are off by
// goes with what they change, and where both changed the slope it hid the gap.
#include <Eigen/Core>
#include <string>
#include <vector>

#include "amb_rotor/model/model.hpp"

namespace amb_rotor {

/// A fit may move what is known by a share up to so many times from the belief, either way.
constexpr double farthest_factor = 20.0;

struct Coordinate {
  std::string name;      ///< rotor.mass_kg, sensor_runout.a_1x_m ...
  double scale = 1.0;    ///< a change of this size counts; finite differences take a share of it
  double lower = -1e300, upper = 1e300;
  double prior_std = 0.0;   ///< 0: none
  double prior_mean = 0.0;
  bool by_logarithm = false;  ///< a nuisance: the machine's number is exp of it; limits and prior are the logarithm's
  bool is_angle = false;      ///< a nuisance: whole turns do nothing, and it is kept within half a turn of prior_mean
};

/// A parameter with its standard deviation, as written into a diagnosis.
struct FittedParameter {
  std::string name, unit;
  double value = 0.0, std = 0.0;
};

class FitSpace {
 public:
  /// @param belief    the rig as its owner believes, with the effects that its model file already has (these stay)
  /// @param fitted    effects whose parameters are to be fitted, with the values to start from
  FitSpace(const Model& belief, const std::vector<EffectSetting>& fitted);

  /// Of the current channels [A], rms. What of it goes round the loop rounds the corner of an amplifier's limit, which predictions
  /// without noise meet a little lower: a limit is never stated closer than half of it.
  void setCurrentNoise(double rms_A) { current_noise_A_ = rms_A; }
  int size() const { return static_cast<int>(coordinates_.size()); }
  int nuisances() const { return nuisances_; }
  /// The place in `x` of a nuisance; -1: it is none.
  int nuisanceNamed(const std::string& name) const;
  /// The places of the nuisances in `x` that lie further from their belief than so many prior standard deviations.
  std::vector<int> farFromBelief(const Eigen::VectorXd& x, double deviations) const;
  const std::vector<Coordinate>& coordinates() const { return coordinates_; }
  const Eigen::VectorXd& start() const { return start_; }
  /// Model at a point; coordinates beyond their limits are taken at the limit.
  Model model(const Eigen::VectorXd& x) const;
  /// Nuisance values with their standard deviations from a covariance of the coordinates.
  std::vector<FittedParameter> nuisanceValues(const Eigen::VectorXd& x, const Eigen::MatrixXd& covariance) const;
  /// Parameters of one fitted effect (its place in `fitted`), by error propagation to value and phase; what is fitted by a
  /// logarithm or a reciprocal deviates as far as the farther of its values one deviation to either side. Where an amplitude is within
  /// three deviations of nothing, its phase deviates by a third of half a turn at least, however close the line is on which both lie: a
  /// second unbalance hangs together with the rig's own, and its other side is as far off as nothing twice.
  std::vector<FittedParameter> effectValues(int place, const Eigen::VectorXd& x,
                                            const Eigen::MatrixXd& covariance) const;
  const std::vector<EffectSetting>& fitted() const { return fitted_; }
  Eigen::VectorXd clamped(Eigen::VectorXd x) const;
  /// Number of the parameters of the fitted effects.
  int effectCoordinates() const { return size() - nuisances_; }

 private:
  enum class Kind { plain, logarithm, inverse_root, reciprocal, factor, rise, quotient, vector_cosine, vector_sine };
  struct Slot {
    int effect, parameter, coordinate;
    Kind kind;
    int harmonic;
    int other_parameter;  ///< of a vector: its phase; of a rise: what it rises from; of a quotient: its divisor
    double sign;          ///< of a rise
  };
  std::vector<double> values(int place, const Eigen::VectorXd& x) const;
  void addSlot(int effect, int parameter, Kind kind, const Coordinate& coordinate, int harmonic = 1, int other = -1,
               double sign = 1.0);

  int coordinateOf(int place, int parameter) const;
  static double spread(Kind kind, const Coordinate& coordinate, double x, double std);

  Model belief_;
  std::vector<EffectSetting> fitted_;
  std::vector<Coordinate> coordinates_;
  std::vector<Slot> slots_;
  Eigen::VectorXd start_;
  double current_noise_A_ = 0.0;
  int nuisances_ = 0;
};

/// Whether a name of `uncertainty` is one of the machine (sensor.* are of the recordings).
bool isMachineUncertainty(const std::string& name);

}  // namespace amb_rotor
