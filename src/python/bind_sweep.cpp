// amb_rotor._core: the basic model's lanes and sweeps.
#include <pybind11/complex.h>
#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

#include <cstring>

#include "amb_rotor/machine/basic_annular_rub.hpp"
#include "amb_rotor/machine/basic_continuation.hpp"
#include "amb_rotor/machine/basic_sweep.hpp"

namespace py = pybind11;

namespace amb_rotor {
namespace {

py::array_t<double> numbers(const std::vector<double>& values) {
  return py::array_t<double>(static_cast<py::ssize_t>(values.size()), values.data());
}

py::array_t<double> states(const std::vector<BasicState<double>>& all, std::vector<py::ssize_t> shape) {
  shape.push_back(4);
  py::array_t<double> array(shape);
  static_assert(sizeof(BasicState<double>) == 4 * sizeof(double));
  std::memcpy(array.mutable_data(), all.data(), all.size() * sizeof(BasicState<double>));
  return array;
}

/// What the lanes say, as numpy arrays; exponents per unit of dimensionless time.
py::dict asDict(const BasicLaneResult& r, const std::vector<BasicMotion>& motions,
                const std::vector<double>& frequency_ratios) {
  py::dict d;
  const auto n = static_cast<py::ssize_t>(r.machines);
  d["end"] = states(r.end, {n});
  d["sections"] = states(r.sections, {n, r.turns_kept});
  d["contact_fraction"] = numbers(r.contact_fraction);
  d["max_radius"] = numbers(r.max_radius);
  d["min_radius"] = numbers(r.min_radius);
  d["whirl"] = numbers(r.whirl);
  d["machine_steps"] = r.machine_steps;
  d["instruction_set"] = r.instruction_set;
  std::vector<double> exponents;
  for (std::size_t i = 0; i < r.lyapunov.size(); ++i) {
    exponents.push_back(exponentPerTime(r.lyapunov[i], frequency_ratios[i]));
  }
  if (!exponents.empty()) d["largest_lyapunov"] = numbers(exponents);
  if (motions.empty() && r.turns_kept > 0) {
    py::array_t<int> periods(n);
    for (std::size_t i = 0; i < r.machines; ++i) {
      const auto* first = &r.sections[i * static_cast<std::size_t>(r.turns_kept)];
      periods.mutable_at(static_cast<py::ssize_t>(i)) = r.diverged[i] ? 0 : basicPeriod(first, r.turns_kept);
    }
    d["period"] = periods;
  }
  if (!motions.empty()) {
    py::list regimes;
    py::array_t<int> periods(n);
    for (std::size_t i = 0; i < motions.size(); ++i) {
      regimes.append(toString(motions[i].regime));
      periods.mutable_at(static_cast<py::ssize_t>(i)) = motions[i].period;
    }
    d["regime"] = regimes;
    d["period"] = periods;
  }
  return d;
}

using Columns = std::map<std::string, py::array_t<double, py::array::c_style | py::array::forcecast>>;

py::dict runLanes(const Columns& parameters,
                  const py::array_t<double, py::array::c_style | py::array::forcecast>& initial,
                  const std::string& contact, const std::string& friction, int steps_per_turn,
                  int turns_skipped, int turns_kept, bool regimes, int threads) {
  py::ssize_t n = 1;
  for (const auto& [key, column] : parameters) n = std::max(n, column.size());
  std::vector<BasicParameters<double>> machines;
  std::vector<NamedValues> named;
  std::vector<double> frequency_ratios;
  for (py::ssize_t i = 0; i < n; ++i) {
    NamedValues values;
    for (const auto& [key, column] : parameters) {
      if (column.size() != 1 && column.size() != n) {
        throw InputError({{"", 0, key, std::to_string(column.size()), "one value, or one for each machine"}});
      }
      values.emplace_back(key, column.data()[column.size() == 1 ? 0 : i]);
    }
    machines.push_back(basicParametersFrom(values));
    named.push_back(std::move(values));
    frequency_ratios.push_back(machines.back().frequency_ratio);
  }
  if (initial.size() % 4 != 0) {
    throw InputError({{"", 0, "initial", std::to_string(initial.size()), "x, y, vx, vy for each machine"}});
  }
  std::vector<BasicState<double>> start(static_cast<std::size_t>(initial.size() / 4));
  std::memcpy(static_cast<void*>(start.data()), initial.data(), start.size() * sizeof(BasicState<double>));
  if (parameters.count(clearance_name) > 0) {
    if (start.size() == 1) start.resize(machines.size(), start.front());
    for (std::size_t i = 0; i < std::min(start.size(), named.size()); ++i)
      start[i] = overOwnClearance(start[i], named[i]);
  }
  BasicLaneOptions options;
  options.contact = contact == "hertz" ? BasicContact::hertz : BasicContact::linear;
  options.friction = friction == "sliding" ? BasicFriction::sliding : BasicFriction::spin;
  options.steps_per_turn = steps_per_turn;
  options.turns_skipped = turns_skipped;
  options.turns_kept = turns_kept;
  options.lyapunov = regimes;
  options.threads = threads;
  BasicLaneResult result;
  std::vector<BasicMotion> motions;
  {
    py::gil_scoped_release release;
    result = runBasicLanes(machines, start, options);
    if (regimes) motions = basicMotions(result);
  }
  return asDict(result, motions, frequency_ratios);
}

py::dict asDict(const BranchPoint& p) {
  py::dict d;
  d["parameter"] = p.parameter;
  d["state"] = py::make_tuple(p.state.x, p.state.y, p.state.vx, p.state.vy);
  d["multipliers"] = std::vector<std::complex<double>>(p.multipliers.begin(), p.multipliers.end());
  d["stable"] = p.stable;
  d["max_radius"] = p.max_radius;
  d["contact_fraction"] = p.contact_fraction;
  d["touch_downs"] = p.touch_downs;
  return d;
}

py::list continuation(const BasicSweep& sweep) {
  if (!sweep.continuation.given) {
    throw InputError({{"", 0, "continuation", "", "the key is missing: what to follow, and from where"}});
  }
  std::vector<Branch> branches;
  {
    py::gil_scoped_release release;
    branches = runContinuation(sweep, [] {
      py::gil_scoped_acquire acquire;  // Ctrl-C
      if (PyErr_CheckSignals() != 0) throw py::error_already_set();
    });
  }
  py::list all;
  for (const auto& branch : branches) {
    py::dict d;
    py::list points, bifurcations;
    for (const auto& point : branch.points) points.append(asDict(point));
    for (const auto& found : branch.bifurcations) {
      py::dict b = asDict(found.at);
      b["kind"] = name(found.kind);
      bifurcations.append(b);
    }
    d["turns"] = branch.turns;
    d["points"] = points;
    d["bifurcations"] = bifurcations;
    d["ended"] = branch.ended;
    all.append(d);
  }
  return all;
}

NamedValues namedValues(const std::map<std::string, double>& values) {
  return {values.begin(), values.end()};
}

}  // namespace

void bindSweep(py::module_& m) {
  m.def("basic_parameter_names", &basicParameterNames);
  m.def(
      "annular_rub_border",
      [](const std::map<std::string, double>& values) {
        return annularRubFrictionBorder(basicParametersFrom(namedValues(values)));
      },
      py::arg("parameters"), "Friction at which the synchronous full annular rub loses its stability.");
  m.def(
      "annular_rub_radii",
      [](const std::map<std::string, double>& values) {
        return annularRubRadii(basicParametersFrom(namedValues(values)));
      },
      py::arg("parameters"));
  m.def(
      "annular_rub_stable",
      [](const std::map<std::string, double>& values, double radius) {
        return annularRubStable(basicParametersFrom(namedValues(values)), radius);
      },
      py::arg("parameters"), py::arg("radius"));
  m.def("run_basic_lanes", &runLanes, py::arg("parameters"), py::arg("initial"),
        py::arg("contact") = "linear", py::arg("friction") = "spin", py::arg("steps_per_turn") = 200,
        py::arg("turns_skipped") = 400, py::arg("turns_kept") = 100, py::arg("regimes") = true,
        py::arg("threads") = 0,
        "Runs machines of the basic model side by side. parameters: name -> one value or one a machine.");
  py::class_<BasicSweep>(m, "BasicSweep", "A sweep of the basic model, read from an amb-sweep/1 file.")
      .def(py::init(&readBasicSweep), py::arg("path"))
      .def_readonly("name", &BasicSweep::name)
      .def_readonly("title", &BasicSweep::title)
      .def_readonly("source", &BasicSweep::source)
      .def_property_readonly("size", &BasicSweep::size)
      .def_property_readonly(
          "contact",
          [](const BasicSweep& s) { return s.run.contact == BasicContact::hertz ? "hertz" : "linear"; })
      .def_property_readonly(
          "friction_law",
          [](const BasicSweep& s) { return s.run.friction == BasicFriction::sliding ? "sliding" : "spin"; })
      .def_property_readonly("steps_per_turn", [](const BasicSweep& s) { return s.run.steps_per_turn; })
      .def_property_readonly("kept_turns", [](const BasicSweep& s) { return s.run.turns_kept; })
      .def_property_readonly("turns",
                             [](const BasicSweep& s) { return s.run.turns_kept + s.run.turns_skipped; })
      .def_property_readonly("axes",
                             [](const BasicSweep& s) {
                               py::list axes;
                               for (const auto& axis : s.swept) {
                                 axes.append(py::make_tuple(axis.parameter, numbers(axis.values)));
                               }
                               return axes;
                             })
      .def_property_readonly("parameters",
                             [](const BasicSweep& s) {
                               py::dict values;
                               for (const auto& [key, value] : s.parameters) values[py::str(key)] = value;
                               return values;
                             })
      .def_property_readonly("initial",
                             [](const BasicSweep& s) {
                               const auto& i = s.initial.front();
                               return py::make_tuple(i.x, i.y, i.vx, i.vy);
                             })
      .def_property_readonly("continued_parameter",
                             [](const BasicSweep& s) { return s.continuation.parameter; })
      .def("run_continuation", &continuation, "Branches of periodic motion that the file asks for.")
      .def("values_at", &BasicSweep::valuesAt, py::arg("point"))
      .def(
          "run",
          [](const BasicSweep& sweep, std::size_t first, std::size_t count) {
            if (count == 0 || first + count > sweep.size()) throw py::index_error("points outside the grid");
            BasicSweepPart part;
            std::vector<double> frequency_ratios;
            {
              py::gil_scoped_release release;
              part = runBasicSweep(sweep, first, count);
              for (std::size_t i = 0; i < count; ++i) {
                frequency_ratios.push_back(sweep.machineAt(first + i).frequency_ratio);
              }
            }
            return asDict(part.lanes, part.motions, frequency_ratios);
          },
          py::arg("first"), py::arg("count"), "Points [first, first + count) of the grid.");
}

}  // namespace amb_rotor
