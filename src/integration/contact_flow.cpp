#include "amb_rotor/integration/contact_flow.hpp"

#include <algorithm>
#include <cmath>

#include "amb_rotor/common/check.hpp"
#include "amb_rotor/integration/dense_products.hpp"

namespace amb_rotor {
namespace {

/// An error below this part of the tolerance lets the step be doubled: the estimate is of order 7.
constexpr double grow_below = 0.3 / 128.0;
/// Shortest look ahead in flight [s].
constexpr double shortest_look_s = 5e-7;

}  // namespace

ContactFlow::ContactFlow(const LinearFlow& flow, const EndContacts& contacts, const Options& options)
    : flow_(flow), contacts_(contacts), options_(options) {
  AMB_ROTOR_CHECK(flow.outputs() == rows && flow.inputs() >= end_inputs,
                  "four outputs and two forces an end");
  for (auto& table : table_) table = flow.emptyTable();
  own_ = flow.emptyTable();
  const int size = flow.size(), modes = flow.modes();
  own_real_.setZero(modes);
  own_imaginary_.setZero(modes);
  span_real_.setZero(modes);
  span_imaginary_.setZero(modes);
  moved_.setZero(std::max(size, rows));
  for (auto& k : kept_) k.setZero(rows);
  for (auto& d : drift_) d.setZero(rows);
  free_.setZero((points + 1) * rows);
  w_.setZero((points + 1) * rows);
  start_w_.setZero(rows);
  u_.setZero(flow.inputs() * points);
  last_u_ = evaluated_ = u_;
  pushed_.setZero(flow.inputs() - end_inputs);
  before_ = w_;
  guards_.setZero(points * ends);
  start_guards_.setZero(ends);
  const Eigen::MatrixXd& c = flow.outputMatrix();
  const int zeros = size - 2 * modes;
  speed_weight_.setZero(ends, modes);
  for (int e = 0; e < ends; ++e) {
    const int vx = per_end * e + 2, vy = vx + 1;
    for (int k = 0; k < modes; ++k)
      speed_weight_(e, k) = std::sqrt(c(vx, k) * c(vx, k) + c(vx, modes + k) * c(vx, modes + k) +
                                      c(vy, k) * c(vy, k) + c(vy, modes + k) * c(vy, modes + k));
  }
  for (int k = 0; k < modes; ++k)
    if (flow.eigenvalues()[k].real() > 0.0) growing_.push_back(k);
  Drive still;
  still.rest = still.cosine = still.sine = Eigen::VectorXd::Zero(size);
  still.drift.setZero(zeros);
  still.place.setZero(rows);
  still.rest_by.setZero(size, 0);
  still.decay_by.setZero(size, 0);
  still.drift_by.setZero(zeros, 0);
  setDrive(still);
}

void ContactFlow::setDrive(const Drive& drive) {
  drive_ = drive;
  for (Turn& turn : turn_) turn.h = -1.0;
  const Eigen::MatrixXd& c = flow_.outputMatrix();
  rest_output_ = c * drive_.rest + drive_.place;
  rest_outputs_ = c * drive_.rest_by;
  decay_outputs_ = c * drive_.decay_by;
  kept_[1] = c * drive_.cosine;
  kept_[2] = c * drive_.sine;
  rest_now_ = drive_.rest;
  drift_now_ = drive_.drift;
  decay_now_.setZero(flow_.size());
}

void ContactFlow::begin(double angle, const double* held, const double* excess, const Pushes* pushes) {
  angle_ = angle;
  pushes_ = pushes;
  if (pushes == nullptr) u_.tail((flow_.inputs() - end_inputs) * points).setZero();
  const Eigen::Map<const Eigen::VectorXd> hold(held, drive_.rest_by.cols()),
      over(excess, drive_.decay_by.cols());
  rest_now_ = drive_.rest;
  product(drive_.rest_by.data(), flow_.size(), hold.size(), held, rest_now_.data(), true);
  product(drive_.decay_by.data(), flow_.size(), over.size(), excess, decay_now_.data(), false);
  kept_[0] = rest_output_;
  kept_[0].noalias() += rest_outputs_ * hold;
  kept_[3].noalias() = decay_outputs_ * over;
  const int zeros = static_cast<int>(drive_.drift.size());
  if (zeros == 0) return;
  const Eigen::MatrixXd& c = flow_.outputMatrix();
  drift_now_ = drive_.drift;
  drift_now_.noalias() += drive_.drift_by * hold;
  drift_[0].noalias() = c.rightCols(zeros) * drift_now_;
  for (int o = 0; o < c.rows(); ++o) {
    double sum = 0.0;
    for (int i = 0; i < zeros; ++i)
      for (int j = 0; j < zeros; ++j)
        sum += c(o, 2 * flow_.modes() + i) * flow_.chain()(i, j) * drift_now_[j];
    drift_[1][o] = 0.5 * sum;
  }
}

const LinearFlow::Table& ContactFlow::ladder(int level) {
  LinearFlow::Table& table = table_[level];
  if (table.h < 0.0) flow_.build(options_.longest_step / (1 << level), table);
  return table;
}

void ContactFlow::keptUp(double time, double* w) const {
  const double angle = angle_ + drive_.speed * time, c = std::cos(angle), s = std::sin(angle),
               d = drive_.rate > 0.0 ? std::exp(-drive_.rate * time) : 0.0;
  for (int o = 0; o < rows; ++o) w[o] = kept_[0][o] + c * kept_[1][o] + s * kept_[2][o] + d * kept_[3][o];
}

void ContactFlow::outputs(const double* s, double* w) const {
  product(flow_.outputMatrix().data(), rows, flow_.size(), s, w, false);
}

void ContactFlow::whole(double time, const Eigen::VectorXd& own, Eigen::VectorXd& out) const {
  const double angle = angle_ + drive_.speed * time,
               d = drive_.rate > 0.0 ? std::exp(-drive_.rate * time) : 0.0;
  out = own + rest_now_ + std::cos(angle) * drive_.cosine + std::sin(angle) * drive_.sine + d * decay_now_;
}

void ContactFlow::own(double time, const Eigen::VectorXd& whole, Eigen::VectorXd& out) const {
  const double angle = angle_ + drive_.speed * time,
               d = drive_.rate > 0.0 ? std::exp(-drive_.rate * time) : 0.0;
  out = whole - rest_now_ - std::cos(angle) * drive_.cosine - std::sin(angle) * drive_.sine - d * decay_now_;
}

double ContactFlow::guard(int end, const double* w, int mode, double* u) const {
  const double* at = w + per_end * end;
  u[0] = u[1] = 0.0;
  if (mode == 0) {
    const double gap = options_.clearance - std::sqrt(at[0] * at[0] + at[1] * at[1]);
    if (gap > 0.0) return gap;
    double unused[2];
    EndContacts::Normal none;
    return -contacts_.force(end, at, unused, none);
  }
  EndContacts::Normal none;
  return contacts_.force(end, at, u, none);
}

void ContactFlow::speedBounds(const double* s, double horizon, double bound[ends]) const {
  const int modes = flow_.modes(), zeros = flow_.size() - 2 * modes;
  Eigen::Matrix<double, ends, 1> sum = Eigen::Matrix<double, ends, 1>::Zero();
  for (int k = 0; k < modes; ++k)
    sum += speed_weight_.col(k).head<ends>() * (std::abs(s[k]) + std::abs(s[modes + k]));
  for (int k : growing_)
    sum += speed_weight_.col(k).head<ends>() *
           ((std::abs(s[k]) + std::abs(s[modes + k])) * std::expm1(flow_.eigenvalues()[k].real() * horizon));
  const double* z = s + 2 * modes;
  for (int end = 0; end < ends; ++end) {
    bound[end] = sum[end];
    // a drift is even or evenly accelerated
    const int vx = per_end * end + 2;
    double speed[2] = {0.0, 0.0}, change[2] = {0.0, 0.0};
    for (int i = 0; i < zeros; ++i) {
      double rate = drift_now_[i];
      for (int j = 0; j < zeros; ++j) rate += flow_.chain()(i, j) * z[j];
      for (int axis = 0; axis < 2; ++axis) {
        const double c = flow_.outputMatrix()(vx + axis, 2 * modes + i);
        speed[axis] += c * z[i];
        change[axis] += c * rate;
      }
    }
    if (zeros > 0) bound[end] += std::hypot(speed[0], speed[1]) + horizon * std::hypot(change[0], change[1]);
    for (int k = 1; k < 4; ++k) bound[end] += std::hypot(kept_[k][vx], kept_[k][vx + 1]);
  }
}

bool ContactFlow::flight(double& time, double length, double* s, const int* mode, int& event_end) {
  const int size = flow_.size();
  const double span = length - time;
  double* w = start_w_.data();
  double u[2];
  double* at = moved_.data();  // s at `passed` seconds into the flight
  const auto see = [&](double passed) {
    std::copy(s, s + size, at);
    if (passed > 0.0) {
      const bool whole = passed == span;
      if (!whole || std::abs(span_ - span) > 1e-15) {
        double* real = whole ? span_real_.data() : own_real_.data();
        double* imaginary = whole ? span_imaginary_.data() : own_imaginary_.data();
        flow_.factors(passed, real, imaginary);
        if (whole) span_ = span;
      }
      flow_.move((whole ? span_real_ : own_real_).data(), (whole ? span_imaginary_ : own_imaginary_).data(),
                 passed, at);
      drift(passed, at);
    }
    outputs(at, w);
    double other[rows];
    keptUp(time + passed, other);
    for (int o = 0; o < rows; ++o) w[o] += other[o];
    ++statistics_.evaluations;
  };
  double passed = 0.0, before = 0.0;
  see(0.0);
  for (;;) {
    int touching = -1;
    double g[ends];
    for (int e = 0; e < ends; ++e) {
      g[e] = guard(e, w, mode[e], u);
      if (g[e] < -threshold()) touching = e;
    }
    if (touching >= 0) {
      if (passed == 0.0) {  // it carries from the start
        event_end = touching;
        return true;
      }
      // Newton on the gap, kept between the last look and this one
      double low = before, high = passed, t = passed;
      for (int i = 0; i < 60; ++i) {
        see(t);
        const double* at_end = w + per_end * touching;
        const double distance = std::sqrt(at_end[0] * at_end[0] + at_end[1] * at_end[1]);
        const double depth = distance - options_.clearance;
        const double gap = guard(touching, w, 0, u);
        if (std::abs(gap) < threshold() || high - low < 1e-15) break;
        (gap > 0.0 ? low : high) = t;
        const double rate = (at_end[0] * at_end[2] + at_end[1] * at_end[3]) / distance;
        double next = t - depth / rate;
        if (!(next > low && next < high)) next = 0.5 * (low + high);
        t = next;
      }
      std::copy(at, at + size, s);
      time += t;
      event_end = touching;
      return true;
    }
    if (passed >= span) break;
    double step = span - passed, bound[ends];
    const double horizon = std::min(step, 1e-3);
    speedBounds(at, horizon, bound);
    for (int e = 0; e < ends; ++e) {
      step = std::min(step, std::max({shortest_look_s, g[e] / bound[e], 0.0}));
      if (g[e] < bound[e] * (span - passed)) step = std::min(step, horizon);  // the bound holds no longer
    }
    before = passed;
    passed = std::min(span, passed + step);
    if (span - passed < 1e-15) passed = span;
    see(passed);
  }
  std::copy(at, at + size, s);
  time = length;
  return false;
}

void ContactFlow::drift(double t, double* s) const {
  double* z = s + 2 * flow_.modes();
  const int zeros = static_cast<int>(drift_now_.size());
  for (int i = 0; i < zeros; ++i) {
    z[i] += t * drift_now_[i];
    for (int j = 0; j < zeros; ++j) z[i] += 0.5 * t * t * flow_.chain()(i, j) * drift_now_[j];
  }
}

/// Root of a guard that is g at t, by the depth's rate where it is the depth that ends the mode.
double ContactFlow::newton(int end, const double* w, double t, double g) const {
  const double* at = w + per_end * end;
  const double distance = std::sqrt(at[0] * at[0] + at[1] * at[1]), depth = distance - options_.clearance;
  if (std::abs(std::abs(g) - std::abs(depth)) > 1e-6 * std::abs(depth) + 1e-18) return -1.0;
  return t - depth * distance / (at[0] * at[2] + at[1] * at[3]);
}

bool ContactFlow::findEvent(double h, const int* mode, int& event_end, double& low, double& low_guard,
                            double& high, double& high_guard) {
  const double* x = LinearFlow::abscissae();
  double unused[2];
  for (int e = 0; e < ends; ++e) start_guards_[e] = std::max(0.0, guard(e, start_w_.data(), mode[e], unused));
  for (int i = 0; i <= points; ++i) {
    for (int e = 0; e < ends; ++e) {
      const double* w = &w_[i * rows];
      const double g = mode[e] != 0 && i < points ? guards_[i * ends + e] : guard(e, w, mode[e], unused);
      if (g < -threshold()) {
        event_end = e;
        low = i > 0 ? x[i - 1] * h : 0.0;
        low_guard = start_guards_[e];
        high = (i < points ? x[i] : 1.0) * h;
        high_guard = g;
        return true;
      }
    }
    for (int e = 0; e < ends; ++e) {
      const double* w = &w_[i * rows];
      start_guards_[e] =
          std::max(0.0, mode[e] != 0 && i < points ? guards_[i * ends + e] : guard(e, w, mode[e], unused));
    }
  }
  return false;
}

/// Repeats a step up to the event; true: own_ and u_ hold it.
bool ContactFlow::toEvent(double time, const double* s, const int* mode, int end, double low,
                          double low_guard, double high, double high_guard) {
  double unused[2];
  double t = low + (high - low) * low_guard / (low_guard - high_guard);
  for (int pass = 0; pass < 30; ++pass) {
    if (!(t > 0.0)) t = 0.5 * high;
    own_.h = -1.0;
    flow_.build(t, own_);
    if (!solve(own_, time, s, mode)) return false;
    const double g = guard(end, &w_[points * rows], mode[end], unused);
    if (std::abs(g) <= threshold() || high - low < 1e-15) return true;
    const double next = newton(end, &w_[points * rows], t, g);
    if (g > 0.0) {
      low = t, low_guard = g;
    } else {
      high = t, high_guard = g;
    }
    t = next > low && next < high ? next : low + (high - low) * low_guard / (low_guard - high_guard);
    if (pass > 6 && pass % 3 == 0) t = 0.5 * (low + high);
  }
  return true;
}

IntegrationStatus ContactFlow::advance(double length, double* s, int* mode, const Observer& onEvent) {
  double time = 0.0;
  long events = 0, steps = 0;
  const auto changed = [&](int end) {
    mode[end] = 1 - mode[end];
    last_h_ = 0.0;
    if (mode[end] != 0) {
      level_ = first_level_;
      fresh_ = true;
    }
    ++statistics_.events;
    if (onEvent) onEvent(end, time);
  };
  while (time < length - 1e-16) {
    if (++steps > 10'000'000) return IntegrationStatus::step_limit;
    if (events > 1'000'000) return IntegrationStatus::event_limit;
    bool carries = pushes_ != nullptr;
    for (int e = 0; e < ends; ++e) carries = carries || mode[e] != 0;
    int end = -1;
    if (!carries) {
      if (flight(time, length, s, mode, end)) {
        ++events;
        changed(end);
      }
      continue;
    }
    const double left = length - time, rung = options_.longest_step / (1 << level_);
    const bool own = rung > left + 1e-15;
    if (own && std::abs(own_.h - left) > 1e-15) flow_.build(left, own_);
    const LinearFlow::Table& table = own ? own_ : ladder(level_);
    const double h = table.h;
    const bool solved = solve(table, time, s, mode);
    const double size = solved ? error(table) : 2.0;
    if (!(size <= 1.0)) {
      ++statistics_.rejected;
      last_h_ = solved ? h : 0.0;
      last_u_ = u_;
      last_ended_ = false;
      do ++level_;
      while (level_ < levels && options_.longest_step / (1 << level_) > 0.51 * h);
      if (level_ >= levels) {
        level_ = levels - 1;
        for (int i = 0; i < flow_.size(); ++i)
          if (!std::isfinite(s[i])) return IntegrationStatus::not_finite;
        return IntegrationStatus::step_too_small;
      }
      continue;
    }
    outputs(s, start_w_.data());
    {
      double w[rows];
      keptUp(time, w);
      for (int o = 0; o < rows; ++o) start_w_[o] += w[o];
    }
    double low = 0.0, low_guard = 0.0, high = 0.0, high_guard = 0.0;
    if (findEvent(h, mode, end, low, low_guard, high, high_guard)) {
      last_h_ = h;
      last_u_ = u_;
      last_ended_ = false;
      if (high > 1e-13) {
        if (!toEvent(time, s, mode, end, low, low_guard, high, high_guard))
          return IntegrationStatus::step_too_small;
        take(own_, mode, s);
        time += own_.h;
        ++statistics_.steps;
      }
      ++events;
      changed(end);
      continue;
    }
    take(table, mode, s);
    time = own ? length : time + h;
    ++statistics_.steps;
    if (fresh_) first_level_ = level_;
    fresh_ = false;
    last_h_ = h;
    last_u_ = u_;
    last_ended_ = true;
    if (!own && level_ > 0 && size < grow_below) --level_;
  }
  for (int i = 0; i < flow_.size(); ++i)
    if (!std::isfinite(s[i])) return IntegrationStatus::not_finite;
  return IntegrationStatus::ok;
}

}  // namespace amb_rotor
