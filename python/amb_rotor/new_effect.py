"""A new effect from the law that a diagnosis proposes: as a file of format amb-effect/1 (as C++: new_effect_cpp.py).

Each term of the law (the hypothesis effects `force_law`, `force_law_at_plane` of one plane of the rotor and `force_law_of_tilt`)
is known here as a force, in the formulas of effect files and in C++. p = (x, y) is the rotor's displacement at a magnetic bearing
or that plane, or half of bearing b's less a's, v its velocity, i the current, t the shaft's angle. Terms of `signal_law` are what
is added to the signals (x, y) of a sensor pair.
"""
from __future__ import annotations

import dataclasses
import re

# v/|v| is tanh of so many times the speed [s/m], as in force_law.
_ROUNDED, _SHARP = "1e3", "1e4"


@dataclasses.dataclass(frozen=True)
class Term:
    """One term of a law: its name and unit, what it is, and its force per unit of the coefficient."""
    name: str
    unit: str
    meaning: str
    excited_by: str
    x: str
    y: str
    cpp_x: str
    cpp_y: str
    role: str = "plain"


def _along(name, unit, meaning, excited_by, factor, cpp_factor, vector=("x", "y"), cpp="p"):
    """A term along a vector: factor times it."""
    times, cpp_times = (f" * {factor}" if factor else ""), (f"{cpp_factor} * " if cpp_factor else "")
    return Term(name, unit, meaning, excited_by, f"{vector[0]}{times}", f"{vector[1]}{times}",
                f"{cpp_times}{cpp}.x", f"{cpp_times}{cpp}.y")


_MOTION = "large and small amplitudes: steps, chirps, rotation near a critical speed"
_VELOCITY = ("vx", "vy")
_CURRENT = ("ix", "iy")
_SPEED = "runs at two or more speeds"
_LONG = "long runs"
_SIGN, _CPP_SIGN = f"tanh({_ROUNDED} * rate) / rate", f"hyperbolicTangent(S({_ROUNDED}) * rate) / rate"
# (cos nt, sin nt) from the cosine c and sine s of the angle, as force_law has them.
_CPP_TURNS = {"": ("shaft.cosine", "shaft.sine"), "2": ("c2", "s2"), "3": ("c3", "s3")}


def _turning(name: str, order: str, back: bool) -> list[Term]:
    """Cosine and sine term of a force that turns at n times the shaft's angle, forward or backward."""
    cos, sin = (f"{function}({order + ' * ' if order else ''}angle)" for function in ("cos", "sin"))
    c, s = _CPP_TURNS[order]
    t, sign = f"{order}t", "" if back else "-"
    if back:
        return [Term(f"{name}_cosine_N", "N", f"(cos {t}, -sin {t})", "rotation", cos, f"-{sin}", c, f"-{s}"),
                Term(f"{name}_sine_N", "N", f"(sin {t}, cos {t})", "rotation", sin, cos, s, c)]
    return [Term(f"{name}_cosine_N", "N", f"(cos {t}, sin {t})", "rotation", cos, sin, c, s),
            Term(f"{name}_sine_N", "N", f"({sign}sin {t}, cos {t})", "rotation", f"-{sin}", cos, f"-{s}", c)]


def _axes(name: str, unit: str, meaning: str, excited_by: str, factor: str, cpp: str) -> list[Term]:
    """The same factor along x and along y."""
    return [Term(f"{name}_x_{unit}", unit.replace("_per_", "/").replace("_", " "), f"{meaning} e_x", excited_by, factor, "0",
                 cpp, "S(0.0)"),
            Term(f"{name}_y_{unit}", unit.replace("_per_", "/").replace("_", " "), f"{meaning} e_y", excited_by, "0", factor,
                 "S(0.0)", cpp)]


def _hum(axis: str, function: str) -> Term:
    formula = f"{function}(2 * pi * {FREQUENCY} * time)"
    cpp = f"hum_{'cosine' if function == 'cos' else 'sine'}"
    name = f"hum_{axis}_{'cosine' if function == 'cos' else 'sine'}_N"
    x, y = (formula, "0") if axis == "x" else ("0", formula)
    cpp_x, cpp_y = (cpp, "S(0.0)") if axis == "x" else ("S(0.0)", cpp)
    return Term(name, "N", f"{function}(2 pi f time) e_{axis}", _LONG, x, y, cpp_x, cpp_y)


def _antisymmetric(term: Term) -> Term:
    """The term with the other sign at end a."""
    name = f"antisym_{term.name}"
    return Term(name, term.unit, f"-+ {term.meaning.split(': ')[-1]}", f"tilting motion; {term.excited_by}",
                f"(2 * end - 1) * ({term.x})", f"(2 * end - 1) * ({term.y})", f"side * ({term.cpp_x})", f"side * ({term.cpp_y})")


# The frequency of the terms that repeat in time: one more parameter of an effect that has such a term.
FREQUENCY = "time_frequency_hz"
# The axial position of a law at one plane: its last parameter. The width of a step in the signals, or the current: likewise.
PLANE = "z_m"
WIDTH, CURRENT_WIDTH = "step_width_m", "step_width_A"


@dataclasses.dataclass(frozen=True)
class Place:
    """Where a law acts, as in effect files: magnetic_bearings, rotor (at the plane z_m), tilt, sensors."""
    kind: str = "magnetic_bearings"
    z_m: float | None = None
    step_width: float | None = None  # of the signals [m], of the current [A]

    @staticmethod
    def of(unexplained: dict) -> Place:
        plane = unexplained.get("plane_z_m")
        if plane:
            return Place("rotor", plane["value"])
        return Place(unexplained.get("place", Place.kind), None, unexplained.get(WIDTH) or unexplained.get(CURRENT_WIDTH))


BEARINGS = Place()
# Each place: where it is in words, what its line in an effect file says beside it, the quantities of its formulas.
_PLACES = {"magnetic_bearings": ("a force at the bearings", "or: rotor (at a parameter z_m), tilt, sensors",
                                 "x y vx vy ix iy angle speed time end"),
           "rotor": ("a force at one plane of the rotor", "at z_m; or: magnetic_bearings, tilt, sensors",
                     "x y vx vy angle speed time"),
           "tilt": ("a couple", "the force at bearing b, its opposite at a; or: magnetic_bearings, rotor, sensors",
                    "x y vx vy angle speed time, (x, y) = (p_b - p_a)/2"),
           "sensors": ("signals of the sensors", "added to each; or: magnetic_bearings, rotor, tilt",
                       "x y angle speed time end, (x, y) the signals so far")}


_PLAIN = (
    _along("position_N_per_m", "N/m", "stiffness: p", "any motion", "", ""),
    _along("position_square_N_per_m2", "N/m2", "|p| p", _MOTION, "radius", "radius"),
    _along("position_cube_N_per_m3", "N/m3", "|p|^2 p", _MOTION, "radius^2", "radius * radius"),
    _along("position_fourth_N_per_m4", "N/m4", "|p|^3 p", _MOTION, "radius^3", "radius * radius * radius"),
    Term("position_axes_N_per_m", "N/m", "(x, -y)", "motion in both directions", "x", "-y", "p.x", "-p.y"),
    Term("position_mixed_N_per_m", "N/m", "(y, x)", "motion in both directions", "y", "x", "p.y", "p.x"),
    Term("position_axes_cube_N_per_m3", "N/m3", "(x^3, y^3)", _MOTION, "x^3", "y^3", "p.x * p.x * p.x", "p.y * p.y * p.y"),
    _along("velocity_N_s_per_m", "N s/m", "damping: v", "any motion", "", "", _VELOCITY, "v"),
    Term("velocity_axes_N_s_per_m", "N s/m", "(vx, -vy)", "motion in both directions", "vx", "-vy", "v.x", "-v.y"),
    Term("velocity_mixed_N_s_per_m", "N s/m", "(vy, vx)", "motion in both directions", "vy", "vx", "v.y", "v.x"),
    Term("velocity_cross_N_s_per_m", "N s/m", "(-vy, vx)", "excitation in one direction", "-vy", "vx", "-v.y", "v.x"),
    _along("velocity_square_N_s2_per_m2", "N s2/m2", "|v| v", _MOTION, "rate", "rate", _VELOCITY, "v"),
    Term("velocity_axes_square_N_s2_per_m2", "N s2/m2", "(|vx| vx, |vy| vy)", _MOTION, "abs(vx) * vx", "abs(vy) * vy",
         "magnitude(v.x) * v.x", "magnitude(v.y) * v.y"),
    _along("velocity_sign_N", "N", "v/|v|, rounded off below 1 mm/s", _MOTION, _SIGN, _CPP_SIGN, _VELOCITY, "v"),
    _along("velocity_sharp_sign_N", "N", "v/|v|, rounded off below 0.1 mm/s", _MOTION, f"tanh({_SHARP} * rate) / rate",
           f"hyperbolicTangent(S({_SHARP}) * rate) / rate", _VELOCITY, "v"),
    _along("velocity_position_N_s_per_m3", "N s/m3", "|p|^2 v", _MOTION, "radius^2", "radius * radius", _VELOCITY, "v"),
    _along("sign_position_N_per_m", "N/m", "|p| v/|v|, rounded off below 1 mm/s", _MOTION, f"radius * {_SIGN}",
           f"radius * {_CPP_SIGN}", _VELOCITY, "v"),
    Term("cross_N_per_m", "N/m", "(-y, x)", "excitation in one direction", "-y", "x", "-p.y", "p.x"),
    Term("cross_speed_N_s_per_m", "N s/m", "speed (-y, x)", _SPEED, "-y * speed", "x * speed", "-shaft.speed * p.y",
         "shaft.speed * p.x"),
    _along("position_speed_N_s2_per_m", "N s2/m", "speed^2 p", _SPEED, "speed^2", "shaft.speed * shaft.speed"),
    _along("position_turn_N_s_per_m", "N s/m", "|speed| p", _SPEED, "abs(speed)", "magnitude(shaft.speed)"),
    Term("cross_position_speed_N_s_per_m2", "N s/m2", "speed |p| (-y, x)", _SPEED, "-y * radius * speed", "x * radius * speed",
         "-shaft.speed * radius * p.y", "shaft.speed * radius * p.x"),
    _along("velocity_speed_N_s2_per_m", "N s2/m", "|speed| v", _SPEED, "abs(speed)", "magnitude(shaft.speed)", _VELOCITY,
           "v"),
    Term("velocity_cross_speed_N_s2_per_m", "N s2/m", "speed (-vy, vx)", _SPEED, "-vy * speed", "vx * speed",
         "-shaft.speed * v.y", "shaft.speed * v.x"),
    *_turning("turning", "", False), *_turning("twice", "2", False), *_turning("thrice", "3", False),
    *_turning("back", "", True), *_turning("back_twice", "2", True), *_turning("back_thrice", "3", True),
    Term("turning_speed_cosine_N_s", "N s", "speed (cos t, sin t)", _SPEED, "speed * cos(angle)", "speed * sin(angle)",
         "shaft.speed * shaft.cosine", "shaft.speed * shaft.sine"),
    Term("turning_speed_sine_N_s", "N s", "speed (-sin t, cos t)", _SPEED, "-speed * sin(angle)", "speed * cos(angle)",
         "-shaft.speed * shaft.sine", "shaft.speed * shaft.cosine"),
    Term("turning_position_cosine_N_per_m", "N/m", "(x cos 2t + y sin 2t, x sin 2t - y cos 2t)", "rotation under load",
         "x * cos(2 * angle) + y * sin(2 * angle)", "x * sin(2 * angle) - y * cos(2 * angle)", "p.x * c2 + p.y * s2",
         "p.x * s2 - p.y * c2"),
    Term("turning_position_sine_N_per_m", "N/m", "(y cos 2t - x sin 2t, x cos 2t + y sin 2t)", "rotation under load",
         "y * cos(2 * angle) - x * sin(2 * angle)", "x * cos(2 * angle) + y * sin(2 * angle)", "p.y * c2 - p.x * s2",
         "p.x * c2 + p.y * s2"),
    *_axes("speed", "N_s", "speed", _SPEED, "speed", "shaft.speed"),
    *_axes("speed_square", "N_s2", "speed^2", _SPEED, "speed^2", "shaft.speed * shaft.speed"),
    _along("current_N_per_A", "N/A", "i", "excitation", "", "", _CURRENT, "i"),
    Term("current_axes_N_per_A", "N/A", "(ix, -iy)", "excitation in both directions", "ix", "-iy", "i.x", "-i.y"),
    Term("current_mixed_N_per_A", "N/A", "(iy, ix)", "excitation in one direction", "iy", "ix", "i.y", "i.x"),
    Term("current_cross_N_per_A", "N/A", "(-iy, ix)", "excitation in one direction", "-iy", "ix", "-i.y", "i.x"),
    _along("current_square_N_per_A2", "N/A2", "|i| i", "large excitation", "hypot(ix, iy)", "squareRoot(i.dot(i))", _CURRENT, "i"),
    _along("current_cube_N_per_A3", "N/A3", "|i|^2 i", "large excitation", "(ix^2 + iy^2)", "i.dot(i)", _CURRENT, "i"),
    Term("current_axes_cube_N_per_A3", "N/A3", "(ix^3, iy^3)", "large excitation", "ix^3", "iy^3", "i.x * i.x * i.x",
         "i.y * i.y * i.y"),
    Term("current_axes_square_N_per_A2", "N/A2", "(ix^2, iy^2)", "large excitation", "ix^2", "iy^2", "i.x * i.x", "i.y * i.y"),
    Term("current_axes_sign_N", "N", f"(tanh(ix/w), tanh(iy/w)), w = {CURRENT_WIDTH}", "excitation", f"tanh(ix / {CURRENT_WIDTH})",
         f"tanh(iy / {CURRENT_WIDTH})", f"hyperbolicTangent(i.x / {CURRENT_WIDTH})", f"hyperbolicTangent(i.y / {CURRENT_WIDTH})"),
    _along("current_position_N_per_A2_m", "N/(A2 m)", "|i|^2 p", "large excitation", "(ix^2 + iy^2)", "i.dot(i)"),
    *_axes("drift", "N_per_s", "time", _LONG, "time", "S(shaft.time)"),
    _along("drift_position_N_per_m_s", "N/(m s)", "time p", _LONG, "time", "S(shaft.time)"),
    _along("drift_velocity_N_per_m", "N/m", "time v", _LONG, "time", "S(shaft.time)", _VELOCITY, "v"),
    _hum("x", "cos"), _hum("x", "sin"), _hum("y", "cos"), _hum("y", "sin"),
)
_BOTH_WAYS = ("position_N_per_m", "position_cube_N_per_m3", "velocity_N_s_per_m", "velocity_square_N_s2_per_m2",
              "velocity_sign_N", "cross_N_per_m", "velocity_speed_N_s2_per_m", "turning_cosine_N", "turning_sine_N",
              "current_cube_N_per_A3")
TERMS = {term.name: term for term in _PLAIN}
TERMS |= {f"antisym_{name}": _antisymmetric(TERMS[name]) for name in _BOTH_WAYS}


def _signal(term: Term) -> Term:
    """A force's term as one of the signal."""
    unit = {"N/m2": "1/m", "N s/m": "s", "N": "m", "N/(m s)": "1/s", "N/s": "m/s"}[term.unit]
    name = {"position_turn_N_s_per_m": "turn_s", "drift_position_N_per_m_s": "drift_per_s",
            "drift_x_N_per_s": "drift_x_m_per_s", "drift_y_N_per_s": "drift_y_m_per_s"}.get(term.name, term.name[:-1] + "m")
    return dataclasses.replace(term, name=f"signal_{name}", unit=unit)


_SIGNALS = (
    Term("signal_square_per_m", "1/m", "(|x| x, |y| y)", _MOTION, "abs(x) * x", "abs(y) * y", "magnitude(p.x) * p.x",
         "magnitude(p.y) * p.y"),
    Term("signal_even_per_m", "1/m", "(x^2, y^2)", _MOTION, "x^2", "y^2", "p.x * p.x", "p.y * p.y"),
    Term("signal_cube_per_m2", "1/m2", "(x^3, y^3)", _MOTION, "x^3", "y^3", "p.x * p.x * p.x", "p.y * p.y * p.y"),
    Term("signal_step_m", "m", f"(tanh(x/w), tanh(y/w)), w = {WIDTH}", _MOTION, f"tanh(x / {WIDTH})", f"tanh(y / {WIDTH})",
         f"hyperbolicTangent(p.x / {WIDTH})", f"hyperbolicTangent(p.y / {WIDTH})"),
    Term("signal_mixed", "1", "(y, x)", "motion in both directions", "y", "x", "p.y", "p.x"),
    *(_signal(TERMS[name]) for name in ("position_turn_N_s_per_m", "drift_position_N_per_m_s", "drift_x_N_per_s", "drift_y_N_per_s",
                                        "thrice_cosine_N", "thrice_sine_N", "back_thrice_cosine_N", "back_thrice_sine_N")),
)
SIGNAL_TERMS = {term.name: term for term in _SIGNALS}

# What the formulas call on beside the quantities; each is written where a term needs it.
_WHERE = {"radius": "hypot(x, y)", "rate": "sqrt(vx^2 + vy^2 + 1e-24)"}
# A fit may move a coefficient this many times its first value, either way.
_REACH = 1e3


# How far a frequency may move in a fit, and a plane from the centre of mass.
_FREQUENCY_REACH, _FARTHEST_PLANE_M = 0.02, 2.0
# Each width's unit, its value where a diagnosis does not tell it, and how many times that a fit may move it, either way.
_WIDTHS = {WIDTH: ("m", 1e-5), CURRENT_WIDTH: ("A", 0.05)}
_WIDTH_REACH = 10.0


def reads(text: str, name: str) -> bool:
    return re.search(rf"\b{name}\b", text) is not None


def _needed(terms: list[Term]) -> list[str]:
    return [name for name in _WHERE if any(reads(term.x + " " + term.y, name) for term in terms)]


def terms_of(rows: list[dict]) -> list[Term]:
    """What a diagnosis names. KeyError: a term that is not known."""
    known = TERMS | SIGNAL_TERMS
    return [known[row["term"]] for row in rows]


def _call_on(terms: list[dict], name: str) -> bool:
    """Whether a law has a term whose formula needs a number of its effect: the frequency that it repeats with, a step's width."""
    return any(reads(term.x + " " + term.y, name) for term in terms_of(terms))


def said(place: Place) -> str:
    return _PLACES[place.kind][0]


def parameters(terms: list[dict], frequency_hz: float | None = None, place: Place = BEARINGS) -> list[dict]:
    """The parameters of an effect with these terms, as in its file. term: a name that terms_of() knows, and a coefficient."""
    rows = []
    if _call_on(terms, FREQUENCY):
        frequency = 50.0 if frequency_hz is None else frequency_hz
        rows.append({"name": FREQUENCY, "unit": "Hz", "lower": (1 - _FREQUENCY_REACH) * frequency,
                     "upper": (1 + _FREQUENCY_REACH) * frequency, "typical": frequency, "meaning": "of the force in time"})
    for row, term in zip(terms, terms_of(terms)):
        value = float(f"{row['coefficient']:.6g}")
        reach = _REACH * abs(value) if value else 1.0
        rows.append({"name": term.name, "unit": term.unit, "lower": -reach, "upper": reach, "typical": value,
                     "neutral": 0.0, "meaning": f"{'signal' if place.kind == 'sensors' else 'force'} per {term.meaning}"})
    for name, (unit, unknown) in _WIDTHS.items():
        if not _call_on(terms, name):
            continue
        width = place.step_width or unknown
        rows.append({"name": name, "unit": unit, "lower": float(f"{width / _WIDTH_REACH:.3g}"), "upper": float(f"{width * _WIDTH_REACH:.3g}"),
                     "typical": float(f"{width:.6g}"), "meaning": "over which the step is rounded off"})
    if place.z_m is not None:
        rows.append({"name": PLANE, "unit": "m", "lower": -_FARTHEST_PLANE_M, "upper": _FARTHEST_PLANE_M,
                     "typical": float(f"{place.z_m:.6g}"), "meaning": "axial position"})
    return rows


def number(value: float) -> str:
    """As a YAML float: with a point."""
    text = repr(float(value))
    return text if "." in text or "e" not in text else text.replace("e", ".0e")


def yaml_file(name: str, terms: list[dict], summary: str, remarks: list[str], frequency_hz: float | None = None,
              place: Place = BEARINGS) -> str:
    """The effect file."""
    _, beside, names = _PLACES[place.kind]
    chosen = terms_of(terms)
    lines = [f"# {remark}" for remark in remarks]
    lines += ["format: amb-effect/1", f"effect: {name}", f'summary: "{summary}"',
              f'excited_by: "{"; ".join(dict.fromkeys(term.excited_by for term in chosen))}"',
              f"{f'place: {place.kind}':<37} # {beside}", "parameters:"]
    for row in parameters(terms, frequency_hz, place):
        keys = [key for key in ("lower", "upper", "typical", "neutral") if key in row]
        numbers = ", ".join(f"{key}: {number(row[key])}" for key in keys)
        lines.append(f'  - {{name: {row["name"]}, unit: "{row["unit"]}", {numbers},\n     meaning: "{row["meaning"]}"}}')
    needed = _needed(chosen)
    if needed:
        lines += ["where:"] + [f'  {key}: "{_WHERE[key]}"' for key in needed]
    lines.append(f"law:                                  # of {names}, and the names above")
    for axis in ("x", "y"):
        formula = " + ".join(f"{term.name} * ({getattr(term, axis)})" for term in chosen)
        lines.append(f'  {f"signal_{axis}_m" if place.kind == "sensors" else f"force_{axis}_N"}: "{formula}"')
    return "\n".join(lines) + "\n"


def class_name(name: str) -> str:
    return "".join(part.capitalize() for part in name.split("_"))
