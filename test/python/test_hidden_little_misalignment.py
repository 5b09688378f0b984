"""A bow with auxiliary bearings less than a micrometre aside, by the independent program (test/independent): without contact the bow is all,
and through contact the error of all runs is near the noise with the bow alone. One rub tells.
"""
from __future__ import annotations

import pathlib
import sys

import numpy as np
import pytest

from amb_rotor import _core

sys.path.insert(0, str(pathlib.Path(__file__).parents[1] / "independent"))
import driver  # noqa: E402
import sets  # noqa: E402

NOISE_M, NOISE_A = 0.4e-6, 0.005
OFFSETS = {"offset_ax_m": 0.3e-6, "offset_ay_m": 0.35e-6, "offset_bx_m": -0.8e-6, "offset_by_m": -0.7e-6}
HIDDEN = [{"effect": "shaft_bow", "parameters": {"bow_a_m": 3e-6, "bow_b_m": 4e-6, "phase_rad": 1.4}},
          {"effect": "auxiliary_bearing_misalignment", "parameters": OFFSETS}]


@pytest.fixture(scope="module")
def diagnosis(tmp_path_factory):
    folder = tmp_path_factory.mktemp("little_misalignment")
    simulator, dice = driver.Simulator(folder), np.random.default_rng(5)
    rig = sets.rig(gravity=9.81)
    runs = sets.plan(rig, contact=True)
    sets.raise_bursts(simulator, rig, HIDDEN, runs)
    recordings = []
    for run in runs:
        channels, tacho = sets.record(simulator, rig, HIDDEN, run, dice.uniform(-3, 3))
        noise = np.repeat([NOISE_M, NOISE_A], 4) * dice.normal(size=channels.shape)
        recordings.append((channels + noise, tacho))
    sets.write(folder / "set", "little-misalignment", rig, HIDDEN, {}, recordings, runs, noise_um=1e6 * NOISE_M,
               noise_A=[NOISE_A] * 4)
    dataset = _core.read_dataset(str(folder / "set"))
    return _core.diagnose(dataset.belief, dataset, candidates=[entry["effect"] for entry in HIDDEN])[0]


@pytest.mark.timeout(600)
def test_it_is_looked_for_though_the_error_of_all_runs_is_near_the_noise(diagnosis):
    bow = diagnosis["steps"][0]
    assert bow["added"] == "shaft_bow"
    assert bow["validation_error_free"] < 1.05 and bow["validation_error_contact"] < 1.1, "it is plain, and this shows nothing"
    assert [step["added"] for step in diagnosis["steps"][1:]] == ["auxiliary_bearing_misalignment"]


def test_its_numbers_are_right(diagnosis):
    for name, true in OFFSETS.items():
        found = diagnosis["steps"][1]["parameters"][name]
        assert abs(found["value"] - true) < 3 * found["std"], name
