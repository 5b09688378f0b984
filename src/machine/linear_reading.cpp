#include "linear_reading.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "amb_rotor/common/units.hpp"
#include "amb_rotor/machine/assembly.hpp"

namespace amb_rotor {
namespace {

/// Misfit of the linear equations at random states that counts as nonlinear, of the size of their terms:
/// round-off is a thousand times smaller, the weakest effect of the catalogue at its weakest a thousand times
/// larger.
constexpr double largest_probe_misfit = 1e-9;

/// Share of the largest entry of a row below which another is round-off.
constexpr double cancelled_share = 1e-15;

/// Times of a run that are tried lie between 0 and twice this.
constexpr double latest_probe_s = 5.0;

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

LinearReading::LinearReading(const Machine<double>& machine, const Schedule* schedule,
                             const Vec2<double> bearing_on[2], double speed)
    : machine_(machine), n_(machine.stateSize()), speed_(speed), schedule_(schedule) {
  in_.bearing_on[0] = bearing_on[0];
  in_.bearing_on[1] = bearing_on[1];
  in_.shaft = Shaft<double>::at(0.0, speed, 0.0);
  law_ = in_;
  law_.contact_mode = carries_;
  probe();
  if (reason_.empty()) recogniseLaw();
}

double LinearReading::general(int end, const double* w, double* u, Normal& normal) const {
  const Vec2<double> none;
  const Contact<double> c =
      machine_.contactAt(end, {w[0], w[1]}, {w[2], w[3]}, law_.shaft, none, none, 0.0, law_);
  // continued smoothly to where the law would pull: the event is found there
  const double tangential = c.normal_force * coulombFactor(c.friction_coefficient, c.slip);
  u[0] = -c.normal_force * c.normal.x - tangential * c.normal.y;
  u[1] = -c.normal_force * c.normal.y + tangential * c.normal.x;
  normal = {c.normal_force, c.slope, c.damping, c.normal.x, c.normal.y};
  return std::min(c.penetration, c.margin);
}

/// Rates at a state, an angle, currents and a time, without contact.
Eigen::VectorXd LinearReading::rates(const Eigen::VectorXd& y, double angle, const double* current,
                                     const Vec2<double>* force, const double* unbalance, double time_s) {
  static const int free[2] = {0, 0};
  Inputs<double> in = in_;
  in.extra_force = force;
  in.extra_unbalance = unbalance;
  in.contact_mode = free;
  in.shaft = Shaft<double>::at(angle, speed_, 0.0);
  in.shaft.time = time_s;
  if (current != nullptr) {
    in.force_current[0] = {current[0], current[1]};
    in.force_current[1] = {current[2], current[3]};
  }
  Eigen::VectorXd rate = Eigen::VectorXd::Zero(n_);
  machine_.derivatives(in, y.data(), rate.data());
  return rate;
}

LinearReading::View LinearReading::view(const Eigen::VectorXd& y, double angle, const double* current) {
  static const int free[2] = {0, 0};
  Inputs<double> in = in_;
  in.contact_mode = free;
  in.shaft = Shaft<double>::at(angle, speed_, 0.0);
  if (current != nullptr) {
    in.force_current[0] = {current[0], current[1]};
    in.force_current[1] = {current[2], current[3]};
  }
  Observation<double> seen;
  machine_.observe(in, y.data(), nullptr, seen);
  View out;
  for (int e = 0; e < 2; ++e) {
    const Vec2<double> of_end[] = {seen.sensor_position[e],
                                   seen.amb_position[e],
                                   machine_.rotor().at(plane_amb + e, y.data()),
                                   machine_.rotor().at(plane_sensor + e, y.data()),
                                   seen.aux_position[e],
                                   seen.contact[e].centre,
                                   seen.bearing_force[e]};
    int row = 2 * e;
    for (const Vec2<double>& value : of_end) {
      out[row] = value.x;
      out[row + 1] = value.y;
      row += 4;
    }
  }
  return out;
}

void LinearReading::probe() {
  const Eigen::VectorXd zero = Eigen::VectorXd::Zero(n_);
  const Eigen::VectorXd f0 = rates(zero, 0.0, nullptr);
  constant_ = 0.5 * (f0 + rates(zero, pi, nullptr));
  cosine_ = f0 - constant_;
  sine_ = rates(zero, 0.5 * pi, nullptr) - constant_;
  system_.a.resize(n_, n_);
  view_.resize(view_rows, n_);
  view0_ = view(zero);
  place0_ = places(view0_);
  for (int j = 0; j < n_; ++j) {
    Eigen::VectorXd y = zero;
    y[j] = 1.0;
    view_.col(j) = view(y) - view0_;
    system_.a.col(j) = rates(y, 0.0, nullptr) - f0;
  }
  // what is left where terms cancel is none: balancing would blow it up to the size of the others
  for (int i = 0; i < n_; ++i) {
    const double none = cancelled_share * system_.a.row(i).cwiseAbs().maxCoeff();
    for (int j = 0; j < n_; ++j)
      if (std::fabs(system_.a(i, j)) < none) system_.a(i, j) = 0.0;
  }
  by_current_.resize(n_, 4);
  for (int a = 0; a < 4; ++a) {
    double current[4] = {0.0, 0.0, 0.0, 0.0};
    current[a] = 1.0;
    by_current_.col(a) = rates(zero, 0.0, current) - f0;
    force_by_current_.col(a) = (view(zero, 0.0, current) - view0_).segment<4>(forces_from);
  }
  probeSchedule(f0);
  driven_ = by_current_.cwiseAbs().maxCoeff() > 0.0;
  if (speed_ == 0.0) {  // the angle stands still: its forces are constant, and known when the angle is
    if (cosine_.norm() + sine_.norm() > 0.0) reason_ = "unbalance at rest";
    cosine_.setZero();
    sine_.setZero();
  }
  if (n_ == 4 * machine_.rotor().modes()) {
    const int modes = machine_.rotor().modes();
    for (int k = 0; k < modes; ++k)
      for (const int first : {0, 2 * modes}) system_.pairs.emplace_back(first + k, first + modes + k);
  }
  system_.c.resize(8, n_);
  for (int e = 0; e < 2; ++e) {
    const Eigen::MatrixXd place = view_.middleRows(ends_from + 2 * e, 2) - view_.middleRows(centres_from + 2 * e, 2);
    system_.c.middleRows(4 * e, 2) = place;
    system_.c.middleRows(4 * e + 2, 2) = place * system_.a;  // a place's rate is a velocity state
  }
  if (!reason_.empty()) return;
  probeContacts();
  if (reason_.empty()) check();
}

/// What forces and unbalances of the schedule do: columns of B behind those of the contacts, in pairs (x, y
/// of a force; cosine, sine of an unbalance).
void LinearReading::probeSchedule(const Eigen::VectorXd& f0) {
  if (schedule_ != nullptr) {
    forces_.resize(schedule_->forcePlanes().size());
    factors_.resize(schedule_->unbalances().size());
  }
  later_factors_ = drive_factors_ = factors_;
  const std::size_t forces = forces_.size(), unbalances = factors_.size();
  system_.b.setZero(n_, static_cast<Eigen::Index>(4 + 2 * (forces + unbalances)));
  const Eigen::VectorXd zero = Eigen::VectorXd::Zero(n_), f1 = rates(zero, 0.5 * pi, nullptr);
  Eigen::Index column = 4;
  for (std::size_t i = 0; i < forces; ++i)
    for (const Vec2<double>& unit : {Vec2<double>{1.0, 0.0}, Vec2<double>{0.0, 1.0}}) {
      std::vector<Vec2<double>> force(forces);
      force[i] = unit;
      system_.b.col(column++) = rates(zero, 0.0, nullptr, force.data()) - f0;
    }
  for (std::size_t i = 0; i < unbalances; ++i) {
    std::vector<double> factor(unbalances, 0.0);
    factor[i] = 1.0;
    system_.b.col(column++) = rates(zero, 0.0, nullptr, nullptr, factor.data()) - f0;
    system_.b.col(column++) = rates(zero, 0.5 * pi, nullptr, nullptr, factor.data()) - f1;
  }
}

/// The columns of B, from forces in two directions.
void LinearReading::probeContacts() {
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

Eigen::VectorXd LinearReading::contactEffect(int end, const Eigen::VectorXd& y, Vec2<double>& force) {
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

void LinearReading::fail(const char* what) {
  if (reason_.empty()) reason_ = std::string(what) + " not linear in the state";
}

/// What is seen at a state against its linear form.
void LinearReading::checkView(const View& seen, const Eigen::VectorXd& y, const Eigen::Vector4d& current) {
  const double largest = largest_probe_misfit * machine_.rig().auxiliary_bearing.clearance_m;
  View misfit = seen - view0_ - view_ * y, terms = view0_.cwiseAbs() + view_.cwiseAbs() * y.cwiseAbs();
  misfit.segment<4>(forces_from) -= force_by_current_ * current;
  terms.segment<4>(forces_from) += force_by_current_.cwiseAbs() * current.cwiseAbs();
  misfit = misfit.cwiseAbs();
  if (!(misfit.segment<4>(sensors_from).maxCoeff() <= largest)) fail("sensors' places are");
  if (!(misfit.segment<4>(magnets_from).maxCoeff() <= largest)) fail("magnets' places are");
  const View most = largest_probe_misfit * terms;
  for (int row = 0; row < view_rows; ++row) shown_ = shown_ && misfit[row] <= most[row] + 1e-300;
}

/// The linear equations against the machine's own at random states, in and out of contact.
void LinearReading::check() {
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
    if (rates(y, angle, current, nullptr, nullptr, latest_probe_s * (1.0 + spread.next())) != seen && reason_.empty())
      reason_ = "a force knows the time";
    const Eigen::Map<Eigen::Vector4d> i(current);
    const Eigen::VectorXd forces =
        constant_ + std::cos(angle) * cosine_ + std::sin(angle) * sine_ + by_current_ * i;
    const Eigen::VectorXd misfit = seen - system_.a * y - forces;
    const Eigen::VectorXd terms = system_.a.cwiseAbs() * y.cwiseAbs() + constant_.cwiseAbs() +
                                  cosine_.cwiseAbs() + sine_.cwiseAbs() +
                                  by_current_.cwiseAbs() * i.cwiseAbs();
    if (!(misfit.array().abs() <= largest_probe_misfit * terms.array() + 1e-300).all()) fail("rates are");
    const View now = view(y, angle, current);
    checkView(now, y, i);
    const Eigen::Vector4d place = places(now) - place0_;
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
      const double inside[4] = {moved[0] + place0_[2 * e], moved[1] + place0_[2 * e + 1], moved[2], moved[3]};
      double u[2];
      Normal normal;
      general(e, inside, u, normal);
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

/// The machine's law by its values at a depth; taken for one of the plain ones where it is that to round-off
/// at others, at both ends.
void LinearReading::recogniseLaw() {
  const auto& bearing = machine_.rig().auxiliary_bearing;
  const double clearance = bearing.clearance_m, depth = 0.01 * clearance;
  Normal at, moving;
  double u[2];
  const double still[4] = {clearance + depth, 0.0, 0.0, 0.0},
               inwards[4] = {clearance + depth, 0.0, 1e-3, 0.0};
  general(0, still, u, at);
  general(0, inwards, u, moving);
  PlainLaw law;
  law.clearance = clearance;
  law.surface_speed = bearing.rotor_radius_m * law_.shaft.speed;
  law.friction = bearing.friction_coefficient;
  for (const bool hertz : {false, true}) {
    law.hertz = hertz;
    law.stiffness = at.force / (hertz ? std::pow(depth, 1.5) : depth);
    law.compliance = 1.0 / law.stiffness;
    law.damping = hertz ? at.damping / at.force : at.damping;
    Spread spread;
    law.known = true;
    for (int trial = 0; trial < 32 && law.known; ++trial) {
      const double angle = pi * spread.next(), r = clearance + (0.05 + 0.05 * spread.next()) * clearance;
      // half of the trials slip next to nothing: friction may rise there
      const double back = trial % 4 < 2 ? 0.0 : law.surface_speed * (1.0 + 0.05 * spread.next());
      const double w[4] = {r * std::cos(angle), r * std::sin(angle), 0.2 * spread.next() + back * std::sin(angle),
                           0.2 * spread.next() - back * std::cos(angle)};
      double by_law[2], by_machine[2];
      Normal own, machines;
      const double guard = law.force(w, by_law, own), expected = general(trial % 2, w, by_machine, machines);
      const auto same = [](double a, double b, double size) {
        return std::abs(a - b) <= 1e-11 * std::abs(size);
      };
      const double size = machines.slope * clearance + machines.damping;
      law.known = same(by_law[0], by_machine[0], size) && same(by_law[1], by_machine[1], size) &&
                  same(own.slope, machines.slope, machines.slope) &&
                  std::abs(own.damping - machines.damping) <= 1e-11 * (machines.damping + 1.0) &&
                  same(guard, expected, clearance);
    }
    if (law.known) break;
  }
  plain_ = law;
}

}  // namespace amb_rotor
