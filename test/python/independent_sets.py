"""Sets of the independent program (test/independent/blind.py), made for a test."""
from __future__ import annotations

import pathlib
import subprocess
import sys

import yaml

from amb_rotor import _core

BLIND = pathlib.Path(__file__).parents[1] / "independent" / "blind.py"


def independent_set(seed: int, index: int, folder: pathlib.Path) -> tuple:
    """The data set, and the true parameters of what is hidden in it, by effect."""
    subprocess.run([sys.executable, str(BLIND), "--seed", str(seed), "--only", str(index), "--out", str(folder)], check=True)
    made = folder / f"set-{index:04d}"
    truth = yaml.safe_load((made / "truth.yaml").read_text())
    return _core.read_dataset(str(made)), {entry["effect"]: entry["parameters"] for entry in truth["effects"]}
