"""Basins: which knocks end in which regime (format amb-basin/1, doc/formats_sweep.md).

The rotor is at the centre when it is knocked off with a speed, in a direction relative to the unbalance (whose phase is
0 at that instant; the basic model with a centred bearing is isotropic, so only the difference counts). Every point of the
grid direction by speed is one lane.
"""
from __future__ import annotations

import math
import pathlib

import numpy

from amb_rotor.sweeps.document import Document

FORMAT = "amb-basin/1"
KEYS = {"format", "name", "title", "source", "contact", "friction_law", "parameters", "direction_deg", "speed", "run"}
POINTS_AT_ONCE = 4096


def read_basin(path: pathlib.Path) -> dict:
    """@raise InputError: all faults of the file"""
    document = Document(path, FORMAT)
    document.keys("", KEYS)
    document.known("parameters", document.laws())
    found = dict(document.data, parameters=document.numbers("parameters"), run=document.run("steps_per_turn"),
                 direction_deg=document.axis("direction_deg"), speed=document.axis("speed"))
    if "frequency_ratio" not in found["parameters"]:
        document.fault("parameters/frequency_ratio", "the key is missing")
    document.done()
    return found


def run_basin(document: dict, progress=None) -> dict:
    """Regime, contact fraction and whirl of every point; rows: speed, columns: direction."""
    from amb_rotor import _core
    direction, speed = numpy.meshgrid(numpy.radians(document["direction_deg"]), document["speed"])
    zero = numpy.zeros(direction.size)
    initial = numpy.stack([zero, zero, (speed * numpy.cos(direction)).ravel(), (speed * numpy.sin(direction)).ravel()], axis=1)
    run = document["run"]
    parameters = {key: numpy.array([float(value)]) for key, value in document["parameters"].items()}
    found = {"regime": [], "contact_fraction": [], "whirl": []}
    for first in range(0, len(initial), POINTS_AT_ONCE):
        part = initial[first:first + POINTS_AT_ONCE]
        # One parameter a machine tells the lanes how many there are.
        columns = {**parameters, "frequency_ratio": numpy.full(len(part), parameters["frequency_ratio"][0])}
        result = _core.run_basic_lanes(columns, part, contact=document["contact"], friction=document["friction_law"],
                                       steps_per_turn=run["steps_per_turn"],
                                       turns_skipped=run["turns"] - run["kept_turns"], turns_kept=run["kept_turns"])
        for key, values in found.items():
            values.append(numpy.asarray(result[key]))
        if progress:
            progress(len(part))
    return {key: numpy.concatenate(values).reshape(direction.shape) for key, values in found.items()}


def run_command(args, path: pathlib.Path) -> int:
    """`amb sweep FILE` for a file of this format."""
    from amb_rotor.cli import common
    from amb_rotor.sweeps import draw
    document = read_basin(path)
    folder = common.out_folder(args, "sweep", document["name"])
    size = len(document["direction_deg"]) * len(document["speed"])
    with common.progress_bar(size, "knocks") as bar:
        found = run_basin(document, bar.update)
    names, counts = numpy.unique(found["regime"], return_counts=True)
    shares = {str(name): count / size for name, count in zip(names, counts)}
    print(f"{size} knocks: " + ", ".join(f"{100 * share:.1f} % {name}" for name, share in
                                         sorted(shares.items(), key=lambda item: -item[1])))
    whirls = numpy.isin(found["regime"], ("dry_whirl", "diverged"))
    by_speed = whirls.mean(axis=1)
    if whirls.any():
        slowest = document["speed"][int(numpy.argmax(by_speed > 0.0))]
        certain = numpy.flatnonzero(by_speed < 1.0)
        surely = document["speed"][certain[-1] + 1] if certain[-1] + 1 < len(by_speed) else math.nan
        print(f"dry whirl from a knock of {slowest:.3f} on" +
              (f"; from {surely:.3f} on in every direction" if math.isfinite(surely) else "; in no range of speeds surely"))
    common.write_json(args, {"name": document["name"], "shares": shares,
                             "dry_whirl_by_speed": dict(zip(map(float, document["speed"]), map(float, by_speed)))})
    with common.atomic_path(folder / "basin.npz") as part:
        numpy.savez_compressed(part, direction_deg=document["direction_deg"], speed=document["speed"], **found)
    pictures = draw.regime_map(document["title"], [("knock_speed", document["speed"]),
                                                   ("knock_direction_deg", document["direction_deg"])],
                               found["regime"].ravel(), [], folder, "basin")
    common.report_line(pictures[0])
    return 0
