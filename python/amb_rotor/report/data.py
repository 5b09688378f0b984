"""Numbers for the report's pictures, out of a comparison: small enough to be embedded."""
from __future__ import annotations

import math

import numpy

from amb_rotor.report import force
from amb_rotor.report.numbers import short

CHANNELS = ("ax", "ay", "bx", "by", "iax", "iay", "ibx", "iby")
# Displacements are drawn in micrometres, currents in ampere.
FACTORS = (1e6,) * 4 + (1.0,) * 4
OVERLAY_BINS = 350
CLOSE_SAMPLES = 400
ORBIT_BINS = 72
ORBIT_POINTS = 600


def envelope(values: numpy.ndarray, bins: int = OVERLAY_BINS) -> numpy.ndarray:
    """Least and largest value of each bin, one after the other: what an eye sees of a long record."""
    count = len(values)
    if count <= 2 * bins:
        return values
    edges = numpy.linspace(0, count, bins + 1).astype(int)[:-1]
    low, high = numpy.minimum.reduceat(values, edges), numpy.maximum.reduceat(values, edges)
    return numpy.column_stack([low, high]).ravel()


def envelope_times(count: int, rate: float, bins: int = OVERLAY_BINS) -> numpy.ndarray:
    if count <= 2 * bins:
        return numpy.arange(count) / rate
    edges = numpy.linspace(0, count, bins + 1)[:-1] / rate
    step = count / rate / bins
    return numpy.column_stack([edges + 0.25 * step, edges + 0.75 * step]).ravel()


def channel_errors(run: dict) -> list:
    """Root mean square of the residual over its noise, a channel each; null where it was not measured."""
    residual = run["measured"] - run["predicted"]
    return [float(numpy.sqrt(numpy.mean((residual[:, k] / noise) ** 2))) if noise > 0 else None
            for k, noise in enumerate(run["noise"])]


def residual_orbit(run: dict, end: int) -> dict | None:
    """The residual of an end's displacement: its mean over the shaft's angle, and points of the last turns."""
    if run["noise"][2 * end] <= 0 or run["noise"][2 * end + 1] <= 0:
        return None
    if len(run["angle_rad"]) < 2 or abs(run["angle_rad"][-1] - run["angle_rad"][0]) < 4 * math.pi:
        return None
    residual = 1e6 * (run["measured"] - run["predicted"])[:, 2 * end:2 * end + 2]
    place = (numpy.mod(run["angle_rad"], 2 * math.pi) / (2 * math.pi) * ORBIT_BINS).astype(int) % ORBIT_BINS
    count = numpy.maximum(numpy.bincount(place, minlength=ORBIT_BINS), 1)
    mean = [numpy.bincount(place, residual[:, axis], ORBIT_BINS) / count for axis in (0, 1)]
    last = residual[-ORBIT_POINTS:]
    return {"mean_x": short([*mean[0], mean[0][0]], 3), "mean_y": short([*mean[1], mean[1][0]], 3),
            "x": short(last[:, 0], 3), "y": short(last[:, 1], 3)}


def close_up(measured: numpy.ndarray, predicted: numpy.ndarray, rate: float, factor: float) -> dict:
    """The stretch around the largest residual, sample by sample."""
    residual = measured - predicted
    size = min(CLOSE_SAMPLES, len(residual))
    power = numpy.convolve(residual ** 2, numpy.ones(size), "valid")
    begin = int(numpy.argmax(power))
    part = slice(begin, begin + size)
    return {"from": begin / rate, "measured": short(factor * measured[part]),
            "predicted": short(factor * predicted[part]), "residual": short(factor * residual[part], 3)}


def run_data(run: dict) -> dict:
    measured, predicted = run["measured"], run["predicted"]
    count, rate = len(measured), run["sample_rate_hz"]
    channels = {}
    for index, (name, factor) in enumerate(zip(CHANNELS, FACTORS)):
        if run["noise"][index] <= 0:
            continue
        channels[name] = {"measured": short(factor * envelope(measured[:, index])),
                          "predicted": short(factor * envelope(predicted[:, index])),
                          "residual": short(factor * envelope(measured[:, index] - predicted[:, index]), 3),
                          "close": close_up(measured[:, index], predicted[:, index], rate, factor)}
    return {"id": run["id"], "use": run["use"], "kind": run["kind"], "error": run["error"],
            "channel_errors": channel_errors(run), "sample_rate_hz": rate, "t": short(envelope_times(count, rate), 5), "channels": channels,
            "orbits": [residual_orbit(run, end) for end in (0, 1)]}


@numpy.errstate(all="ignore")  # a channel far beyond all sense is a remark, its squares may overflow
def stage(label: str, comparison: dict) -> dict:
    """One model against the measurements, for the page."""
    model = comparison["model"]
    return {"forces": force.force_maps(comparison["runs"], model), "label": label, "errors": comparison["errors"], "validation_errors": comparison["validation_errors"],
            "nuisance": comparison["nuisance"], "remarks": comparison["remarks"], "model_hash": model.hash,
            "model_text": model.text, "runs": [run_data(run) for run in comparison["runs"]]}
