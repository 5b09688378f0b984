"""A bow with auxiliary bearings that are aside, by the independent program (test/independent): without contact the bow is all."""
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
BOW = {"effect": "shaft_bow", "parameters": {"bow_a_m": 3e-6, "bow_b_m": 4e-6, "phase_rad": 1.4}}
LITTLE = {"offset_ax_m": 0.3e-6, "offset_ay_m": 0.35e-6, "offset_bx_m": -0.8e-6, "offset_by_m": -0.7e-6}
MUCH = {name: 12 * value for name, value in LITTLE.items()}


def made(folder: pathlib.Path, offsets: dict):
    """The data set of a rig with the bow and these offsets."""
    hidden = [BOW, {"effect": "auxiliary_bearing_misalignment", "parameters": offsets}]
    simulator, dice = driver.Simulator(folder), np.random.default_rng(5)
    rig = sets.rig(gravity=9.81)
    runs = sets.plan(rig, contact=True)
    sets.raise_bursts(simulator, rig, hidden, runs)
    recordings = []
    for run in runs:
        channels, tacho = sets.record(simulator, rig, hidden, run, dice.uniform(-3, 3))
        noise = np.repeat([NOISE_M, NOISE_A], 4) * dice.normal(size=channels.shape)
        recordings.append((channels + noise, tacho))
    sets.write(folder / "set", "misalignment", rig, hidden, {}, recordings, runs, noise_um=1e6 * NOISE_M, noise_A=[NOISE_A] * 4)
    return _core.read_dataset(str(folder / "set"))


@pytest.fixture(scope="module")
def of_little(tmp_path_factory):
    dataset = made(tmp_path_factory.mktemp("little"), LITTLE)
    return _core.diagnose(dataset.belief, dataset, candidates=["shaft_bow", "auxiliary_bearing_misalignment"])[0]


@pytest.mark.long
@pytest.mark.timeout(600)
def test_a_little_is_looked_for_though_the_error_of_all_runs_is_near_the_noise(of_little):
    bow = of_little["steps"][0]
    assert bow["added"] == "shaft_bow"
    assert bow["validation_error_free"] < 1.05 and bow["validation_error_contact"] < 1.1, "it is plain, and this shows nothing"
    assert [step["added"] for step in of_little["steps"][1:]] == ["auxiliary_bearing_misalignment"]


@pytest.mark.long
def test_a_little_is_measured(of_little):
    for name, true in LITTLE.items():
        found = of_little["steps"][1]["parameters"][name]
        assert abs(found["value"] - true) < 3 * found["std"], name


@pytest.mark.long
@pytest.mark.timeout(600)
def test_where_nothing_comes_after_the_runs_with_contact_are_fitted_too(tmp_path):
    """The bow explains what is missing without contact alone: its runs through contact wait, and are fitted in the end."""
    dataset = made(tmp_path, MUCH)
    diagnosis, adopted, _ = _core.diagnose(dataset.belief, dataset, candidates=["shaft_bow"])
    assert diagnosis["verdict"] == "unknown" and [step["added"] for step in diagnosis["steps"]] == ["shaft_bow"]
    left = diagnosis["steps"][0]["validation_error_contact"]
    compared = _core.compare(adopted, dataset, refit=True)["validation_errors"]["error_contact"]
    assert left == pytest.approx(compared, rel=0.05)
