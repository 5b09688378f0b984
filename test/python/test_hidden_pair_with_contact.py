"""A lag of the amplifiers with a falling friction: a set of the independent program (test/independent/blind.py).

Without contact only the lag shows; what contact shows is looked at beside it. The rubs slide far faster than the friction
falls: its coefficient at rest and its speed lie in a long flat valley, and their stated deviations must say so.
"""
from __future__ import annotations

import pytest

from amb_rotor import _core
from independent_sets import diagnosed_pair, independent_set

INDEX = 37  # of seed 11


@pytest.mark.long
@pytest.mark.timeout(600)
def test_contact_is_looked_at_beside_what_shows_without(tmp_path):
    diagnosis, hidden = diagnosed_pair(11, INDEX, tmp_path, "amplifier_lag", "velocity_dependent_friction")
    first, second = diagnosis["ranking"]
    assert (first["effect"], first["beside"]) == ("amplifier_lag", "")
    assert (second["effect"], second["beside"]) == ("velocity_dependent_friction", "amplifier_lag")
    assert second["evidence"] > 1000
    for step in diagnosis["steps"]:
        for name, found in step["parameters"].items():
            assert abs(found["value"] - hidden[step["added"]][name]["value"]) < 3 * found["std"], name


@pytest.mark.long
@pytest.mark.timeout(600)
def test_a_friction_that_hardly_shows_is_looked_for_though_no_run_is_left_above_the_noise(tmp_path):
    """A current limit leaves 0.903 of the held-out runs through contact, the friction beside it 0.897: windows with free starts take
    the noise of the loop away, and how far below it the right model leaves them nobody knows."""
    dataset, hidden = independent_set(7373, 33, tmp_path, reading=("--offsets", "loop"))
    assert set(hidden) == {"current_saturation", "velocity_dependent_friction"}
    diagnosis, *_ = _core.diagnose(dataset.belief, dataset, candidates=list(hidden))
    assert diagnosis["steps"][0]["validation_error_contact"] < 0.95, "it is plain, and this shows nothing"
    assert [step["added"] for step in diagnosis["steps"]] == ["current_saturation", "velocity_dependent_friction"]
    for step in diagnosis["steps"]:
        for name, found in step["parameters"].items():
            assert abs(found["value"] - hidden[step["added"]][name]["value"]) < 3 * found["std"], name
