#pragma once
// Longer steps of a fit through contact, where its windows are less curved than their normal equations say.
#include <Eigen/Core>
#include <vector>

namespace amb_rotor {

/// The starts of windows follow a step to first order only; through many impacts they find better ones for it, and what is left then
/// rises much less than the normal equations foretell: steps creep. What the gradient has lost over the last step s
/// tells by how much,
///   ease = s.H s / (s.(g - g'))
/// with H, g of the windows where it began, g' where it ended. It is 1 for a parabola. A further step takes H / ease for H.
/// Source: the secant of Barzilai and Borwein (IMA J. Numer. Anal. 8 (1988) 141), here of one part of a sum.
class WindowEase {
 public:
  double value() const { return ease_; }
  /// Whether a step should be longer for it, where the windows leave so much.
  /// @param mean_square  over the noise
  bool isWanted(double mean_square) const;
  /// @param h, g   the windows' normal equations where a step began, g minus the gradient of half their squares
  /// @param after  g where it ended
  void learn(const Eigen::MatrixXd& h, const Eigen::VectorXd& g, const Eigen::VectorXd& after, const Eigen::VectorXd& step);
  /// A step that was longer for it has failed.
  void shorten();
  /// Takes from normal equations what those of the windows count too much in them; `held` coordinates (empty: none) stay.
  void relieve(const Eigen::MatrixXd& windows_h, const std::vector<bool>& held, Eigen::MatrixXd& h) const;

 private:
  double ease_ = 1.0;
};

}  // namespace amb_rotor
