#include "amb_rotor/machine/basic_orbit.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "amb_rotor/common/check.hpp"
#include "amb_rotor/common/units.hpp"
#include "basic_laws.hpp"
#include "basic_taylor.hpp"

namespace amb_rotor {
namespace {

using Five = Dual<double, 5>;  // 4 initial state, 1 parameter

template <class T>
using Quad = std::array<T, 4>;

double slopeNorm(const double&) { return 0.0; }
double slopeNorm(const Five& a) {
  double sum = 0.0;
  for (double s : a.slope) sum = std::max(sum, std::abs(s));
  return sum;
}

// Dormand and Prince 5(4).
constexpr double node[7] = {0, 1.0 / 5, 3.0 / 10, 4.0 / 5, 8.0 / 9, 1, 1};
constexpr double stage[7][6] = {{0},
                                {1.0 / 5},
                                {3.0 / 40, 9.0 / 40},
                                {44.0 / 45, -56.0 / 15, 32.0 / 9},
                                {19372.0 / 6561, -25360.0 / 2187, 64448.0 / 6561, -212.0 / 729},
                                {9017.0 / 3168, -355.0 / 33, 46732.0 / 5247, 49.0 / 176, -5103.0 / 18656},
                                {35.0 / 384, 0, 500.0 / 1113, 125.0 / 192, -2187.0 / 6784, 11.0 / 84}};
constexpr double fifth_less_fourth[7] = {71.0 / 57600,      0,          -71.0 / 16695, 71.0 / 1920,
                                         -17253.0 / 339200, 22.0 / 525, -1.0 / 40};

/// One machine in phase units, with T = double or Five.
template <class Model, class T>
class Flow {
 public:
  Flow(const BasicCoefficients<T>& c, const BasicOrbitOptions& options) : c_(c), options_(options) {}

  void rate(double phase, const Quad<T>& q, bool contact, Quad<T>& out) {
    const T fx = c_.forcing * std::cos(phase), fy = c_.forcing * std::sin(phase);
    out[0] = q[2];
    out[1] = q[3];
    if (contact) {
      Model::template acceleration<BasicBranch::contact>(c_, fx, fy, q[0], q[1], q[2], q[3], out[2], out[3]);
    } else {
      Model::template acceleration<BasicBranch::free>(c_, fx, fy, q[0], q[1], q[2], q[3], out[2], out[3]);
    }
    ++orbit.evaluations;
  }

  /// Squared distance from the bearing's centre less 1, and its rate.
  double gap(const Quad<T>& q) const {
    const double u = valueOf(q[0]) - valueOf(c_.misalignment_x),
                 v = valueOf(q[1]) - valueOf(c_.misalignment_y);
    return u * u + v * v - 1.0;
  }
  double gapRate(const Quad<T>& q) const {
    const double u = valueOf(q[0]) - valueOf(c_.misalignment_x),
                 v = valueOf(q[1]) - valueOf(c_.misalignment_y);
    return 2.0 * (u * valueOf(q[2]) + v * valueOf(q[3]));
  }

  double tryStep(double phase, const Quad<T>& q, double h, bool contact, Quad<T>& next) {
    for (int s = 1; s < 7; ++s) {
      Quad<T> at = q;
      for (int j = 0; j < s; ++j) {
        if (stage[s][j] == 0.0) continue;
        for (int i = 0; i < 4; ++i) at[i] = at[i] + (h * stage[s][j]) * k_[j][i];
      }
      if (s == 6) next = at;
      rate(phase + node[s] * h, at, contact, k_[s]);
    }
    double error = 0.0;
    for (int i = 0; i < 4; ++i) {
      T e = (h * fifth_less_fourth[0]) * k_[0][i];
      for (int s = 2; s < 7; ++s) e = e + (h * fifth_less_fourth[s]) * k_[s][i];
      error = std::max(error, std::abs(valueOf(e)) / options_.tolerance);
      error = std::max(error, slopeNorm(e) / (options_.tolerance * (1.0 + slopeNorm(next[i]))));
    }
    return error;
  }

  /// Gap at a share of the step just tried: cubic Hermite polynomial of x and y.
  double gapAt(const Quad<T>& q, const Quad<T>& next, double h, double s) const {
    double p[2];
    for (int i = 0; i < 2; ++i) {
      const double a = valueOf(q[i]), b = valueOf(next[i]), va = h * valueOf(q[i + 2]),
                   vb = h * valueOf(next[i + 2]);
      const double d = b - a;
      p[i] = a + s * (va + s * ((3.0 * d - 2.0 * va - vb) + s * (va + vb - 2.0 * d)));
    }
    const double u = p[0] - valueOf(c_.misalignment_x), v = p[1] - valueOf(c_.misalignment_y);
    return u * u + v * v - 1.0;
  }

  void run(Quad<T>& q, double end, const BasicObserver& observer, double eta) {
    if constexpr (std::is_same_v<Model, BasicModel<LinearContact, SpinFriction>>)
      runSeries(q, end, observer, eta);
    else
      runSteps(q, end, observer, eta);
  }

  bool startsInContact(const Quad<T>& q) const { return gap(q) > 0.0 || (gap(q) == 0.0 && gapRate(q) > 0.0); }

  /// By Taylor series (basic_taylor.hpp).
  void runSeries(Quad<T>& q, double end, const BasicObserver& observer, double eta) {
    BasicTaylor<T> series(c_, options_.tolerance);
    double phase = 0.0, in_contact = 0.0;
    bool contact = startsInContact(q);
    const auto note = [&](double at, const Quad<T>& s) {
      observer(at, {valueOf(s[0]), valueOf(s[1]), eta * valueOf(s[2]), eta * valueOf(s[3])}, contact);
    };
    if (observer) note(phase, q);
    double largest = gap(q), turning = -2.0;
    while (phase < end - 1e-13) {
      double h = series.expand(phase, q.data(), contact);
      orbit.evaluations += series.order();
      if (++orbit.steps > options_.step_limit || !(h > 1e-14)) {
        orbit.finite = false;
        return;
      }
      h = std::min(h, end - phase);
      const auto passage = series.passage(h, contact, largest);
      const bool event = passage.event > 0.0;
      if (event) h = passage.event;
      largest = std::max(largest, passage.largest);
      turning = std::max(turning, passage.turning);
      if (observer) {
        const int parts = static_cast<int>(h / observer_spacing) + 1;
        for (int i = 1; i < parts; ++i) {
          Quad<T> between;
          series.at(h * i / parts, between.data());
          note(phase + h * i / parts, between);
        }
      }
      series.at(h, q.data());
      phase += h;
      if (contact) in_contact += h;
      if (event) {
        contact = !contact;
        if (contact) ++orbit.touch_downs;
      }
      largest = std::max(largest, gap(q));
      if (observer) note(phase, q);
    }
    orbit.max_radius = std::sqrt(largest + 1.0);
    if (turning > -1.0) orbit.largest_free_radius = std::sqrt(turning + 1.0);
    orbit.contact_fraction = in_contact / end;
  }

  /// By Dormand and Prince's method.
  void runSteps(Quad<T>& q, double end, const BasicObserver& observer, double eta) {
    double phase = 0.0, h = 0.05, in_contact = 0.0;
    bool contact = startsInContact(q);
    double last_rate = gapRate(q);
    const auto note = [&] {
      if (observer)
        observer(phase, {valueOf(q[0]), valueOf(q[1]), eta * valueOf(q[2]), eta * valueOf(q[3])}, contact);
    };
    note();
    rate(phase, q, contact, k_[0]);
    while (phase < end - 1e-13) {
      if (++orbit.steps > options_.step_limit || h < 1e-14 || !std::isfinite(h)) {
        orbit.finite = false;
        return;
      }
      h = std::min(h, end - phase);
      Quad<T> next;
      double error = tryStep(phase, q, h, contact, next);
      if (!(error < 1.0)) {
        h *= std::isfinite(error) ? std::max(0.2, 0.9 * std::pow(error, -0.2)) : 0.2;
        continue;
      }
      const double grown = h * std::min(4.0, 0.9 * std::pow(std::max(error, 1e-10), -0.2));
      const double share = crossing(q, next, h, contact);
      bool event = share < 1.0;
      if (event) {
        h = std::max(share * h, 1e-14);
        // Newton on the length of the repeated step: the event is where the method's own end state touches.
        for (int i = 0; i < 8; ++i) {
          tryStep(phase, q, h, contact, next);
          const double slope = gapRate(next);
          if (slope == 0.0 || std::abs(gap(next)) < 1e-14) break;
          const double correction = -gap(next) / slope;
          if (!(std::abs(correction) < h)) break;
          h += correction;
        }
      }
      if (!event) trackTurning(q, next, h, contact, last_rate);
      phase += h;
      if (contact) in_contact += h;
      q = next;
      k_[0] = k_[6];
      if (event) {
        contact = !contact;
        if (contact) ++orbit.touch_downs;
        rate(phase, q, contact, k_[0]);
      }
      last_rate = gapRate(q);
      orbit.max_radius = std::max(orbit.max_radius, std::sqrt(gap(q) + 1.0));
      note();
      h = grown;
    }
    orbit.contact_fraction = in_contact / end;
  }

  BasicOrbit orbit;

 private:
  /// A step by series is observed at least as often [rad]: cubic polynomials between these points are good to
  /// 1e-7.
  static constexpr double observer_spacing = 0.02;

  /// Share of the step at which the mode ends; 1: it does not.
  double crossing(const Quad<T>& q, const Quad<T>& next, double h, bool contact) const {
    const double sign = contact ? 1.0 : -1.0;
    constexpr int parts = 8;
    double before = 0.0;
    for (int i = 1; i <= parts; ++i) {
      const double at = static_cast<double>(i) / parts;
      const double g = i == parts ? gap(next) : gapAt(q, next, h, at);
      // Just after an event the gap is 0 within round-off: only a clear wrong side counts there.
      if (sign * g < (i < parts ? -1e-12 : -1e-14)) {
        double low = before, high = at;
        for (int j = 0; j < 60; ++j) {
          const double middle = 0.5 * (low + high);
          (sign * gapAt(q, next, h, middle) > 0.0 ? low : high) = middle;
        }
        // A mode left at once (low = 0) is a gap that is on the wrong side by round-off: stay in the mode.
        return low > 0.0 ? high : 1.0;
      }
      before = at;
    }
    return 1.0;
  }

  void trackTurning(const Quad<T>& q, const Quad<T>& next, double h, bool contact, double last_rate) {
    if (contact || !(last_rate > 0.0) || gapRate(next) >= 0.0) return;
    double largest = std::max(gap(q), gap(next));
    for (int i = 1; i < 16; ++i) largest = std::max(largest, gapAt(q, next, h, i / 16.0));
    orbit.largest_free_radius = std::max(orbit.largest_free_radius, std::sqrt(largest + 1.0));
  }

  BasicCoefficients<T> c_;
  BasicOrbitOptions options_;
  Quad<T> k_[7];
};

template <class F>
auto withModel(const BasicOrbitOptions& o, F&& f) {
  return withBasicModel(o.contact, o.friction, f);
}

std::vector<double> fieldsOf(const BasicParameters<double>& p) {
  std::vector<double> values;
  BasicParameters<double>::visit(p, [&](const char*, const double& value) { values.push_back(value); });
  return values;
}

template <class T>
BasicParameters<T> lifted(const BasicParameters<double>& p,
                          const std::optional<BasicParameters<double>>& direction) {
  BasicParameters<T> out;
  const std::vector<double> values = fieldsOf(p), slopes = direction ? fieldsOf(*direction) : values;
  std::size_t i = 0;
  BasicParameters<T>::visit(out, [&](const std::string&, T& field) {
    field = T(values[i]);
    if constexpr (std::is_same_v<T, Five>) {
      if (direction) field.slope[4] = slopes[i];
    }
    ++i;
  });
  return out;
}

}  // namespace

Eigen::Vector4d phaseUnits(const BasicState<double>& s, double eta) {
  return {s.x, s.y, s.vx / eta, s.vy / eta};
}
BasicState<double> timeUnits(const Eigen::Vector4d& q, double eta) {
  return {q[0], q[1], eta * q[2], eta * q[3]};
}

BasicOrbit advanceBasic(const BasicParameters<double>& given, const BasicState<double>& initial, int turns,
                        const BasicOrbitOptions& options, const BasicObserver& observer) {
  const BasicParameters<double> p = rotatedToPhaseZero(given);
  const double angle = given.unbalance_phase, eta = p.frequency_ratio;
  const Eigen::Vector4d start = phaseUnits(rotated(initial, -angle), eta);
  return withModel(options, [&](auto model) {
    using Model = decltype(model);
    Flow<Model, double> flow(basicCoefficients<typename Model::Contact>(p, 1.0 / eta), options);
    Quad<double> q{start[0], start[1], start[2], start[3]};
    const BasicObserver turned = [&](double phase, const BasicState<double>& s, bool contact) {
      observer(phase, rotated(s, angle), contact);
    };
    flow.run(q, two_pi * turns, observer ? turned : BasicObserver{}, eta);
    flow.orbit.end = rotated(timeUnits({q[0], q[1], q[2], q[3]}, eta), angle);
    return flow.orbit;
  });
}

BasicOrbit basicOrbit(const BasicParameters<double>& p, const BasicState<double>& initial, int turns,
                      const BasicOrbitOptions& options) {
  AMB_ROTOR_CHECK(p.unbalance_phase == 0.0, "turn the machine to phase 0 first: derivatives are in its axes");
  const double eta = p.frequency_ratio;
  const Eigen::Vector4d start = phaseUnits(initial, eta);
  return withModel(options, [&](auto model) {
    using Model = decltype(model);
    const auto lifted_parameters = lifted<Five>(p, options.direction);
    const Five unit = inverseOf(lifted_parameters.frequency_ratio);
    Flow<Model, Five> flow(basicCoefficients<typename Model::Contact>(lifted_parameters, unit), options);
    Quad<Five> q;
    for (int i = 0; i < 4; ++i) {
      q[i] = Five(start[i]);
      q[i].slope[i] = 1.0;
    }
    flow.run(q, two_pi * turns, {}, eta);
    BasicOrbit& orbit = flow.orbit;
    orbit.end = timeUnits({q[0].value, q[1].value, q[2].value, q[3].value}, eta);
    for (int i = 0; i < 4; ++i) {
      for (int j = 0; j < 4; ++j) orbit.monodromy(i, j) = q[i].slope[j];
      orbit.by_parameter[i] = q[i].slope[4];
    }
    return orbit;
  });
}

Eigen::Matrix4d saltationJump(const BasicParameters<double>& given, const BasicState<double>& state,
                              double phase, const BasicOrbitOptions& options) {
  const BasicParameters<double> p = rotatedToPhaseZero(given);
  const BasicState<double> s = rotated(state, -given.unbalance_phase);
  return withModel(options, [&](auto model) {
    using Model = decltype(model);
    Flow<Model, double> flow(basicCoefficients<typename Model::Contact>(p, 1.0 / p.frequency_ratio), options);
    const Eigen::Vector4d at = phaseUnits(s, p.frequency_ratio);
    const Quad<double> q{at[0], at[1], at[2], at[3]};
    Quad<double> inside, outside;
    flow.rate(phase, q, false, inside);
    flow.rate(phase, q, true, outside);
    const Eigen::Vector4d normal(2.0 * (q[0] - p.misalignment_x), 2.0 * (q[1] - p.misalignment_y), 0.0, 0.0);
    const Eigen::Map<Eigen::Vector4d> free(inside.data()), contact(outside.data());
    return Eigen::Matrix4d((contact - free) * normal.transpose() / normal.dot(free));
  });
}

}  // namespace amb_rotor
