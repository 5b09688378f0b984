"""Eddy currents that a lag of the amplifiers, or a delay, nearly stands in for: a set of the independent program (test/independent/blind.py).

The delay is left at 1.04 times the noise, which may be the floor of a noisy loop, after as many iterations as the eddy currents need to
begin: these stood at 3 times the noise by then, and were not gone on with.
"""
from __future__ import annotations

from amb_rotor import _core
from independent_sets import independent_set

SEED, INDEX = 8484, 16


def test_what_promises_as_much_as_a_stand_in_is_gone_on_with(tmp_path):
    dataset, hidden = independent_set(SEED, INDEX, tmp_path, reading=("--integrators", "settled"))
    assert set(hidden) == {"eddy_current_lag"}
    diagnosis, *_ = _core.diagnose(dataset.belief, dataset, candidates=["amplifier_lag", "control_delay", "eddy_current_lag"])
    rivals = [entry for entry in diagnosis["ranking"] if entry["effect"] != "eddy_current_lag"]
    assert min(entry["validation_error"] for entry in rivals) < 1.05, "none stands in for them, and this shows nothing"
    assert [step["added"] for step in diagnosis["steps"]] == ["eddy_current_lag"]
    corner = diagnosis["steps"][0]["parameters"]["corner_hz"]
    assert abs(corner["value"] - hidden["eddy_current_lag"]["corner_hz"]["value"]) < 3 * corner["std"]
