"""A stator that moves, far above its resonance, and a rotor's mass that stands in for it: a set of the independent program.

The rotor moves against a stator of mass M as if its own were m M/(m + M), which a fit without the stator finds, 42 deviations of the
belief away; what is left is a resonance near 22 Hz that leaves the runs 1.008 times the noise, where right ones leave 1.006. From a
heavy stator no small step leads there: less of one and more of the other have to come at once.
"""
from __future__ import annotations

import pytest

from amb_rotor import _core
from independent_sets import independent_set

SEED, INDEX = 8484, 33


@pytest.fixture(scope="module")
def hidden_in(tmp_path_factory):
    dataset, hidden = independent_set(SEED, INDEX, tmp_path_factory.mktemp("foundation"), reading=("--integrators", "settled"))
    assert set(hidden) == {"sensor_runout", "foundation_resonance"}
    return dataset, {effect: {name: entry["value"] for name, entry in values.items()} for effect, values in hidden.items()}


def expect_foundation(parameters: dict, true: dict) -> None:
    for name, value in true.items():
        assert abs(parameters[name]["value"] - value) < 3 * parameters[name]["std"], name


def test_a_mass_far_below_its_belief_gives_way_to_the_stator_that_moves(hidden_in):
    dataset, hidden = hidden_in
    model = dataset.belief.with_effect("sensor_runout", hidden["sensor_runout"])
    diagnosis, *_ = _core.diagnose(model, dataset, candidates=["foundation_resonance"])
    assert [step["added"] for step in diagnosis["steps"]] == ["foundation_resonance"]
    assert diagnosis["baseline"]["validation_error"] < 1.01, "the mass does not stand in for it, and this shows nothing"
    expect_foundation(diagnosis["steps"][0]["parameters"], hidden["foundation_resonance"])
    assert not [sentence for sentence in diagnosis["sentences"] if "rotor.mass_kg" in sentence]


@pytest.mark.long
def test_it_gives_way_beside_a_runout_that_the_wrong_mass_has_bent(hidden_in):
    dataset, hidden = hidden_in
    diagnosis, *_ = _core.diagnose(dataset.belief, dataset, candidates=list(hidden))
    assert [step["added"] for step in diagnosis["steps"]] == ["sensor_runout", "foundation_resonance"]
    expect_foundation(diagnosis["steps"][1]["parameters"], hidden["foundation_resonance"])
    for name, true in hidden["sensor_runout"].items():
        if name.endswith("_m"):
            found = diagnosis["steps"][0]["parameters"][name]
            assert abs(found["value"] - true) < 3 * found["std"], name
