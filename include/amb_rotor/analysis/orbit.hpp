#pragma once
// Orbit of the rotor's centre in one plane: size, place in the clearance, ellipse of one order.
//
// Frame: inertial, x horizontal, y vertical, spin positive from x to y; z = x + i y. Radii are about the
// bearing's centre (center_x, center_y) in the same frame, unless a name says otherwise.
// Units: any one unit of length throughout (SI in this program: m); the clearance in the same unit.
//
// One order n of the motion is the ellipse z(theta) = F exp(i n theta) + B exp(-i n theta), theta the shaft
// angle, F the forward and B the backward vector. With |F|, |B|:
//   semi-major axis a = |F| + |B|, semi-minor axis b = |F| - |B| (negative: run through backward),
//   inclination of the major axis from x (arg F + arg B)/2 modulo pi.
// Source: Muszynska, Rotordynamics (2005), full spectrum and filtered orbits.
// Left out: the orbit's position along the shaft (one plane a call).
#include <complex>
#include <cstddef>
#include <string>
#include <vector>

namespace amb_rotor {

/// How an orbit is run through, seen against the positive spin.
enum class WhirlDirection {
  none,      ///< no motion, or no full turn about the centre
  forward,   ///< with the spin
  backward,  ///< against the spin
  planar     ///< to and fro on a line
};

std::string toString(WhirlDirection direction);

/// Ellipse of one order of the motion.
struct OrbitEllipse {
  double semi_major = 0.0;   ///< [m] |F| + |B|, >= 0
  double semi_minor = 0.0;   ///< [m] |F| - |B|, negative: backward
  double inclination = 0.0;  ///< [rad] of the major axis from x, in (-pi/2, pi/2]
  double major_phase = 0.0;  ///< [rad] n theta at which the rotor is on the major axis, in (-pi, pi]
  WhirlDirection direction = WhirlDirection::none;
};

/// @param forward F, @param backward B of the header's equation [m].
/// @param planar_ratio semi axes with |b| <= planar_ratio a count as planar (noise makes b never exactly 0).
OrbitEllipse orbitEllipse(std::complex<double> forward, std::complex<double> backward,
                          double planar_ratio = 1e-3);

/// Size and place of an orbit.
struct OrbitStatistics {
  std::size_t samples = 0;
  std::size_t non_finite = 0;              ///< samples that held NaN or infinity; they are in no other number
  double mean_x = 0.0;                     ///< [m] in the inertial frame
  double mean_y = 0.0;                     ///< [m]
  double rms_about_mean = 0.0;             ///< [m] sqrt(mean((x - mean_x)^2 + (y - mean_y)^2))
  double mean_radius = 0.0;                ///< [m] about the bearing's centre
  double max_radius = 0.0;                 ///< [m] about the bearing's centre
  double min_radius = 0.0;                 ///< [m] about the bearing's centre
  double peak_to_peak_x = 0.0;             ///< [m]
  double peak_to_peak_y = 0.0;             ///< [m]
  double max_radius_over_clearance = 0.0;  ///< [-] above 1: the auxiliary bearing is pressed in
  double mean_radius_over_clearance = 0.0;  ///< [-]
};

/// Orbit statistics, sample by sample. Means are weighted; the weight is the sample's share of time.
class OrbitAccumulator {
 public:
  /// @throw InputError when the clearance is not above 0.
  explicit OrbitAccumulator(double clearance, double center_x = 0.0, double center_y = 0.0);

  void add(double x, double y, double weight = 1.0);
  OrbitStatistics statistics() const;
  void reset();

 private:
  double clearance_, center_x_, center_y_;
  std::size_t samples_ = 0, non_finite_ = 0;
  double weight_ = 0.0, mean_x_ = 0.0, mean_y_ = 0.0, square_sum_ = 0.0, mean_radius_ = 0.0;
  double max_radius_ = 0.0, min_radius_ = 0.0;
  double low_x_ = 0.0, high_x_ = 0.0, low_y_ = 0.0, high_y_ = 0.0;
};

/// Statistics of samples equally spaced in time. @throw InputError: lengths differ, clearance not above 0.
OrbitStatistics orbitStatistics(const std::vector<double>& x, const std::vector<double>& y, double clearance,
                                double center_x = 0.0, double center_y = 0.0);

/// Points of an orbit.
struct Orbit {
  std::vector<double> x;
  std::vector<double> y;
};

/// The orbit about the bearing's centre in units of the clearance: contact begins at radius 1.
/// @throw InputError: lengths differ, clearance not above 0.
Orbit orbitInClearance(const std::vector<double>& x, const std::vector<double>& y, double clearance,
                       double center_x = 0.0, double center_y = 0.0);

}  // namespace amb_rotor
