"""How likely is a motion in the auxiliary bearings after the magnetic bearings fail, and which change of the design helps.

A file of format amb-drop-probability/1 (doc/formats_sweep.md) names a model, a scenario with the failure, what of both is
uncertain, and changes of the design as factors on the model's numbers. Every sample is an event-accurate run of the whole
machine, named by amb_rotor/drop.py; every design runs the same samples, so that a difference is not that of the draw.
"""
from __future__ import annotations

import concurrent.futures
import os
import pathlib

import numpy
import yaml

from amb_rotor.errors import InputError
from amb_rotor.sweeps import drops, probability

FORMAT = "amb-drop-probability/1"
KEYS = {"format", "name", "title", "model", "scenario", "motion_from_s", "relative_tolerance", "wanted", "samples", "seed",
        "drawn", "changes"}
SPEED = "scenario.speed.start_hz"
ENDS = ("diverged", 0.0, 0.0, 0.0, 0.0, 0, float("inf"), [])  # a run that leaves all bounds


def read(path: pathlib.Path) -> dict:
    """The document; its model and scenario as paths beside the file. @raise InputError"""
    try:
        document = yaml.safe_load(path.read_text())
    except yaml.YAMLError as error:
        raise InputError(f"{path}: {error}") from error
    if not isinstance(document, dict) or document.get("format") != FORMAT:
        raise InputError(f"{path}: format: must be {FORMAT}")
    faults = [f"{path}: {key}: the key is missing" for key in sorted(KEYS - document.keys())]
    faults += [f"{path}: {key}: the key is not known here" for key in sorted(document.keys() - KEYS)]
    if faults:
        raise InputError(faults)
    for key in ("samples", "seed"):
        if not isinstance(document[key], int) or document[key] < (key == "samples"):
            faults.append(f"{path}: {key}: {document[key]}: must be a whole number of at least {int(key == 'samples')}")
    wanted = document["wanted"]
    if not isinstance(wanted, dict) or wanted.get("motion") not in drops.KINDS or set(wanted) - drops.WANTED_KEYS:
        faults.append(f"{path}: wanted: motion ({', '.join(drops.KINDS)}) and, if a rate matters, whirl_from_hz, whirl_to_hz")
    for key in ("drawn", "changes"):
        if not isinstance(document[key], dict) or not document[key]:
            faults.append(f"{path}: {key}: names, each with its value")
    for name, factors in (document["changes"] or {}).items() if isinstance(document["changes"], dict) else ():
        if not isinstance(factors, dict) or not all(isinstance(factor, (int, float)) and factor > 0 for factor in factors.values()):
            faults.append(f"{path}: changes.{name}: paths of numbers of the model, each with a factor above 0")
    for key in ("model", "scenario"):
        document[key] = path.parent / str(document[key])
        if not document[key].is_file():
            faults.append(f"{path}: {key}: there is no file {document[key]}")
    if faults:
        raise InputError(faults)
    return document


def run(document: dict, progress=None) -> tuple[dict, dict]:
    """Wanted or not for every sample of every design, and what was drawn."""
    from amb_rotor import _core, drop
    random = numpy.random.default_rng(document["seed"])
    samples = document["samples"]
    drawn = {path: probability._drawn(spec, random, samples, f"drawn.{path}") for path, spec in document["drawn"].items()}
    model = _core.read_model(str(document["model"]))
    fields = model.fields
    paths = {path for path in drawn if path != SPEED} | {path for factors in document["changes"].values() for path in factors}
    unknown = sorted(path for path in paths if path not in fields)
    if unknown:
        raise InputError(f"{document['name']}: {', '.join(unknown)}: no number of {document['model']}")
    text = yaml.safe_load(document["scenario"].read_text())
    tolerance, begin = float(document["relative_tolerance"]), float(document["motion_from_s"])

    def scenario_at(index: int):
        if SPEED in drawn:
            text["speed"] = {**text["speed"], "start_hz": float(drawn[SPEED][index])}
        return _core.parse_scenario(yaml.safe_dump(text, sort_keys=False), str(document["scenario"]))

    scenarios = [scenario_at(index) for index in range(samples)]

    def one(task) -> bool:
        factors, index = task
        values = {path: float(column[index]) for path, column in drawn.items() if path != SPEED}
        for path, factor in factors.items():
            values[path] = factor * values.get(path, fields[path])
        machine = model.with_overrides([f"{path}={value!r}" for path, value in values.items()])
        result = _core.simulate(machine, scenarios[index], relative_tolerance=tolerance)
        found = drop.motion(result["columns"], result["clearance_m"], begin) if result["status"] == "ok" else drop.Motion(*ENDS)
        if progress:
            progress(1)
        return drops.matches(document, found)

    outcomes = {}
    # A run computes without the interpreter's lock.
    with concurrent.futures.ThreadPoolExecutor(os.cpu_count()) as pool:
        for name, factors in {"as it is": {}, **document["changes"]}.items():
            outcomes[name] = numpy.array(list(pool.map(one, [(factors, index) for index in range(samples)])))
    return outcomes, drawn


def run_command(args, path: pathlib.Path) -> int:
    """`amb sweep FILE` for a file of this format."""
    from amb_rotor.cli import common
    from amb_rotor.sweeps import draw
    document = read(path)
    folder = common.out_folder(args, "sweep", document["name"])
    with common.progress_bar(document["samples"] * (1 + len(document["changes"])), "drops") as bar:
        outcomes, drawn = run(document, bar.update)
    what = drops.wanted_text(document)
    rows = probability.tell(outcomes, what)
    first = outcomes["as it is"]
    for name, column in drawn.items():  # which uncertain value decides
        edges = numpy.quantile(column, [0.0, 0.25, 0.5, 0.75, 1.0])
        shares = [first[(column >= low) & (column <= high)].mean() for low, high in zip(edges[:-1], edges[1:])]
        print(f"  by quarters of {name} ({', '.join(f'{edge:.4g}' for edge in edges)}): "
              + ", ".join(f"{share:.3f}" for share in shares))
    common.write_json(args, {"name": document["name"], "designs": rows,
                             "samples": [{"drawn": {key: float(column[index]) for key, column in drawn.items()},
                                          "wanted": bool(first[index])} for index in range(len(first))]})
    names = sorted(drawn, key=lambda name: -abs(numpy.corrcoef(drawn[name], first)[0, 1]) if first.any() and not first.all() else 0)
    right, up = (names + names)[:2]
    pictures = draw.outcomes(document["title"], what, (right, drawn[right]), (up, drawn[up]), first, rows, folder)
    common.report_line(pictures[0])
    return 0
