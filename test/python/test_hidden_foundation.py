"""A stator that moves, far above its resonance, and a rotor's mass that stands in for it: a set of the independent program.

The rotor moves against a stator of mass M as if its own were m M/(m + M), which a fit without the stator finds, 42 deviations of the
belief away, and a runout bends to it; what is left is a resonance near 22 Hz that leaves the runs 1.008 times the noise, where right
ones leave 1.006. From a heavy stator no small step leads there: less of one and more of the other have to come at once.
"""
from __future__ import annotations

import pytest

from amb_rotor import _core
from independent_sets import independent_set

SEED, INDEX = 8484, 33


@pytest.mark.long
def test_a_mass_far_below_its_belief_gives_way_to_the_stator_that_moves(tmp_path):
    dataset, hidden = independent_set(SEED, INDEX, tmp_path, reading=("--integrators", "settled"))
    assert set(hidden) == {"sensor_runout", "foundation_resonance"}
    diagnosis, *_ = _core.diagnose(dataset.belief, dataset, candidates=list(hidden))
    assert diagnosis["steps"][0]["validation_error"] < 1.01, "the mass does not stand in for it, and this shows nothing"
    assert [step["added"] for step in diagnosis["steps"]] == ["sensor_runout", "foundation_resonance"]
    found = {step["added"]: step["parameters"] for step in diagnosis["steps"]}
    asked = {"foundation_resonance": hidden["foundation_resonance"],
             "sensor_runout": {name: true for name, true in hidden["sensor_runout"].items() if name.endswith("_m")}}
    for effect, parameters in asked.items():
        for name, true in parameters.items():
            assert abs(found[effect][name]["value"] - true["value"]) < 3 * found[effect][name]["std"], name
    assert not [sentence for sentence in diagnosis["sentences"] if "rotor.mass_kg" in sentence]
