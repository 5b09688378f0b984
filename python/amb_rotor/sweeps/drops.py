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

from amb_rotor.sweeps.document import Document

FORMAT = "amb-drop-map/1"
KEYS = {"format", "name", "title", "model", "scenario", "motion_from_s", "wanted", "grid", "relative_tolerance"}
WANTED_KEYS = {"motion", "whirl_from_hz", "whirl_to_hz"}
KINDS = ("free", "rest", "oscillation", "spring", "forward_whirl", "backward_whirl", "magnet_hit")


def check(document: Document) -> tuple:
    """Model and scenario as paths beside the file, None with a fault where there is no file; `wanted` and the rest of what files
    of drops share."""
    if document.keys("wanted", ("motion",), WANTED_KEYS):
        document.choice("wanted/motion", KINDS)
        for key in set(document.get("wanted")) - {"motion"}:
            document.number(f"wanted/{key}")
    document.number("motion_from_s", "at least 0", lambda value: value >= 0.0)
    document.number("relative_tolerance", "above 0 and at most 0.01", lambda value: 0.0 < value <= 0.01)
    paths = []
    for key in ("model", "scenario"):
        paths.append(document.path.parent / str(document.get(key)))
        if not paths[-1].is_file():
            document.fault(key, "there is no such file beside this one")
            paths[-1] = None
    return tuple(paths)


def read_drops(path: pathlib.Path) -> dict:
    """The file's content; its model and scenario as paths beside it. @raise InputError: all faults of the file"""
    from amb_rotor import _core
    document = Document(path, FORMAT)
    document.keys("", KEYS)
    model, scenario = check(document)
    document.known("grid", list(_core.read_model(str(model)).fields) if model else document.get("grid") or [])
    grid = {key: document.axis(f"grid/{key}").tolist() for key in document.get("grid") or {}}
    if not grid:
        document.fault("grid", "path of a number of the model -> list of values")
    document.done()
    return dict(document.data, model=model, scenario=scenario, grid=grid)


def size(document: dict) -> int:
    return math.prod(len(values) for values in document["grid"].values())


def matches(document: dict, motion) -> bool:
    wanted = document["wanted"]
    return wanted["motion"] in (motion.kind, motion.ended) and \
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
        found = drop.motion_of_run(result, float(document["motion_from_s"]))
        if progress:
            progress(1)
        return {"values": grid[index], "motion": found}

    # a run computes without the interpreter's lock
    with concurrent.futures.ThreadPoolExecutor(os.cpu_count()) as pool:
        return list(pool.map(one, range(len(grid))))
