#pragma once
// What tests compare of two runs: the graph's and the machine's in process.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <string>
#include <vector>

#include "amb_rotor/analysis/contact.hpp"
#include "amb_rotor/analysis/regime.hpp"
#include "amb_rotor/machine/run.hpp"
#include "amb_rotor/ros/conversions.hpp"
#include "amb_rotor/ros/messages.hpp"

namespace amb_rotor::testing {

/// What was recorded of a run, whatever made it.
struct Recording {
  std::vector<double> time, angle;
  std::array<std::vector<double>, 4> displacement, position,
      velocity;  // at the sensors; at the auxiliary bearings
  std::array<std::vector<double>, 2> normal_force;
  double clearance = 0.0;
};

inline void append(Recording& out, const RotorState& state, const ContactForces& contact) {
  if (state.record < 0) return;
  out.time.push_back(state.time);
  out.angle.push_back(state.shaft.angle);
  for (int a = 0; a < 4; ++a) {
    out.displacement[a].push_back(axisOf(state.sensor_signal, a));
    const EndContact& end = contact.ends[a / 2];
    out.position[a].push_back(axisOf(state.aux_position, a) - (a % 2 == 0 ? end.centre_x : end.centre_y));
  }
  for (int e = 0; e < 2; ++e) out.normal_force[e].push_back(contact.ends[e].normal_force);
}

inline Recording recordingOf(const Simulation& run) {
  Recording out;
  const Trajectory& t = run.trajectory;
  out.time = t.time_s;
  out.angle = t.angle_rad;
  out.displacement = t.displacement_m;
  for (int a = 0; a < 4; ++a)
    for (std::size_t i = 0; i < t.time_s.size(); ++i)
      out.position[a].push_back(t.aux_position_m[a][i] - t.aux_centre_m[a][i]);
  out.normal_force = t.normal_force_N;
  out.clearance = t.clearance_m;
  return out;
}

/// Index of the first recorded instant with contact at either end; the length without one.
inline std::size_t firstContact(const Recording& run) {
  for (std::size_t i = 0; i < run.time.size(); ++i)
    if (run.normal_force[0][i] > 0.0 || run.normal_force[1][i] > 0.0) return i;
  return run.time.size();
}

/// Largest difference of the displacements over the first n instants, in clearances.
inline double largestDifference(const Recording& a, const Recording& b, std::size_t n, double clearance) {
  double largest = 0.0;
  for (int axis = 0; axis < 4; ++axis)
    for (std::size_t i = 0; i < n; ++i)
      largest = std::max(largest, std::fabs(a.displacement[axis][i] - b.displacement[axis][i]) / clearance);
  return largest;
}

struct ContactSummary {
  ContactStatistics statistics;
  RegimeResult regime;
};

inline ContactSummary summary(const Recording& run, int end, double clearance, double rotor_radius) {
  const auto& x = run.position[2 * end];
  const auto& y = run.position[2 * end + 1];
  RegimeInput input;
  input.points = stroboscopicSection(run.time, run.angle, x, y);
  input.clearance = clearance;
  for (std::size_t i = 0; i < x.size(); ++i)
    input.max_radius = std::max(input.max_radius, std::hypot(x[i], y[i]));
  input.spin = (run.angle.back() - run.angle.front()) / (run.time.back() - run.time.front());
  input.rotor_radius = rotor_radius;
  input.contact = contactStatistics(run.time, run.normal_force[end], x, y);
  input.whirl = whirlFromOrbit(run.time, x, y);
  return {input.contact, decideRegime(input, 0.01)};
}

/// The part of a recording from an instant on.
inline Recording from(const Recording& run, double time) {
  Recording out = run;
  const std::size_t first =
      std::lower_bound(run.time.begin(), run.time.end(), time - 1e-9) - run.time.begin();
  const auto cut = [&](std::vector<double>& v) {
    if (!v.empty()) v.erase(v.begin(), v.begin() + static_cast<std::ptrdiff_t>(first));
  };
  cut(out.time);
  cut(out.angle);
  for (int a = 0; a < 4; ++a) {
    cut(out.displacement[a]);
    cut(out.position[a]);
  }
  for (int e = 0; e < 2; ++e) cut(out.normal_force[e]);
  return out;
}

// Issue 2, item 6.
constexpr double displacement_tolerance = 0.005;  // clearances, until the first contact
constexpr double contact_tolerance = 0.05;        // relative, of contact fraction and rms force

/// The graph's run against the machine's, as item 6 wants it.
inline void expectEqual(const Recording& graph, const Recording& machine, double clearance,
                        double rotor_radius, double settled_from, bool contact_expected) {
  ASSERT_EQ(graph.time.size(), machine.time.size());
  for (std::size_t i = 0; i < graph.time.size(); ++i) ASSERT_NEAR(graph.time[i], machine.time[i], 1e-12);
  const std::size_t first = std::min(firstContact(graph), firstContact(machine));
  const double free_difference = largestDifference(graph, machine, first, clearance);
  EXPECT_LT(free_difference, displacement_tolerance);
  std::printf("largest difference until the first contact (%zu of %zu instants): %.3g clearances\n", first,
              graph.time.size(), free_difference);
  ASSERT_EQ(first < graph.time.size(), contact_expected);
  if (!contact_expected) return;
  const Recording late_graph = from(graph, settled_from), late_machine = from(machine, settled_from);
  for (int end = 0; end < 2; ++end) {
    const ContactSummary g = summary(late_graph, end, clearance, rotor_radius);
    const ContactSummary m = summary(late_machine, end, clearance, rotor_radius);
    std::printf(
        "end %c: regime %s (period %d) / %s (%d), contact fraction %.5f / %.5f, rms force %.5g / %.5g N, "
        "impacts %zu / %zu\n",
        'a' + end, toString(g.regime.regime).c_str(), g.regime.period, toString(m.regime.regime).c_str(),
        m.regime.period, g.statistics.contact_fraction, m.statistics.contact_fraction, g.statistics.rms_force,
        m.statistics.rms_force, g.statistics.impacts, m.statistics.impacts);
    EXPECT_EQ(g.regime.regime, m.regime.regime);
    EXPECT_EQ(g.regime.period, m.regime.period);
    EXPECT_NEAR(g.statistics.contact_fraction, m.statistics.contact_fraction,
                contact_tolerance * m.statistics.contact_fraction);
    EXPECT_NEAR(g.statistics.rms_force, m.statistics.rms_force, contact_tolerance * m.statistics.rms_force);
  }
}

}  // namespace amb_rotor::testing
