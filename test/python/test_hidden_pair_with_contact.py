"""A lag of the amplifiers with a falling friction: a set of the independent program (test/independent/blind.py).

Without contact only the lag shows; what contact shows is looked at beside it. The rubs slide far faster than the friction
falls: its coefficient at rest and its speed lie in a long flat valley, and their stated deviations must say so.
"""
from __future__ import annotations

import pytest

from independent_sets import diagnosed_pair

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
