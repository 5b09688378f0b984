"""The runs that a diagnosis proposes to part two effects: as scenario files, models of both, and the commands to run them."""
from __future__ import annotations

import pathlib
import shlex

from amb_rotor.cli import common

FOLDER = "experiments"


def command(folder: pathlib.Path, experiment: dict, effect: str) -> str:
    """What simulates one of the two models in an experiment; `folder` is that of the diagnosis."""
    place = folder / FOLDER
    words = ["./amb", "simulate", str(place / f"model_{effect}.yaml"), "--scenario", str(place / f"{experiment['name']}.yaml")]
    for override in experiment["overrides"].get(effect, []):
        words += ["--set", override]
    return shlex.join([*words, "--out", str(place / f"{experiment['name']}_{effect}.csv")])


def write(part: pathlib.Path, folder: pathlib.Path, diagnosis: dict, rivals: dict) -> None:
    """Writes the files into `part`, which becomes `folder`, and puts the commands into the diagnosis."""
    if not diagnosis.get("experiments"):
        return
    (part / FOLDER).mkdir()
    wanted = {experiment[side] for experiment in diagnosis["experiments"] for side in ("effect", "against")}
    for effect in sorted(wanted & rivals.keys()):
        rivals[effect].write(str(part / FOLDER / f"model_{effect}.yaml"))
    for experiment in diagnosis["experiments"]:
        common.atomic_write(part / FOLDER / f"{experiment['name']}.yaml", experiment["scenario"])
        experiment["commands"] = [command(folder, experiment, effect) for effect in (experiment["effect"], experiment["against"])]
