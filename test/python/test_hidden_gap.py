"""A number that runs without contact leave open and runs with contact tell: a set of the independent program (test/independent/blind.py).

The magnets' force goes with (current/gap) squared. Without contact the quotient of bias current and gap is known to parts in ten
thousand, either of them to 8 %.
"""
from __future__ import annotations

import pytest

from amb_rotor import _core
from independent_sets import SETTLED, independent_set

INDEX = 11  # of seed 5252


@pytest.mark.long
@pytest.mark.timeout(600)
def test_bias_and_gap_are_found_through_contact(tmp_path):
    dataset, hidden = independent_set(5252, INDEX, tmp_path, reading=SETTLED)
    assert set(hidden) == {"magnetic_nonlinearity"}
    diagnosis, *_ = _core.diagnose(dataset.belief, dataset, candidates=list(hidden), time_limit_s=0.0)
    assert [step["added"] for step in diagnosis["steps"]] == ["magnetic_nonlinearity"]
    for name in ("bias_current_A", "air_gap_m"):
        found, true = diagnosis["steps"][0]["parameters"][name], hidden["magnetic_nonlinearity"][name]["value"]
        assert found["std"] < 2e-3 * true, "through contact they are known far closer, or this shows nothing"
        assert abs(found["value"] - true) < 3 * found["std"], name
