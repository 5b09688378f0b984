"""An effect that leaves little beside a strong one: a set of the independent program (test/independent/blind.py).

Spin drag takes the error of the speeds from thousands to 1.02 times the noise. A seal's cross-coupled stiffness is in the rest,
and pulls at the drag's torque: without it that ends four stated deviations off.
"""
from __future__ import annotations

import pytest

from independent_sets import diagnosed_pair

INDEX = 34  # of seed 11


@pytest.mark.timeout(600)
def test_a_seal_behind_a_drag_is_found(tmp_path):
    diagnosis, hidden = diagnosed_pair(11, INDEX, tmp_path, "spin_drag", "cross_coupled_stiffness")
    assert 1.015 < diagnosis["steps"][0]["validation_error_free"] < 1.05, "the seal is hidden, or this shows nothing"
    for name in ("torque_N_m", "decay_per_s"):
        found = next(step for step in diagnosis["steps"] if step["added"] == "spin_drag")["parameters"][name]
        assert abs(found["value"] - hidden["spin_drag"][name]["value"]) < 3 * found["std"], name
