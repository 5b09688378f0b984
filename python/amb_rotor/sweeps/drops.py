"""Map of drops: which motion in the auxiliary bearings follows a power failure, over a grid of uncertain values.

A file of format amb-drop-map/1 names a model, a scenario, the values that are uncertain with a grid of each, and the
motion that is looked for (doc/formats_sweep.md). Every point is an event-accurate run of the whole machine; what it
shows is decided in amb_rotor/drop.py.
"""
from __future__ import annotations

import concurrent.futures
import itertools
import math
import os
import pathlib

import yaml

from amb_rotor.errors import InputError

FORMAT = "amb-drop-map/1"
KEYS = {"format", "name", "title", "model", "scenario", "motion_from_s", "wanted", "grid", "relative_tolerance"}
WANTED_KEYS = {"motion", "whirl_from_hz", "whirl_to_hz"}
KINDS = ("free", "rest", "oscillation", "spring", "forward_whirl", "backward_whirl")


def _grid_faults(path: pathlib.Path, grid) -> list[str]:
    if not isinstance(grid, dict) or not grid:
        return [f"{path}: grid: path of a number of the model -> list of values"]
    return [f"{path}: grid.{key}: a list of numbers" for key, values in grid.items()
            if not isinstance(values, list) or not values or not all(isinstance(v, (int, float)) for v in values)]


def read_drops(path: pathlib.Path) -> dict:
    """The document; its model and scenario as paths beside the file. @raise InputError"""
    try:
        document = yaml.safe_load(path.read_text())
    except yaml.YAMLError as error:
        raise InputError(f"{path}: {error}") from error
    if not isinstance(document, dict) or document.get("format") != FORMAT:
        raise InputError(f"{path}: format: must be {FORMAT}")
    faults = [f"{path}: {key}: the key is missing" for key in sorted(KEYS - document.keys())]
    faults += [f"{path}: {key}: the key is not known here" for key in sorted(document.keys() - KEYS)]
    if not faults:
        wanted = document["wanted"]
        if not isinstance(wanted, dict) or wanted.get("motion") not in KINDS or set(wanted) - WANTED_KEYS:
            faults.append(f"{path}: wanted: motion ({', '.join(KINDS)}) and, if a rate matters, whirl_from_hz, whirl_to_hz")
        faults += _grid_faults(path, document["grid"])
        for key in ("model", "scenario"):
            document[key] = path.parent / str(document[key])
            if not document[key].is_file():
                faults.append(f"{path}: {key}: there is no file {document[key]}")
    if faults:
        raise InputError(faults)
    return document


def size(document: dict) -> int:
    return math.prod(len(values) for values in document["grid"].values())


def matches(document: dict, motion) -> bool:
    wanted = document["wanted"]
    return motion.kind == wanted["motion"] and \
        wanted.get("whirl_from_hz", -math.inf) <= motion.whirl_hz <= wanted.get("whirl_to_hz", math.inf)


def wanted_text(document: dict) -> str:
    wanted = document["wanted"]
    rate = f" of {wanted['whirl_from_hz']:g} to {wanted['whirl_to_hz']:g} Hz" if "whirl_from_hz" in wanted else ""
    return wanted["motion"].replace("_", " ") + rate


def run_drops(document: dict, progress=None) -> list[dict]:
    """Each point of the grid, in order: its values and its Motion."""
    from amb_rotor import _core, drop
    model = _core.read_model(str(document["model"]))
    scenario = _core.read_scenario(str(document["scenario"]))
    names = list(document["grid"])
    grid = [dict(zip(names, values)) for values in itertools.product(*document["grid"].values())]
    machines = [model.with_overrides([f"{name}={value!r}" for name, value in values.items()]) for values in grid]

    def one(index: int) -> dict:
        result = _core.simulate(machines[index], scenario, relative_tolerance=float(document["relative_tolerance"]))
        if result["status"] == "ok":
            found = drop.motion(result["columns"], result["clearance_m"], float(document["motion_from_s"]))
        else:
            found = drop.Motion("diverged", 0.0, 0.0, 0.0, 0.0, 0, math.inf, [])
        if progress:
            progress(1)
        return {"values": grid[index], "motion": found}

    # a run computes without the interpreter's lock
    with concurrent.futures.ThreadPoolExecutor(os.cpu_count()) as pool:
        return list(pool.map(one, range(len(grid))))
