"""The hypothesis of a diagnosis as a picture: its force at a bearing, or at its plane, over each quantity that it depends on.

The law is `force_law` of the catalogue with the terms that were found. A vector (position, velocity, control current)
points along x; what is not on the axis of a picture is 0 in the first curve and at the end of its range, along x, in the
second, which shows products. Ranges are those of the runs without contact (99.5 % of the samples): beyond them a law that
was fitted says nothing. At end a, displacement and velocity as far as its sensors saw them go; terms that tilt the rotor have
the other sign at end b. Laws at one plane (`force_law_at_plane`) and of the tilt (`force_law_of_tilt`: over half of bearing b's
displacement less a's, the force at b) have the same terms; there, the rotor is taken as straight. Of a law of the sensors' signals
(`signal_law`) it is what is added to a signal, over the signal.
"""
from __future__ import annotations

import numpy

from amb_rotor.report import force
from amb_rotor.report.numbers import short

POINTS = 121
REACHED_PERCENT = 99.5
# Quantity: argument of the law, whether it is a vector, name and unit of its axis, axis over SI, least of its range.
_AXES = {"position": ("position", True, "displacement along x [µm]", 1e6, -1.0),
         "velocity": ("velocity", True, "velocity along x [mm/s]", 1e3, -1.0),
         "control current": ("current", True, "control current along x [A]", 1.0, -1.0),
         "shaft angle": ("angle_rad", False, "shaft angle [deg]", 180.0 / numpy.pi, 0.0),
         "spin speed": ("speed_rad_s", False, "spin speed [Hz]", 0.5 / numpy.pi, 0.0),
         "time": ("time_s", False, "time in the run [s]", 1.0, 0.0)}


def weights_of(unexplained: dict, sensor_z_m: tuple[float, float] | None, amb_z_m: tuple[float, float] | None) -> tuple[float, float]:
    """Of the displacements at the sensors a and b: their sum is that which a law goes by. Without planes: that at sensor a."""
    if not sensor_z_m or sensor_z_m[0] == sensor_z_m[1]:
        return 1.0, 0.0
    apart = sensor_z_m[1] - sensor_z_m[0]
    if unexplained.get("place") == "tilt" and amb_z_m:
        half = 0.5 * (amb_z_m[1] - amb_z_m[0]) / apart
        return -half, half
    if not unexplained.get("plane_z_m"):
        return 1.0, 0.0
    share = (unexplained["plane_z_m"]["value"] - sensor_z_m[0]) / apart
    return 1.0 - share, share


def reaches(runs: list[dict], weights: tuple[float, float] = (1.0, 0.0)) -> dict:
    """How far each quantity went, in SI, in runs without contact where there are any. weights: weights_of()."""
    quiet = [run for run in runs if not force.holds_contact(run)] or runs
    found = {name: 0.0 for name in _AXES} | {"shaft angle": 2.0 * numpy.pi}

    def take(name, values):
        values = numpy.abs(values[numpy.isfinite(values)])
        if values.size:
            found[name] = max(found[name], float(numpy.percentile(values, REACHED_PERCENT)))

    for run in quiet:
        rate, measured = run["sample_rate_hz"], run["measured"]
        half = max(2, round(0.5 * force.WINDOW_S * rate))
        place = weights[0] * measured[:, 0:2]
        if weights[1]:
            place = place + weights[1] * measured[:, 2:4]
        take("position", place)
        if len(measured) > 2 * half:
            for axis in (0, 1):
                take("velocity", force.parabola(place[:, axis], half, rate)[1])
        take("control current", measured[:, 4:6])
        take("spin speed", numpy.asarray(run["speed_rad_s"]))
        found["time"] = max(found["time"], len(measured) / rate)
    return found


def law_curves(unexplained: dict, runs: list[dict], sensor_z_m: tuple[float, float] | None = None,
               amb_z_m: tuple[float, float] | None = None) -> list[dict]:
    """For each quantity of the law {quantity, axis, at, curves: [{name, x, y}]}: where it is evaluated, in the unit of its axis,
    and F_x and F_y [N] there; of a law of the signals, what is added to them [µm]. Empty where there is no law by terms (a line of
    fixed frequency has none). sensor_z_m, amb_z_m: of a and b, for a law at one plane and of the tilt."""
    from amb_rotor import _core
    terms = {term["term"]: term["coefficient"] for term in unexplained["terms"]}
    shown = [name for name in _AXES if name in unexplained["depends_on"]]
    if not terms or not shown:
        return []
    signals = unexplained.get("place") == "sensors"
    law = "signal_law" if signals else "force_law"
    schema = next(effect for effect in _core.effect_catalogue() if effect["id"] == law)
    names = [parameter["name"] for parameter in schema["parameters"]]
    values = [terms.get(name, 0.0) for name in names]
    width = "step_width_m" if signals else "step_width_A"
    values[names.index(width)] = unexplained.get(width) or schema["parameters"][-1]["typical"]
    if unexplained.get("frequency_hz"):
        values[names.index("time_frequency_hz")] = unexplained["frequency_hz"]
    reach = reaches(runs, weights_of(unexplained, sensor_z_m, amb_z_m))

    def at(place: dict) -> tuple[float, float]:
        arguments = {}
        for name, (argument, vector, _, _, _) in _AXES.items():
            value = place.get(name, 0.0)
            arguments[argument] = (value, 0.0) if vector else value
        if not signals:
            return _core.bearing_force(law, values, **arguments)
        signal = arguments.pop("position")
        told = _core.sensor_signal(law, values, signal, **{key: arguments[key] for key in ("angle_rad", "speed_rad_s", "time_s")})
        return tuple(1e6 * (after - before) for after, before in zip(told, signal))

    result = []
    for name in shown:
        _, _, axis, factor, least = _AXES[name]
        places = numpy.linspace(least * reach[name], reach[name], POINTS)
        curves = []
        for label, others in (("others at 0", {}), ("others at their end", reach)):
            rest = {other: others.get(other, 0.0) for other in shown if other != name}
            made = numpy.array([at(rest | {name: place}) for place in places])
            curves.append({"name": label if len(shown) > 1 else "", "x": short(made[:, 0]), "y": short(made[:, 1])})
            if len(shown) == 1:
                break
        result.append({"quantity": name, "axis": axis, "at": short(factor * places), "curves": curves})
    return result
