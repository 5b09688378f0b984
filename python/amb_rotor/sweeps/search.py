"""Search for unstated values: which grid point shows a published figure's motion.

A file of format amb-search/1 names a figure's parameters, the values the figure sweeps, the motion it shows in
ranges of them, and a grid of the values that it leaves out (doc/formats_sweep.md). Every grid point is run over
the whole sweep in the lanes; its score is the number of swept values, inside the ranges, whose motion is the
published one.

With `sampling` the grid's ranges are sampled at random instead (many unstated values at once), and the best
samples are refined by smaller boxes about them. There the score is the mean over the published ranges of the
share of each that is right, so that one long range of period 1 does not outweigh the rest of a figure.
"""
from __future__ import annotations

import dataclasses
import itertools
import math
import pathlib

import numpy

from amb_rotor.sweeps.document import Document

FORMAT = "amb-search/1"
# What a machine does is one number: its period (0: does not repeat within 16 turns), IMPACTS more where it touches now and
# then, and ALWAYS more where it touches all the time; DIVERGED where it leaves all bounds, which is no motion at all. So does a
# dry whirl in a Hertz contact that grows until it turns by more than COARSEST radians in a step: from there on the integrator
# damps it, and what is seen is not the equations'.
IMPACTS, ALWAYS, DIVERGED, COARSEST = 100, 200, 99, 0.3
LEAST_ALWAYS, FARTHEST = 0.999, 10.0    # share of the time; distance from the bearing's centre over the clearance


def _period(code):
    return code % 100


# Published motion -> what counts as that motion.
MOTIONS = {
    **{f"period_{n}": lambda code, n=n: _period(code) == n for n in range(1, 17)},
    "aperiodic": lambda code: _period(code) == 0,
    "aperiodic_with_impacts": lambda code: code == IMPACTS,
    "aperiodic_always_in_contact": lambda code: code == ALWAYS,
    "period_1_or_2": lambda code: (_period(code) == 1) | (_period(code) == 2),
    "period_8_or_more": lambda code: (_period(code) == 0) | ((_period(code) >= 8) & (_period(code) <= 16)),
}
POINTS_AT_ONCE = 4096


@dataclasses.dataclass
class Search:
    """What a search file says."""
    name: str
    title: str
    contact: str
    parameters: dict
    swept: str
    values: numpy.ndarray
    expected: list      # (from, to, motion)
    grid: dict          # name -> values
    initial: list
    run: dict
    sampling: dict      # samples, seed, refinements; empty: the whole grid


STATE = ("x", "y", "vx", "vy")
REFINED, BOX = 24, 0.25  # best samples that are refined; first half width of their boxes, over the range


def read_search(path: pathlib.Path) -> Search:
    """Reads an amb-search/1 file. @raise InputError: all its faults"""
    document = Document(path, FORMAT)
    document.keys("", {"format", "name", "title", "contact", "parameters", "swept", "expected", "grid", "initial", "run"},
                  {"sampling"})
    names = document.laws("spin")
    document.known("parameters", names)
    document.known("grid", [*names, *STATE])
    if isinstance(document.get("swept"), dict):
        document.choice("swept/parameter", names)
    values = document.axis("swept")
    grid = {key: document.axis(f"grid/{key}") for key in document.get("grid") or {}}
    expected = []
    for index in range(len(document.get("expected") or [])):
        if document.keys(f"expected/{index}", ("from", "to", "motion")):
            expected.append((document.number(f"expected/{index}/from"), document.number(f"expected/{index}/to"),
                             document.choice(f"expected/{index}/motion", MOTIONS)))
    if not expected:
        document.fault("expected", "at least one range")
    initial = document.axis("initial")
    if len(initial) != len(STATE):
        document.fault("initial", "must be [x, y, vx, vy]")
    sampling = {}
    if document.get("sampling") and document.keys("sampling", ("samples", "seed", "refinements")):
        sampling = {key: document.whole(f"sampling/{key}", int(key == "samples")) for key in document.get("sampling")}
    found = Search(document.get("name"), document.get("title"), document.get("contact"), document.numbers("parameters"),
                   (document.get("swept") or {}).get("parameter"), values, expected, grid, initial, document.run("steps_per_turn"),
                   sampling)
    document.done()
    return found


def published(search: Search) -> list:
    """The published motion at each swept value; None outside all ranges."""
    motions = []
    for value in search.values:
        inside = [motion for low, high, motion in search.expected if low <= value <= high]
        motions.append(inside[0] if inside else None)
    return motions


def agreement(search: Search, periods: numpy.ndarray) -> numpy.ndarray:
    """Number of swept values that show the published motion; `periods`: [..., swept value]."""
    hits = numpy.zeros(periods.shape[:-1], int)
    for index, motion in enumerate(published(search)):
        if motion is not None:
            hits += MOTIONS[motion](periods[..., index])
    return hits


def shares(search: Search, periods: numpy.ndarray) -> numpy.ndarray:
    """Mean over the published ranges of the share of their swept values that show the published motion."""
    scores = []
    for low, high, motion in search.expected:
        inside = (search.values >= low) & (search.values <= high)
        if inside.any():
            scores.append(MOTIONS[motion](periods[..., inside]).mean(axis=-1))
    return numpy.mean(scores, axis=0)


def run_points(search: Search, points: numpy.ndarray, progress=None) -> numpy.ndarray:
    """What the machines do at every swept value, a row each point (values in the order of the grid's names)."""
    from amb_rotor import _core
    count = len(search.values)
    periods = numpy.zeros((len(points), count), int)
    batch = max(1, POINTS_AT_ONCE // count)
    for first in range(0, len(points), batch):
        part = points[first:first + batch]
        columns = {key: numpy.array([float(value)]) for key, value in search.parameters.items()}
        initial = numpy.tile(numpy.array(search.initial, float), (len(part) * count, 1))
        for index, key in enumerate(search.grid):
            values = numpy.repeat(part[:, index], count)
            if key in STATE:
                initial[:, STATE.index(key)] = values
            else:
                columns[key] = values
        columns[search.swept] = numpy.tile(search.values, len(part))
        turns, kept = search.run["turns"], search.run["kept_turns"]
        result = _core.run_basic_lanes(columns, initial, contact=search.contact,
                                       steps_per_turn=search.run["steps_per_turn"], turns_skipped=turns - kept,
                                       turns_kept=kept, regimes=False)
        contact = result["contact_fraction"]
        codes = result["period"] + numpy.where(contact > LEAST_ALWAYS, ALWAYS, numpy.where(contact > 0.0, IMPACTS, 0))
        fast = 2.0 * math.pi * numpy.abs(result["whirl"]) / search.run["steps_per_turn"] > COARSEST
        codes[fast | ~(result["max_radius"] < FARTHEST)] = DIVERGED
        periods[first:first + batch] = codes.reshape(len(part), count)
        if progress:
            progress(len(part))
    return periods


def run_search(search: Search, progress=None) -> tuple[numpy.ndarray, numpy.ndarray]:
    """All grid points (as rows of values) and their number of hits."""
    points = numpy.array(list(itertools.product(*search.grid.values())))
    return points, agreement(search, run_points(search, points, progress))


def sampled_size(search: Search) -> int:
    """Points that a sampled search runs."""
    return search.sampling["samples"] * (1 + search.sampling["refinements"]) if search.sampling else 0


def run_sampled(search: Search, progress=None) -> tuple[numpy.ndarray, numpy.ndarray, numpy.ndarray]:
    """Points, hits and scores of a sampled search. A refinement runs as many points again, in boxes about the
    best so far that halve each time. Values of two or fewer (a friction direction) are chosen, not interpolated."""
    random = numpy.random.default_rng(search.sampling["seed"])
    low = numpy.array([values.min() for values in search.grid.values()])
    high = numpy.array([values.max() for values in search.grid.values()])
    choices = [values if len(values) <= 2 else None for values in search.grid.values()]
    count = search.sampling["samples"]

    def run(points):
        for index, values in enumerate(choices):
            if values is not None:
                points[:, index] = values[numpy.abs(points[:, index, None] - values).argmin(axis=1)]
        periods = run_points(search, points, progress)
        return points, agreement(search, periods), shares(search, periods)

    points, hits, scores = run(random.uniform(low, high, (count, len(low))))
    for refinement in range(search.sampling["refinements"]):
        best = points[numpy.argsort(-scores, kind="stable")[:REFINED]]
        box = BOX * 0.5 ** refinement * (high - low)
        about = best[random.integers(0, len(best), count)]
        found = run(numpy.clip(about + random.uniform(-box, box, about.shape), low, high))
        points, hits, scores = (numpy.concatenate(pair) for pair in zip((points, hits, scores), found))
    return points, hits, scores
