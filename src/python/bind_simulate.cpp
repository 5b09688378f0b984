// amb_rotor._core: one run of one machine.
#include "amb_rotor/common/units.hpp"
#include "amb_rotor/machine/run.hpp"
#include "bind.hpp"

namespace py = pybind11;

namespace amb_rotor {
namespace {

constexpr const char* axes[4] = {"ax", "ay", "bx", "by"};
constexpr const char* ends[2] = {"a", "b"};

template <std::size_t n>
void put(py::dict& d, const std::string& head, const std::string& unit,
         std::array<std::vector<double>, n>& rows) {
  for (std::size_t i = 0; i < n; ++i) {
    const std::string name = head + (n == 4 ? axes[i] : ends[i]) + "_" + unit;
    d[py::str(name)] = ownedArray(std::move(rows[i]));
  }
}

/// Columns have the names of a bag's table (`amb convert`), and some more.
py::dict asDict(Simulation&& simulation) {
  Trajectory& t = simulation.trajectory;
  py::dict columns, d;
  columns["t_s"] = ownedArray(std::move(t.time_s));
  columns["angle_rad"] = ownedArray(std::move(t.angle_rad));
  for (double& speed : t.speed_rad_s) speed /= two_pi;
  columns["speed_Hz"] = ownedArray(std::move(t.speed_rad_s));
  put(columns, "", "m", t.displacement_m);
  put(columns, "i", "A", t.current_A);
  put(columns, "position_", "m", t.position_m);
  put(columns, "aux_", "m", t.aux_position_m);
  put(columns, "centre_", "m", t.aux_centre_m);
  put(columns, "bearing_", "N", t.bearing_force_N);
  put(columns, "contact_", "N", t.contact_force_N);
  put(columns, "normal_", "N", t.normal_force_N);
  put(columns, "friction_", "N", t.friction_force_N);
  put(columns, "penetration_", "m", t.penetration_m);
  put(columns, "slip_", "m_s", t.slip_m_s);
  put(columns, "ring_speed_", "rad_s", t.ring_speed_rad_s);
  py::list contacts;
  for (const auto& span : t.contacts) contacts.append(py::make_tuple(ends[span.end], span.from_s, span.to_s));
  const RunOutcome& outcome = simulation.outcome;
  d["columns"] = columns;
  d["contacts"] = contacts;
  d["clearance_m"] = t.clearance_m;
  d["status"] = outcome.status == RunStatus::ok           ? "ok"
                : outcome.status == RunStatus::diverged   ? "diverged"
                : outcome.status == RunStatus::magnet_hit ? "magnet_hit"
                                                          : "failed";
  d["magnet_hit"] = py::none();
  if (outcome.magnet_hit) {
    py::dict hit;
    hit["bearing"] = ends[outcome.magnet_hit->end];
    hit["time_s"] = outcome.magnet_hit->time_s;
    hit["displacement_m"] = outcome.magnet_hit->displacement_m;
    hit["air_gap_m"] = outcome.magnet_hit->air_gap_m;
    d["magnet_hit"] = hit;
  }
  d["reason"] = outcome.reason;
  d["time_s"] = outcome.time_s;
  d["steps"] = outcome.steps;
  d["evaluations"] = outcome.evaluations;
  d["events"] = outcome.events;
  d["path"] = outcome.path;
  return d;
}

}  // namespace

void bindSimulate(py::module_& m) {
  m.def(
      "simulate",
      [](const Model& model, const Scenario& scenario, double relative_tolerance, double settle_s, bool modal) {
        requireModes(model);
        RunOptions options;
        options.relative_tolerance = relative_tolerance;
        options.settle_s = settle_s;
        options.modal = modal;
        Simulation simulation;
        {
          const py::gil_scoped_release release;
          const EndsAtOnce ends;
          simulation = simulate(model, scenario, options);
        }
        return asDict(std::move(simulation));
      },
      py::arg("model"), py::arg("scenario"), py::arg("relative_tolerance") = 1e-8, py::arg("settle_s") = 0.5,
      py::arg("modal") = true,
      "Event-accurate run. `columns`: name with unit -> array.");
}

}  // namespace amb_rotor
