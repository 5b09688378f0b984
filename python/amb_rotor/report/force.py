"""The force that a model lacks, from what its prediction leaves.

A rotor of mass m, tilting inertia I and polar inertia P turns at W. What is measured less what is predicted, e of the
displacements and d of the control currents, obeys the same equations as the rotor itself, with the force f that is
missing at the two magnetic bearings (z_a, z_b from the centre of gravity; e_0 of the centre, t_x = d e_x/dz the tilt):

    f_a + f_b         = m e_0''            - sum_b (Ki d_b + Ks e_b)
    f_a z_a + f_b z_b = I t_x'' + P W t_y' - sum_b z_b (Ki d_b + Ks e_b)      (y: - P W t_x')

Second derivatives come from parabolas through WINDOW_S about each instant: forces that change within it are flattened
(a sine by 5 % where its period is six windows), and noise is left in the single value; means over many are shown. Left
out: bending, and forces elsewhere, which show up as their share at the bearings. Runs with contact are not used.
"""
from __future__ import annotations

import math

import numpy

from amb_rotor.report.numbers import short

WINDOW_S = 2.5e-3
CELLS = 15          # of a map, each way
ANGLE_BINS = 36
LEAST = 25          # samples in a cell that is shown
_FIELDS = {"m": "rig.rotor.mass_kg", "i": "rig.rotor.transverse_inertia_kg_m2", "p": "rig.rotor.polar_inertia_kg_m2",
           "ki": "rig.amb.current_stiffness_N_per_A", "ks": "rig.amb.displacement_stiffness_N_per_m"}


def parabola(values: numpy.ndarray, half: int, rate: float) -> tuple:
    """Value, first and second derivative at each instant but the first and last `half`, by least squares."""
    place = numpy.arange(-half, half + 1) / rate
    rows = numpy.linalg.pinv(numpy.column_stack([numpy.ones_like(place), place, place ** 2]))
    return tuple(factor * numpy.convolve(values, row[::-1], "valid") for factor, row in zip((1.0, 1.0, 2.0), rows))


def ends(a: numpy.ndarray, b: numpy.ndarray, here: tuple, there: tuple) -> tuple:
    """Two signals of a straight shaft at other planes."""
    slope = (b - a) / (here[1] - here[0])
    return tuple(a + (z - here[0]) * slope for z in there)


def holds_contact(run: dict) -> bool:
    return run["kind"] in ("rub", "drop")


def missing_force(run: dict, model) -> dict | None:
    """Force [N], position [m] and velocity [m/s] at both bearings (arrays of end, axis, instant), and the shaft's angle."""
    if model.amb_model != "linear" or min(run["noise"]) <= 0 or holds_contact(run):
        return None
    fields = model.fields
    m, inertia, polar, ki, ks = (fields[path] for path in _FIELDS.values())
    sensor, amb = ([fields[f"rig.planes.{name}.{end}"] for end in "ab"] for name in ("sensor", "amb"))
    rate = run["sample_rate_hz"]
    half = max(2, round(0.5 * WINDOW_S * rate))
    if len(run["measured"]) < 20 * half:
        return None
    residual = run["measured"] - run["predicted"]
    inner = slice(half, len(residual) - half)
    speed = run["speed_rad_s"][inner]
    plane = []  # of x, y: values at the bearings, of the centre and the tilt, and their derivatives
    for axis in (0, 1):
        error = [parabola(residual[:, 2 * end + axis], half, rate) for end in (0, 1)]
        current = [parabola(residual[:, 4 + 2 * end + axis], half, rate)[0] for end in (0, 1)]
        motion = [parabola(run["measured"][:, 2 * end + axis], half, rate) for end in (0, 1)]
        plane.append({"bearing": ends(error[0][0], error[1][0], sensor, amb), "current": current,
                      "second": ends(error[0][2], error[1][2], sensor, (0.0, 1.0)),
                      "first": ends(error[0][1], error[1][1], sensor, (0.0, 1.0)),
                      "position": ends(motion[0][0], motion[1][0], sensor, amb),
                      "velocity": ends(motion[0][1], motion[1][1], sensor, amb)})
    force = numpy.empty((2, 2, len(speed)))
    for axis, own, other, sign in ((0, plane[0], plane[1], 1.0), (1, plane[1], plane[0], -1.0)):
        known = [ki * own["current"][end] + ks * own["bearing"][end] for end in (0, 1)]
        tilt_second = own["second"][1] - own["second"][0]
        tilt_rate = other["first"][1] - other["first"][0]
        total = m * own["second"][0] - known[0] - known[1]
        moment = inertia * tilt_second + sign * polar * speed * tilt_rate - amb[0] * known[0] - amb[1] * known[1]
        force[1, axis] = (moment - amb[0] * total) / (amb[1] - amb[0])
        force[0, axis] = total - force[1, axis]
    pick = lambda name: numpy.array([[plane[axis][name][end] for axis in (0, 1)] for end in (0, 1)])  # noqa: E731
    turns = abs(run["angle_rad"][-1] - run["angle_rad"][0]) > 4 * math.pi
    return {"force": force, "position": pick("position"), "velocity": pick("velocity"),
            "angle": run["angle_rad"][inner] if turns else None}


def parts_along(force: numpy.ndarray, vector: numpy.ndarray) -> tuple:
    """Parts of the force along a vector and at right angles to it, a quarter turn ahead."""
    size = numpy.maximum(numpy.hypot(vector[0], vector[1]), 1e-30)
    return ((force[0] * vector[0] + force[1] * vector[1]) / size, (force[1] * vector[0] - force[0] * vector[1]) / size)


def cell_map(vector: numpy.ndarray, force: numpy.ndarray, factor: float) -> dict | None:
    """Mean of both parts of the force in cells of the plane of a vector, drawn in units of 1/factor."""
    reach = factor * float(numpy.percentile(numpy.abs(vector), 99.5))
    if not reach > 0.0:
        return None
    edges = numpy.linspace(-reach, reach, CELLS + 1)
    along, across = parts_along(force, vector)
    count, _, _ = numpy.histogram2d(factor * vector[1], factor * vector[0], bins=(edges, edges))
    cells = []
    for part in (along, across):
        total, _, _ = numpy.histogram2d(factor * vector[1], factor * vector[0], bins=(edges, edges), weights=part)
        mean = numpy.where(count >= LEAST, total / numpy.maximum(count, 1), numpy.nan)
        cells.append([short(row, 3) for row in mean])
    return {"centres": short(0.5 * (edges[1:] + edges[:-1])), "along": cells[0], "across": cells[1]}


def angle_means(angle: numpy.ndarray, force: numpy.ndarray) -> dict:
    place = (numpy.mod(angle, 2 * math.pi) / (2 * math.pi) * ANGLE_BINS).astype(int) % ANGLE_BINS
    count = numpy.bincount(place, minlength=ANGLE_BINS)
    mean = [numpy.where(count >= LEAST, numpy.bincount(place, part, ANGLE_BINS) / numpy.maximum(count, 1), numpy.nan)
            for part in force]
    return {"angle_deg": short((numpy.arange(ANGLE_BINS) + 0.5) * 360.0 / ANGLE_BINS), "x": short(mean[0], 3),
            "y": short(mean[1], 3)}


def force_maps(runs: list[dict], model) -> list[dict | None]:
    """For each end the maps over position [um] and velocity [mm/s], and the means over the shaft's angle."""
    found = [one for one in (missing_force(run, model) for run in runs) if one]
    if not found:
        return [None, None]
    turning = [one for one in found if one["angle"] is not None]
    result = []
    for end in (0, 1):
        joined = {name: numpy.concatenate([one[name][end] for one in found], axis=1)
                  for name in ("force", "position", "velocity")}
        angle = angle_means(numpy.concatenate([one["angle"] for one in turning]),
                            numpy.concatenate([one["force"][end] for one in turning], axis=1)) if turning else None
        result.append({"position": cell_map(joined["position"], joined["force"], 1e6),
                       "velocity": cell_map(joined["velocity"], joined["force"], 1e3), "angle": angle})
    return result
