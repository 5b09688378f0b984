#include "amb_rotor/analysis/contact.hpp"

#include <algorithm>
#include <cmath>

#include "argument.hpp"

namespace amb_rotor {

ContactAccumulator::ContactAccumulator(ContactOptions options) : options_(options) {
  requireArgument(options.touch_force >= 0.0, "touch_force", options.touch_force, "must be at least 0 [N]");
  requireArgument(options.release_force >= 0.0 && options.release_force <= options.touch_force,
                  "release_force", options.release_force, "must be from 0 to touch_force [N]");
}

void ContactAccumulator::interval(double from, double to, double force_from, double force_to, bool contact) {
  const double h = to - from;
  // Exact for a linear force.
  const double square = h * (force_from * force_from + force_from * force_to + force_to * force_to) / 3.0;
  duration_ += h;
  impulse_ += 0.5 * h * (force_from + force_to);
  square_ += square;
  if (!contact) return;
  contact_time_ += h;
  square_contact_ += square;
  current_contact_ += h;
  longest_contact_ = std::max(longest_contact_, current_contact_);
}

void ContactAccumulator::add(double time, double normal_force, double x, double y) {
  if (!std::isfinite(time) || !std::isfinite(normal_force) || !std::isfinite(x) || !std::isfinite(y)) {
    ++non_finite_;
    started_ = false;
    contact_ = false;
    current_contact_ = 0.0;
    return;
  }
  const bool contact_now =
      contact_ ? normal_force > options_.release_force : normal_force > options_.touch_force;
  max_force_ = std::max(max_force_, normal_force);
  double weight = 0.0;
  if (!started_) {
    started_ = true;
    if (contact_now) ++contacts_;
  } else if (time >= time_) {
    const double contact_before = contact_time_;
    if (contact_now == contact_) {
      interval(time_, time, force_, normal_force, contact_);
    } else {
      const double level = contact_now ? options_.touch_force : options_.release_force;
      const double share = (level - force_) / (normal_force - force_);
      const double crossing = time_ + share * (time - time_);
      interval(time_, crossing, force_, level, contact_);
      if (contact_now) {
        ++impacts_;
        ++contacts_;
        current_contact_ = 0.0;
      }
      interval(crossing, time, level, normal_force, contact_now);
      if (!contact_now) current_contact_ = 0.0;
    }
    weight = contact_time_ - contact_before;
  }
  if (contact_now) {
    const double angle = std::atan2(y - options_.center_y, x - options_.center_x);
    direction_cosine_ += weight * std::cos(angle);
    direction_sine_ += weight * std::sin(angle);
    direction_weight_ += weight;
    const int bin = static_cast<int>(std::floor((angle + M_PI) * 180.0 / M_PI));
    arc_.set(std::clamp(bin, 0, 359));
  }
  contact_ = contact_now;
  time_ = time;
  force_ = normal_force;
}

ContactStatistics ContactAccumulator::statistics() const {
  ContactStatistics s;
  s.duration = duration_;
  s.impacts = impacts_;
  s.max_force = max_force_;
  s.impulse = impulse_;
  s.longest_contact = longest_contact_;
  s.non_finite = non_finite_;
  if (duration_ > 0.0) {
    s.contact_fraction = contact_time_ / duration_;
    s.mean_force = impulse_ / duration_;
    s.rms_force = std::sqrt(square_ / duration_);
  }
  if (contact_time_ > 0.0) {
    s.rms_force_in_contact = std::sqrt(square_contact_ / contact_time_);
    s.mean_contact = contact_time_ / static_cast<double>(std::max<std::size_t>(1, contacts_));
  }
  if (direction_weight_ > 0.0) {
    s.mean_direction = std::atan2(direction_sine_, direction_cosine_);
    s.direction_spread = 1.0 - std::hypot(direction_cosine_, direction_sine_) / direction_weight_;
  }
  if (arc_.any()) {
    int gap = 0, longest_gap = 0;
    for (std::size_t i = 0; i < 2 * arc_.size(); ++i) {  // twice round: a gap may span the end
      gap = arc_[i % arc_.size()] ? 0 : gap + 1;
      longest_gap = std::max(longest_gap, gap);
    }
    s.rub_arc = (360 - longest_gap) * M_PI / 180.0;
  }
  return s;
}

void ContactAccumulator::reset() { *this = ContactAccumulator(options_); }

ContactStatistics contactStatistics(const std::vector<double>& time, const std::vector<double>& normal_force,
                                    const std::vector<double>& x, const std::vector<double>& y,
                                    const ContactOptions& options) {
  requireSameLength(time, normal_force, "normal_force");
  requireSameLength(time, x, "x");
  requireSameLength(time, y, "y");
  ContactAccumulator accumulator(options);
  for (std::size_t i = 0; i < time.size(); ++i) accumulator.add(time[i], normal_force[i], x[i], y[i]);
  return accumulator.statistics();
}

}  // namespace amb_rotor
