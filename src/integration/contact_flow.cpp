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

double norm(const double* at) { return std::sqrt(at[0] * at[0] + at[1] * at[1]); }

/// Products with 0 are 0 but for infinities and what is no number: without a branch each.
bool allFinite(const double* s, int size) {
  double sum[4] = {};
  int i = 0;
  for (; i + 4 <= size; i += 4)
    for (int k = 0; k < 4; ++k) sum[k] += 0.0 * s[i + k];
  for (; i < size; ++i) sum[0] += 0.0 * s[i];
  return sum[0] + sum[1] + sum[2] + sum[3] == 0.0;
}

/// Whether a guard is the depth's and not the force's.
bool ofDepth(double guard, double depth) {
  return std::abs(std::abs(guard) - std::abs(depth)) <= 1e-6 * std::abs(depth) + 1e-18;
}

}  // namespace

ContactFlow::ContactFlow(const LinearFlow& flow, const EndContacts& contacts, const Options& options)
    : flow_(flow), contacts_(contacts), options_(options) {
  AMB_ROTOR_CHECK(flow.outputs() == rows && flow.inputs() >= end_inputs,
                  "four outputs and two forces an end");
  for (auto& table : table_) table = flow.emptyTable();
  const int size = flow.size(), modes = flow.modes();
  own_real_.setZero(modes);
  own_imaginary_.setZero(modes);
  span_real_.setZero(modes);
  span_imaginary_.setZero(modes);
  moved_.setZero(std::max(size, rows));
  kept_.setZero();
  parts_.setZero(3 * rows);
  free_.setZero((points + 1) * rows);
  w_.setZero((points + 1) * rows);
  start_w_.setZero(rows);
  u_.setZero(flow.inputs() * points);
  last_u_ = evaluated_ = u_;
  pushed_.setZero(flow.inputs() - end_inputs);
  before_ = w_;
  const AlignedMatrix& c = flow.outputMatrix();
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
  pole_size_ = flow.eigenvalues().cwiseAbs();
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
  const AlignedMatrix& c = flow_.outputMatrix();
  rest_output_ = c * drive_.rest + drive_.place;
  rest_outputs_ = c * drive_.rest_by;
  decay_outputs_ = c * drive_.decay_by;
  kept_.col(1) = c * drive_.cosine;
  kept_.col(2) = c * drive_.sine;
  rest_now_ = drive_.rest;
  drift_now_ = drive_.drift;
  drift_later_.noalias() = flow_.chain() * drift_now_;
  decay_now_.setZero(flow_.size());
  exact_.time = -1.0;
}

void ContactFlow::begin(double angle, const double* held, const double* excess, const Pushes* pushes) {
  angle_ = angle;
  ++interval_;
  phase_.time = exact_.time = -1.0;
  pushes_ = pushes;
  if (pushes == nullptr) u_.tail((flow_.inputs() - end_inputs) * points).setZero();
  const Eigen::Map<const Eigen::VectorXd> hold(held, drive_.rest_by.cols()),
      over(excess, drive_.decay_by.cols());
  rest_now_ = drive_.rest;
  product(drive_.rest_by.data(), flow_.size(), hold.size(), held, rest_now_.data(), true);
  product(drive_.decay_by.data(), flow_.size(), over.size(), excess, decay_now_.data(), false);
  kept_.col(0) = rest_output_;
  kept_.col(0).noalias() += rest_outputs_ * hold;
  kept_.col(3).noalias() = decay_outputs_ * over;
  const int zeros = static_cast<int>(drive_.drift.size());
  if (zeros == 0) return;
  const AlignedMatrix& c = flow_.outputMatrix();
  drift_now_ = drive_.drift;
  drift_now_.noalias() += drive_.drift_by * hold;
  drift_later_.noalias() = flow_.chain() * drift_now_;
  kept_.col(4).noalias() = c.rightCols(zeros) * drift_now_;
  kept_.col(5).noalias() = c.rightCols(zeros) * (0.5 * drift_later_);
}

const LinearFlow::Table& ContactFlow::ladder(int level) {
  LinearFlow::Table& table = table_[level];
  if (table.h < 0.0) flow_.build(options_.longest_step / (1 << level), table);
  return table;
}

/// A step of a length of its own.
const LinearFlow::Table& ContactFlow::ownTable(double h) {
  for (int i = 0; i < kept_own; ++i)
    if (std::abs(table_[levels + i].h - h) <= 1e-15) return table_[levels + i];
  LinearFlow::Table& table = table_[levels + next_own_];
  next_own_ = (next_own_ + 1) % kept_own;
  flow_.build(h, table);
  return table;
}

ContactFlow::Phase ContactFlow::phaseOf(double time) const {
  const double angle = angle_ + drive_.speed * time;
  return {time, std::cos(angle), std::sin(angle), drive_.rate > 0.0 ? std::exp(-drive_.rate * time) : 0.0};
}

/// Kept: a step begins where the last one ended, and is taken again where it does not do.
const ContactFlow::Phase& ContactFlow::phaseAt(double time) {
  if (phase_.time != time) phase_ = phaseOf(time);
  return phase_;
}

/// Kept: an interval's start and end are asked for several times.
const ContactFlow::Phase& ContactFlow::exactPhase(double time) const {
  if (exact_.time != time) exact_ = phaseOf(time);
  return exact_;
}

void ContactFlow::keptUp(double time, double* w) const {
  const Phase& now = exactPhase(time);
  for (int o = 0; o < rows; ++o)
    w[o] = kept_(o, 0) + now.cosine * kept_(o, 1) + now.sine * kept_(o, 2) + now.decay * kept_(o, 3);
}

void ContactFlow::outputs(const double* s, double* w) const {
  product(flow_.outputMatrix().data(), rows, flow_.size(), s, w, false);
}

void ContactFlow::whole(double time, const Eigen::VectorXd& own, Eigen::VectorXd& out) const {
  const Phase& now = exactPhase(time);
  out = own + rest_now_ + now.cosine * drive_.cosine + now.sine * drive_.sine + now.decay * decay_now_;
}

void ContactFlow::own(double time, const Eigen::VectorXd& whole, Eigen::VectorXd& out) const {
  const Phase& now = exactPhase(time);
  out = whole - rest_now_ - now.cosine * drive_.cosine - now.sine * drive_.sine - now.decay * decay_now_;
}

double ContactFlow::guard(int end, const double* w, int mode, double* u) const {
  const double* at = w + per_end * end;
  u[0] = u[1] = 0.0;
  if (mode == 0) {
    const double gap = options_.clearance - norm(at);
    if (gap > 0.0) return gap;
    double unused[2];
    EndContacts::Normal none;
    return -contacts_.force(end, at, unused, none);
  }
  EndContacts::Normal none;
  return contacts_.force(end, at, u, none);
}

void ContactFlow::bounds(const double* s, double horizon, double speed[ends], double acceleration[ends]) const {
  using OfEnds = Eigen::Matrix<double, ends, 1>;
  const int modes = flow_.modes(), zeros = flow_.size() - 2 * modes;
  OfEnds fast = OfEnds::Zero(), bent = OfEnds::Zero();
  const auto add = [&](int k, double factor) {
    const OfEnds part = speed_weight_.col(k).head<ends>() * (factor * (std::abs(s[k]) + std::abs(s[modes + k])));
    fast += part;
    bent += pole_size_[k] * part;
  };
  for (int k = 0; k < modes; ++k) add(k, 1.0);
  for (int k : growing_) add(k, std::expm1(flow_.eigenvalues()[k].real() * horizon));
  const double* z = s + 2 * modes;
  for (int end = 0; end < ends; ++end) {
    speed[end] = fast[end];
    acceleration[end] = bent[end];
    // a drift is even or evenly accelerated
    const int vx = per_end * end + 2;
    double drifting[2] = {0.0, 0.0}, change[2] = {0.0, 0.0};
    for (int i = 0; i < zeros; ++i) {
      double rate = drift_now_[i];
      for (int j = 0; j < zeros; ++j) rate += flow_.chain()(i, j) * z[j];
      for (int axis = 0; axis < 2; ++axis) {
        const double c = flow_.outputMatrix()(vx + axis, 2 * modes + i);
        drifting[axis] += c * z[i];
        change[axis] += c * rate;
      }
    }
    if (zeros > 0) {
      const double even = norm(change);
      speed[end] += norm(drifting) + horizon * even;
      acceleration[end] += even;
    }
    const double rates[] = {drive_.speed, drive_.speed, drive_.rate};
    for (int k = 0; k < 3; ++k) {
      const double part = norm(&kept_(vx, k + 1));
      speed[end] += part;
      acceleration[end] += std::abs(rates[k]) * part;
    }
  }
}

/// Time within which an end stays inside, up to `most`: |x(t)| <= |x + v t| + A t^2/2 = f(t), which is convex, so that its chords
/// to where it is outside are above it.
double ContactFlow::staysInside(const double* at, double acceleration, double most) const {
  constexpr int chords = 4;
  const auto f = [&](double t) {
    const double to[2] = {at[0] + t * at[2], at[1] + t * at[3]};
    return norm(to) + 0.5 * acceleration * t * t;
  };
  double low = 0.0, f_low = norm(at), high = most, f_high = f(most);
  if (f_high <= options_.clearance) return most;
  for (int i = 0; i < chords && f_low < options_.clearance; ++i) {
    low += (high - low) * (options_.clearance - f_low) / (f_high - f_low);
    f_low = f(low);
    const double middle = 0.5 * (low + high), f_middle = f(middle);
    if (f_middle > options_.clearance) high = middle, f_high = f_middle;
  }
  return low;
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
    double step = span - passed, bound[ends], acceleration[ends];
    const double horizon = std::min(step, 1e-3);
    bounds(at, horizon, bound, acceleration);
    for (int e = 0; e < ends; ++e) {
      const double left = span - passed;
      if (!(g[e] < bound[e] * left)) continue;
      // the bounds hold up to the horizon
      const double inside = std::max(g[e] / bound[e], staysInside(w + per_end * e, acceleration[e], horizon));
      step = std::min({step, horizon, std::max(shortest_look_s, inside)});
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
  for (int i = 0; i < zeros; ++i) z[i] += t * (drift_now_[i] + 0.5 * t * drift_later_[i]);
}

ContactFlow::Depth ContactFlow::depth(int end, const double* w) const {
  const double* at = w + per_end * end;
  const double distance = norm(at);
  return {distance - options_.clearance, (at[0] * at[2] + at[1] * at[3]) / distance};
}

/// Root of a guard that is g at t, by the depth's rate where it is the depth that ends the mode.
double ContactFlow::newton(int end, const double* w, double t, double g) const {
  const Depth now = depth(end, w);
  return ofDepth(g, now.value) ? t - now.value / now.rate : -1.0;
}

/// Where to look first: by depths and rates where it is the depth that ends the mode (a cubic polynomial of
/// the time by the depth), else on the guards' chord.
double ContactFlow::Change::first() const {
  const double length = high - low, rise = high_depth.value - low_depth.value, u = -low_depth.value / rise,
               v = 1.0 - u;
  const double t =
      low + u * u * (3.0 - 2.0 * u) * length + u * v * rise * (v / low_depth.rate - u / high_depth.rate);
  const bool usable = ofDepth(low_guard, low_depth.value) && ofDepth(high_guard, high_depth.value) &&
                      low_depth.rate * rise > 0.0 && high_depth.rate * rise > 0.0 && t > low && t < high;
  return usable ? t : low + length * low_guard / (low_guard - high_guard);
}

/// Looks at the nodes and the end; what was there before the first is asked only where it matters.
bool ContactFlow::findEvent(double time, double h, const double* s, const int* mode, Change& change) {
  const double* x = LinearFlow::abscissae();
  double unused[2], w[rows];
  const auto see = [&](int i, int e) {
    for (int o = per_end * e; o < per_end * (e + 1); ++o) w[o] = w_[rowOf(o, i)];
  };
  const auto guardAt = [&](int i, int e) {
    if (mode[e] != 0 && i < points) return nodes_->guard[e * points + i];
    see(i, e);
    return guard(e, w, mode[e], unused);
  };
  for (int i = 0; i <= points; ++i) {
    for (int e = 0; e < ends; ++e) {
      change.high_guard = guardAt(i, e);
      if (!(change.high_guard < -threshold())) continue;
      change.end = e;
      change.high = (i < points ? x[i] : 1.0) * h;
      see(i, e);
      change.high_depth = depth(e, w);
      if (i > 0) {
        change.low = x[i - 1] * h;
        change.low_guard = guardAt(i - 1, e);
        see(i - 1, e);
      } else {
        double kept[rows];
        outputs(s, w);
        keptUp(time, kept);
        for (int o = 0; o < rows; ++o) w[o] += kept[o];
        change.low_guard = guard(e, w, mode[e], unused);
      }
      change.low_depth = depth(e, w);
      change.low_guard = std::max(0.0, change.low_guard);
      return true;
    }
  }
  return false;
}

/// Repeats a step up to the event: the table of that part, whose forces are in u_; null: it cannot be solved.
const LinearFlow::Table* ContactFlow::toEvent(double time, const double* s, const int* mode, Change change) {
  double unused[2];
  const auto between = [&] {
    return change.low + (change.high - change.low) * change.low_guard / (change.low_guard - change.high_guard);
  };
  double t = change.first();
  const LinearFlow::Table* part = nullptr;
  for (int pass = 0; pass < 30; ++pass) {
    if (!(t > 0.0)) t = 0.5 * change.high;
    part = &ownTable(t);
    if (!solve(*part, time, s, mode)) return nullptr;
    const double* at = &w_[points * rows];
    const double g = guard(change.end, at, mode[change.end], unused);
    if (std::abs(g) <= threshold() || change.high - change.low < 1e-15) return part;
    const double next = newton(change.end, at, t, g);
    if (g > 0.0) {
      change.low = t, change.low_guard = g;
    } else {
      change.high = t, change.high_guard = g;
    }
    t = next > change.low && next < change.high ? next : between();
    if (pass > 6 && pass % 3 == 0) t = 0.5 * (change.low + change.high);
  }
  return part;
}

IntegrationStatus ContactFlow::advance(double length, double* s, int* mode, const Observer& onEvent) {
  double time = 0.0;
  long events = 0, steps = 0;
  const auto changed = [&](int end) {
    mode[end] = 1 - mode[end];
    last_h_ = 0.0;
    last_ended_ = false;
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
    const bool last = rung > left + 1e-15;
    const LinearFlow::Table& table = last ? ownTable(left) : ladder(level_);
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
        return allFinite(s, flow_.size()) ? IntegrationStatus::step_too_small : IntegrationStatus::not_finite;
      }
      continue;
    }
    Change change;
    if (findEvent(time, h, s, mode, change)) {
      last_h_ = h;
      last_u_ = u_;
      last_ended_ = false;
      if (change.high > 1e-13) {
        const LinearFlow::Table* const part = toEvent(time, s, mode, change);
        if (part == nullptr) return IntegrationStatus::step_too_small;
        take(*part, s);
        time += part->h;
        ++statistics_.steps;
      }
      ++events;
      changed(change.end);
      continue;
    }
    take(table, s);
    phase_ = phaseAt(time).turned(turnOf(table), points, h);
    time = phase_.time = last ? length : time + h;
    ++statistics_.steps;
    if (fresh_) first_level_ = level_;
    fresh_ = false;
    earlier_h_ = last_ended_ ? last_h_ : 0.0;
    for (int i = 0; i < end_inputs; ++i) earlier_u_[i] = last_u_[LinearFlow::column(i, points - 1)];
    last_h_ = h;
    last_u_ = u_;
    last_ended_ = true;
    if (!last && level_ > 0 && size < grow_below) --level_;
  }
  return allFinite(s, flow_.size()) ? IntegrationStatus::ok : IntegrationStatus::not_finite;
}

}  // namespace amb_rotor
