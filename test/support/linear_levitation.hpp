#pragma once
// An independent model of a levitated rigid beam in discrete time, for tests: between instants the matrix
// exponential of one linear system, at instants the controller's difference equations. It shares no code with
// the machine but the structs of its inputs (the exponential is Eigen's). No contact, linear bearings, constant speed.
#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <set>
#include <vector>

#include "amb_rotor/common/linear_algebra.hpp"
#include "amb_rotor/model/model.hpp"
#include "amb_rotor/model/scenario.hpp"

namespace amb_rotor::testing_support {

class LinearLevitation {
 public:
  struct Row {
    double time;
    std::array<double, 4> signal, current;  ///< ax, ay, bx, by
  };

  /// @param grid_s  force waveforms are held at their middle over pieces of this length (steps need none)
  explicit LinearLevitation(const Model& model, double speed_rad_s, double grid_s = 1e-5)
      : model_(model), speed_(speed_rad_s), grid_(grid_s) {
    const auto& rig = model.rig;
    // states: x, y, b, r (b tilt about y, r minus the tilt about x), their rates, 4 currents, cos, sin, 1
    system_ = Eigen::MatrixXd::Zero(states, states);
    const double mass[4] = {rig.rotor.mass_kg, rig.rotor.mass_kg, rig.rotor.transverse_inertia_kg_m2,
                            rig.rotor.transverse_inertia_kg_m2};
    for (int i = 0; i < 4; ++i) system_(i, 4 + i) = 1.0;
    for (int end = 0; end < 2; ++end)
      for (int axis = 0; axis < 2; ++axis) {
        const double z = rig.planes.amb[end];
        Eigen::RowVectorXd force = Eigen::RowVectorXd::Zero(states);
        force(axis) = rig.amb.displacement_stiffness_N_per_m;
        force(2 + axis) = rig.amb.displacement_stiffness_N_per_m * z;
        force(8 + 2 * end + axis) = rig.amb.current_stiffness_N_per_A;
        system_.row(4 + axis) += force / mass[axis];
        system_.row(6 + axis) += z * force / mass[2 + axis];
        system_(8 + 2 * end + axis, 8 + 2 * end + axis) = -2.0 * M_PI * rig.amb.amplifier_bandwidth_hz;
      }
    const double gyroscopic = rig.rotor.polar_inertia_kg_m2 * speed_ / rig.rotor.transverse_inertia_kg_m2;
    system_(6, 7) -= gyroscopic;
    system_(7, 6) += gyroscopic;
    system_(12, 13) = -speed_;
    system_(13, 12) = speed_;
    for (const auto& u : rig.unbalance) {
      const double f = u.moment_kg_m * speed_ * speed_, c = std::cos(u.phase_rad), s = std::sin(u.phase_rad);
      const Eigen::Matrix2d turn = (Eigen::Matrix2d() << c, -s, s, c).finished();
      system_.block<2, 2>(4, 12) += f / mass[0] * turn;
      system_.block<2, 2>(6, 12) += f * u.plane_z_m / mass[2] * turn;
    }
    system_(5, 14) = -rig.gravity_m_s2;
  }

  /// From rest at the origin or from the given coordinates (order of a scenario).
  std::vector<Row> run(const Scenario& scenario) {
    const auto& rig = model_.rig;
    const auto& c = rig.controller;
    Eigen::VectorXd x = Eigen::VectorXd::Zero(states);
    x(14) = 1.0;
    x(12) = 1.0;
    for (std::size_t i = 0; i < scenario.initial_displacement_m.size(); ++i) {
      x(i) = scenario.initial_displacement_m[i];
      if (i < scenario.initial_velocity_m_s.size()) x(4 + i) = scenario.initial_velocity_m_s[i];
    }
    const double period = 1.0 / c.sample_rate_hz,
                 pole = std::exp(-2.0 * M_PI * c.derivative_filter_hz * period);
    std::array<double, 4> previous{}, slope{}, sum{}, command{};
    std::multimap<double, std::array<double, 4>> under_way;
    std::vector<Row> rows;
    // all instants at which something is done, as multiples of a tiny tick so that equal ones are one
    const double tick = 1e-11;
    std::set<long long> instants;
    const auto ticks = [&](double t) { return static_cast<long long>(std::llround(t / tick)); };
    const long long last = ticks(scenario.duration_s);
    std::map<long long, int> what;  // 1 sample, 2 record
    for (int n = 0; ticks(n * period) <= last; ++n) {
      what[ticks(n * period)] |= 1;
      instants.insert(ticks(n * period));
      instants.insert(ticks(n * period + c.delay_s));
    }
    for (int n = 0; ticks(n / scenario.record_rate_hz) <= last; ++n) {
      what[ticks(n / scenario.record_rate_hz)] |= 2;
      instants.insert(ticks(n / scenario.record_rate_hz));
    }
    bool waves = false;
    for (const auto& e : scenario.excitations) {
      instants.insert(ticks(e.start_s));
      if (e.duration_s > 0.0) instants.insert(ticks(e.start_s + e.duration_s));
      waves = waves || (e.kind == Excitation::Kind::force && e.waveform != Waveform::step);
    }
    if (waves)
      for (double t = 0.0; ticks(t) <= last; t += grid_) instants.insert(ticks(t));
    for (auto it = instants.begin(); it != instants.end(); ++it) {
      const long long now = *it;
      if (now > last) break;
      const double t = now * tick;
      std::array<double, 4> s{};
      for (int end = 0; end < 2; ++end)
        for (int axis = 0; axis < 2; ++axis)
          s[2 * end + axis] = x(axis) + rig.planes.sensor[end] * x(2 + axis);
      const auto found = what.find(now);
      const int todo = found == what.end() ? 0 : found->second;
      if ((todo & 2) != 0) rows.push_back({t, s, {x(8), x(9), x(10), x(11)}});
      if ((todo & 1) != 0) {
        std::array<double, 4> u{};
        for (int a = 0; a < 4; ++a) {
          slope[a] = pole * slope[a] + (1.0 - pole) * (s[a] - previous[a]) / period;
          sum[a] += period * s[a];
          previous[a] = s[a];
          u[a] = -(c.kp_A_per_m * s[a] + c.kd_A_s_per_m * slope[a] + c.ki_A_per_m_s * sum[a]);
        }
        under_way.emplace(t + c.delay_s, u);
      }
      while (!under_way.empty() && under_way.begin()->first <= t + 0.5 * tick) {
        command = under_way.begin()->second;
        under_way.erase(under_way.begin());
      }
      const auto next = std::next(it);
      if (next == instants.end() || now == last) break;
      const double to = std::min(*next, last) * tick;
      Eigen::MatrixXd a = system_;
      std::array<double, 4> target = command;
      for (const auto& e : scenario.excitations) {
        const bool on =
            t >= e.start_s - 0.5 * tick && (e.duration_s <= 0.0 || t < e.start_s + e.duration_s - 0.5 * tick);
        if (!on) continue;
        if (e.kind == Excitation::Kind::current) {
          const double sampled = std::floor(t / period + 1e-6) * period;  // held from the controller's instant
          target[2 * e.end + e.axis] += wave(e, std::max(sampled, e.start_s) - e.start_s);
        } else {
          const double f = wave(e, 0.5 * (t + to) - e.start_s);
          const double fx = f * std::cos(e.direction_rad), fy = f * std::sin(e.direction_rad);
          a(4, 14) += fx / rig.rotor.mass_kg;
          a(5, 14) += fy / rig.rotor.mass_kg;
          a(6, 14) += e.plane_z_m * fx / rig.rotor.transverse_inertia_kg_m2;
          a(7, 14) += e.plane_z_m * fy / rig.rotor.transverse_inertia_kg_m2;
        }
      }
      const double limit = std::min(rig.amb.bias_current_A, rig.amb.max_current_A - rig.amb.bias_current_A);
      for (int i = 0; i < 4; ++i) target[i] = std::max(-limit, std::min(limit, target[i]));
      // currents relative to their targets decay by themselves: targets enter through the constant state
      for (int i = 0; i < 4; ++i) a(8 + i, 14) = -a(8 + i, 8 + i) * target[i];
      x = matrixExponential(a * (to - t)) * x;
    }
    return rows;
  }

  static double wave(const Excitation& e, double t) {
    switch (e.waveform) {
      case Waveform::step:
        return e.amplitude;
      case Waveform::impulse:
        return e.amplitude * std::sin(M_PI * t / e.duration_s);
      case Waveform::sine:
        return e.amplitude * std::sin(2.0 * M_PI * e.start_hz * t);
      case Waveform::chirp:
        return e.amplitude *
               std::sin(2.0 * M_PI * (e.start_hz + 0.5 * (e.end_hz - e.start_hz) * t / e.duration_s) * t);
    }
    return 0.0;
  }

 private:
  static constexpr int states = 15;
  const Model& model_;
  double speed_, grid_;
  Eigen::MatrixXd system_;
};

}  // namespace amb_rotor::testing_support
