#include "amb_rotor/machine/modal_stepper.hpp"

#include <Eigen/LU>
#include <cmath>
#include <cstring>
#include <functional>

#include "amb_rotor/common/units.hpp"
#include "amb_rotor/integration/contact_flow.hpp"

namespace amb_rotor {
namespace {

/// Misfit of the linear equations at random states that counts as nonlinear, of the size of their terms:
/// round-off is a thousand times smaller, the weakest effect of the catalogue at its weakest a thousand times
/// larger.
constexpr double largest_probe_misfit = 1e-9;
/// h0 where nothing is sampled [s]; steps are this halved so and so often.
constexpr double longest_modal_step_s = 1.0 / 8192.0;

/// Numbers in (-1, 1) that are the same each time (Weyl's sequence).
class Spread {
 public:
  double next() {
    at_ += 0.6180339887498949;
    at_ -= std::floor(at_);
    return 2.0 * at_ - 1.0;
  }

 private:
  double at_ = 0.0;
};

}  // namespace

/// One linear machine: its equations, its modes, and the state in them.
class ModalStepper::Linear final : public EndContacts {
 public:
  Linear(const Machine<double>& machine, const Vec2<double> bearing_on[2], double speed, double tolerance)
      : machine_(machine), n_(machine.stateSize()), speed_(speed) {
    in_.bearing_on[0] = bearing_on[0];
    in_.bearing_on[1] = bearing_on[1];
    in_.shaft = Shaft<double>::at(0.0, speed, 0.0);
    law_ = in_;
    law_.contact_mode = carries_;
    probe();
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

  const std::string& reason() const { return reason_; }
  bool serves(const Vec2<double> on[2], double speed) const {
    return on[0].x == in_.bearing_on[0].x && on[0].y == in_.bearing_on[0].y &&
           on[1].x == in_.bearing_on[1].x && on[1].y == in_.bearing_on[1].y && speed == speed_;
  }
  const IntegratorStatistics* statistics() const { return contact_ ? &contact_->statistics() : nullptr; }

  double force(int end, const double* w, double* u) const override {
    const Vec2<double> none;
    const Contact<double> c =
        machine_.contactAt(end, {w[0], w[1]}, {w[2], w[3]}, law_.shaft, none, none, 0.0, law_);
    // continued smoothly to where the law would pull: the event is found there
    const double tangential = c.normal_force * coulombFactor(c.friction_coefficient, c.slip);
    u[0] = -c.normal_force * c.normal.x - tangential * c.normal.y;
    u[1] = -c.normal_force * c.normal.y + tangential * c.normal.x;
    return std::min(c.penetration, c.margin);
  }

  IntegrationStatus advance(double from, double length, double angle, const double target[4],
                            const double current[4], MachineState<double>& state,
                            const std::function<void(int, bool, double, const double*)>& observer) {
    double* y = state.mechanics.data();
    const Eigen::Map<Eigen::VectorXd> mechanics(y, n_);
    // what was written last is still known in modal coordinates
    if (std::memcmp(y, written_.data(), sizeof(double) * static_cast<std::size_t>(n_)) != 0)
      whole_.noalias() = flow_->toModal() * mechanics;
    ContactFlow::Drive& drive = contact_->drive;
    drive.rest = rest_;
    drive.drift = drift_;
    drive.decay.setZero();
    for (int a = 0; a < 4 && driven_; ++a) {
      drive.rest += target[a] * rest_current_.col(a);
      drive.drift += target[a] * drift_current_.col(a);
      drive.decay += (current[a] - target[a]) * decay_current_.col(a);
    }
    drive.angle = angle;
    drive.speed = speed_;
    contact_->prepare();
    own_.setZero();
    contact_->whole(0.0, own_.data(), kept_);
    own_ = whole_ - kept_;
    const auto on_event = [&](int end, double time) {
      if (!observer) return;
      contact_->whole(time, own_.data(), kept_);
      event_.noalias() = flow_->fromModal() * kept_;
      observer(end, state.contact_mode[end] != 0, from + time, event_.data());
    };
    // by reference: a copy of it would be allocated
    const auto status = contact_->advance(length, own_.data(), state.contact_mode, std::cref(on_event));
    contact_->whole(length, own_.data(), whole_);
    written_.noalias() = flow_->fromModal() * whole_;
    std::memcpy(y, written_.data(), sizeof(double) * static_cast<std::size_t>(n_));
    return status;
  }

 private:
  /// Rates at a state, an angle and currents, without contact.
  Eigen::VectorXd rates(const Eigen::VectorXd& y, double angle, const double* current) {
    static const int free[2] = {0, 0};
    Inputs<double> in = in_;
    in.contact_mode = free;
    in.shaft = Shaft<double>::at(angle, speed_, 0.0);
    if (current != nullptr) {
      in.force_current[0] = {current[0], current[1]};
      in.force_current[1] = {current[2], current[3]};
    }
    Eigen::VectorXd rate = Eigen::VectorXd::Zero(n_);
    machine_.derivatives(in, y.data(), rate.data());
    return rate;
  }
  /// Displacements of the ends in their bearings.
  Eigen::Vector4d places(const Eigen::VectorXd& y) {
    static const int free[2] = {0, 0};
    Inputs<double> in = in_;
    in.contact_mode = free;
    Observation<double> seen;
    machine_.observe(in, y.data(), nullptr, seen);
    Eigen::Vector4d out;
    for (int e = 0; e < 2; ++e) {
      out[2 * e] = seen.aux_position[e].x - seen.contact[e].centre.x;
      out[2 * e + 1] = seen.aux_position[e].y - seen.contact[e].centre.y;
    }
    return out;
  }

  void probe() {
    const Eigen::VectorXd zero = Eigen::VectorXd::Zero(n_);
    const Eigen::VectorXd f0 = rates(zero, 0.0, nullptr);
    constant_ = 0.5 * (f0 + rates(zero, pi, nullptr));
    cosine_ = f0 - constant_;
    sine_ = rates(zero, 0.5 * pi, nullptr) - constant_;
    system_.a.resize(n_, n_);
    Eigen::MatrixXd c(4, n_);
    place0_ = places(zero);
    for (int j = 0; j < n_; ++j) {
      Eigen::VectorXd y = zero;
      y[j] = 1.0;
      system_.a.col(j) = rates(y, 0.0, nullptr) - f0;
      c.col(j) = places(y) - place0_;
    }
    by_current_.resize(n_, 4);
    for (int a = 0; a < 4; ++a) {
      double current[4] = {0.0, 0.0, 0.0, 0.0};
      current[a] = 1.0;
      by_current_.col(a) = rates(zero, 0.0, current) - f0;
    }
    driven_ = by_current_.cwiseAbs().maxCoeff() > 0.0;
    if (speed_ == 0.0) {  // the angle stands still: its forces are constant, and known when the angle is
      if (cosine_.norm() + sine_.norm() > 0.0) reason_ = "unbalance at rest";
      cosine_.setZero();
      sine_.setZero();
    }
    system_.c.resize(8, n_);
    for (int e = 0; e < 2; ++e) {
      system_.c.middleRows(4 * e, 2) = c.middleRows(2 * e, 2);
      system_.c.middleRows(4 * e + 2, 2) =
          c.middleRows(2 * e, 2) * system_.a;  // a place's rate is a velocity state
    }
    if (!reason_.empty()) return;
    probeContacts();
    if (reason_.empty()) check();
  }

  /// The columns of B, from forces in two directions.
  void probeContacts() {
    system_.b.resize(n_, 4);
    const double far = 2.0 * machine_.rig().auxiliary_bearing.clearance_m + place0_.cwiseAbs().maxCoeff();
    const int modes = machine_.rotor().modes();
    for (int e = 0; e < 2; ++e) {
      Eigen::MatrixXd effect(n_, 2);
      Eigen::Matrix2d force;
      for (int i = 0; i < 2; ++i) {
        Eigen::VectorXd y = Eigen::VectorXd::Zero(n_);
        y[i * modes] = far;
        Vec2<double> acting;
        effect.col(i) = contactEffect(e, y, acting);
        force(0, i) = acting.x;
        force(1, i) = acting.y;
      }
      if (!(std::abs(force.determinant()) > 0.0)) {
        reason_ = "no contact force to be seen";
        return;
      }
      system_.b.middleCols(2 * e, 2) = effect * force.inverse();
    }
  }
  Eigen::VectorXd contactEffect(int end, const Eigen::VectorXd& y, Vec2<double>& force) {
    const int mode[2] = {end == 0, end == 1};
    Inputs<double> in = in_;
    in.contact_mode = mode;
    Eigen::VectorXd rate = Eigen::VectorXd::Zero(n_);
    machine_.derivatives(in, y.data(), rate.data());
    Contact<double> contact[2];
    machine_.contacts(in, y.data(), contact);
    force = contact[end].force;
    return rate - rates(y, 0.0, nullptr);
  }

  void fail(const char* what) {
    if (reason_.empty()) reason_ = std::string(what) + " not linear in the state";
  }
  /// The linear equations against the machine's own at random states, in and out of contact.
  void check() {
    Spread spread;
    const int rotor = machine_.coordinates();
    const double clearance = machine_.rig().auxiliary_bearing.clearance_m;
    for (int trial = 0; trial < 4; ++trial) {
      Eigen::VectorXd y(n_);
      for (int i = 0; i < n_; ++i) y[i] = spread.next() * (i < rotor ? 0.5 * clearance : 100.0 * clearance);
      double current[4];
      for (double& c : current) c = 0.5 * spread.next();
      const double angle = pi * spread.next();
      const Eigen::VectorXd seen = rates(y, angle, current);
      const Eigen::Map<Eigen::Vector4d> i(current);
      const Eigen::VectorXd forces =
          constant_ + std::cos(angle) * cosine_ + std::sin(angle) * sine_ + by_current_ * i;
      const Eigen::VectorXd misfit = seen - system_.a * y - forces;
      const Eigen::VectorXd terms = system_.a.cwiseAbs() * y.cwiseAbs() + constant_.cwiseAbs() +
                                    cosine_.cwiseAbs() + sine_.cwiseAbs() +
                                    by_current_.cwiseAbs() * i.cwiseAbs();
      if (!(misfit.array().abs() <= largest_probe_misfit * terms.array() + 1e-300).all()) fail("rates are");
      const Eigen::Vector4d place = places(y) - place0_;
      for (int e = 0; e < 2; ++e) {
        const Eigen::VectorXd w = system_.c.middleRows(4 * e, 4) * y;
        for (int axis = 0; axis < 2; ++axis)
          if (!(std::abs(place[2 * e + axis] - w[axis]) <= largest_probe_misfit * clearance))
            fail("contacts' places are");
        const double at[4] = {w[0] + place0_[2 * e], w[1] + place0_[2 * e + 1], w[2], w[3]};
        double depth, rate;
        machine_.approach(e, y.data(), depth, rate);
        const double distance = std::hypot(at[0], at[1]);
        if (!(std::abs(distance - clearance - depth) <= largest_probe_misfit * clearance) ||
            !(std::abs((at[0] * at[2] + at[1] * at[3]) / distance - rate) <= 1e-7 * 100.0 * clearance))
          fail("contacts' velocities are");
        y[0] += 3.0 * clearance;  // into contact
        Vec2<double> force;
        const Eigen::VectorXd effect = contactEffect(e, y, force);
        const Eigen::VectorXd moved = system_.c.middleRows(4 * e, 4) * y;
        const double inside[4] = {moved[0] + place0_[2 * e], moved[1] + place0_[2 * e + 1], moved[2],
                                  moved[3]};
        double u[2];
        this->force(e, inside, u);
        const double size = std::hypot(force.x, force.y);
        if (size > 0.0 && !(std::hypot(u[0] - force.x, u[1] - force.y) <= 1e-7 * size))
          fail("contact forces are");
        const Eigen::VectorXd expected = system_.b.middleCols(2 * e, 2) * Eigen::Vector2d(force.x, force.y);
        if (!((effect - expected).norm() <= 1e-7 * (1.0 + expected.norm()))) fail("contacts' effects are");
        y[0] -= 3.0 * clearance;
      }
    }
    // neither forces nor contact move a place at once
    if ((system_.c.topRows(2) * system_.b).norm() + (system_.c.middleRows(4, 2) * system_.b).norm() > 0.0 ||
        (system_.c.topRows(2) * constant_).norm() + (system_.c.topRows(2) * cosine_).norm() > 0.0)
      fail("places are");
  }

  void prepareDrive() {
    const Eigen::MatrixXd& modal = flow_->toModal();
    const int size = flow_->size(), zeros = size - 2 * flow_->modes();
    flow_->rest(modal * constant_, rest_, drift_);
    rest_current_.setZero(size, 4);
    decay_current_.setZero(size, 4);
    drift_current_.setZero(zeros, 4);
    const double rate = driven_ ? CurrentTrack<double>(machine_).amplifier().rate() : 0.0;
    for (int a = 0; a < 4 && driven_; ++a) {
      const Eigen::VectorXd g = modal * by_current_.col(a);
      Eigen::VectorXd s, d;
      flow_->rest(g, s, d);
      rest_current_.col(a) = s;
      drift_current_.col(a) = d;
      decay_current_.col(a) = flow_->decaying(g, rate);
    }
    ContactFlow::Drive& drive = contact_->drive;
    drive.rate = rate;
    drive.place = Eigen::VectorXd::Zero(8);
    for (int e = 0; e < 2; ++e) drive.place.segment(4 * e, 2) = place0_.segment(2 * e, 2);
    if (speed_ != 0.0) flow_->harmonic(modal * cosine_, modal * sine_, speed_, drive.cosine, drive.sine);
    whole_.setZero(size);
    own_ = kept_ = whole_;
    written_.setConstant(n_, std::nan(""));
    event_.setZero(n_);
  }

  const Machine<double>& machine_;
  int n_;
  double speed_;
  Inputs<double> in_, law_;
  const int carries_[2] = {1, 1};
  std::string reason_;
  LinearSystem system_;
  Eigen::Vector4d place0_;
  Eigen::VectorXd constant_, cosine_, sine_;
  Eigen::MatrixXd by_current_;
  bool driven_ = false;
  std::unique_ptr<LinearFlow> flow_;
  std::unique_ptr<ContactFlow> contact_;
  Eigen::VectorXd rest_, drift_;
  Eigen::MatrixXd rest_current_, drift_current_, decay_current_;
  Eigen::VectorXd whole_, own_, kept_, written_, event_;
};

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
  general_.setContactObserver(observer);
  observer_ = std::move(observer);
}

IntegratorStatistics ModalStepper::statistics() const {
  IntegratorStatistics sum = general_.statistics();
  for (const auto& linear : known_) {
    if (linear == nullptr || linear->statistics() == nullptr) continue;
    const IntegratorStatistics& own = *linear->statistics();
    sum.steps += own.steps;
    sum.rejected += own.rejected;
    sum.evaluations += own.evaluations;
    sum.events += own.events;
  }
  return sum;
}

ModalStepper::Linear* ModalStepper::linearFor(const Simulator<double>& sim, double from, double to,
                                              const Simulator<double>::Held& held) {
  reason_ = fixed_reason_;
  if (!reason_.empty()) return nullptr;
  const Schedule* schedule = sim.drive().schedule;
  if (schedule != nullptr && !(schedule->forcePlanes().empty() && schedule->unbalances().empty()))
    reason_ = "a schedule has forces";
  const Shaft<double> start = sim.drive().shaft(from), end = sim.drive().shaft(to);
  const double middle = sim.drive().shaft(0.5 * (from + to)).speed;
  if (start.acceleration != 0.0 || end.acceleration != 0.0 || start.speed != end.speed ||
      middle != start.speed)
    reason_ = "the speed changes";
  if (!reason_.empty()) return nullptr;
  for (int i = 0; i < 2; ++i)
    if (known_[i] != nullptr && known_[i]->serves(held.bearing_on, start.speed)) {
      last_ = i;
      reason_ = known_[i]->reason();
      return reason_.empty() ? known_[i].get() : nullptr;
    }
  last_ = 1 - last_;
  known_[last_] = std::make_unique<Linear>(machine_, held.bearing_on, start.speed, tolerance_);
  reason_ = known_[last_]->reason();
  return reason_.empty() ? known_[last_].get() : nullptr;
}

bool ModalStepper::advance(const Simulator<double>& sim, double from, double to, MachineState<double>& state,
                           const Simulator<double>::Held& held) {
  Linear* linear = linearFor(sim, from, to, held);
  if (linear == nullptr) {
    const bool done = general_.advance(sim, from, to, state, held);
    result_ = general_.result();
    return done;
  }
  const double angle = sim.drive().shaft(from).angle;
  result_.status = linear->advance(from, to - from, angle, held.target, state.current, state, observer_);
  result_.time = to;
  if (result_.status != IntegrationStatus::ok) return false;
  const auto& track = sim.track();
  track.move(track.decay(to - from), held.target, state.current, state.lag.data());
  return true;
}

}  // namespace amb_rotor
