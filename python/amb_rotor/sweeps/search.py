"""Search for unstated values: which grid point shows a published figure's motion.

A file of format amb-search/1 names a figure's parameters, the values the figure sweeps, the motion it shows in
ranges of them, and a grid of the values that it leaves out (doc/formats_sweep.md). Every grid point is run over
the whole sweep in the lanes; its score is the share of swept values, inside the ranges, whose motion is the
published one.
"""
from __future__ import annotations

import dataclasses
import itertools
import math
import pathlib

import numpy
import yaml

from amb_rotor.errors import InputError

FORMAT = "amb-search/1"
# Published motion -> what counts as that motion. 0: does not repeat within 16 turns.
MOTIONS = {
    **{f"period_{n}": lambda period, n=n: period == n for n in range(1, 17)},
    "aperiodic": lambda period: period == 0,
    "period_1_or_2": lambda period: (period == 1) | (period == 2),
    "period_8_or_more": lambda period: (period == 0) | (period >= 8),
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


def _values(spec, key: str) -> numpy.ndarray:
    if isinstance(spec, list):
        return numpy.array(spec, float)
    try:
        if "step" in spec:
            count = math.floor((spec["to"] - spec["from"]) / spec["step"] * (1 + 1e-12)) + 1
            return spec["from"] + spec["step"] * numpy.arange(count)
        return numpy.linspace(spec["from"], spec["to"], int(spec["count"]))
    except (TypeError, KeyError) as error:
        raise InputError(f"{key}: a list of numbers, or from, to and step or count ({error})") from error


def read_search(path: pathlib.Path) -> Search:
    """Reads an amb-search/1 file. @raise InputError"""
    try:
        document = yaml.safe_load(path.read_text())
    except yaml.YAMLError as error:
        raise InputError(f"{path}: {error}") from error
    if not isinstance(document, dict) or document.get("format") != FORMAT:
        raise InputError(f"{path}: format: must be {FORMAT}")
    required = {"format", "name", "title", "contact", "parameters", "swept", "expected", "grid", "initial", "run"}
    faults = [f"{path}: {key}: the key is missing" for key in sorted(required - document.keys())]
    faults += [f"{path}: {key}: the key is not known here" for key in sorted(document.keys() - required)]
    if faults:
        raise InputError(faults)
    expected = [(float(item["from"]), float(item["to"]), item["motion"]) for item in document["expected"]]
    faults = [f"{path}: expected: {motion} is none of {', '.join(MOTIONS)}"
              for _, _, motion in expected if motion not in MOTIONS]
    if faults:
        raise InputError(faults)
    swept = document["swept"]
    return Search(document["name"], document["title"], document["contact"], document["parameters"],
                  swept["parameter"], _values(swept, f"{path}: swept"), expected,
                  {key: _values(spec, f"{path}: grid.{key}") for key, spec in document["grid"].items()},
                  document["initial"], document["run"])


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


def run_search(search: Search, progress=None) -> tuple[numpy.ndarray, numpy.ndarray]:
    """All grid points (as rows of values) and their number of hits."""
    from amb_rotor import _core
    points = numpy.array(list(itertools.product(*search.grid.values())))
    hits = numpy.zeros(len(points), int)
    names = list(search.grid)
    batch = max(1, POINTS_AT_ONCE // len(search.values))
    for first in range(0, len(points), batch):
        part = points[first:first + batch]
        columns = {key: numpy.array([float(value)]) for key, value in search.parameters.items()}
        for index, key in enumerate(names):
            columns[key] = numpy.repeat(part[:, index], len(search.values))
        columns[search.swept] = numpy.tile(search.values, len(part))
        turns, kept = search.run["turns"], search.run["kept_turns"]
        result = _core.run_basic_lanes(columns, numpy.array(search.initial, float), contact=search.contact,
                                       steps_per_turn=search.run["steps_per_turn"], turns_skipped=turns - kept,
                                       turns_kept=kept, regimes=False)
        hits[first:first + batch] = agreement(search, result["period"].reshape(len(part), -1))
        if progress:
            progress(len(part))
    return points, hits
