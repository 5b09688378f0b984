#pragma once
// Lyapunov exponents: from the variational equation (Benettin), with the jump (saltation) matrix at events,
// and from a series of points (Rosenstein); winding number.
//
// Variational equation: tangent vectors Q (columns) are carried by the flow over an interval, Q -> Phi Q, and
// made orthonormal again, Phi Q = Q' R; lambda_k = sum ln R_kk / sum of the intervals. Units: 1 over the unit
// of the interval (per second where the caller gives seconds, per turn where he gives turns).
//
// Event at h(x, t) = 0 with the reset x+ = g(x-, t): the tangent jumps by
//   S = G + (f2 - G f1 - g_t) n^T / (n^T f1 + h_t),  G = dg/dx, n = dh/dx, f1 = f(x-), f2 = f(x+).
// Without reset (G = I, g_t = 0): S = I + (f2 - f1) n^T/(n^T f1 + h_t). Where f is continuous (contact
// without damping and friction) S = I. At grazing the denominator is 0 and S does not exist.
//
// From a series: mean logarithm of the distance of nearest neighbours (in state, not in time) against the
// steps since; the slope of its straight part is lambda_1 (per step). No straight part: noise or too few
// points.
//
// Sources: Benettin et al., Meccanica 15 (1980); the jump as in Leine and Nijmeijer; Rosenstein,
// Collins, De Luca, Physica D 65 (1993); Das et al., Nonlinearity 30 (2017) for the weighted mean of the
// winding number. Left out: spectra from series; noise reduction.
#include <Eigen/Core>
#include <cstddef>
#include <functional>
#include <string>
#include <vector>

namespace amb_rotor {

/// Accumulates the exponents of a tangent space that the caller carries along.
class LyapunovAccumulator {
 public:
  /// Makes the columns orthonormal in place and adds their growth over the interval.
  /// @param interval length of the flow since the last call, > 0. @throw InputError otherwise.
  /// Columns that became 0 or not finite make the result invalid.
  void add(Eigen::MatrixXd& tangent, double interval);
  Eigen::VectorXd exponents() const;  ///< descending in the long run; per unit of interval
  /// Standard error of the largest from the scatter over 10 consecutive blocks; 0 with fewer than 20
  /// intervals.
  double largestStandardError() const;
  bool valid() const { return valid_ && total_ > 0.0; }
  std::size_t intervals() const { return growth_.size(); }

 private:
  Eigen::VectorXd sums_;
  double total_ = 0.0;
  bool valid_ = true;
  std::vector<double> growth_, lengths_;
};

struct LyapunovResult {
  bool valid = false;
  std::string reason;         ///< why not valid
  Eigen::VectorXd exponents;  ///< per unit of interval
  double standard_error = 0.0;
};

/// Carries state and tangent over one interval, jumps included; returns false when it cannot (diverged,
/// grazing).
using TangentFlow = std::function<bool(Eigen::VectorXd& state, Eigen::MatrixXd& tangent)>;

/// @param count exponents wanted, 1 .. size of the state. @param transient intervals before counting.
/// @throw InputError: count, intervals or interval out of range.
LyapunovResult lyapunovBenettin(const TangentFlow& flow, Eigen::VectorXd state, std::size_t count,
                                double interval, std::size_t intervals, std::size_t transient = 0);

/// An event as its linearisation needs it. Empty reset_jacobian: no reset.
struct HybridEvent {
  Eigen::VectorXd field_before;    ///< f1
  Eigen::VectorXd field_after;     ///< f2
  Eigen::VectorXd normal;          ///< n = dh/dx
  double guard_rate = 0.0;         ///< h_t
  Eigen::MatrixXd reset_jacobian;  ///< G
  Eigen::VectorXd reset_rate;      ///< g_t; empty: 0
};

struct SaltationMatrix {
  Eigen::MatrixXd matrix;      ///< empty at grazing
  double approach_rate = 0.0;  ///< n^T f1 + h_t
  bool grazing = false;
};

/// @param grazing_tolerance grazing where |n^T f1 + h_t| <= tolerance * |n| |f1|.
/// @throw InputError: sizes differ.
SaltationMatrix saltationMatrix(const HybridEvent& event, double grazing_tolerance = 1e-12);

struct SeriesLyapunovOptions {
  std::size_t theiler_window = 1;  ///< neighbours nearer in time than this do not count, >= 1
  std::size_t horizon = 20;        ///< steps followed
  double saturation_share = 0.7;   ///< straight part: up to this share of the rise to the plateau
};

struct SeriesLyapunov {
  bool valid = false;
  std::string reason;
  double exponent = 0.0;           ///< per step
  double standard_error = 0.0;     ///< of the straight line
  std::vector<double> divergence;  ///< mean ln distance after 0, 1, ... steps
  std::size_t fit_steps = 0;       ///< last step of the straight part
};

/// @param points one state a column: Poincare points or a delay embedding.
SeriesLyapunov lyapunovFromSeries(const Eigen::MatrixXd& points, const SeriesLyapunovOptions& options = {});

/// Columns (u_i, u_(i+lag), ...). @throw InputError: dimension or lag 0.
Eigen::MatrixXd delayEmbedding(const std::vector<double>& series, std::size_t dimension, std::size_t lag);

/// Turns of the point about a centre per step, in (-1/2, 1/2], from points x, y that go round it once, in
/// order. Smooth quasi-periodic points: error falls faster than any power of 1/n.
double windingNumber(const std::vector<double>& x, const std::vector<double>& y, double center_x,
                     double center_y);

/// Mean step of a lifted angle in turns (circle maps): lift [turns], not wrapped.
double windingNumber(const std::vector<double>& lift);

}  // namespace amb_rotor
