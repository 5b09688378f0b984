"""Two effects that one of many numbers stands in for: a set of the independent program (test/independent/blind.py).

A motor's pull and iron that saturates, 15 times the noise. A bending mode of 500 Hz with its damping and its shapes at the sensors at the
ends of their ranges leaves 1.04 times the noise.
"""
from __future__ import annotations

import pytest

from amb_rotor import _core
from independent_sets import independent_set

INDEX = 34  # of seed 6262


@pytest.mark.long
@pytest.mark.timeout(600)
def test_a_mode_at_the_ends_of_its_ranges_gives_way_to_two(tmp_path):
    dataset, hidden = independent_set(6262, INDEX, tmp_path, reading=("--integrators", "settled"))
    two = {"motor_magnetic_pull", "magnetic_saturation"}
    assert set(hidden) == two
    candidates = [*two, "shaft_flexibility", "sensor_runout"]
    diagnosis, *_ = _core.diagnose(dataset.belief, dataset, candidates=sorted(candidates), time_limit_s=0.0)
    assert diagnosis["withdrawn"] == ["shaft_flexibility"], "it came first, or this shows nothing"
    assert {step["added"] for step in diagnosis["steps"]} == two
    assert diagnosis["steps"][-1]["validation_error"] < 1.01
    for step in diagnosis["steps"]:
        for name, found in step["parameters"].items():
            assert abs(found["value"] - hidden[step["added"]][name]["value"]) < 3 * found["std"], name
