// amb_rotor._core: analysis of recorded motion, the same code as the analysis node.
#include "amb_rotor/analysis/harmonics.hpp"
#include "amb_rotor/analysis/poincare.hpp"
#include "amb_rotor/analysis/spectrum.hpp"
#include "bind.hpp"

namespace py = pybind11;

namespace amb_rotor {
namespace {

using Column = std::vector<double>;

}  // namespace

void bindAnalysis(py::module_& m) {
  m.def(
      "orders",
      [](const Column& angle, const Column& x, const Column& y, int max_order) {
        OrderOptions options;
        options.max_order = max_order;
        const OrderAnalysis found = orderAnalysis(angle, x, y, options);
        py::dict d, forward, backward;
        for (const auto& c : found.components) {
          forward[py::float_(c.order)] = py::make_tuple(c.forward.real(), c.forward.imag());
          backward[py::float_(c.order)] = py::make_tuple(c.backward.real(), c.backward.imag());
        }
        d["valid"] = found.valid;
        d["reason"] = found.reason;
        d["forward"] = forward;
        d["backward"] = backward;
        return d;
      },
      py::arg("angle"), py::arg("x"), py::arg("y"), py::arg("max_order") = 5);
  m.def(
      "stroboscopic_section",
      [](const Column& time, const Column& angle, const Column& x, const Column& y) {
        Column px, py_, pt;
        for (const auto& point : stroboscopicSection(time, angle, x, y)) {
          pt.push_back(point.time);
          px.push_back(point.x);
          py_.push_back(point.y);
        }
        return py::make_tuple(ownedArray(std::move(pt)), ownedArray(std::move(px)),
                              ownedArray(std::move(py_)));
      },
      py::arg("time"), py::arg("angle"), py::arg("x"), py::arg("y"),
      "Times, x and y once a turn, at angle 0.");
  m.def(
      "full_spectrum",
      [](const Column& x, const Column& y, double sample_rate_hz, std::size_t segment_length) {
        SpectrumOptions options;
        options.segment_length = segment_length;
        Spectrum s = fullSpectrum(x, y, sample_rate_hz, options);
        return py::make_tuple(ownedArray(std::move(s.frequency)), ownedArray(std::move(s.amplitude)));
      },
      py::arg("x"), py::arg("y"), py::arg("sample_rate_hz"), py::arg("segment_length") = 0,
      "Frequencies (negative: backward) and amplitudes.");
}

}  // namespace amb_rotor
