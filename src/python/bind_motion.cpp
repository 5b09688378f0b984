// amb_rotor._core: single motions of the basic model: recorded, and by harmonic balance.
#include <map>

#include "amb_rotor/machine/basic_continuation.hpp"
#include "amb_rotor/machine/basic_dry_whirl.hpp"
#include "amb_rotor/machine/basic_harmonic_balance.hpp"
#include "amb_rotor/machine/basic_record.hpp"
#include "bind.hpp"

namespace py = pybind11;

namespace amb_rotor {
namespace {

using StateTuple = std::array<double, 4>;

BasicState<double> stateOf(const StateTuple& s) { return {s[0], s[1], s[2], s[3]}; }
py::tuple tupleOf(const BasicState<double>& s) { return py::make_tuple(s.x, s.y, s.vx, s.vy); }

BasicOrbitOptions lawsOf(const std::string& contact, const std::string& friction) {
  BasicOrbitOptions options;
  options.contact = contact == "hertz" ? BasicContact::hertz : BasicContact::linear;
  options.friction = friction == "sliding" ? BasicFriction::sliding : BasicFriction::spin;
  options.tolerance = 1e-9;
  return options;
}

py::dict record(const std::map<std::string, double>& parameters, const StateTuple& initial,
                const std::string& contact, const std::string& friction, int turns_skipped, int turns_kept,
                int samples_per_turn) {
  const NamedValues named(parameters.begin(), parameters.end());
  const auto p = basicParametersFrom(named);
  checkBasicParameters(p);
  BasicRecord r;
  {
    const py::gil_scoped_release release;
    r = recordBasic(p, overOwnClearance(stateOf(initial), named), turns_skipped, turns_kept, samples_per_turn,
                    lawsOf(contact, friction));
  }
  std::vector<double> x, y, vx, vy;
  for (const auto& s : r.state) {
    x.push_back(s.x);
    y.push_back(s.y);
    vx.push_back(s.vx);
    vy.push_back(s.vy);
  }
  py::dict d;
  d["phase"] = ownedArray(std::move(r.phase));
  d["x"] = ownedArray(std::move(x));
  d["y"] = ownedArray(std::move(y));
  d["vx"] = ownedArray(std::move(vx));
  d["vy"] = ownedArray(std::move(vy));
  d["normal_force"] = ownedArray(std::move(r.normal_force));
  d["depth_rate"] = ownedArray(std::move(r.depth_rate));
  const double c = clearanceOf(named);  // the end can be the next one's initial state
  d["end"] = tupleOf({c * r.end.x, c * r.end.y, c * r.end.vx, c * r.end.vy});
  d["contact_fraction"] = r.contact_fraction;
  d["touch_downs"] = r.touch_downs;
  d["finite"] = r.finite;
  d["misalignment"] = py::make_tuple(p.misalignment_x, p.misalignment_y);
  return d;
}

/// Harmonic balance at a point of a branch, started from the orbit that shooting found.
py::dict harmonicBalanceAt(const BasicSweep& sweep, double value, const StateTuple& state, int turns,
                           int harmonics) {
  const ContinuationProblem problem = continuationProblem(sweep);
  const auto p = problem.machineAt(value);
  HarmonicBalanceOptions options;
  options.contact = sweep.run.contact;
  options.friction = sweep.run.friction;
  options.turns = turns;
  options.harmonics = harmonics * turns;
  HarmonicBalance found;
  {
    const py::gil_scoped_release release;
    const auto guess = recordBasic(p, stateOf(state), 0, turns, 4 * harmonics, problem.orbit);
    found = harmonicBalance(p, guess.state, options);
  }
  py::dict d;
  d["converged"] = found.converged;
  d["iterations"] = found.iterations;
  d["residual"] = found.residual;
  d["last_harmonics"] = found.last_harmonics;
  d["state"] = tupleOf(found.state);
  return d;
}

}  // namespace

void bindMotion(py::module_& m) {
  m.def("record_basic", &record, py::arg("parameters"), py::arg("initial"), py::arg("contact") = "linear",
        py::arg("friction") = "spin", py::arg("turns_skipped") = 400, py::arg("turns_kept") = 100,
        py::arg("samples_per_turn") = 200, "Event-accurate motion of one machine at evenly spaced phases.");
  m.def(
      "dry_whirl_friction",
      [](const std::map<std::string, double>& values, double whirl_speed) {
        return dryWhirlFriction(basicParametersFrom({values.begin(), values.end()}), whirl_speed);
      },
      py::arg("parameters"), py::arg("whirl_speed"),
      "Friction above which a backward whirl of this speed grows; NaN where there is none.");
  m.def("harmonic_balance_at", &harmonicBalanceAt, py::arg("sweep"), py::arg("value"), py::arg("state"),
        py::arg("turns"), py::arg("harmonics") = 64, "Harmonic balance at a point of a sweep file's branch.");
}

}  // namespace amb_rotor
