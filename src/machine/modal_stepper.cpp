#include "amb_rotor/machine/modal_stepper.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <functional>

#include "amb_rotor/common/check.hpp"
#include "amb_rotor/common/units.hpp"
#include "amb_rotor/integration/contact_flow.hpp"
#include "amb_rotor/integration/dense_products.hpp"
#include "amb_rotor/machine/assembly.hpp"
#include "linear_reading.hpp"

namespace amb_rotor {
namespace {

/// h0 where nothing is sampled [s]; steps are this halved so and so often.
constexpr double longest_modal_step_s = 1.0 / 2048.0;

/// Largest distance from the origin; not a number where one of them is.
double largestOf(const Vec2<double> (&places)[6]) {
  double largest = 0.0;
  for (const Vec2<double>& place : places) {
    const double radius = std::hypot(place.x, place.y);
    if (std::isnan(radius)) return radius;
    largest = std::max(largest, radius);
  }
  return largest;
}

}  // namespace

/// One linear machine: its modes, and the state in them.
class ModalStepper::Linear final : public LinearReading {
 public:
  Linear(const Machine<double>& machine, const Schedule* schedule, const Vec2<double> bearing_on[2],
         double speed, double tolerance)
      : LinearReading(machine, schedule, bearing_on, speed) {
    if (!reason_.empty()) return;
    flow_ = std::make_unique<LinearFlow>(system_);
    if (!flow_->usable()) {
      reason_ = flow_->reason();
      return;
    }
    ContactFlow::Options options;
    options.tolerance = tolerance;
    options.clearance = machine.rig().auxiliary_bearing.clearance_m;
    options.longest_step = machine.ambModel() == AmbModel::linear
                               ? 1.0 / machine.rig().controller.sample_rate_hz
                               : longest_modal_step_s;
    contact_ = std::make_unique<ContactFlow>(*flow_, *this, options);
    prepareDrive();
  }

  const IntegratorStatistics* statistics() const { return contact_ ? &contact_->statistics() : nullptr; }

  /// Takes mechanics over, where they are not those that were written last: these are still known.
  void read(const double* mechanics) {
    if (std::memcmp(mechanics, written_.data(), sizeof(double) * static_cast<std::size_t>(n_)) == 0) return;
    planes_known_ = false;
    whole_.noalias() = flow_->toModal() * Eigen::Map<const Eigen::VectorXd>(mechanics, n_);
  }
  void write(double* mechanics) {
    flow_->mechanics(whole_, turned_, written_);
    std::memcpy(mechanics, written_.data(), sizeof(double) * static_cast<std::size_t>(n_));
  }
  void atSensors(Vec2<double> out[2]) const { at(sensors_from, out); }
  void atMagnets(Vec2<double> out[2]) const { at(magnets_from, out); }
  bool view(const Inputs<double>& in, RotorView& out) const {
    if (!shown_ || !serves(schedule_, in.bearing_on, in.shaft.speed)) return false;
    Eigen::Matrix<double, recorded_rows, 1> seen = recorded0_;
    product(recorded_.data(), recorded_rows, whole_.size(), whole_.data(), seen.data(), true);
    constexpr int planes = sensors_and_magnets;  // those are known
    seen.segment<4>(forces_from - planes) +=
        force_by_current_ * Eigen::Vector4d(in.force_current[0].x, in.force_current[0].y, in.force_current[1].x,
                                            in.force_current[1].y);
    const auto pair = [&](int row) { return Vec2<double>{seen[row - planes], seen[row - planes + 1]}; };
    at(sensors_from, out.sensor_position);
    for (int e = 0; e < 2; ++e) {
      out.aux_position[e] = pair(ends_from + 2 * e);
      out.bearing_force[e] = pair(forces_from + 2 * e);
      out.contact[e] = machine_.contactAt(e, out.aux_position[e], pair(view_rows + 2 * e), in.shaft,
                                          pair(centres_from + 2 * e), {}, 0.0, in);
    }
    const Vec2<double> places[] = {pair(absolute_from),     pair(absolute_from + 2), pair(absolute_from + 4),
                                   pair(absolute_from + 6), out.aux_position[0],     out.aux_position[1]};
    out.largest_radius = largestOf(places);
    return true;
  }

  /// Moves on; where that fails the state is as it was, but for the contacts.
  IntegrationStatus advance(double from, double length, double angle, const double target[4],
                            const double current[4], int contact_mode[2],
                            const std::function<void(int, bool, double, const double*)>& observer) {
    double excess[4];
    for (int a = 0; a < 4; ++a) excess[a] = current[a] - target[a];
    angle_ = angle;
    const bool acts = pushed(from, from + length);
    contact_->begin(angle, target, excess, acts ? &pushes_ : nullptr);
    contact_->own(0.0, whole_, own_);
    const auto on_event = [&](int end, double time) {
      if (!observer) return;
      contact_->whole(time, own_, kept_);
      flow_->mechanics(kept_, turned_, event_);
      observer(end, contact_mode[end] != 0, from + time, event_.data());
    };
    // by reference: a copy of it would be allocated
    const auto status = contact_->advance(length, own_.data(), contact_mode, std::cref(on_event));
    if (status != IntegrationStatus::ok) return status;
    contact_->whole(length, own_, whole_);
    planes_known_ = false;
    return status;
  }

 private:
  /// The rotor at sensors and magnets, both at once: whoever asks for the ones asks for the others.
  void at(int row, Vec2<double> out[2]) const {
    if (!planes_known_) {
      planes_ = view0_.head<sensors_and_magnets>();
      product(to_planes_.data(), sensors_and_magnets, whole_.size(), whole_.data(), planes_.data(), true);
      planes_known_ = true;
    }
    out[0] = {planes_[row], planes_[row + 1]};
    out[1] = {planes_[row + 2], planes_[row + 3]};
  }
  /// Whether something of the schedule acts in an interval that is not in the drive; then pushes_ says what.
  bool pushed(double from, double to) {
    if (schedule_ == nullptr) return false;
    since_ = from;
    if (!factors_.empty()) {
      schedule_->unbalanceFactors(from, from, factors_);
      schedule_->unbalanceFactors(to, from, later_factors_);
      if (factors_ == later_factors_ && factors_ != drive_factors_) {
        drive_factors_ = factors_;
        harmonicDrive();
        contact_->setDrive(drive_);
      }
      if (factors_ != drive_factors_ || factors_ != later_factors_) return true;
    }
    return !forces_.empty() && schedule_->forcesOn(from);
  }
  /// Forces of the schedule, and unbalances beyond those in the drive, at a time since `since_`.
  void push(double time, double* u) {
    if (!forces_.empty()) schedule_->forces(since_ + time, since_, forces_);
    for (const auto& force : forces_) {
      *u++ = force.x;
      *u++ = force.y;
    }
    if (factors_.empty()) return;
    schedule_->unbalanceFactors(since_ + time, since_, factors_);
    const double angle = angle_ + speed_ * time;
    for (std::size_t i = 0; i < factors_.size(); ++i) {
      const double beyond = factors_[i] - drive_factors_[i];
      *u++ = beyond * std::cos(angle);
      *u++ = beyond * std::sin(angle);
    }
  }

  void prepareDrive() {
    const Eigen::MatrixXd& modal = flow_->toModal();
    const int size = flow_->size(), zeros = size - 2 * flow_->modes();
    flow_->rest(modal * constant_, drive_.rest, drive_.drift);
    const int held = driven_ ? 4 : 0;
    drive_.rest_by.setZero(size, held);
    drive_.decay_by.setZero(size, held);
    drive_.drift_by.setZero(zeros, held);
    drive_.speed = speed_;
    drive_.rate = driven_ ? CurrentTrack<double>(machine_).amplifier().rate() : 0.0;
    for (int a = 0; a < held; ++a) {
      const Eigen::VectorXd g = modal * by_current_.col(a);
      Eigen::VectorXd s, d;
      flow_->rest(g, s, d);
      drive_.rest_by.col(a) = s;
      drive_.drift_by.col(a) = d;
      drive_.decay_by.col(a) = flow_->decaying(g, drive_.rate);
    }
    drive_.place = Eigen::VectorXd::Zero(8);
    for (int e = 0; e < 2; ++e) drive_.place.segment(4 * e, 2) = place0_.segment(2 * e, 2);
    harmonicDrive();
    contact_->setDrive(drive_);
    const Eigen::MatrixXd seen = view_ * flow_->fromModal();
    to_planes_ = seen.topRows(sensors_and_magnets);
    recorded_.setZero(recorded_rows, size);
    recorded_.topRows(recorded_rows - 4) = seen.bottomRows(recorded_rows - 4);
    for (int e = 0; e < 2; ++e)
      recorded_.middleRows(recorded_rows - 4 + 2 * e, 2) = flow_->outputMatrix().middleRows(4 * e + 2, 2);
    recorded0_ << view0_.tail<recorded_rows - 4>(), Eigen::Vector4d::Zero();
    whole_.setZero(size);
    turned_ = own_ = kept_ = whole_;
    written_.setConstant(n_, std::nan(""));
    event_.setZero(n_);
  }
  /// Unbalances of the rig, and of the schedule by their factors in the drive.
  void harmonicDrive() {
    Eigen::VectorXd cosine = cosine_, sine = sine_;
    Eigen::Index column = 4 + 2 * static_cast<Eigen::Index>(forces_.size());
    for (const double factor : drive_factors_) {
      cosine += factor * system_.b.col(column++);
      sine += factor * system_.b.col(column++);
    }
    drive_.cosine.setZero(flow_->size());
    drive_.sine = drive_.cosine;
    if (speed_ != 0.0)
      flow_->harmonic(flow_->toModal() * cosine, flow_->toModal() * sine, speed_, drive_.cosine, drive_.sine);
  }

  std::unique_ptr<LinearFlow> flow_;
  std::unique_ptr<ContactFlow> contact_;
  ContactFlow::Drive drive_;
  static constexpr int sensors_and_magnets = 8;
  static constexpr int recorded_rows = view_rows - sensors_and_magnets + 4;  ///< the others, the ends' velocities
  AlignedMatrix to_planes_, recorded_;
  Eigen::Matrix<double, recorded_rows, 1> recorded0_;
  mutable Eigen::Matrix<double, sensors_and_magnets, 1> planes_;
  mutable bool planes_known_ = false;
  Eigen::VectorXd whole_, turned_, own_, kept_, written_, event_;
  double since_ = 0.0, angle_ = 0.0;  ///< at the start of the interval
  const ContactFlow::Pushes pushes_ = [this](double time, double* u) { push(time, u); };
};

RotorView RotorView::of(const Machine<double>& machine, const Inputs<double>& in, const double* mechanics) {
  Observation<double> seen;
  machine.observe(in, mechanics, nullptr, seen);
  RotorView out;
  for (int e = 0; e < 2; ++e) {
    out.sensor_position[e] = seen.sensor_position[e];
    out.aux_position[e] = seen.aux_position[e];
    out.bearing_force[e] = seen.bearing_force[e];
    out.contact[e] = seen.contact[e];
    out.ring_speed[e] = seen.ring_speed[e];
  }
  out.largest_radius = largestRadius(machine.rotor(), mechanics);
  return out;
}

double RotorView::largestRadius(const ModalRotor<double>& rotor, const double* mechanics) {
  const auto at = [&](int plane) { return rotor.at(plane, mechanics); };
  const Vec2<double> planes[] = {at(plane_amb), at(plane_amb + 1), at(plane_sensor), at(plane_sensor + 1),
                                 at(plane_aux), at(plane_aux + 1)};
  return largestOf(planes);
}

ModalStepper::ModalStepper(const Machine<double>& machine, double relative_tolerance)
    : machine_(machine), tolerance_(relative_tolerance), general_(machine, relative_tolerance) {
  if (machine.spin() != Spin::prescribed) fixed_reason_ = "the spin is a state";
  if (machine.frictionLaw() == FrictionLaw::set_valued) fixed_reason_ = "friction is set-valued";
  if (machine.electrics().size() > 0) fixed_reason_ = "coils or filters are states";
  if (machine.ringState() >= 0) fixed_reason_ = "the rings spin";
  if (!machine.relaxationRates().empty()) fixed_reason_ = "the current lags";
}
ModalStepper::~ModalStepper() = default;

void ModalStepper::setContactObserver(std::function<void(int, bool, double, const double*)> observer) {
  observer_ = std::move(observer);
  if (!observer_) {
    counted_ = nullptr;
    return general_.setContactObserver(nullptr);
  }
  counted_ = [this](int end, bool touching, double time, const double* mechanics) {
    ++told_;
    observer_(end, touching, time, mechanics);
  };
  general_.setContactObserver([this](int end, bool touching, double time, const double* mechanics) {
    if (skip_ > 0)
      --skip_;
    else
      observer_(end, touching, time, mechanics);
  });
}

std::string ModalStepper::Taken::text() const {
  if (general == 0) return modal == 0 ? "no step" : "modal coordinates";
  const std::string why = " (" + reason + ")";
  if (modal == 0) return "event stepper" + why;
  char share[16];
  std::snprintf(share, sizeof share, "%.3g",
                100.0 * static_cast<double>(modal) / static_cast<double>(modal + general));
  return std::string("modal coordinates for ") + share + " % of the intervals, else event stepper" + why;
}

namespace {

void add(const IntegratorStatistics& own, IntegratorStatistics& sum, int sign = 1) {
  sum.steps += sign * own.steps;
  sum.rejected += sign * own.rejected;
  sum.evaluations += sign * own.evaluations;
  sum.events += sign * own.events;
}

}  // namespace

IntegratorStatistics ModalStepper::statistics() const {
  IntegratorStatistics sum = general_.statistics();
  add(replaced_, sum);
  for (const auto& linear : known_)
    if (linear != nullptr && linear->statistics() != nullptr) add(*linear->statistics(), sum);
  add(before_, sum, -1);
  return sum;
}

void ModalStepper::countAnew() {
  add(statistics(), before_);
  taken_ = {};
}

ModalStepper::Linear* ModalStepper::linearFor(const Simulator<double>& sim, double from, double to,
                                              const Simulator<double>::Held& held) {
  reason_ = fixed_reason_;
  if (!reason_.empty()) return nullptr;
  const Schedule* schedule = sim.drive().schedule;
  const Shaft<double> start = sim.drive().shaft(from), end = sim.drive().shaft(to);
  const double middle = sim.drive().shaft(0.5 * (from + to)).speed;
  if (start.acceleration != 0.0 || end.acceleration != 0.0 || start.speed != end.speed ||
      middle != start.speed)
    reason_ = "the speed changes";
  if (!reason_.empty()) return nullptr;
  for (int i = 0; i < 2; ++i)
    if (known_[i] != nullptr && known_[i]->serves(schedule, held.bearing_on, start.speed)) {
      last_ = i;
      reason_ = known_[i]->reason();
      return reason_.empty() ? known_[i].get() : nullptr;
    }
  last_ = 1 - last_;
  if (known_[last_] != nullptr && known_[last_]->statistics() != nullptr) add(*known_[last_]->statistics(), replaced_);
  known_[last_] = std::make_unique<Linear>(machine_, schedule, held.bearing_on, start.speed, tolerance_);
  reason_ = known_[last_]->reason();
  return reason_.empty() ? known_[last_].get() : nullptr;
}

void ModalStepper::bring(MachineState<double>& state) {
  if (holder_ == nullptr) return;
  AMB_ROTOR_CHECK(&state == held_state_,
                  "a stepper's intervals follow each other on one state, or are brought first");
  holder_->write(state.mechanics.data());
  holder_ = nullptr;
}

bool ModalStepper::atSensors(const MachineState<double>& state, Vec2<double> out[2]) const {
  if (holder_ == nullptr || &state != held_state_) return false;
  holder_->atSensors(out);
  return true;
}

bool ModalStepper::atMagnets(const MachineState<double>& state, Vec2<double> out[2]) const {
  if (holder_ == nullptr || &state != held_state_) return false;
  holder_->atMagnets(out);
  return true;
}

bool ModalStepper::view(const Inputs<double>& in, const MachineState<double>& state, RotorView& out) const {
  return holder_ != nullptr && &state == held_state_ && holder_->view(in, out);
}

bool ModalStepper::advanceGeneral(const Simulator<double>& sim, double from, double to,
                                  MachineState<double>& state, const Simulator<double>::Held& held) {
  ++taken_.general;
  if (taken_.reason != reason_) taken_.reason = reason_;
  const bool done = general_.advance(sim, from, to, state, held);
  result_ = general_.result();
  skip_ = 0;
  return done;
}

bool ModalStepper::advance(const Simulator<double>& sim, double from, double to, MachineState<double>& state,
                           const Simulator<double>::Held& held) {
  Linear* linear = linearFor(sim, from, to, held);
  if (linear != holder_) bring(state);
  if (linear == nullptr) return advanceGeneral(sim, from, to, state, held);
  if (holder_ == nullptr) linear->read(state.mechanics.data());
  AMB_ROTOR_CHECK(holder_ == nullptr || &state == held_state_, "the state of another run");
  const int before[2] = {state.contact_mode[0], state.contact_mode[1]};
  const double angle = sim.drive().shaft(from).angle;
  told_ = 0;
  holder_ = linear;
  held_state_ = &state;
  const IntegrationStatus status =
      linear->advance(from, to - from, angle, held.target, state.current, state.contact_mode, counted_);
  if (status != IntegrationStatus::ok) {  // from the start once more; what was told is not told again
    bring(state);
    std::copy(before, before + 2, state.contact_mode);
    reason_ = "a contact that modal steps do not get through";
    skip_ = told_;
    return advanceGeneral(sim, from, to, state, held);
  }
  ++taken_.modal;
  result_.status = status;
  result_.time = to;
  const auto& track = sim.track();
  track.move(track.decay(to - from), held.target, state.current, state.lag.data());
  return true;
}

}  // namespace amb_rotor
