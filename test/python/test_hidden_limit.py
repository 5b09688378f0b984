"""An effect that hardly shows in the runs to validate: a set of the independent program (test/independent/blind.py).

Sensors' gains are off, and a current limit is reached in one run to fit. With the gains alone the runs to validate stand at 1.005 times
the noise, where a search would end, and that run at 1.26.
"""
from __future__ import annotations

import pytest

from independent_sets import diagnosed_pair

INDEX = 34  # of seed 16


@pytest.mark.long
@pytest.mark.timeout(600)
def test_a_limit_that_one_run_to_fit_reaches_is_found(tmp_path):
    diagnosis, hidden = diagnosed_pair(16, INDEX, tmp_path, "sensor_gain_error", "current_saturation")
    assert diagnosis["steps"][0]["validation_error_free"] < 1.015, "the search goes on by itself, and this shows nothing"
    found = diagnosis["steps"][1]["parameters"]["max_current_A"]
    assert abs(found["value"] - hidden["current_saturation"]["max_current_A"]["value"]) < 3 * found["std"]
