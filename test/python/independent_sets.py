"""Sets of the independent program (test/independent/blind.py), made for a test."""
from __future__ import annotations

import pathlib
import subprocess
import sys

import yaml

from amb_rotor import _core

BLIND = pathlib.Path(__file__).parents[1] / "independent" / "blind.py"


SETTLED = ("--offsets", "loop", "--integrators", "settled")


def independent_set(seed: int, index: int, folder: pathlib.Path, *laws: str, reading: tuple[str, ...] = ()) -> tuple:
    """The data set, and the true parameters of what is hidden in it, by effect. laws: of a round of these laws only; reading: of the
    sentences of the format that can be read in two ways, as SETTLED."""
    chosen = [*(["--laws", *laws] if laws else []), *reading]
    subprocess.run([sys.executable, str(BLIND), "--seed", str(seed), "--only", str(index), "--out", str(folder), *chosen], check=True)
    made = folder / f"set-{index:04d}"
    truth = yaml.safe_load((made / "truth.yaml").read_text())
    return _core.read_dataset(str(made)), {entry["effect"]: entry["parameters"] for entry in truth["effects"]}


def diagnosed_pair(seed: int, index: int, folder: pathlib.Path, first: str, second: str) -> tuple[dict, dict]:
    """The diagnosis of a set by the two effects that it hides, found in this order, and their true parameters."""
    dataset, hidden = independent_set(seed, index, folder)
    assert set(hidden) == {first, second}
    diagnosis, *_ = _core.diagnose(dataset.belief, dataset, candidates=list(hidden))
    assert [step["added"] for step in diagnosis["steps"]] == [first, second]
    return diagnosis, hidden
