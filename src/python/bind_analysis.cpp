// amb_rotor._core: analysis of recorded motion, the same code as the analysis node.
#include "amb_rotor/analysis/contact.hpp"
#include "amb_rotor/analysis/harmonics.hpp"
#include "amb_rotor/analysis/lyapunov.hpp"
#include "amb_rotor/analysis/orbit.hpp"
#include "amb_rotor/analysis/poincare.hpp"
#include "amb_rotor/analysis/regime.hpp"
#include "amb_rotor/analysis/spectrum.hpp"
#include "amb_rotor/analysis/tacho.hpp"
#include "amb_rotor/analysis/whirl.hpp"
#include "amb_rotor/common/units.hpp"
#include "bind.hpp"

namespace py = pybind11;

namespace amb_rotor {
namespace {

using Column = std::vector<double>;

/// Nearer to the centre than this share of the clearance the rotor has no direction.
constexpr double least_radius_share = 1e-4;
/// Fewer points than this give no exponent.
constexpr std::size_t least_points = 100;

/// Times, x, y, vx, vy of the points of a section.
py::tuple asTuple(const std::vector<PoincarePoint>& points) {
  Column t, x, y, vx, vy;
  for (const auto& point : points) {
    t.push_back(point.time);
    x.push_back(point.x);
    y.push_back(point.y);
    vx.push_back(point.vx);
    vy.push_back(point.vy);
  }
  return py::make_tuple(ownedArray(std::move(t)), ownedArray(std::move(x)), ownedArray(std::move(y)),
                        ownedArray(std::move(vx)), ownedArray(std::move(vy)));
}

py::tuple asTuple(Spectrum&& s) {
  return py::make_tuple(ownedArray(std::move(s.frequency)), ownedArray(std::move(s.amplitude)));
}

CrossingDirection crossingDirection(const std::string& text) {
  if (text == "rising") return CrossingDirection::rising;
  if (text == "falling") return CrossingDirection::falling;
  if (text == "both") return CrossingDirection::both;
  throw InputError({{"", 0, "direction", text, "rising, falling or both"}});
}

py::dict waterfallOf(const Column& x, const Column& y, double sample_rate, std::size_t segment_length,
                     double overlap, const Column& speed, double start_time) {
  SpectrumOptions options;
  options.segment_length = segment_length;
  options.overlap = overlap;
  const Waterfall found = waterfall(x, y, sample_rate, options, speed, start_time);
  Column times, speeds, amplitudes;
  for (const auto& line : found.lines) {
    times.push_back(line.time);
    speeds.push_back(line.speed);
    amplitudes.insert(amplitudes.end(), line.amplitude.begin(), line.amplitude.end());
  }
  const auto lines = static_cast<py::ssize_t>(found.lines.size());
  const auto width = static_cast<py::ssize_t>(found.frequency.size());
  py::dict d;
  d["frequency"] = py::array_t<double>(width, found.frequency.data());
  d["time"] = ownedArray(std::move(times));
  d["speed"] = ownedArray(std::move(speeds));
  d["amplitude"] = ownedArray(std::move(amplitudes), {lines, width});
  return d;
}

/// The regime of a recorded motion with all that decided it.
py::dict motionFacts(const Column& time, const Column& angle, const Column& x, const Column& y,
                     const Column& normal_force, double clearance, double rotor_radius, double tolerance) {
  if (time.size() < 2)
    throw InputError({{"", 0, "time", std::to_string(time.size()), "two samples at least"}});
  const OrbitStatistics orbit = orbitStatistics(x, y, clearance);
  RegimeInput input;
  input.points = stroboscopicSection(time, angle, x, y);
  input.clearance = clearance;
  input.max_radius = orbit.max_radius;
  input.spin = (angle.back() - angle.front()) / (time.back() - time.front());
  input.rotor_radius = rotor_radius;
  input.contact = contactStatistics(time, normal_force, x, y);
  input.whirl = whirlFromOrbit(time, x, y, 0.0, 0.0, least_radius_share * clearance);
  const RegimeResult regime = decideRegime(input, tolerance);
  py::dict d;
  d["regime"] = toString(regime.regime);
  d["period"] = regime.period;
  d["certain"] = regime.certain;
  d["reason"] = regime.reason;
  d["slip"] = toString(regime.slip);
  d["repeat_error"] = regime.repeat_error;
  d["winding_number"] = regime.winding_number;
  d["chaos_number"] = regime.chaos_number;
  d["forecast_ratio"] = regime.forecast_ratio;
  d["turns"] = static_cast<long>(input.points.size());
  d["max_radius"] = orbit.max_radius_over_clearance;
  d["mean_radius"] = orbit.mean_radius_over_clearance;
  d["contact_fraction"] = input.contact.contact_fraction;
  d["impacts"] = input.contact.impacts;
  d["max_force"] = input.contact.max_force;
  d["rub_arc_rad"] = input.contact.rub_arc;
  d["whirl"] = toString(input.whirl.direction);
  d["whirl_rad_s"] = input.whirl.frequency;
  d["largest_lyapunov"] = py::none();
  if (input.points.size() >= least_points) {
    Eigen::MatrixXd states(2, static_cast<Eigen::Index>(input.points.size()));
    for (std::size_t i = 0; i < input.points.size(); ++i) {
      states.col(static_cast<Eigen::Index>(i)) << input.points[i].x / clearance,
          input.points[i].y / clearance;
    }
    const SeriesLyapunov found = lyapunovFromSeries(states);
    if (found.valid) {
      d["largest_lyapunov"] = found.exponent;
      d["largest_lyapunov_error"] = found.standard_error;
    }
  }
  return d;
}

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
      [](const Column& time, const Column& angle, const Column& x, const Column& y, double phase) {
        const py::tuple all = asTuple(stroboscopicSection(time, angle, x, y, {}, {}, phase));
        return py::make_tuple(all[0], all[1], all[2]);
      },
      py::arg("time"), py::arg("angle"), py::arg("x"), py::arg("y"), py::arg("phase") = 0.0,
      "Times, x and y once a turn, at the angle `phase`.");
  m.def(
      "surface_section",
      [](const Column& time, const Column& surface, const Column& x, const Column& y,
         const std::string& direction) {
        return asTuple(surfaceSection(time, surface, x, y, crossingDirection(direction)));
      },
      py::arg("time"), py::arg("surface"), py::arg("x"), py::arg("y"), py::arg("direction") = "rising",
      "Times, x, y, vx, vy where `surface` crosses 0.");
  m.def(
      "amplitude_spectrum",
      [](const Column& signal, double sample_rate_hz) {
        return asTuple(amplitudeSpectrum(signal, sample_rate_hz));
      },
      py::arg("signal"), py::arg("sample_rate_hz"), "Frequencies and amplitudes.");
  m.def(
      "full_spectrum",
      [](const Column& x, const Column& y, double sample_rate_hz, std::size_t segment_length) {
        SpectrumOptions options;
        options.segment_length = segment_length;
        return asTuple(fullSpectrum(x, y, sample_rate_hz, options));
      },
      py::arg("x"), py::arg("y"), py::arg("sample_rate_hz"), py::arg("segment_length") = 0,
      "Frequencies (negative: backward) and amplitudes.");
  m.def("waterfall", &waterfallOf, py::arg("x"), py::arg("y"), py::arg("sample_rate_hz"),
        py::arg("segment_length"), py::arg("overlap") = 0.5, py::arg("speed") = Column{},
        py::arg("start_time") = 0.0,
        "Short-time spectra: frequency, time, speed, amplitude[line, frequency].");
  m.def(
      "shaft_angle",
      [](const Column& time, const Column& tacho, double threshold) {
        TachoOptions options;
        options.threshold = threshold;
        options.hysteresis = 0.5 * std::abs(threshold);
        const TachoPulses pulses = findPulses(time, tacho, options);
        const ShaftAngle shaft = pulses.state == TachoState::turning ? ShaftAngle(pulses) : ShaftAngle();
        return py::make_tuple(ownedArray(shaft.angles(time)), ownedArray(shaft.speeds(time)));
      },
      py::arg("time"), py::arg("tacho"), py::arg("threshold") = 0.5,
      "Angle [rad] and speed [rad/s] at each time; 0 where no pulses come.");
  m.def("motion_facts", &motionFacts, py::arg("time"), py::arg("angle"), py::arg("x"), py::arg("y"),
        py::arg("normal_force"), py::arg("clearance"), py::arg("rotor_radius") = 0.0,
        py::arg("tolerance") = 0.01,
        "Regime of a recorded motion about the auxiliary bearing's centre, with what decided it.");
}

}  // namespace amb_rotor
