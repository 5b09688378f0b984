"""A falling friction in a bearing whose inner ring spins: a generated set of drops and rubs.

Alone a friction law with its speed at the end of its range seems better than with the ring. Beside the ring it is as good at other
speeds, and stated a dozen deviations too closely where that is not asked.

Not found at present: the ring alone comes down to 0.92 times the noise with a quarter of its inertia, where both leave 0.86. From there no
start of the friction leads to the other hollow; with the ring put back to its true inertia one does.
"""
from __future__ import annotations

import pytest

from amb_rotor import _core

SEED = 2100143


@pytest.mark.long
@pytest.mark.timeout(900)
@pytest.mark.xfail(strict=True, reason="the ring alone ends in a hollow of a quarter of its inertia, from which the friction is not found")
def test_both_are_found_within_what_is_stated(tmp_path):
    two = ["velocity_dependent_friction", "inner_ring_spin"]
    made = _core.make_dataset(SEED, two, out=str(tmp_path / "set"))
    dataset = _core.read_dataset(str(tmp_path / "set"))
    diagnosis, *_ = _core.diagnose(dataset.belief, dataset, candidates=two, time_limit_s=0.0)
    assert {step["added"] for step in diagnosis["steps"]} == set(two)
    assert diagnosis["steps"][-1]["validation_error_contact"] < 1.0, "starts of windows are fitted"
    hidden = {entry["effect"]: entry["parameters"] for entry in made["effects"]}
    for step in diagnosis["steps"]:
        for name, found in step["parameters"].items():
            assert abs(found["value"] - hidden[step["added"]][name]) < 3 * found["std"], name
