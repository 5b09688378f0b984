#pragma once
// Whirl of the rotor's centre: direction and frequency, slipping or rolling on the auxiliary bearing.
//
// From the orbit: phi = atan2(y - y_c, x - x_c) about the bearing's centre, unwrapped; the whirl frequency is
// the slope of the straight line fitted to phi(t), positive forward (with the spin). Samples nearer to the
// centre than `least_radius` have no direction and are passed over. From the full spectrum: the largest line
// and the energies at positive and negative frequencies.
//
// Rolling: a rotor of radius R that spins at Omega inside a fixed ring of radius R + C, its centre on a
// circle of radius r about the ring's centre (C the clearance, r = C plus the penetration) at the whirl speed
// w, slips with
//   v = R Omega + r w.  Pure rolling: w = -R Omega / r, with r = C the known -R Omega / C (backward).
//
// Units: rad/s, m, s. Valid: at least about 8 samples a whirl (resolved = false where the angle steps by more
// than 3/4 of a half turn: the direction may then be aliased).
// Source: thesis 2.3 and 5.2 (backward whirl); rolling as above. Left out: a ring that turns itself (subtract its
// speed from Omega and w's frame by the caller).
#include <cstddef>
#include <string>
#include <vector>

#include "amb_rotor/analysis/orbit.hpp"
#include "amb_rotor/analysis/spectrum.hpp"

namespace amb_rotor {

struct WhirlState {
  WhirlDirection direction = WhirlDirection::none;
  double frequency = 0.0;      ///< [rad/s] signed, backward negative
  double revolutions = 0.0;    ///< signed turns about the centre in the record
  double forward_share = 0.0;  ///< [-] of the angle's path that was forward
  double mean_radius = 0.0;    ///< [m] about the centre
  bool resolved = true;        ///< false: too few samples a whirl
  std::size_t samples = 0;     ///< used
};

/// Sample-by-sample whirl.
class WhirlAccumulator {
 public:
  /// @throw InputError: least radius below 0.
  explicit WhirlAccumulator(double center_x = 0.0, double center_y = 0.0, double least_radius = 0.0);

  void add(double time, double x, double y);
  WhirlState state() const;
  void reset();

 private:
  double center_x_, center_y_, least_radius_;
  bool resolved_ = true;
  std::size_t samples_ = 0;
  double first_time_ = 0.0, last_angle_ = 0.0, path_ = 0.0, forward_path_ = 0.0, total_path_ = 0.0;
  double radius_sum_ = 0.0, mean_time_ = 0.0, mean_path_ = 0.0, time_square_ = 0.0, time_path_ = 0.0;
};

/// Whirl of a record. @throw InputError: lengths differ, least radius below 0.
WhirlState whirlFromOrbit(const std::vector<double>& time, const std::vector<double>& x,
                          const std::vector<double>& y, double center_x = 0.0, double center_y = 0.0,
                          double least_radius = 0.0);

/// What the full spectrum says of the whirl.
struct SpectralWhirl {
  WhirlDirection direction = WhirlDirection::none;
  double frequency = 0.0;        ///< [rad/s] of the largest peak, signed
  double amplitude = 0.0;        ///< [m] of that peak
  double forward_energy = 0.0;   ///< [m^2] sum of squares at positive frequencies
  double backward_energy = 0.0;  ///< [m^2]
};

/// @param planar_ratio energies that differ by less than this share of their sum count as planar.
SpectralWhirl whirlFromSpectrum(const Spectrum& full_spectrum, double planar_ratio = 0.01);

enum class SlipKind { undefined, slipping, rolling };
std::string toString(SlipKind kind);

struct SlipState {
  SlipKind kind = SlipKind::undefined;  ///< undefined without spin
  double rolling_whirl = 0.0;           ///< [rad/s] -R Omega / r
  double slip_speed = 0.0;              ///< [m/s] R Omega + r w
};

/// @param spin Omega [rad/s], @param whirl w [rad/s] signed, @param rotor_radius R [m],
/// @param orbit_radius r [m], the clearance or the measured mean radius.
/// @param tolerance rolling where |slip speed| <= tolerance * |R Omega|: the share by which mean whirl and
/// radius are uncertain. @throw InputError: radii not above 0, tolerance below 0.
SlipState slipState(double spin, double whirl, double rotor_radius, double orbit_radius,
                    double tolerance = 0.05);

}  // namespace amb_rotor
