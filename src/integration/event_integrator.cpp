#include "amb_rotor/integration/event_integrator.hpp"

#include <algorithm>
#include <cmath>

#include "amb_rotor/common/check.hpp"

namespace amb_rotor {
namespace {

// Dormand-Prince 5(4)
constexpr double c2 = 1.0 / 5, c3 = 3.0 / 10, c4 = 4.0 / 5, c5 = 8.0 / 9;
constexpr double a21 = 1.0 / 5;
constexpr double a31 = 3.0 / 40, a32 = 9.0 / 40;
constexpr double a41 = 44.0 / 45, a42 = -56.0 / 15, a43 = 32.0 / 9;
constexpr double a51 = 19372.0 / 6561, a52 = -25360.0 / 2187, a53 = 64448.0 / 6561, a54 = -212.0 / 729;
constexpr double a61 = 9017.0 / 3168, a62 = -355.0 / 33, a63 = 46732.0 / 5247, a64 = 49.0 / 176,
                 a65 = -5103.0 / 18656;
constexpr double a71 = 35.0 / 384, a73 = 500.0 / 1113, a74 = 125.0 / 192, a75 = -2187.0 / 6784, a76 = 11.0 / 84;
constexpr double e1 = 71.0 / 57600, e3 = -71.0 / 16695, e4 = 71.0 / 1920, e5 = -17253.0 / 339200, e6 = 22.0 / 525,
                 e7 = -1.0 / 40;
constexpr double d1 = -12715105075.0 / 11282082432.0, d3 = 87487479700.0 / 32700410799.0,
                 d4 = -10690763975.0 / 1880347072.0, d5 = 701980252875.0 / 199316789632.0,
                 d6 = -1453857185.0 / 822651844.0, d7 = 69997945.0 / 29380423.0;

/// A step is searched for events in quarters.
constexpr int sample_points = 5;

}  // namespace

std::string IntegrationResult::reason() const {
  switch (status) {
    case IntegrationStatus::ok: return "ok";
    case IntegrationStatus::step_too_small: return "the step became too small (stiff or singular motion)";
    case IntegrationStatus::step_limit: return "too many steps";
    case IntegrationStatus::event_limit: return "too many events (chattering)";
    case IntegrationStatus::not_finite: return "the state became infinite or undefined";
  }
  return "unknown";
}

EventIntegrator::EventIntegrator(HybridSystem& system, IntegratorOptions options)
    : system_(system), options_(std::move(options)), n_(system.size()) {
  if (options_.absolute.empty()) options_.absolute.assign(n_, 1.0);
  AMB_ROTOR_CHECK(static_cast<int>(options_.absolute.size()) == n_, "one absolute scale for each state");
  for (auto& k : k_) k.assign(n_, 0.0);
  for (auto& d : dense_) d.assign(n_, 0.0);
  next_.assign(n_, 0.0);
  work_.assign(n_, 0.0);
  start_.assign(n_, 0.0);
  dense_state_.assign(n_, 0.0);
  samples_.assign(sample_points * system.guards(), 0.0);
  guard_now_.assign(system.guards(), 0.0);
}

double EventIntegrator::trial(double time, const double* y, double h) {
  const int n = n_;
  double* w = work_.data();
  double *k1 = k_[0].data(), *k2 = k_[1].data(), *k3 = k_[2].data(), *k4 = k_[3].data(), *k5 = k_[4].data(),
         *k6 = k_[5].data(), *k7 = k_[6].data(), *z = next_.data();
  for (int i = 0; i < n; ++i) w[i] = y[i] + h * a21 * k1[i];
  system_.derivatives(time + c2 * h, w, k2);
  for (int i = 0; i < n; ++i) w[i] = y[i] + h * (a31 * k1[i] + a32 * k2[i]);
  system_.derivatives(time + c3 * h, w, k3);
  for (int i = 0; i < n; ++i) w[i] = y[i] + h * (a41 * k1[i] + a42 * k2[i] + a43 * k3[i]);
  system_.derivatives(time + c4 * h, w, k4);
  for (int i = 0; i < n; ++i) w[i] = y[i] + h * (a51 * k1[i] + a52 * k2[i] + a53 * k3[i] + a54 * k4[i]);
  system_.derivatives(time + c5 * h, w, k5);
  for (int i = 0; i < n; ++i)
    w[i] = y[i] + h * (a61 * k1[i] + a62 * k2[i] + a63 * k3[i] + a64 * k4[i] + a65 * k5[i]);
  system_.derivatives(time + h, w, k6);
  for (int i = 0; i < n; ++i)
    z[i] = y[i] + h * (a71 * k1[i] + a73 * k3[i] + a74 * k4[i] + a75 * k5[i] + a76 * k6[i]);
  system_.derivatives(time + h, z, k7);
  statistics_.evaluations += 6;
  double sum = 0.0;
  for (int i = 0; i < n; ++i) {
    const double error =
        h * (e1 * k1[i] + e3 * k3[i] + e4 * k4[i] + e5 * k5[i] + e6 * k6[i] + e7 * k7[i]);
    const double scale =
        options_.relative_tolerance * std::max({options_.absolute[i], std::fabs(y[i]), std::fabs(z[i])});
    sum += (error / scale) * (error / scale);
  }
  const double norm = std::sqrt(sum / n);
  return std::isfinite(norm) ? norm : 1e10;
}

void EventIntegrator::dense(double s, double* out) const {
  const double r = 1.0 - s;
  for (int i = 0; i < n_; ++i)
    out[i] = dense_[0][i] +
             s * (dense_[1][i] + r * (dense_[2][i] + s * (dense_[3][i] + r * dense_[4][i])));
}

double EventIntegrator::guardAt(double time, double h, double share, int guard) {
  dense(share, dense_state_.data());
  system_.guardValues(time + share * h, dense_state_.data(), guard_now_.data());
  return guard_now_[guard];
}

double EventIntegrator::dip(double time, double h, int guard, int interval) {
  const int guards = static_cast<int>(guard_now_.size());
  const double from = 0.25 * interval, to = from + 0.25;
  const int first = interval == 0 ? 0 : interval - 1;
  double s[3], g[3];
  for (int i = 0; i < 3; ++i) {
    s[i] = 0.25 * (first + i);
    g[i] = samples_[(first + i) * guards + guard];
  }
  const double size = std::max({std::fabs(g[0]), std::fabs(g[1]), std::fabs(g[2])});
  // successive parabolas through three points; only an apex near zero is worth a look
  for (int pass = 0; pass < 6; ++pass) {
    const double slope = (g[1] - g[0]) / (s[1] - s[0]);
    const double bend = ((g[2] - g[1]) / (s[2] - s[1]) - slope) / (s[2] - s[0]);
    if (!(bend > 0.0)) return -1.0;
    const double apex = 0.5 * (s[0] + s[1] - slope / bend);
    const double least = g[0] + (apex - s[0]) * (slope + bend * (apex - s[1]));
    if (!(apex > from && apex < to) || least > 0.1 * size) return -1.0;
    for (double known : s)
      if (std::fabs(apex - known) < 1e-9) return -1.0;
    const double value = guardAt(time, h, apex, guard);
    if (value < 0.0) return apex;
    // the lower of the two inner points becomes the middle of the next three
    const bool left = apex < s[1];
    const double s_low = left ? apex : s[1], g_low = left ? value : g[1];
    const double s_high = left ? s[1] : apex, g_high = left ? g[1] : value;
    if (g_low < g_high) {
      s[1] = s_low, g[1] = g_low;
      s[2] = s_high, g[2] = g_high;
    } else {
      s[0] = s_low, g[0] = g_low;
      s[1] = s_high, g[1] = g_high;
    }
  }
  return -1.0;
}

bool EventIntegrator::locate(double time, double h, double& at, int& guard) {
  const int guards = static_cast<int>(guard_now_.size());
  for (int point = 0; point < sample_points; ++point) {
    dense(0.25 * point, dense_state_.data());
    system_.guardValues(time + 0.25 * point * h, dense_state_.data(), &samples_[point * guards]);
  }
  for (int interval = 0; interval + 1 < sample_points; ++interval) {
    at = 2.0;
    for (int g = 0; g < guards; ++g) {
      double low = 0.25 * interval, high = low + 0.25;
      if (samples_[(interval + 1) * guards + g] >= 0.0) high = dip(time, h, g, interval);
      if (high < 0.0) continue;
      // bisection with the guard's sign only: guards may have kinks
      for (int pass = 0; pass < 60 && high - low > 1e-15; ++pass) {
        const double middle = 0.5 * (low + high);
        (guardAt(time, h, middle, g) < 0.0 ? high : low) = middle;
      }
      if (high < at) {
        at = high;
        guard = g;
      }
    }
    if (at < 2.0) return true;
  }
  return false;
}

double EventIntegrator::cross(double time, const double* y, double width, double longest, int guard) {
  // The dense output places the crossing to its own order only. The state that the method itself reaches must lie
  // behind it, or the new mode would be left again at once.
  double before = 0.0, value_before = 0.0;
  for (int pass = 0; pass < 20; ++pass) {
    trial(time, y, width);
    system_.guardValues(time + width, next_.data(), guard_now_.data());
    const double value = guard_now_[guard];
    if (value < 0.0) return width;
    const double slope = pass == 0 ? 0.0 : (value - value_before) / (width - before);
    before = width;
    value_before = value;
    const double least = longest * 1e-12 * (1 << pass);
    width += slope < 0.0 ? std::max(least, -1.01 * value / slope) : least;
    if (width >= longest) return -1.0;
  }
  return before;
}

IntegrationResult EventIntegrator::advance(double start, double end, double* state) {
  IntegrationResult result;
  double time = start;
  const double span = end - start;
  result.time = time;
  if (span <= 0.0) return result;
  if (!have_rate_) {
    system_.derivatives(time, state, k_[0].data());
    ++statistics_.evaluations;
    have_rate_ = true;
    if (step_ <= 0.0) step_ = options_.first_step > 0.0 ? options_.first_step : span * 1e-2;
  }
  if (options_.largest_step > 0.0) step_ = std::min(step_, options_.largest_step);
  const int guards = static_cast<int>(guard_now_.size());
  long steps = 0, events = 0;
  // A guard that is already negative at the start (the mode no longer fits) fires at once.
  const auto settleModes = [&]() -> bool {
    if (guards == 0) return true;
    for (int pass = 0; pass < 8; ++pass) {
      system_.guardValues(time, state, guard_now_.data());
      bool changed = false;
      for (int g = 0; g < guards; ++g)
        if (guard_now_[g] < 0.0) {
          system_.onEvent(g, time, state);
          ++statistics_.events;
          changed = true;
        }
      if (!changed) return true;
      system_.derivatives(time, state, k_[0].data());
      ++statistics_.evaluations;
    }
    return true;  // a guard of exactly zero width: carry on, the next step decides
  };
  settleModes();
  while (time < end) {
    if (++steps > options_.step_limit) {
      result.status = IntegrationStatus::step_limit;
      return result;
    }
    double h = std::min(step_, end - time);
    const bool last = time + h >= end - 1e-14 * std::fabs(end);
    if (last) h = end - time;
    std::copy(state, state + n_, start_.begin());
    const double error = trial(time, state, h);
    if (error > 1.0) {
      ++statistics_.rejected;
      step_ = h * std::max(0.1, 0.9 * std::pow(error, -0.2));
      if (!std::isfinite(error) || step_ < options_.smallest_step) {
        bool finite = true;
        for (int i = 0; i < n_; ++i) finite = finite && std::isfinite(next_[i]);
        result.status = finite ? IntegrationStatus::step_too_small : IntegrationStatus::not_finite;
        return result;
      }
      continue;
    }
    const double* y = start_.data();
    const auto buildDense = [&](double width) {
      for (int i = 0; i < n_; ++i) {
        const double difference = next_[i] - y[i];
        const double bulge = width * k_[0][i] - difference;
        dense_[0][i] = y[i];
        dense_[1][i] = difference;
        dense_[2][i] = bulge;
        dense_[3][i] = difference - width * k_[6][i] - bulge;
        dense_[4][i] = width * (d1 * k_[0][i] + d3 * k_[2][i] + d4 * k_[3][i] + d5 * k_[4][i] + d6 * k_[5][i] +
                                d7 * k_[6][i]);
      }
    };
    bool event = false;
    int guard = -1;
    if (guards > 0 || observer_) buildDense(h);
    double taken = h;
    if (guards > 0) {
      double at = 0.0;
      if (locate(time, h, at, guard)) {
        taken = cross(time, y, std::max(at * h, 1e-16), h, guard);
        event = taken > 0.0;
        if (!event) {  // the method's own motion crosses only in the next step
          taken = h;
          trial(time, y, h);
        }
        if (observer_) buildDense(taken);
      }
    }
    if (observer_) {
      start_time_ = time;
      observer_(time, time + taken,
                [&](double t, double* out) { dense(taken > 0.0 ? (t - start_time_) / taken : 0.0, out); });
    }
    std::copy(next_.begin(), next_.end(), state);
    time = (!event && last) ? end : time + taken;
    result.time = time;
    ++statistics_.steps;
    if (event) {
      if (++events > options_.event_limit) {
        result.status = IntegrationStatus::event_limit;
        return result;
      }
      ++statistics_.events;
      system_.onEvent(guard, time, state);
      system_.derivatives(time, state, k_[0].data());
      ++statistics_.evaluations;
      settleModes();
    } else {
      k_[0].swap(k_[6]);
      // PI control (Hairer II.4): smoother than error alone
      const double factor =
          0.9 * std::pow(std::max(error, 1e-10), -0.17) * std::pow(std::max(previous_error_, 1e-4), 0.04);
      previous_error_ = std::max(error, 1e-4);
      if (!last || factor < 1.0) step_ = h * std::min(5.0, std::max(0.2, factor));
      if (last) step_ = std::max(step_, h * std::min(5.0, std::max(0.2, factor)));
      if (options_.largest_step > 0.0) step_ = std::min(step_, options_.largest_step);
    }
  }
  for (int i = 0; i < n_; ++i)
    if (!std::isfinite(state[i])) result.status = IntegrationStatus::not_finite;
  return result;
}

}  // namespace amb_rotor
