"""A law of no catalogue that two effects of the catalogue hide: a set of `./amb make-dataset` with quadratic damping.

A delay bends towards it and sensors that are turned by some thousandths take what is left to 1.047 times the noise, which
passed for the floor; the law alone leaves 1.00.
"""
from __future__ import annotations

from amb_rotor import _core

SEED = 4100153


def test_a_law_is_asked_for_where_two_effects_leave_little(tmp_path):
    made = _core.make_dataset(SEED, ["quadratic_damping"], out=str(tmp_path))
    assert made["law"] == "quadratic_damping" and made["depends_on"] == ["velocity"]
    dataset = _core.read_dataset(str(tmp_path))
    diagnosis, *_ = _core.diagnose(dataset.belief, dataset, candidates=["control_delay", "sensor_axis_rotation"])
    assert diagnosis["ranking"][0]["validation_error"] < 1.12, "the law is not hidden, and this shows nothing"
    assert diagnosis["verdict"] == "unknown" and diagnosis["steps"] == []
    unexplained = diagnosis["unexplained"]
    assert unexplained["depends_on"] == ["velocity"]
    (term,) = unexplained["terms"]
    assert abs(term["coefficient"] + 5602.78) < 3 * term["std"]  # amount of the truth.yaml, N s2/m2
