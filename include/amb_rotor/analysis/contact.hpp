#pragma once
// Statistics of the contact of rotor and auxiliary bearing in one plane.
//
// The rotor is in contact while the normal force N exceeds `touch_force`; it has left when N falls to
// `release_force` or below (hysteresis, so that noise on N makes no impacts). Between samples N is linear,
// and the times of touching and release are its crossings; time shares and integrals follow from that. An
// impact is one touch-down. The rub angle is the direction of the rotor's centre from the bearing's centre
// while in contact: its mean direction, its spread, and the smallest arc that holds all of it (1 deg steps).
//
// Units: N, s, m, rad; frame: inertial, angles from x towards y. Valid: times grow.
// Errors: InputError for lengths or thresholds; samples with NaN are counted and end the interval.
#include <bitset>
#include <cstddef>
#include <vector>

namespace amb_rotor {

struct ContactOptions {
  double touch_force = 0.0;    ///< [N] contact begins above it, >= 0
  double release_force = 0.0;  ///< [N] contact ends at or below it, 0 <= release <= touch
  double center_x = 0.0;       ///< [m] of the auxiliary bearing
  double center_y = 0.0;       ///< [m]
};

struct ContactStatistics {
  double duration = 0.0;          ///< [s] of the record
  double contact_fraction = 0.0;  ///< [-] share of the time in contact
  std::size_t impacts = 0;        ///< touch-downs; a record that begins in contact does not count that one
  double max_force = 0.0;         ///< [N]
  double mean_force = 0.0;        ///< [N] over all the time
  double rms_force = 0.0;         ///< [N] over all the time
  double rms_force_in_contact = 0.0;  ///< [N] over the time in contact
  double impulse = 0.0;               ///< [N s] integral of N
  double longest_contact = 0.0;       ///< [s]
  double mean_contact = 0.0;          ///< [s] time in contact over number of contacts
  double mean_direction = 0.0;        ///< [rad] circular mean of the contact's direction, weighted by time
  double direction_spread = 0.0;      ///< [-] 1 - resultant: 0 all at one place, 1 evenly all round
  double rub_arc = 0.0;               ///< [rad] smallest arc that holds all contact, 2 pi: all round
  std::size_t non_finite = 0;
};

/// Sample-by-sample contact statistics.
class ContactAccumulator {
 public:
  /// @throw InputError: thresholds out of order.
  explicit ContactAccumulator(ContactOptions options = {});

  void add(double time, double normal_force, double x, double y);
  ContactStatistics statistics() const;
  bool inContact() const { return contact_; }
  void reset();

 private:
  void interval(double from, double to, double force_from, double force_to, bool contact);

  ContactOptions options_;
  bool started_ = false, contact_ = false;
  double time_ = 0.0, force_ = 0.0;
  double duration_ = 0.0, contact_time_ = 0.0, max_force_ = 0.0, impulse_ = 0.0, square_ = 0.0,
         square_contact_ = 0.0;
  double current_contact_ = 0.0, longest_contact_ = 0.0;
  std::size_t impacts_ = 0, contacts_ = 0, non_finite_ = 0;
  double direction_cosine_ = 0.0, direction_sine_ = 0.0, direction_weight_ = 0.0;
  std::bitset<360> arc_;
};

/// Statistics of a record. @throw InputError: lengths differ, thresholds out of order.
ContactStatistics contactStatistics(const std::vector<double>& time, const std::vector<double>& normal_force,
                                    const std::vector<double>& x, const std::vector<double>& y,
                                    const ContactOptions& options = {});

}  // namespace amb_rotor
