#pragma once
// Poincare sections of a sampled motion: stroboscopic (once a turn of the shaft) and by a surface.
//
// Stroboscopic: the states at which the shaft angle theta = phase + 2 pi k (k whole; phase 0: the tacho's
// rising edge). Surface: the states at which a given scalar g of the state crosses 0, rising, falling or
// both; with g = radial velocity, falling, these are the turning points outwards.
//
// Between samples the crossing is the root of the cubic through the four samples around it; the state there
// is the cubic Hermite polynomial where velocities are given, and the cubic through the four samples where
// they are not (its derivative is then the velocity). Error O(h^4) for a smooth motion, h the sample step; in
// the step of an impact O(h^2) of the acceleration's jump. First and last interval: three samples.
//
// Units: SI; frame: inertial, x horizontal, y vertical, spin positive. Times must not fall; of two samples
// at one time (an event written twice) the later counts. A crossing at the very first sample does not count.
// Source: thesis 6.1.2. Left out: roots that leave and return between two samples.
#include <cstddef>
#include <limits>
#include <optional>
#include <vector>

namespace amb_rotor {

/// One sample of the motion in one plane.
struct MotionSample {
  static constexpr double unknown = std::numeric_limits<double>::quiet_NaN();
  double time = 0.0;                  ///< [s]
  double angle = 0.0;                 ///< shaft angle [rad], unwrapped
  double x = 0.0, y = 0.0;            ///< [m]
  double vx = unknown, vy = unknown;  ///< [m/s]; NaN: not known
  double surface = 0.0;               ///< g, used by the section by a surface only
};

/// One point of a section.
struct PoincarePoint {
  double time = 0.0;          ///< [s]
  double angle = 0.0;         ///< shaft angle [rad]
  double x = 0.0, y = 0.0;    ///< [m]
  double vx = 0.0, vy = 0.0;  ///< [m/s]
  long index = 0;             ///< stroboscopic: k of phase + 2 pi k; surface: +1 rising, -1 falling
};

enum class SectionKind { stroboscopic, surface };
enum class CrossingDirection { rising, falling, both };

struct SectionOptions {
  SectionKind kind = SectionKind::stroboscopic;
  double phase = 0.0;                                       ///< [rad] stroboscopic: the angle of the section
  CrossingDirection direction = CrossingDirection::rising;  ///< surface only
};

/// Sample-by-sample section; a point comes out one sample after its crossing.
class PoincareAccumulator {
 public:
  explicit PoincareAccumulator(SectionOptions options = {});

  /// Points whose interval is complete now, none to a few.
  std::vector<PoincarePoint> add(const MotionSample& sample);
  /// Points of the last interval.
  std::vector<PoincarePoint> finish();
  /// Samples left out because they held NaN in time, position or section value, or went back in time.
  std::size_t dropped() const { return dropped_; }

 private:
  std::vector<PoincarePoint> pointsBetween(std::size_t left) const;

  SectionOptions options_;
  std::vector<MotionSample> window_;  ///< at most four
  bool first_interval_done_ = false;
  std::size_t dropped_ = 0;
};

/// Stroboscopic section of a record. vx, vy may be empty.
/// @throw InputError: lengths differ.
std::vector<PoincarePoint> stroboscopicSection(const std::vector<double>& time,
                                               const std::vector<double>& angle, const std::vector<double>& x,
                                               const std::vector<double>& y,
                                               const std::vector<double>& vx = {},
                                               const std::vector<double>& vy = {}, double phase = 0.0);

/// Section g = 0 of a record. vx, vy may be empty. @throw InputError: lengths differ.
std::vector<PoincarePoint> surfaceSection(const std::vector<double>& time, const std::vector<double>& surface,
                                          const std::vector<double>& x, const std::vector<double>& y,
                                          CrossingDirection direction, const std::vector<double>& vx = {},
                                          const std::vector<double>& vy = {});

/// Velocity away from the bearing's centre [m/s]; the velocity along x at the centre itself.
double radialVelocity(double x, double y, double vx, double vy, double center_x = 0.0, double center_y = 0.0);

}  // namespace amb_rotor
