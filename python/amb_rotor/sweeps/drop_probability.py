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

from amb_rotor.sweeps import drops, probability
from amb_rotor.sweeps.document import Document

FORMAT = "amb-drop-probability/1"
KEYS = {"format", "name", "title", "model", "scenario", "motion_from_s", "relative_tolerance", "wanted", "samples", "seed",
        "drawn", "changes"}
SPEED = "scenario.speed.start_hz"


def read(path: pathlib.Path) -> dict:
    """The file's content, its model and scenario as paths beside it. @raise InputError: all faults of the file"""
    from amb_rotor import _core
    document = Document(path, FORMAT)
    document.keys("", KEYS)
    model, scenario = drops.check(document)
    names = list(_core.read_model(str(model)).fields) if model else []
    document.known("drawn", [*names, SPEED] if model else document.get("drawn") or [])
    for name in document.get("drawn") or ():
        probability.check_drawn(document, f"drawn/{name}")
    if model:
        probability.check_changes(document, names)
    document.whole("samples", 1)
    document.whole("seed", 0)
    document.done()
    return dict(document.data, model=model, scenario=scenario)


def run(document: dict, progress=None) -> tuple[dict, dict]:
    """Wanted or not for every sample of every design, and what was drawn."""
    from amb_rotor import _core, drop
    random = numpy.random.default_rng(document["seed"])
    samples = document["samples"]
    drawn = {path: probability.drawn(spec, random, samples) for path, spec in document["drawn"].items()}
    model = _core.read_model(str(document["model"]))
    fields = model.fields
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
        found = drop.motion_of_run(result, begin)
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
